//! A protective field, by which a scanner is a switch.

use std::path::{Path, PathBuf};

use glam::DVec2;
use serde::Deserialize;

use super::Lidar;
use super::corners::read_corners;
use super::zone::ZoneFile;
use crate::diagnostics::{Place, only_one};
use crate::sensor::Station;
use crate::sensor::kinds::shared::{Silence, length};
use crate::sensor::prism::Prism;
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;
use perirobot_march::voxel::solid::is_simple;
use perirobot_scene::source::Sources;

/// Most corners of a field; scanners allow some dozens.
pub(crate) const MAX_CORNERS: usize = 1000;
/// The farthest coordinate of a corner, in metres.
pub(crate) const FARTHEST_M: f64 = 1e3;

/// A protective field.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct FieldFile {
    /// Corners [x, y] in metres, x ahead and y left; its sides must not cross.
    polygon_m: Option<Vec<[f64; 2]>>,
    /// Instead of polygon_m: a table of corners with the columns x_m,y_m, as `perirobot field` writes it.
    polygon: Option<PathBuf>,
    /// Instead of polygon_m: a zone of a PSENscan by Pilz.
    psenscan: Option<ZoneFile>,
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
    pub(super) fn check(self, at: &Place, sources: &Sources) -> Result<ProtectiveField> {
        let height_m = length(at, "height_m", self.height_m)?;
        let Outline { polygon_m, .. } = outline(at, self.polygon_m, self.polygon, self.psenscan, sources)?;
        let volume = Prism { polygon_m, z_m: [0.0, height_m] };
        Ok(ProtectiveField { volume, otherwise_free: self.otherwise != Some(Silence::Unknown) })
    }
}

/// The corners of a field, and the speeds for which it is, if its file says so.
pub(super) struct Outline {
    /// Its corners.
    pub(super) polygon_m: Vec<DVec2>,
    /// The lowest and highest speed in centimetres a second; backwards is negative.
    pub(super) speeds_cm_s: Option<[i64; 2]>,
}

/// The corners of a field, written in the study, in a table or in the configuration of a scanner.
pub(super) fn outline(
    at: &Place,
    inline: Option<Vec<[f64; 2]>>,
    table: Option<PathBuf>,
    zone: Option<ZoneFile>,
    sources: &Sources,
) -> Result<Outline> {
    let choices = vec![
        ("polygon_m", inline.map(CornerSource::Inline)),
        ("polygon", table.map(|path| CornerSource::Table(at.folder().join(path)))),
        ("psenscan", zone.map(CornerSource::Zone)),
    ];
    let polygon_m = match only_one(at, "polygon", choices)? {
        CornerSource::Zone(zone) => return zone.outline(&at.key("psenscan"), sources),
        CornerSource::Inline(corners) => inline_corners(at, corners)?,
        CornerSource::Table(path) => {
            table_corners(&path, sources).map_err(|e| at.wrap(e.with_place("polygon")))?
        }
    };
    Ok(Outline { polygon_m, speeds_cm_s: None })
}

/// Where the corners of a field are written.
enum CornerSource {
    /// In the study.
    Inline(Vec<[f64; 2]>),
    /// In a table.
    Table(PathBuf),
    /// In the configuration of a scanner.
    Zone(ZoneFile),
}

fn inline_corners(at: &Place, corners: Vec<[f64; 2]>) -> Result<Vec<DVec2>> {
    if corners.len() > MAX_CORNERS {
        let count = format!("({} corners)", corners.len());
        return Err(at.wrong("polygon_m", count, &format!("must have at most {MAX_CORNERS}")));
    }
    let reach = "must be [x, y] in metres within 1000 of the scanner";
    if let Some(corner) = corners.iter().flatten().find(|value| !is_near(value)) {
        return Err(at.wrong("polygon_m", corner, reach));
    }
    bound_area(&corners).map_err(|issue| at.wrap(issue.with_place("polygon_m")))?;
    Ok(corners.into_iter().map(DVec2::from_array).collect())
}

fn table_corners(path: &Path, sources: &Sources) -> Result<Vec<DVec2>> {
    let corners = read_corners(path, sources)?;
    bound_area(&corners).map_err(|issue| issue.with_place(path))?;
    Ok(corners.into_iter().map(DVec2::from_array).collect())
}

/// Whether a coordinate is one of a field's corner.
pub(super) fn is_near(value: &f64) -> bool {
    (-FARTHEST_M..=FARTHEST_M).contains(value)
}

/// Checks that corners bound one area.
///
/// # Errors
/// With the sides that meet, or the number of corners.
pub(crate) fn bound_area(corners_m: &[[f64; 2]]) -> Result<(), Issue> {
    // Sides are tested in hundredths of a millimetre, independent of the voxel size.
    let fine = |value: f64| (value * 1e5).round() as i64;
    let corners: Vec<_> = corners_m.iter().map(|corner| corner.map(fine)).collect();
    is_simple(&corners).map_err(|e| Issue::says(e.to_string()))
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
