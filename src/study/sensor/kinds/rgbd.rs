//! An RGB-D camera: one ray a pixel, and volumes around the keypoints that it detects in its image.

use std::sync::Arc;

use serde::Deserialize;
use toml::Table;

use super::shared::camera::{camera, tolerance};
use super::shared::camera_info;
use super::shared::range::{CalibrationFile, NoiseFile, RangeKeys, refuse_former};
use super::shared::{Silence, each_once, length};
use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{EvidenceWords, POINTS, Page};
use crate::diagnostics::Place;
use crate::keys::exactly;
use crate::sensor::keypoints::{self, BONES, Detected, KeypointCamera};
use crate::sensor::range::{Along, Range};
use crate::sensor::spacing::RaySpacing;
use crate::sensor::{Camera, Claim, FieldOfView, Kind, MEASURES, RayScale, Station};
use perirobot_march::Result;
use perirobot_march::backend::{Planes, Rays};
use perirobot_march::error::{Issue, Site};
use perirobot_march::voxel::grid::{MAX_VOXELS_PER_AXIS, ONE_Q16, length_q16};
use perirobot_march::voxel::{BitGrid, Window, solid};
use perirobot_scene::objects::keypoints::JOINTS;
use perirobot_scene::source::Sources;
use perirobot_scene::truth::Truth;

/// Radii that the paper's code has at voxels of 5 cm, in metres.
const SPHERES_RADIUS_M: f64 = 0.20;
const CYLINDERS_RADIUS_M: f64 = 0.25;

/// An RGB-D camera.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct RgbdFile {
    /// Horizontal and vertical angle of view, below 180.
    #[serde(deserialize_with = "exactly")]
    fov_deg: [f64; 2],
    /// Pixels across and down.
    #[serde(deserialize_with = "exactly")]
    resolution_px: [u32; 2],
    /// Nearest and farthest distance that it measures, in metres.
    #[serde(deserialize_with = "exactly")]
    range_m: [f64; 2],
    /// What range_m and noise are measured along: "ray", the distance, or "axis", the depth, as most data sheets have it. Default
    /// "ray".
    range_along: Option<Along>,
    /// Hits nearer than this are its own housing, in metres. Default 0.
    near_ignore_m: Option<f64>,
    /// What a ray that hits nothing says about the voxels that it passed. Default "unknown".
    no_return: Option<Silence>,
    /// Noise of measured distances. Default none.
    noise: Option<NoiseFile>,
    /// Share of returns that is lost, from 0 to below 1. Default 0.
    dropout: Option<f64>,
    /// How far it detects what reflects a share of its light, as [[0.1, 8], [0.9, 25]] for 8 m at 10 % and 25 m at 90 %; one to
    /// three pairs. Default: everything up to the longest range.
    reflectance_ranges_m: Option<Vec<[f64; 2]>>,
    /// How far its mount may be off, drawn anew in each repeat. Default not at all.
    calibration: Option<CalibrationFile>,
    /// The representations that are scored, each separately. Default ["points"].
    representations: Option<Vec<ShapeName>>,
    /// Radius of the spheres around joints, in metres. Default 0.2.
    spheres_radius_m: Option<f64>,
    /// Radius of the cylinders between joints, in metres. Default 0.25.
    cylinders_radius_m: Option<f64>,
    /// How far a hit may be from a joint to count as that joint, in metres. Default 0.15.
    keypoint_tolerance_m: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
enum ShapeName {
    Points,
    Spheres,
    Cylinders,
    Box,
}

impl KindFile for RgbdFile {
    const NAME: &'static str = "rgbd";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "RGB-D camera, scored as `points`, or with volumes around detected keypoints: `spheres`, `cylinders`, \
        `box`",
        keys: "`fov_deg`, `resolution_px`, `range_m`, `range_along?` (ray), `representations?` (points), \
        `spheres_radius_m?` (0.2), `cylinders_radius_m?` (0.25), `keypoint_tolerance_m?` (0.15)",
        evidence: &[
            POINTS,
            EvidenceWords {
                says: "`spheres`, `cylinders`, `box`",
                occupied: "as `points`, and the volume around what was detected",
                free: "as `points`",
            },
        ],
    };

    fn prepare(at: &Place, keys: &mut Table, sources: &Sources) -> Result<Vec<String>> {
        let warnings = camera_info::resolve(at, keys, sources)?;
        refuse_former(at, keys)?;
        Ok(warnings)
    }

    fn check(self, at: &Place, context: &Context) -> Result<Checked> {
        let range = RangeKeys {
            range_m: self.range_m,
            along: self.range_along,
            near_ignore_m: self.near_ignore_m,
            no_return: self.no_return,
            noise: self.noise,
            dropout: self.dropout,
            calibration: self.calibration,
            reflectance_ranges_m: self.reflectance_ranges_m,
        };
        let names = self.representations.unwrap_or_else(|| vec![ShapeName::Points]);
        each_once(at, &names, "representations = [\"points\", \"cylinders\"]")?;
        let spheres = length(at, "spheres_radius_m", self.spheres_radius_m.unwrap_or(SPHERES_RADIUS_M))?;
        let cylinders =
            length(at, "cylinders_radius_m", self.cylinders_radius_m.unwrap_or(CYLINDERS_RADIUS_M))?;
        let shape = |name| match name {
            ShapeName::Points => KeypointShape::Points,
            ShapeName::Spheres => KeypointShape::Spheres { radius_m: spheres },
            ShapeName::Cylinders => KeypointShape::Cylinders { radius_m: cylinders },
            ShapeName::Box => KeypointShape::Box,
        };
        Ok(Rgbd {
            camera: camera(at, self.fov_deg, self.resolution_px)?,
            range: range.check(at, context.noiseless)?,
            shapes: names.into_iter().map(shape).collect(),
            keypoint_tolerance_m: tolerance(at, self.keypoint_tolerance_m)?,
        }
        .into())
    }
}

/// Optics, distances and what is scored.
#[derive(Clone, Debug, PartialEq)]
pub struct Rgbd {
    /// Its optics.
    pub camera: Camera,
    /// What it measures.
    pub range: Range,
    /// Representations in the order they are scored, each once.
    pub shapes: Vec<KeypointShape>,
    /// Largest difference between the distance of a return and of the joint it is taken for, in metres.
    pub keypoint_tolerance_m: f64,
}

/// Where each joint of a person is read.
type Joints = [Option<[i32; 3]>; JOINTS.len()];

/// What a camera makes of the keypoints that it detects, besides the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeypointShape {
    /// Nothing: the points alone (paper: PC).
    Points,
    /// A ball around each joint (PC+Sph).
    Spheres {
        /// Its radius in metres.
        radius_m: f64,
    },
    /// A cylinder along each bone (PC+Cyl).
    Cylinders {
        /// Its radius in metres.
        radius_m: f64,
    },
    /// A box around all joints of a person (PC+Box).
    Box,
}

impl KeypointShape {
    /// Its name in studies and tables.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            KeypointShape::Points => "points",
            KeypointShape::Spheres { .. } => "spheres",
            KeypointShape::Cylinders { .. } => "cylinders",
            KeypointShape::Box => "box",
        }
    }

    /// The volume around what is detected of each person, over the part of a window that holds it.
    fn volume(&self, people: &[Joints], voxel_size_m: f64, window: Window) -> BitGrid {
        let radius_q16 = self.radius_m().map_or(0, |radius_m| length_q16(radius_m, voxel_size_m));
        let reach = (radius_q16 / ONE_Q16).clamp(0, MAX_VOXELS_PER_AXIS.into()) as i32 + 1;
        let joints = people.iter().flatten().flatten().map(|&joint| Window::from_corners(joint, joint));
        let Some(around) = joints.reduce(|all, one| all.union(&one)) else { return BitGrid::nowhere() };
        let mut plane = BitGrid::new(around.grown(reach).intersection(&window));
        for joints in people {
            match self {
                KeypointShape::Points => {}
                KeypointShape::Spheres { .. } => {
                    joints.iter().flatten().for_each(|&joint| solid::ball(&mut plane, joint, radius_q16));
                }
                KeypointShape::Cylinders { .. } => {
                    for [a, b] in BONES {
                        if let (Some(a), Some(b)) = (joints[a], joints[b]) {
                            solid::cylinder(&mut plane, a, b, radius_q16);
                        }
                    }
                }
                KeypointShape::Box => solid::cuboid(&mut plane, joints.iter().flatten().copied()),
            }
        }
        plane
    }

    /// How far its volume reaches from what is detected, in metres; `None` if it has none.
    fn radius_m(&self) -> Option<f64> {
        match *self {
            KeypointShape::Points => None,
            KeypointShape::Spheres { radius_m } | KeypointShape::Cylinders { radius_m } => Some(radius_m),
            KeypointShape::Box => Some(0.0),
        }
    }
}

impl Kind for Rgbd {
    fn name(&self) -> &'static str {
        RgbdFile::NAME
    }

    fn representations(&self) -> Vec<&'static str> {
        self.shapes.iter().map(KeypointShape::name).collect()
    }

    fn only(&self, representation: usize) -> Option<Arc<dyn Kind>> {
        Some(Arc::new(Rgbd { shapes: vec![self.shapes[representation]], ..self.clone() }))
    }

    fn rays(&self, scale: &RayScale) -> Option<Rays> {
        Some(Rays { image: Some(self.camera.image()), ..self.range.rays(self.camera.dirs_q15(), scale) })
    }

    fn field_of_view(&self) -> FieldOfView {
        FieldOfView::Image(self.camera.image())
    }

    fn spacing(&self) -> Option<RaySpacing> {
        Some(RaySpacing::from_image(&self.camera.image()))
    }

    fn range(&self) -> Option<&Range> {
        Some(&self.range)
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        MEASURES
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        match self.shapes.iter().find(|shape| **shape != KeypointShape::Points) {
            Some(shape) => keypoints::check(at)
                .map_err(|e| e.with_place(Site::Subject(format!("representation {:?}", shape.name())))),
            None => Ok(()),
        }
    }

    fn adds(&self, representation: usize) -> bool {
        self.shapes[representation] != KeypointShape::Points
    }

    fn wherever_it_stands(&self, truth: &Truth) -> Option<BitGrid> {
        // Joints are detected on a person, so no volume leaves the person's box grown by the largest radius.
        let radius_m = self.shapes.iter().filter_map(KeypointShape::radius_m).reduce(f64::max)?;
        let radius_q16 = length_q16(radius_m, truth.grid.voxel_size_m);
        let mut volumes = BitGrid::new(truth.grid.window());
        for human in keypoints::humans(truth).filter(|human| !human.voxels.is_empty()) {
            let bounds = human.voxels.bounds();
            let low = bounds.min.map(|x| i64::from(x) * ONE_Q16 - radius_q16);
            let high = bounds.end().map(|x| i64::from(x) * ONE_Q16 + radius_q16);
            solid::half_open_box(&mut volumes, low, high);
        }
        Some(volumes)
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let detected = |rays: &Rays| {
            let placement = &at.placement(self);
            let tolerance_m = self.keypoint_tolerance_m;
            keypoints::detect(&KeypointCamera { camera: &self.camera, rays, placement, tolerance_m }, at)
        };
        let looks = self.shapes.iter().any(|shape| *shape != KeypointShape::Points);
        let people = at.rays.filter(|_| looks).map_or_else(Vec::new, detected);
        let read = |joints: &Detected| joints.map(|joint| joint.map(|found| found.read));
        let people: Vec<Joints> = people.iter().map(read).collect();
        let claim = |shape: &KeypointShape| {
            let occupied = shape.volume(&people, at.truth.grid.voxel_size_m, at.window);
            let planes = Planes { occupied, free: BitGrid::nowhere(), hits: BitGrid::nowhere() };
            Claim { cast: true, planes: (!planes.occupied.is_empty()).then_some(planes) }
        };
        self.shapes.iter().map(claim).collect()
    }
}
