//! The robot's controller as a sensor: it knows where the robot is, and nothing else.

use super::{Claim, Extent, Kind, Setting, Station};
use perirobot_march::backend::Planes;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::truth::Truth;

/// The robot's voxels, surface and inside, except those that the truth calls free: they stay without a label,
/// since in a scene with `interior = "free"` they would count as false alarms.
fn known(truth: &Truth) -> BitGrid {
    let window = truth.robot_volume.window();
    let mut solid = truth.occupied.over(window);
    solid.add(&truth.ignored.over(window));
    solid.keep(&truth.robot_volume);
    solid
}

/// The robot's own pose, taken for certain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownRobot;

impl Kind for KnownRobot {
    fn name(&self) -> &'static str {
        "known_robot"
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["volume"]
    }

    fn settings(&self) -> Vec<(String, Setting)> {
        vec![("known".into(), Setting::Fixed)]
    }

    fn takes_poses(&self) -> bool {
        false
    }

    fn speaks_last(&self) -> bool {
        // No measurement overrules the controller.
        true
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        [3511, 0]
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        at.check_robot()
    }

    fn feels(&self, _: &Station) -> Extent {
        Extent::Only(BitGrid::nowhere())
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let robot = known(at.truth);
        let occupied = robot.over(robot.window().intersection(&at.window));
        vec![Claim {
            cast: false,
            planes: Some(Planes { occupied, free: BitGrid::nowhere(), hits: BitGrid::nowhere() }),
        }]
    }

    fn reach(&self, at: &Station) -> Extent {
        Extent::Only(known(at.truth))
    }
}
