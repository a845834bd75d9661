//! Rays in directions of the user's own: a ring of time-of-flight sensors on a robot's arm, say.

use glam::DMat3;

use super::range::Range;
use super::{Claim, Kind, MEASURES, Scale, Station};
use perirobot_march::backend::Rays;
use perirobot_scene::pose::Pose;

/// Directions in the sensor's link frame (x forward, y left, z up).
#[derive(Clone, Debug, PartialEq)]
pub struct RaySet {
    /// Unit directions, Q15, in the table's order.
    pub dirs_q15: Vec<[i32; 3]>,
    /// What it measures.
    pub range: Range,
}

impl Kind for RaySet {
    fn name(&self) -> &'static str {
        "rays"
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["points"]
    }

    fn rays(&self, scale: &Scale) -> Option<Rays> {
        Some(self.range.rays(self.dirs_q15.clone(), scale))
    }

    fn frame(&self, pose: &Pose) -> DMat3 {
        pose.link()
    }

    fn range(&self) -> Option<&Range> {
        Some(&self.range)
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        MEASURES
    }

    fn adds(&self, _: usize) -> bool {
        false
    }

    fn claims(&self, _: &Station) -> Vec<Claim> {
        vec![Claim { cast: true, planes: None }]
    }
}
