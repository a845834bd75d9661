//! The keys of a sensor whose rays stand in a table, and the table.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;

use super::range::{CalibrationFile, NoiseFile, RangeKeys};
use super::{MAX_RAYS, Silence};
use crate::diagnostics::Place;
use crate::keys::exactly;
use crate::sensor::quantise_q15;
use crate::sensor::ray_set::RaySet;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::source::{Sources, decimal_commas, refuse_other_separators, refuse_width, table_issue};

/// Rays in given directions.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct RaysFile {
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
    /// How far its mount may be off, drawn anew in each repeat. Default not at all.
    calibration: Option<CalibrationFile>,
}

pub(super) fn check(at: &Place, file: RaysFile, noiseless: bool, sources: &Sources) -> Result<RaySet> {
    let range = RangeKeys {
        range_m: file.range_m,
        along: None,
        near_ignore_m: file.near_ignore_m,
        no_return: file.no_return,
        noise: file.noise,
        dropout: file.dropout,
        calibration: file.calibration,
    };
    let path = at.folder().join(file.directions);
    let dirs_q15 = directions(&path, sources).map_err(|e| at.around(e.at("directions")))?;
    Ok(RaySet { dirs_q15, range: range.check(at, noiseless)? })
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
    let unfit = |issue: Issue| Error::from(issue.cure(columns).at(path));
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
        let in_row = |issue: Issue| unfit(issue.at(format!("row {}", row + 1)));
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
