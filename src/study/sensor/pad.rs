//! A pressure pad: the column above it counts as occupied while something stands on it.

use super::prism::Prism;
use super::{Claim, Extent, Kind, SWITCHES, Stance, Station, level, switched};
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;

/// A pad's size and what it makes of pressure. Its pose is its corner of lowest x and y, seen with its
/// heading as x.
#[derive(Clone, Debug, PartialEq)]
pub struct Pad {
    /// Its rectangle, and the column from its own height up.
    pub column: Prism,
    /// Whether what always stands there (the environment) was zeroed at set-up.
    pub tare: bool,
    /// Whether no pressure certifies that the column is free.
    pub otherwise_free: bool,
}

impl Pad {
    /// The column over the layers from the one above the pad's own; `only_first` for that layer alone.
    fn column(&self, at: &Station, only_first: bool) -> BitGrid {
        let (pose, grid) = (at.pose(), &at.truth.grid);
        let first = (grid.position_q16(pose.position_m)[2] >> 16) + 1;
        let whole = self.column.layers_above(&pose, grid, first);
        let layers = if only_first { first..(first + 1).min(whole.end) } else { whole };
        self.column.layers(&pose, grid, at.window, layers)
    }
}

impl Kind for Pad {
    fn name(&self) -> &'static str {
        "pad"
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["volume"]
    }

    fn stance(&self) -> Stance {
        Stance::Level
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        SWITCHES
    }

    fn feels_presence(&self, _: usize) -> bool {
        true
    }

    fn prisms(&self) -> Vec<&Prism> {
        vec![&self.column]
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        level(at)?;
        let (pose, grid) = (at.pose(), &at.truth.grid);
        if !self.column.is_over(&pose, grid) {
            let (low, high) = (grid.corner_m([0; 3]), grid.corner_m(grid.window().end()));
            return Err(Issue::says(format!(
                "lies partly outside the floor, x {:.2} to {:.2} m and y {:.2} to {:.2} m",
                low.x, high.x, low.y, high.y
            ))
            .wanted("move it (its pose is the corner of lowest x and y), or make it smaller"));
        }
        if self.column(&at.everywhere(), true).is_empty() {
            return Err(Issue::says("has no layer of voxels above it in the grid")
                .wanted("put it on the floor, and height_m above a voxel"));
        }
        Ok(())
    }

    fn stuck_by(&self, at: &Station) -> BitGrid {
        if self.tare {
            return BitGrid::nowhere();
        }
        let mut fixed = self.column(&at.everywhere(), true);
        fixed.keep(&at.truth.occupied);
        fixed.remove(&at.truth.human);
        fixed.remove(&at.truth.robot);
        fixed
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let mut pressing = self.column(&at.everywhere(), true);
        pressing.keep(&at.truth.occupied);
        let on = match self.tare {
            true => pressing.intersects(&at.truth.human) || pressing.intersects(&at.truth.robot),
            false => !pressing.is_empty(),
        };
        pressing.keep(&at.truth.human);
        vec![switched(at, self.column(at, false), on, self.otherwise_free, pressing)]
    }

    fn feels(&self, at: &Station) -> Extent {
        Extent::Only(self.column(&at.everywhere(), true))
    }

    fn reach(&self, at: &Station) -> Extent {
        Extent::Only(self.column(&at.everywhere(), false))
    }
}
