//! An RGB camera as a switch: a zone counts as occupied while a person's keypoints are seen anywhere in the
//! image.

use serde::Deserialize;
use toml::Table;

use super::shared::camera::{camera, tolerance};
use super::shared::camera_info;
use super::shared::range::{CalibrationFile, RangeKeys};
use super::shared::{Silence, prism};
use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{EvidenceWords, Page};
use crate::diagnostics::Place;
use crate::keys::{BoxFile, exactly};
use crate::sensor::keypoints::{self, KeypointCamera};
use crate::sensor::prism::Prism;
use crate::sensor::range::Range;
use crate::sensor::{Camera, Claim, Extent, FieldOfView, Kind, RayScale, SWITCHES, Station, switch_planes};
use perirobot_march::Result;
use perirobot_march::backend::Rays;
use perirobot_march::error::Issue;
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_scene::objects::keypoints::JOINTS;
use perirobot_scene::pose::Pose;
use perirobot_scene::source::Sources;
use perirobot_scene::truth::Truth;

/// An RGB camera that watches a zone.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct RgbFile {
    /// Horizontal and vertical angle of view, below 180.
    #[serde(deserialize_with = "exactly")]
    fov_deg: [f64; 2],
    /// Pixels across and down.
    #[serde(deserialize_with = "exactly")]
    resolution_px: [u32; 2],
    /// Nearest and farthest distance that it measures, in metres.
    #[serde(deserialize_with = "exactly")]
    range_m: [f64; 2],
    /// Hits nearer than this are its own housing, in metres. Default 0.
    near_ignore_m: Option<f64>,
    /// How far its mount may be off, drawn anew in each repeat. Default not at all.
    calibration: Option<CalibrationFile>,
    /// The box that it calls occupied while it sees a person, in the world.
    zone: BoxFile,
    /// How many joints of one person it must see. Default 1.
    min_keypoints: Option<u32>,
    /// How far a hit may be from a joint to count as that joint, in metres. Default 0.15.
    keypoint_tolerance_m: Option<f64>,
    /// What it says about the zone while it sees nobody. Default "unknown".
    otherwise: Option<Silence>,
}

impl KindFile for RgbFile {
    const NAME: &'static str = "rgb";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "RGB camera; a person whose joints it detects anywhere in its image makes its whole `zone` occupied",
        keys: "`fov_deg`, `resolution_px`, `range_m`, `zone = { min_m, max_m }` (in the world), `min_keypoints?` \
        (1), `keypoint_tolerance_m?`, `otherwise?` (unknown)",
        evidence: &[EvidenceWords {
            says: "`zone`",
            occupied: "the zone, if at least `min_keypoints` joints of one person are seen",
            free: "else the zone, if `otherwise = \"free\"`",
        }],
    };

    fn prepare(at: &Place, keys: &mut Table, sources: &Sources) -> Result<Vec<String>> {
        camera_info::resolve(at, keys, sources)
    }

    fn check(self, at: &Place, context: &Context) -> Result<Checked> {
        let range = RangeKeys {
            range_m: self.range_m,
            along: None,
            near_ignore_m: self.near_ignore_m,
            no_return: None,
            noise: None,
            dropout: None,
            calibration: self.calibration,
            reflectance_ranges_m: None,
        };
        let min_keypoints = self.min_keypoints.unwrap_or(1) as usize;
        if !(1..=JOINTS.len()).contains(&min_keypoints) {
            return Err(at.wrong("min_keypoints", min_keypoints, "must be from 1 to 17, COCO's joints"));
        }
        Ok(Rgb {
            camera: camera(at, self.fov_deg, self.resolution_px)?,
            range: range.check(at, context.noiseless)?,
            zone: prism(at, "zone", &self.zone)?,
            min_keypoints,
            keypoint_tolerance_m: tolerance(at, self.keypoint_tolerance_m)?,
            // A blocked view certifies nothing.
            otherwise_free: self.otherwise == Some(Silence::Free),
        }
        .into())
    }
}

/// Optics, reach and zone.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rgb {
    /// Its optics.
    pub(crate) camera: Camera,
    /// How far it recognises a person, its own housing and its mount. It measures no distance, so it has no
    /// noise.
    pub(crate) range: Range,
    /// The zone, in the world whatever the camera's pose.
    pub(crate) zone: Prism,
    /// How many joints of one person must be seen.
    pub(crate) min_keypoints: usize,
    /// Largest difference between the distance of what is seen and of the joint, in metres.
    pub(crate) keypoint_tolerance_m: f64,
    /// Whether seeing nobody certifies that the zone is free.
    pub(crate) otherwise_free: bool,
}

impl Rgb {
    fn zone(&self, grid: &Grid, window: Window) -> BitGrid {
        self.zone.voxels(&Pose::ORIGIN, grid, window)
    }
}

impl Kind for Rgb {
    fn name(&self) -> &'static str {
        RgbFile::NAME
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["zone"]
    }

    fn field_of_view(&self) -> FieldOfView {
        FieldOfView::Image(self.camera.image())
    }

    fn range(&self) -> Option<&Range> {
        Some(&self.range)
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        SWITCHES
    }

    fn feels_presence(&self, _: usize) -> bool {
        true
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        keypoints::check(at)?;
        self.zone.check(&Pose::ORIGIN, &at.truth.grid).map_err(|e| e.with_place("zone"))
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let scale = RayScale::new(at.truth.grid.voxel_size_m, false);
        // Only rays towards the joints are cast, since an image measures no distances.
        let rays: &Rays = &self.range.rays(Vec::new(), &scale);
        let placement = &at.placement(self);
        let eye =
            KeypointCamera { camera: &self.camera, rays, placement, tolerance_m: self.keypoint_tolerance_m };
        let people = keypoints::detect(&eye, at);
        let on = people.iter().any(|joints| keypoints::count(joints) >= self.min_keypoints);
        let mut felt = BitGrid::new(at.truth.human.window());
        people.iter().flatten().flatten().for_each(|found| felt.set(found.hit));
        vec![switch_planes(at, self.zone(&at.truth.grid, at.window), on, self.otherwise_free, felt)]
    }

    fn wherever_it_stands(&self, truth: &Truth) -> Option<BitGrid> {
        Some(self.zone(&truth.grid, truth.grid.window()))
    }

    fn reach(&self, _: &Station) -> Extent {
        Extent::Only(BitGrid::nowhere())
    }
}
