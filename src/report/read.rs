//! The folder of a sweep read back, strictly: whatever is missing or does not fit together is an error that says where.
//! What the files mean is `results`' business.

mod csv_rows;
mod manifest;

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::results::{Choice, CombinationResults, Results, only};
use crate::metrics::{COUNTERS, Confusion};
use crate::sweep::table::{BETWEEN_MEMBERS, COUNT_COLUMNS};
use crate::{Error, Result};
use csv_rows::{CsvRow, CsvRows};

/// What mends a folder that does not fit together.
const CURE: &str = "leave the files as the sweep wrote them, or sweep again";

/// No grid has more voxels, and sums of such numbers still fit.
const MOST_VOXELS: u64 = 1 << 32;

/// Columns of results.csv that say what a row is about.
const NAME_COLUMNS: [&str; 7] =
    ["scene", "snapshot", "repeat", "combination", "poses", "representation", "region"];

impl Results {
    /// Reads the folder that a sweep wrote: manifest.json, poses.csv and results.csv. With the results come warnings
    /// about what was made differently. Errors name file, line and column.
    pub fn read(folder: &Path) -> Result<(Results, Vec<String>)> {
        if !folder.is_dir() {
            let what = "is not a folder: name one that `perirobot sweep --out` has written";
            return Err(Error::input(folder.display(), what));
        }
        let (mut results, promised, warnings) = manifest::read(&folder.join("manifest.json"))?;
        let poses = poses(&folder.join("poses.csv"))?;
        let path = folder.join("results.csv");
        let columns: Vec<&str> = NAME_COLUMNS.into_iter().chain(COUNT_COLUMNS).collect();
        let mut rows = CsvRows::open(&path, &columns)?;
        for moment in results.moments() {
            for repeat in 0..results.repeats {
                for combination in 0..promised.len() {
                    for choice in 0..promised[combination] {
                        if results.combinations[combination].choices.len() == choice {
                            let name = rows.next()?.text(4).to_string();
                            let known = &results.combinations[combination];
                            let new = new_choice(known, name, &poses).map_err(|e| rows.wrong(4, &e))?;
                            results.combinations[combination].choices.push(new);
                            rows.again();
                        }
                        choice_rows(&mut results, &mut rows, [moment, repeat, combination, choice])?;
                    }
                }
            }
        }
        rows.end()?;
        Ok((results, warnings))
    }
}

/// The rows of one choice: each representation, each region.
fn choice_rows(
    results: &mut Results,
    rows: &mut CsvRows,
    [moment, repeat, combination, choice]: [usize; 4],
) -> Result<()> {
    let known = &results.combinations[combination];
    let scene = results.scenes.iter().find(|scene| scene.moments.contains(&moment));
    let scene = scene.expect("every moment belongs to a scene");
    let snapshot = (moment - scene.moments.start).to_string();
    let repeat = repeat.to_string();
    for representation in &known.representations {
        for (r, region) in results.regions.iter().enumerate() {
            let name = &known.choices[choice].name;
            let expected: [&str; NAME_COLUMNS.len()] =
                [&scene.name, &snapshot, &repeat, &known.name, name, representation, region];
            let row = rows.next()?;
            for (column, expected) in expected.into_iter().enumerate() {
                if row.text(column) != expected {
                    let what = format!("must be {expected:?}: rows stand in the order of the sweep");
                    return Err(row.wrong(column, &what));
                }
            }
            let counts = counts(&row)?;
            let voxels = results.baselines[moment][r].nothing_seen.total();
            if counts.total() != voxels {
                let what =
                    format!("tp to uf are {} together, the region has {voxels} voxels", counts.total());
                return Err(row.wrong(NAME_COLUMNS.len(), &what));
            }
            results.counts.push(counts);
        }
    }
    Ok(())
}

fn counts(row: &CsvRow) -> Result<Confusion> {
    let mut counts = [0; COUNTERS];
    for (i, count) in counts.iter_mut().enumerate() {
        let column = NAME_COLUMNS.len() + i;
        let number = row.text(column).parse().ok().filter(|n| *n <= MOST_VOXELS);
        *count = number.ok_or_else(|| row.wrong(column, "must be a number of voxels"))?;
    }
    Ok(Confusion::from_counts(counts))
}

/// Group and position of each pose, by sensor and pose; `None` for what is set up without one.
type Poses = HashMap<String, HashMap<String, Option<(String, DVec3)>>>;

fn poses(path: &Path) -> Result<Poses> {
    let mut rows = CsvRows::open(path, &["sensor", "pose", "group", "x_m", "y_m", "z_m"])?;
    let mut poses = Poses::new();
    while let Some(row) = rows.next_if_any()? {
        let coordinate = |column: usize| {
            let value = row.text(column).parse().ok().filter(|v: &f64| v.is_finite());
            value.ok_or_else(|| row.wrong(column, "must be a number of metres, or x_m, y_m, z_m all empty"))
        };
        let place = match (3..6).all(|column| row.text(column).is_empty()) {
            true => None,
            false => {
                let at = DVec3::new(coordinate(3)?, coordinate(4)?, coordinate(5)?);
                Some((row.text(2).to_string(), at))
            }
        };
        let of_sensor = poses.entry(row.text(0).to_string()).or_default();
        if of_sensor.insert(row.text(1).to_string(), place).is_some() {
            return Err(row.wrong(1, "stands twice for this sensor"));
        }
    }
    Ok(poses)
}

/// A choice by its name, as in `camera:wall/1;pads:floor/0`.
fn new_choice(combination: &CombinationResults, name: String, poses: &Poses) -> Result<Choice, String> {
    let mut places = Vec::new();
    let mut left = name.as_str();
    for (i, sensor) in combination.sensors.iter().enumerate() {
        let known = poses.get(sensor).ok_or_else(|| format!("poses.csv has no pose of sensor {sensor:?}"))?;
        left = left
            .strip_prefix(sensor.as_str())
            .and_then(|rest| rest.strip_prefix(':'))
            .ok_or_else(|| format!("must name a pose of sensor {sensor:?}, as in {sensor}:wall/1"))?;
        let end = match combination.sensors.get(i + 1) {
            None => Some(left.len()),
            // A pose may have such text in its name, so the one that exists decides.
            Some(next) => left
                .match_indices(&format!("{BETWEEN_MEMBERS}{next}:"))
                .map(|(at, _)| at)
                .find(|&at| known.contains_key(&left[..at])),
        };
        let place = end.and_then(|end| known.get(&left[..end]));
        let place = place.ok_or_else(|| format!("names a pose of sensor {sensor:?} that poses.csv lacks"))?;
        places.extend(place);
        left = left[end.unwrap_or(left.len())..].trim_start_matches(BETWEEN_MEMBERS);
    }
    let place = only(places.into_iter().map(|(group, at)| (group.as_str(), *at)));
    Ok(Choice { name, place })
}
