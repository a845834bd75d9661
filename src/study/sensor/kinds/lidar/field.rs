//! A protective field, by which a scanner is a switch.

use glam::DVec2;
use serde::Deserialize;

use super::Lidar;
use crate::diagnostics::Place;
use crate::sensor::Station;
use crate::sensor::kinds::shared::{Silence, length};
use crate::sensor::prism::Prism;
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;
use perirobot_march::voxel::solid::is_simple;

/// Most corners of a field; scanners allow some dozens.
const MAX_CORNERS: usize = 1000;

/// A protective field.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct FieldFile {
    /// Corners [x, y] in metres, x ahead and y left; its sides must not cross.
    polygon_m: Vec<[f64; 2]>,
    /// Height of the volume above it, in metres.
    height_m: f64,
    /// What a field without returns says about its volume. Default "free".
    otherwise: Option<Silence>,
}

/// A protective field: the volume above a polygon in the scanner's frame (x is azimuth 0), from the layer of voxels that
/// the scanner is in up, so that what its level rays meet lies inside wherever in a voxel they run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ProtectiveField {
    /// Where it is.
    pub(crate) volume: Prism,
    /// Whether it is certified free while no return lies in it.
    pub(crate) otherwise_free: bool,
}

impl FieldFile {
    pub(super) fn check(self, at: &Place) -> Result<ProtectiveField> {
        let height_m = length(at, "height_m", self.height_m)?;
        let corners = self.polygon_m.len();
        if corners > MAX_CORNERS {
            return Err(at.wrong(
                "polygon_m",
                format!("({corners} corners)"),
                &format!("must have at most {MAX_CORNERS}"),
            ));
        }
        let reach = "must be [x, y] in metres within 1000 of the scanner";
        if let Some(corner) = self.polygon_m.iter().flatten().find(|value| !(-1e3..=1e3).contains(*value)) {
            return Err(at.wrong("polygon_m", corner, reach));
        }
        // Sides are tested in hundredths of a millimetre, independent of the voxel size.
        let fine = |value: f64| (value * 1e5).round() as i64;
        let corners: Vec<_> = self.polygon_m.iter().map(|corner| corner.map(fine)).collect();
        is_simple(&corners).map_err(|e| at.wrap(Issue::says(e.to_string()).with_place("polygon_m")))?;
        let polygon_m = self.polygon_m.into_iter().map(DVec2::from_array).collect();
        let volume = Prism { polygon_m, z_m: [0.0, height_m] };
        Ok(ProtectiveField { volume, otherwise_free: self.otherwise != Some(Silence::Unknown) })
    }
}

impl ProtectiveField {
    /// The voxels that it guards, over the part of the grid that holds them.
    pub(super) fn voxels(&self, lidar: &Lidar, at: &Station) -> BitGrid {
        let (pose, grid) = (at.pose(), &at.truth.grid);
        let own = grid.position_q16(pose.position_m)[2] >> 16;
        let scanner = lidar.scanner(&pose);
        self.volume.layers(&scanner, grid, grid.window(), self.volume.layers_above(&scanner, grid, own))
    }
}
