//! The rows of a sweep as columns for Python: numbers as numpy arrays, names as numbers into lists of them, since
//! there are many rows and few names.

use std::collections::HashMap;

use numpy::IntoPyArray;
use perirobot::Study;
use perirobot::results::columns::{
    COUNT_COLUMNS, DETECTION_COLUMNS, MISSED_COLUMN, pose_names, representation_names,
};
use perirobot::results::rows::scores;
use perirobot::sweep::Row;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The columns of `results.csv`, in its order: int64 and float64 arrays (NaN where a score has no value), and pairs of
/// int32 numbers and the list of names that they count through.
pub(crate) fn columns<'py>(py: Python<'py>, study: &Study, rows: &[Row]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let numbers = |name: &str, number: &dyn Fn(&Row) -> u64| {
        let all: Vec<i64> = rows.iter().map(|row| number(row) as i64).collect();
        columns.set_item(name, all.into_pyarray(py))
    };
    let named = |name: &str, names: Names, number: &dyn Fn(&Row) -> usize| {
        let all: Vec<i32> = rows.iter().map(|row| names.of[number(row)]).collect();
        columns.set_item(name, (all.into_pyarray(py), names.all))
    };
    let combinations = &study.combinations;
    named("scene", Names::of(study.scenes.iter().map(|scene| scene.name.clone())), &|row| row.scene)?;
    numbers("snapshot", &|row| row.snapshot as u64)?;
    numbers("repeat", &|row| row.repeat as u64)?;
    let names = combinations.iter().map(|combination| combination.name.clone());
    named("combination", Names::of(names), &|row| row.combination)?;
    let choices = before(combinations.iter().map(|combination| combination.choices()));
    let names = combinations.iter().flat_map(|combination| {
        (0..combination.choices()).map(|choice| pose_names(study, combination, choice))
    });
    named("poses", Names::of(names), &|row| choices[row.combination] + row.choice)?;
    let ways: Vec<Vec<String>> = combinations.iter().map(|c| representation_names(study, c)).collect();
    let firsts = before(ways.iter().map(Vec::len));
    let names = ways.into_iter().flatten();
    named("representation", Names::of(names), &|row| firsts[row.combination] + row.representation)?;
    let names = study.regions.iter().map(|(name, _)| name.clone());
    named("region", Names::of(names), &|row| row.region)?;
    for (number, name) in COUNT_COLUMNS.iter().enumerate() {
        numbers(name, &|row| row.counts.counts()[number])?;
    }
    for (number, name) in DETECTION_COLUMNS.iter().enumerate() {
        numbers(name, &|row| row.counts.detection.counts()[number])?;
    }
    let missed = Names::of(rows.iter().map(|row| row.counts.detection.missed_names()));
    columns.set_item(MISSED_COLUMN, (missed.of.into_pyarray(py), missed.all))?;
    for score in scores() {
        let all: Vec<f64> = rows.iter().map(|row| score.of(&row.counts).unwrap_or(f64::NAN)).collect();
        columns.set_item(score.name(), all.into_pyarray(py))?;
    }
    Ok(columns)
}

/// Names, each once, and the number of each that was asked for.
struct Names {
    all: Vec<String>,
    of: Vec<i32>,
}

impl Names {
    fn of(names: impl Iterator<Item = String>) -> Names {
        let (mut known, mut all) = (HashMap::new(), Vec::new());
        let of = names.map(|name| {
            *known.entry(name).or_insert_with_key(|name| {
                all.push(name.clone());
                all.len() as i32 - 1
            })
        });
        let of = of.collect();
        Names { all, of }
    }
}

/// How many there are before each.
fn before(counts: impl Iterator<Item = usize>) -> Vec<usize> {
    let sum = |sum: &mut usize, count| Some(std::mem::replace(sum, *sum + count));
    counts.scan(0, sum).collect()
}
