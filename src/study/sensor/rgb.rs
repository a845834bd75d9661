//! An RGB camera as a switch: a zone counts as occupied while a person's keypoints are seen anywhere in the
//! image.
use super::keypoints::{self, KeypointCamera};
use super::prism::Prism;
use super::range::Range;
use super::{Camera, Claim, Extent, FieldOfView, Kind, SWITCHES, Scale, Station, switched};
use perirobot_march::backend::Rays;
use perirobot_march::error::Issue;
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::Truth;

/// Optics, reach and zone.
#[derive(Clone, Debug, PartialEq)]
pub struct Rgb {
    /// Its optics.
    pub camera: Camera,
    /// How far it recognises a person, its own housing and its mount. It measures no distance, so it has no
    /// noise.
    pub range: Range,
    /// The zone, in the world whatever the camera's pose.
    pub zone: Prism,
    /// How many joints of one person must be seen.
    pub min_keypoints: usize,
    /// Largest difference between the distance of what is seen and of the joint, in metres.
    pub keypoint_tolerance_m: f64,
    /// Whether seeing nobody certifies that the zone is free.
    pub otherwise_free: bool,
}

impl Rgb {
    fn zone(&self, grid: &Grid, window: Window) -> BitGrid {
        self.zone.voxels(&Pose::ORIGIN, grid, window)
    }
}

impl Kind for Rgb {
    fn name(&self) -> &'static str {
        "rgb"
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
        self.zone.check(&Pose::ORIGIN, &at.truth.grid).map_err(|e| e.at("zone"))
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let scale = Scale { voxel_size_m: at.truth.grid.voxel_size_m, backdrop: false };
        // Only rays towards the joints are cast, since an image measures no distances.
        let rays: &Rays = &self.range.rays(Vec::new(), &scale);
        let placement = &at.placement(self);
        let eye =
            KeypointCamera { camera: &self.camera, rays, placement, tolerance_m: self.keypoint_tolerance_m };
        let people = keypoints::detect(&eye, at);
        let on = people.iter().any(|joints| keypoints::count(joints) >= self.min_keypoints);
        let mut felt = BitGrid::new(at.truth.human.window());
        people.iter().flatten().flatten().for_each(|found| felt.set(found.hit));
        vec![switched(at, self.zone(&at.truth.grid, at.window), on, self.otherwise_free, felt)]
    }

    fn wherever_it_stands(&self, truth: &Truth) -> Option<BitGrid> {
        Some(self.zone(&truth.grid, truth.grid.window()))
    }

    fn reach(&self, _: &Station) -> Extent {
        Extent::Only(BitGrid::nowhere())
    }
}
