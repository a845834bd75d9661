//! A light curtain: its zone counts as occupied while something is in the gate.

use super::prism::Prism;
use super::{Claim, Kind, Reach, SWITCHES, Setting, Stance, Station, switched};

/// The gate's box and the zone behind it, both in the gate's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Gate {
    /// Where it senses.
    pub gate: Prism,
    /// What it speaks of.
    pub zone: Prism,
    /// Whether an uninterrupted curtain certifies that the zone is free.
    pub otherwise_free: bool,
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

    fn check(&self, at: &Station) -> Result<(), String> {
        self.gate.check(&at.pose(), &at.truth.grid).map_err(|e| format!("box: {e}"))?;
        self.zone.check(&at.pose(), &at.truth.grid).map_err(|e| format!("zone: {e}"))
    }

    fn claim(&self, _: usize, at: &Station) -> Claim {
        let (pose, grid) = (at.pose(), &at.truth.grid);
        let mut inside = self.gate.cells(&pose, grid, grid.window());
        inside.keep(&at.truth.occupied);
        switched(self.zone.cells(&pose, grid, at.window), !inside.is_empty(), self.otherwise_free)
    }

    fn reach(&self, at: &Station) -> Reach {
        Reach::Only(self.zone.cells(&at.pose(), &at.truth.grid, at.truth.grid.window()))
    }
}
