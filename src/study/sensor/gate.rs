//! A light curtain: its zone counts as occupied while something is in the gate.

use super::prism::Prism;
use super::{Claim, Extent, Kind, SWITCHES, Setting, Stance, Station, level, switched};
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;

/// The gate's box and the zone behind it, both in the gate's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Gate {
    /// Where it senses.
    pub gate: Prism,
    /// The zone that it labels.
    pub zone: Prism,
    /// Whether an uninterrupted curtain certifies that the zone is free.
    pub otherwise_free: bool,
}

impl Gate {
    /// What stands in the gate.
    fn inside(&self, at: &Station) -> BitGrid {
        let mut inside = self.gate.voxels(&at.pose(), &at.truth.grid, at.truth.grid.window());
        inside.keep(&at.truth.occupied);
        inside
    }
}

impl Kind for Gate {
    fn name(&self) -> &'static str {
        "gate"
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["volume"]
    }

    fn stance(&self) -> Stance {
        Stance::Level
    }

    fn settings(&self) -> Vec<(String, Setting)> {
        // Its box and zone are then the world's, or its link's.
        vec![("here".into(), Setting::Fixed)]
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        SWITCHES
    }

    fn feels_presence(&self, _: usize) -> bool {
        true
    }

    fn prisms(&self) -> Vec<&Prism> {
        vec![&self.gate, &self.zone]
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        level(at)?;
        self.gate.check(&at.pose(), &at.truth.grid).map_err(|e| e.at("box"))?;
        self.zone.check(&at.pose(), &at.truth.grid).map_err(|e| e.at("zone"))
    }

    fn stuck_by(&self, at: &Station) -> BitGrid {
        let mut fixed = self.inside(at);
        fixed.remove(&at.truth.human);
        fixed.remove(&at.truth.robot);
        fixed
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let (pose, grid) = (at.pose(), &at.truth.grid);
        let mut inside = self.inside(at);
        let on = !inside.is_empty();
        inside.keep(&at.truth.human);
        vec![switched(at, self.zone.voxels(&pose, grid, at.window), on, self.otherwise_free, inside)]
    }

    fn feels(&self, at: &Station) -> Extent {
        Extent::Only(self.gate.voxels(&at.pose(), &at.truth.grid, at.truth.grid.window()))
    }

    fn reach(&self, at: &Station) -> Extent {
        Extent::Only(self.zone.voxels(&at.pose(), &at.truth.grid, at.truth.grid.window()))
    }
}
