//! The robot's controller as a sensor: it knows where the robot is, and nothing else.

use serde::Deserialize;

use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{EvidenceWords, Page};
use crate::diagnostics::Place;
use crate::sensor::{Approached, Claim, Extent, Kind, Setting, Station};
use perirobot_march::Result;
use perirobot_march::backend::Planes;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::truth::Truth;

/// A kind without keys of its own.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct KnownRobotFile {}

impl KindFile for KnownRobotFile {
    const NAME: &'static str = "known_robot";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "the robot, as its controller knows it by the joint angles",
        keys: "",
        evidence: &[EvidenceWords {
            says: "",
            occupied: "the robot's voxels, surface and inside, except where the truth is free: with \
        `interior = \"free\"` (or a leak) the inside stays unknown, where it would be a false alarm",
            free: "nothing",
        }],
    };

    fn check(self, _: &Place, _: &Context) -> Result<Checked> {
        Ok(KnownRobot.into())
    }
}

/// The robot's voxels, surface and inside, except those that the truth calls free: they stay without a label,
/// since in a scene with `interior = "free"` they would count as false alarms.
fn robot_voxels(truth: &Truth) -> BitGrid {
    let window = truth.robot_volume.window();
    let mut solid = truth.occupied.to_window(window);
    solid.add(&truth.ignored.to_window(window));
    solid.keep(&truth.robot_volume);
    solid
}

/// The robot's own pose, taken for certain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct KnownRobot;

impl Kind for KnownRobot {
    fn name(&self) -> &'static str {
        KnownRobotFile::NAME
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

    fn approached(&self) -> Option<Approached> {
        None
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
        let robot = robot_voxels(at.truth);
        let occupied = robot.to_window(robot.window().intersection(&at.window));
        vec![Claim {
            cast: false,
            planes: Some(Planes { occupied, free: BitGrid::nowhere(), hits: BitGrid::nowhere() }),
        }]
    }

    fn reach(&self, at: &Station) -> Extent {
        Extent::Only(robot_voxels(at.truth))
    }
}
