//! Maps and point clouds that real sensors recorded, turned into what a sensor says in the grid of a study.
//!
//! | file | what it is |
//! |---|---|
//! | `.bt`, `.ot` | an OctoMap |
//! | `.npz` | labels over a grid, as `perirobot export` writes them |
//! | `.pcd`, `.ply` | a point cloud, carved from where its sensor was |
//!
//! # Theory
//! A recording has a frame of its own, which stands in the world at a position, turned about the vertical. The
//! voxels of a map are cubes of that frame; their corners are rounded to 1/65536 voxel of the study's grid, and
//! what follows is integers ([`voxels`]):
//!
//! * a voxel of the study is occupied if a part of an occupied voxel of the map lies more than 1/256 voxel deep in it;
//! * it is free if all of it is covered by free voxels of the map;
//! * else it is unknown.
//!
//! So a map on the study's own grid comes back as it is. The points of a cloud mark and carve as returns of a
//! sensor do ([`cloud`]).

pub mod cloud;
mod header;
mod npy;
mod npz;
mod number;
mod pcd;
mod ply;
mod points;
pub mod voxels;

use std::path::Path;

use glam::{DMat3, DVec3};

use crate::backend::Planes;
use crate::scene::octomap;
use crate::source::Sources;
use crate::voxel::Grid;
use crate::voxel::grid::VOXEL_SIZES_M;
use crate::{Error, Result};
use cloud::Cloud;
use voxels::VoxelMap;

/// The endings of all that can be read, for messages.
pub const ENDINGS: &str = "a .bt, .ot, .npz, .pcd or .ply file";

/// How many voxels of a map may stand in a row in a voxel of the grid.
const FINEST: f64 = 64.0;

/// Most voxels of a map that are laid into a grid: three planes of a gigabyte.
const MOST_VOXELS: u64 = 1 << 33;

/// What was recorded, in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Recording {
    /// Voxels that are occupied, free or unknown.
    Map(VoxelMap),
    /// Points that a sensor measured.
    Cloud(Cloud),
}

/// Where the frame of a recording stands in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    position_m: DVec3,
    world_from_frame: DMat3,
}

impl Anchor {
    /// At a position in metres, turned about the vertical from x towards y.
    pub fn new(position_m: DVec3, yaw_rad: f64) -> Anchor {
        // Quarter turns are made exact, so that a map that is not turned keeps its numbers.
        let exact = |v: f64| if (v - v.round()).abs() < 1e-12 { v.round() } else { v };
        let (sin, cos) = (exact(libm::sin(yaw_rad)), exact(libm::cos(yaw_rad)));
        let [x, y] = [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0)];
        Anchor { position_m, world_from_frame: DMat3::from_cols(x, y, DVec3::Z) }
    }

    /// A point of the frame in the world; both in metres.
    pub(crate) fn world(&self, point_m: DVec3) -> DVec3 {
        self.position_m + self.world_from_frame * point_m
    }

    /// A point of the world in the frame; both in metres.
    fn frame(&self, point_m: DVec3) -> DVec3 {
        self.world_from_frame.transpose() * (point_m - self.position_m)
    }
}

impl Recording {
    /// Reads a file by the ending of its name. `sensor_m` says where the sensor was that measured a cloud, in
    /// the recording's frame; the file says it, or else it was at the frame's origin.
    ///
    /// # Errors
    /// When the file cannot be read, is damaged, or holds nothing; when a map is given a place of its sensor.
    pub fn read(path: &Path, sensor_m: Option<DVec3>, sources: &Sources) -> Result<Recording> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let map = match ending.as_deref() {
            Some("bt" | "ot") => VoxelMap::of_tree(octomap::read_tree(path, sources)?),
            Some("npz") => npz::parse(&sources.bytes(path)?).map_err(|e| Error::from(e.at(path)))?,
            Some("pcd") => {
                let cloud = pcd::parse(&sources.bytes(path)?).map_err(|e| Error::from(e.at(path)))?;
                return Ok(Recording::Cloud(cloud.seen_from(sensor_m)));
            }
            Some("ply") => {
                let cloud = ply::parse(&sources.bytes(path)?).map_err(|e| Error::from(e.at(path)))?;
                return Ok(Recording::Cloud(cloud.seen_from(sensor_m)));
            }
            _ => return Err(Error::input(path, format!("must be {ENDINGS}"))),
        };
        if !VOXEL_SIZES_M.contains(&map.voxel_size_m) {
            let what = format!("has voxels of {} m, must be from 0.0001 to 10 m", map.voxel_size_m);
            return Err(Error::input(path, what));
        }
        match sensor_m {
            None => Ok(Recording::Map(map)),
            Some(_) => {
                Err(Error::input(path, "is a map, and the place of a sensor is asked of point clouds only")
                    .wanted("leave it out"))
            }
        }
    }

    /// What it says in a grid: planes over all of it. Its hits are empty
    /// where the recording does not tell which voxels its returns came from.
    pub(crate) fn planes(&self, anchor: &Anchor, grid: &Grid) -> Said {
        match self {
            Recording::Map(map) => map.in_grid(anchor, grid),
            Recording::Cloud(cloud) => Said { planes: cloud.in_grid(anchor, grid), knows_hits: false },
        }
    }

    /// Whether a map's voxels are so small beside those of a grid that they would get lost, or so many in it that laying
    /// it there takes more than some gigabytes.
    pub(crate) fn is_too_fine(&self, anchor: &Anchor, grid: &Grid) -> bool {
        match self {
            Recording::Map(map) => {
                map.voxel_size_m * FINEST < grid.voxel_size_m || map.voxels_near(anchor, grid) > MOST_VOXELS
            }
            Recording::Cloud(_) => false,
        }
    }

    /// What it is, for people.
    pub fn in_words(&self) -> String {
        match self {
            Recording::Map(map) => map.in_words(),
            Recording::Cloud(cloud) => cloud.in_words(),
        }
    }

    /// Lowest and highest corner of what it knows, in its frame, in metres.
    pub(crate) fn bounds_m(&self) -> [DVec3; 2] {
        match self {
            Recording::Map(map) => map.bounds_m(),
            Recording::Cloud(cloud) => cloud.bounds_m(),
        }
    }
}

/// What a recording says in a grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Said {
    /// Occupied and free voxels, and those that returns came from, if that is known. A voxel may be both
    /// occupied and free: occupied wins.
    pub(crate) planes: Planes,
    /// Whether the recording tells which voxels its returns came from.
    pub(crate) knows_hits: bool,
}

#[cfg(test)]
mod tests;
