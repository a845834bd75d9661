//! The rows of a sweep as columns: numbers, and names as numbers into lists of them, since there are many rows and few
//! names. Python gets the numbers as numpy arrays, without another copy.

use std::collections::HashMap;

use numpy::IntoPyArray;
use perirobot::Study;
use perirobot::results::columns::{
    COUNT_COLUMNS, DETECTION_COLUMNS, MISSED_COLUMN, pose_names, representation_names,
};
use perirobot::results::rows::scores;
use perirobot::sweep::Row;
use pyo3::prelude::*;

/// The columns of a table, by their names and in its order.
pub(crate) type Columns = Vec<(&'static str, Column)>;

/// A column.
pub(crate) enum Column {
    /// Whole numbers; int64 in Python.
    Counts(Vec<i64>),
    /// Scores, NaN where there is no value; float64 in Python.
    Scores(Vec<f64>),
    /// Numbers, int32 in Python, and the names that they count through.
    Names(Vec<i32>, Vec<String>),
}

impl<'py> IntoPyObject<'py> for Column {
    type Target = PyAny;
    type Output = Bound<'py, PyAny>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self {
            Column::Counts(all) => Ok(all.into_pyarray(py).into_any()),
            Column::Scores(all) => Ok(all.into_pyarray(py).into_any()),
            Column::Names(of, all) => Ok((of.into_pyarray(py), all).into_pyobject(py)?.into_any()),
        }
    }
}

/// The columns of `results.csv`.
pub(crate) fn columns(study: &Study, rows: &[Row]) -> Columns {
    let counts =
        |number: &dyn Fn(&Row) -> u64| Column::Counts(rows.iter().map(|row| number(row) as i64).collect());
    let named = |names: Names, number: &dyn Fn(&Row) -> usize| {
        Column::Names(rows.iter().map(|row| names.of[number(row)]).collect(), names.all)
    };
    let combinations = &study.combinations;
    let choices = before(combinations.iter().map(|combination| combination.choices()));
    let poses = combinations.iter().flat_map(|combination| {
        (0..combination.choices()).map(|choice| pose_names(study, combination, choice))
    });
    let ways: Vec<Vec<String>> = combinations.iter().map(|c| representation_names(study, c)).collect();
    let firsts = before(ways.iter().map(Vec::len));
    let of_scenes = Names::of(study.scenes.iter().map(|scene| scene.name.clone()));
    let of_combinations = Names::of(combinations.iter().map(|combination| combination.name.clone()));
    let of_regions = Names::of(study.regions.iter().map(|(name, _)| name.clone()));
    let mut columns: Columns = vec![
        ("scene", named(of_scenes, &|row| row.scene)),
        ("snapshot", counts(&|row| row.snapshot as u64)),
        ("repeat", counts(&|row| row.repeat as u64)),
        ("combination", named(of_combinations, &|row| row.combination)),
        ("poses", named(Names::of(poses), &|row| choices[row.combination] + row.choice)),
        (
            "representation",
            named(Names::of(ways.into_iter().flatten()), &|row| firsts[row.combination] + row.representation),
        ),
        ("region", named(of_regions, &|row| row.region)),
    ];
    for (number, name) in COUNT_COLUMNS.into_iter().enumerate() {
        columns.push((name, counts(&|row| row.counts.counts()[number])));
    }
    for (number, name) in DETECTION_COLUMNS.into_iter().enumerate() {
        columns.push((name, counts(&|row| row.counts.detection.counts()[number])));
    }
    let missed = Names::of(rows.iter().map(|row| row.counts.detection.missed_names()));
    columns.push((MISSED_COLUMN, missed.column()));
    for score in scores() {
        let value = |row: &Row| score.of(&row.counts).unwrap_or(f64::NAN);
        columns.push((score.name(), Column::Scores(rows.iter().map(value).collect())));
    }
    columns
}

/// Names, each once, and the number of each that was asked for.
pub(crate) struct Names {
    all: Vec<String>,
    of: Vec<i32>,
}

impl Names {
    pub(crate) fn of(names: impl Iterator<Item = String>) -> Names {
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

    /// All that were asked for.
    pub(crate) fn column(self) -> Column {
        Column::Names(self.of, self.all)
    }
}

/// How many there are before each.
fn before(counts: impl Iterator<Item = usize>) -> Vec<usize> {
    let sum = |sum: &mut usize, count| Some(std::mem::replace(sum, *sum + count));
    counts.scan(0, sum).collect()
}
