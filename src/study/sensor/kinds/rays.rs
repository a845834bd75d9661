//! Rays in directions of the user's own: a ring of time-of-flight sensors on a robot's arm, say.

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};
use serde::Deserialize;
use toml::Table;

use super::shared::Silence;
use super::shared::range::{CalibrationFile, NoiseFile, RangeKeys, refuse_former};
use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{POINTS, Page};
use crate::diagnostics::Place;
use crate::keys::exactly;
use crate::sensor::range::Range;
use crate::sensor::{Approached, Claim, Kind, MAX_RAYS, MEASURES, RayScale, Station, quantise_q15};
use perirobot_march::backend::Rays;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::pose::Pose;
use perirobot_scene::source::{Sources, decimal_commas, refuse_other_separators, refuse_width, table_issue};

/// Rays in given directions.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct RaysFile {
    /// A table with the columns x,y,z.
    directions: PathBuf,
    /// Nearest and farthest distance that it measures, in metres.
    #[serde(deserialize_with = "exactly")]
    range_m: [f64; 2],
    /// Hits nearer than this are its own housing, in metres. Default 0.
    near_ignore_m: Option<f64>,
    /// What a ray that hits nothing says about the voxels that it passed. Default "unknown".
    no_return: Option<Silence>,
    /// Noise of measured distances. Default none.
    noise: Option<NoiseFile>,
    /// Share of returns that is lost, from 0 to below 1. Default 0.
    dropout: Option<f64>,
    /// How far it detects what reflects a share of its light, as [[0.1, 8], [0.9, 25]] for 8 m at 10 % and 25 m at 90 %; one to
    /// three pairs. Default: everything up to the longest range.
    reflectance_ranges_m: Option<Vec<[f64; 2]>>,
    /// How far its mount may be off, drawn anew in each repeat. Default not at all.
    calibration: Option<CalibrationFile>,
}

impl KindFile for RaysFile {
    const NAME: &'static str = "rays";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "any set of rays, for example a ring of time-of-flight sensors",
        keys: "`directions` (a CSV with columns x, y, z in the sensor's link frame: x forward, y left, z up), \
        `range_m`",
        evidence: &[POINTS],
    };

    fn prepare(at: &Place, keys: &mut Table, _: &Sources) -> Result<Vec<String>> {
        refuse_former(at, keys)?;
        Ok(Vec::new())
    }

    fn check(self, at: &Place, context: &Context) -> Result<Checked> {
        let range = RangeKeys {
            range_m: self.range_m,
            along: None,
            near_ignore_m: self.near_ignore_m,
            no_return: self.no_return,
            noise: self.noise,
            dropout: self.dropout,
            calibration: self.calibration,
            reflectance_ranges_m: self.reflectance_ranges_m,
        };
        let path = at.folder().join(self.directions);
        let dirs_q15 = directions(&path, context.sources).map_err(|e| at.wrap(e.with_place("directions")))?;
        Ok(RaySet { dirs_q15, range: range.check(at, context.noiseless)? }.into())
    }
}

#[derive(Deserialize)]
struct RayRow {
    x: f64,
    y: f64,
    z: f64,
}

/// Directions from a table with the header x,y,z, in the link frame; their lengths do not matter.
fn directions(path: &Path, sources: &Sources) -> Result<Vec<[i32; 3]>> {
    let text = sources.table(path)?;
    let columns = "the columns are x,y,z: a direction in the sensor's frame, x forward, y left, z up";
    let unfit = |issue: Issue| Error::from(issue.cure(columns).with_place(path));
    refuse_other_separators(&text).map_err(unfit)?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let damaged = |e: csv::Error| unfit(table_issue(&e));
    let header = reader.headers().map_err(damaged)?.clone();
    let mut dirs_q15 = Vec::new();
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(damaged)?;
        let in_row = |issue: Issue| unfit(issue.with_place(format!("row {}", row + 1)));
        refuse_width(record.iter(), header.len()).map_err(in_row)?;
        let RayRow { x, y, z } = record.deserialize(Some(&header)).map_err(|e| {
            in_row(match decimal_commas(record.iter(), header.len()) {
                Some(cause) => Issue::says(cause),
                None => Issue { sites: Vec::new(), ..table_issue(&e) },
            })
        })?;
        let length = DVec3::new(x, y, z).length();
        if !(length.is_finite() && length > 1e-9) {
            let what = format!("row {}: {x},{y},{z}: must be a direction, finite and not zero", row + 1);
            return Err(Error::input(path, what));
        }
        dirs_q15.push([x, y, z].map(|v| quantise_q15(v / length)));
    }
    if dirs_q15.is_empty() || dirs_q15.len() > MAX_RAYS {
        let what = format!("holds {} rays: from 1 to {MAX_RAYS} are possible; {columns}", dirs_q15.len());
        return Err(Error::input(path, what));
    }
    Ok(dirs_q15)
}

/// Directions in the sensor's link frame (x forward, y left, z up).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RaySet {
    /// Unit directions, Q15, in the table's order.
    pub(crate) dirs_q15: Vec<[i32; 3]>,
    /// What it measures.
    pub(crate) range: Range,
}

impl Kind for RaySet {
    fn name(&self) -> &'static str {
        RaysFile::NAME
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["points"]
    }

    fn rays(&self, scale: &RayScale) -> Option<Rays> {
        Some(self.range.rays(self.dirs_q15.clone(), scale))
    }

    fn frame(&self, pose: &Pose) -> DMat3 {
        pose.link()
    }

    fn range(&self) -> Option<&Range> {
        Some(&self.range)
    }

    fn approached(&self) -> Option<Approached> {
        Some(Approached::AlongRays)
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
