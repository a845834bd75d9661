//! Fields from the configurations of PSENscan safety laser scanners.

use std::path::PathBuf;

use glam::DVec2;
use serde::Deserialize;

use super::field::{Outline, bound_area};
use crate::diagnostics::Place;
use crate::sensor::contour::SHORTEST_M;
use perirobot_march::Result;
use perirobot_scene::psenscan::{ZoneChoice, read_zone};
use perirobot_scene::source::Sources;

/// The zone that an output of a PSENscan stops a machine by.
const USUAL_ZONE: &str = "roOSSD1";
/// Speeds of a file and of a study may differ by so many centimetres a second: the ranges of a file have gaps of one.
const GAP_CM_S: i64 = 1;

/// A zone of a PSENscan.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct ZoneFile {
    /// The XML that the PSENscan Configurator exports.
    file: PathBuf,
    /// The zone set, counted from 1.
    zone_set: usize,
    /// Its zone: "roOSSD1" to "roOSSD3" (safety zones), "warn1" or "warn2". Default "roOSSD1".
    zone: Option<String>,
    /// The scanner of a cluster, counted from 1, the master first; needed if there are several.
    scanner: Option<usize>,
}

impl ZoneFile {
    /// The polygon through the ends of its rays. Where it has no zone between others it ends at the housing.
    pub(super) fn outline(self, at: &Place, sources: &Sources) -> Result<Outline> {
        let path = at.folder().join(self.file);
        let zone = self.zone.unwrap_or_else(|| USUAL_ZONE.into());
        let choice = ZoneChoice { zone_set: self.zone_set, zone, scanner: self.scanner };
        let zone = read_zone(&path, &choice, sources).map_err(|e| at.wrap(e))?;
        let is_there = |(_, mm): &(f64, u32)| *mm > 0;
        let first = zone.reaches.iter().position(is_there);
        let last = zone.reaches.iter().rposition(is_there);
        let Some((first, last)) = first.zip(last) else {
            let what = format!("zone set {} has an empty zone {:?}", choice.zone_set, choice.zone);
            return Err(at.says(what).with_advice("choose another zone or zone set"));
        };
        let corner = |&(azimuth_deg, mm): &(f64, u32)| {
            let (sin, cos) = libm::sincos(azimuth_deg.to_radians());
            let reach_m = (f64::from(mm) / 1e3).max(SHORTEST_M);
            [cos * reach_m, sin * reach_m]
        };
        let corners: Vec<[f64; 2]> =
            zone.reaches[first..=last].iter().map(corner).chain([[0.0; 2]]).collect();
        bound_area(&corners).map_err(|issue| at.wrap(issue.with_place(path)))?;
        let polygon_m = corners.into_iter().map(DVec2::from_array).collect();
        Ok(Outline { polygon_m, speeds_cm_s: zone.speeds_cm_s })
    }
}

/// That a study has a field for other speeds than the scanner's file, which has a direction.
pub(super) fn speed_warning(study_m_s: [f64; 2], file_cm_s: [i64; 2]) -> Option<String> {
    let [low, high] = file_cm_s;
    let (a, b) = (low.saturating_abs(), high.saturating_abs());
    let file = [if low <= 0 && high >= 0 { 0 } else { a.min(b) }, a.max(b)];
    let study = study_m_s.map(|speed| (speed * 100.0).round() as i64);
    let differs = (0..2).any(|end| (file[end] - study[end]).abs() > GAP_CM_S);
    differs.then(|| {
        let [from, to] = study_m_s;
        format!("speed_m_s = [{from}, {to}], but its file has this zone set for {low} to {high} cm/s: correct one of them")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_those_of_the_file() {
        for (study, file, is_same) in [
            ([0.0, 0.1], [-10, 10], true),
            ([0.1, 0.5], [11, 50], true),
            ([0.11, 0.5], [11, 50], true),
            ([0.2, 0.5], [-50, -20], true),
            ([0.0, 0.5], [-50, 20], true),
            ([0.0, 0.2], [-50, 20], false),
            ([0.2, 0.5], [11, 50], false),
            ([0.11, 0.6], [11, 50], false),
        ] {
            assert_eq!(speed_warning(study, file).is_none(), is_same, "{study:?} {file:?}");
        }
    }
}
