//! A pressure pad: the column above it counts as occupied while something stands on it.

use glam::DVec3;
use serde::Deserialize;

use super::shared::{Silence, length};
use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{EvidenceWords, Page};
use crate::diagnostics::Place;
use crate::keys::exactly;
use crate::sensor::prism::Prism;
use crate::sensor::{Approached, Claim, Extent, Kind, SWITCHES, Stance, Station, level, switch_planes};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;

/// The height of the column that a pad labels: a person with an arm raised.
const HEIGHT_M: f64 = 2.2;

/// A pressure pad.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct PadFile {
    /// Along and across where it faces, in metres.
    #[serde(deserialize_with = "exactly")]
    size_m: [f64; 2],
    /// Height of the column above it that it labels, in metres. Default 2.2.
    height_m: Option<f64>,
    /// Whether objects that always stand on it were zeroed at set-up. Default true.
    tare: Option<bool>,
    /// What an idle pad says about the column. Default "free".
    otherwise: Option<Silence>,
}

impl KindFile for PadFile {
    const NAME: &'static str = "pad";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "pressure pad; its pose is the corner of lowest x and y",
        keys: "`size_m`, `height_m?` (2.2), `tare?` (true: it feels only people and robots), `otherwise?` (free)",
        evidence: &[EvidenceWords {
            says: "",
            occupied: "its column, if the truth has an occupied voxel in the column's first layer",
            free: "else the column, unless `otherwise = \"unknown\"`",
        }],
    };

    fn check(self, at: &Place, _: &Context) -> Result<Checked> {
        let [width_m, depth_m] = self.size_m;
        for size_m in self.size_m {
            length(at, "size_m", size_m)?;
        }
        let height_m = length(at, "height_m", self.height_m.unwrap_or(HEIGHT_M))?;
        Ok(Pad {
            column: Prism::from_corners(DVec3::ZERO, DVec3::new(width_m, depth_m, height_m)),
            tare: self.tare.unwrap_or(true),
            otherwise_free: self.otherwise != Some(Silence::Unknown),
        }
        .into())
    }
}

/// A pad's size and what it makes of pressure. Its pose is its corner of lowest x and y, seen with its
/// heading as x.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pad {
    /// Its rectangle, and the column from its own height up.
    pub(crate) column: Prism,
    /// Whether what always stands there (the environment) was zeroed at set-up.
    pub(crate) tare: bool,
    /// Whether no pressure certifies that the column is free.
    pub(crate) otherwise_free: bool,
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
        PadFile::NAME
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["volume"]
    }

    fn stance(&self) -> Stance {
        Stance::Level
    }

    fn approached(&self) -> Option<Approached> {
        Some(Approached::OnFloor)
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
            .with_advice("move it (its pose is the corner of lowest x and y), or make it smaller"));
        }
        if self.column(&at.everywhere(), true).is_empty() {
            return Err(Issue::says("has no layer of voxels above it in the grid")
                .with_advice("put it on the floor, and height_m above a voxel"));
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
        vec![switch_planes(at, self.column(at, false), on, self.otherwise_free, pressing)]
    }

    fn feels(&self, at: &Station) -> Extent {
        Extent::Only(self.column(&at.everywhere(), true))
    }

    fn reach(&self, at: &Station) -> Extent {
        Extent::Only(self.column(&at.everywhere(), false))
    }
}
