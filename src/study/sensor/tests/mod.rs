//! Small cells made by hand, and what the sensors must say in them. Reading a study is tested in `study`,
//! whole sweeps beside the program.

mod cover;
mod detection;
mod field;
mod fusion;
mod look;
mod noise;
mod pad;
mod people;
mod presence;
mod rgb;
mod rgbd;
mod robot;

use std::sync::Arc;

use glam::DVec3;

use super::{Kind, Setting, Station};
use perirobot_march::backend::Planes;
use perirobot_march::voxel::flood::enclosed_voxels;
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_scene::objects::Role;
use perirobot_scene::objects::keypoints::Keypoints;
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::{ObjectVoxels, RadarTruth, Truth};

/// A grid at the world's origin with nothing in it.
pub(crate) fn empty(size: [u32; 3], voxel_size_m: f64) -> Truth {
    let grid = Grid { voxel_size_m, origin: [0; 3], size };
    let blank = BitGrid::new(grid.window());
    Truth {
        grid,
        occupied: blank.clone().into(),
        blockers: blank.clone().into(),
        radar: RadarTruth { blockers: blank.clone().into(), speeds_mm_s: Vec::new() },
        shades: None,
        ignored: blank.clone(),
        human: blank.clone(),
        robot: blank.clone(),
        robot_volume: blank,
        objects: Vec::new(),
    }
}

/// Puts voxels of a role into a cell, as one object.
pub(crate) fn put(truth: &mut Truth, role: Role, voxels: &[[i32; 3]], keypoints: Option<Keypoints>) {
    let mut own = BitGrid::new(truth.grid.window());
    voxels.iter().for_each(|&voxel| own.set(voxel));
    Arc::make_mut(&mut truth.occupied).add(&own);
    Arc::make_mut(&mut truth.blockers).add(&own);
    Arc::make_mut(&mut truth.radar.blockers).add(&own);
    match role {
        Role::Environment => {}
        Role::Human => truth.human.add(&own),
        Role::Robot => {
            truth.robot.add(&own);
            let bounds = own.bounds();
            truth.robot_volume.add(&own);
            truth.robot_volume.add(&enclosed_voxels(&own.to_window(bounds)));
        }
    }
    truth.objects.push(Arc::new(ObjectVoxels {
        name: format!("object {}", truth.objects.len()),
        role,
        stops_rays: true,
        stops_radar: true,
        triangles: 0,
        watertight: None,
        bounds_m: [DVec3::ZERO; 2],
        reach: None,
        voxels: own,
        keypoints,
        warnings: Vec::new(),
    }));
}

pub(crate) fn station(truth: &Truth, setting: Setting) -> Station<'_> {
    Station { moment: [0, 0], truth, window: truth.grid.window(), setting, rays: None, truly: None, draws: 0 }
}

/// A station that stands at a position and faces a direction, level.
pub(crate) fn facing(truth: &Truth, position_m: [f64; 3], facing: [f64; 3]) -> Station<'_> {
    let pose = Pose::facing(position_m.into(), facing.into(), 0.0, 0.0);
    station(truth, Setting::Pose(pose))
}

/// All cells from a lowest to a highest, both included.
pub(crate) fn block(low: [i32; 3], high: [i32; 3]) -> Vec<[i32; 3]> {
    let mut voxels = Vec::new();
    for z in low[2]..=high[2] {
        for y in low[1]..=high[1] {
            voxels.extend((low[0]..=high[0]).map(|x| [x, y, z]));
        }
    }
    voxels
}

/// What a switch says of its volume.
#[derive(Debug, PartialEq)]
pub(crate) enum Says {
    Occupied(Vec<[i32; 3]>),
    Free(Vec<[i32; 3]>),
    Nothing,
}

/// What a switch says at a station; it must not cast.
#[track_caller]
pub(crate) fn says(kind: &dyn Kind, representation: usize, at: &Station) -> Says {
    let claim = kind.claims(at).swap_remove(representation);
    assert!(!claim.cast, "a switch keeps its rays to itself");
    let Some(Planes { occupied, free, .. }) = claim.planes else { return Says::Nothing };
    match (occupied.is_empty(), free.is_empty()) {
        (false, true) => Says::Occupied(occupied.voxels().collect()),
        (true, false) => Says::Free(free.voxels().collect()),
        both => panic!("one of two planes is empty, not {both:?}"),
    }
}

/// The hash as the paper prints it, in 64 bits.
fn pcg(word: u64) -> u64 {
    let state = (word * 747_796_405 + 2_891_336_453) % (1 << 32);
    let mixed = ((state >> ((state >> 28) + 4)) ^ state) * 277_803_737 % (1 << 32);
    (mixed >> 22) ^ mixed
}
