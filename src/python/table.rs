//! The rows of a sweep as columns: numbers, and names as numbers into lists of them, since there are many rows and few
//! names. Python gets the numbers as numpy arrays, without another copy.

use std::collections::HashMap;

use numpy::IntoPyArray;
use perirobot_march::metrics::Confusion;
use perirobot_study::input::Study;
use perirobot_study::world::{Baselines, World};
use perirobot_sweep::results::Subject;
use perirobot_sweep::results::columns::{
    COUNT_COLUMNS, DETECTION_COLUMNS, MISSED_COLUMN, OVERLAP_COLUMNS, pose_names, representation_names,
};
use perirobot_sweep::results::rows::scores;
use perirobot_sweep::scoring::Row;
use pyo3::prelude::*;

/// The columns of a table, by their names and in its order.
pub(crate) type Columns = Vec<(&'static str, ArrayColumn)>;

/// A column.
pub(crate) enum ArrayColumn {
    /// Whole numbers; int64 in Python.
    Counts(Vec<i64>),
    /// Scores, NaN where there is no value; float64 in Python.
    Scores(Vec<f64>),
    /// Numbers, int32 in Python, and the names that they count through.
    Names(Vec<i32>, Vec<String>),
}

impl<'py> IntoPyObject<'py> for ArrayColumn {
    type Target = PyAny;
    type Output = Bound<'py, PyAny>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self {
            ArrayColumn::Counts(all) => Ok(all.into_pyarray(py).into_any()),
            ArrayColumn::Scores(all) => Ok(all.into_pyarray(py).into_any()),
            ArrayColumn::Names(of, all) => Ok((of.into_pyarray(py), all).into_pyobject(py)?.into_any()),
        }
    }
}

/// The names of what rows have by number.
pub(crate) struct Titles {
    scenes: Vec<String>,
    regions: Vec<String>,
    /// Of each combination its name, its choices of poses and its representations.
    combinations: Vec<(String, Vec<String>, Vec<String>)>,
}

impl From<&Study> for Titles {
    fn from(study: &Study) -> Titles {
        let combinations = study.combinations.iter().map(|combination| {
            let poses = (0..combination.choices()).map(|choice| pose_names(study, combination, choice));
            (combination.name.clone(), poses.collect(), representation_names(study, combination))
        });
        Titles {
            scenes: study.scenes.iter().map(|scene| scene.name.clone()).collect(),
            regions: study.regions.iter().map(|(name, _)| name.clone()).collect(),
            combinations: combinations.collect(),
        }
    }
}

impl From<&Subject> for Titles {
    fn from(swept: &Subject) -> Titles {
        let combinations = swept.combinations.iter().map(|combination| {
            let poses = (0..combination.choices()).map(|choice| combination.name_of(choice));
            (combination.name.clone(), poses.collect(), combination.representations.clone())
        });
        Titles {
            scenes: swept.scenes.iter().map(|scene| scene.name.clone()).collect(),
            regions: swept.regions.clone(),
            combinations: combinations.collect(),
        }
    }
}

/// The columns of `results.csv`.
pub(crate) fn columns(titles: Titles, rows: &[Row]) -> Columns {
    let counts = |number: &dyn Fn(&Row) -> u64| {
        ArrayColumn::Counts(rows.iter().map(|row| number(row) as i64).collect())
    };
    let named = |names: NameTable, number: &dyn Fn(&Row) -> usize| {
        ArrayColumn::Names(rows.iter().map(|row| names.of[number(row)]).collect(), names.all)
    };
    let Titles { scenes, regions, combinations } = titles;
    let choices = running_totals(combinations.iter().map(|(_, poses, _)| poses.len()));
    let firsts = running_totals(combinations.iter().map(|(.., ways)| ways.len()));
    let (mut names, mut poses, mut ways) = (Vec::new(), Vec::new(), Vec::new());
    for (name, of_poses, of_ways) in combinations {
        names.push(name);
        poses.extend(of_poses);
        ways.extend(of_ways);
    }
    let mut columns: Columns = vec![
        ("scene", named(NameTable::new(scenes.into_iter()), &|row| row.scene)),
        ("snapshot", counts(&|row| row.snapshot as u64)),
        ("repeat", counts(&|row| row.repeat as u64)),
        ("combination", named(NameTable::new(names.into_iter()), &|row| row.combination)),
        ("poses", named(NameTable::new(poses.into_iter()), &|row| choices[row.combination] + row.choice)),
        (
            "representation",
            named(NameTable::new(ways.into_iter()), &|row| firsts[row.combination] + row.representation),
        ),
        ("region", named(NameTable::new(regions.into_iter()), &|row| row.region)),
    ];
    let of_rows: Vec<Confusion> = rows.iter().map(|row| row.counts).collect();
    columns.extend(count_columns(&of_rows));
    columns
}

/// What simple answers would score in each region at each moment of a study.
pub(crate) fn baselines(study: &Study, worlds: &[World]) -> Columns {
    let (mut words, mut snapshots, mut all) = ([(); 3].map(|()| Vec::new()), Vec::new(), Vec::new());
    for world in worlds {
        for ((region, _), baselines) in study.regions.iter().zip(&world.baselines) {
            let Baselines { all_occupied, all_free, nothing_seen, ceiling } = *baselines;
            let answers = [
                ("all_occupied", all_occupied),
                ("all_free", all_free),
                ("nothing_seen", nothing_seen),
                ("ceiling", ceiling),
            ];
            for (answer, counts) in answers {
                for (column, word) in words.iter_mut().zip([&world.name, region.as_str(), answer]) {
                    column.push(word.to_string());
                }
                snapshots.push(world.snapshot as i64);
                all.push(counts);
            }
        }
    }
    let [scenes, regions, answers] = words.map(|all| NameTable::new(all.into_iter()).column());
    let mut columns: Columns = vec![
        ("scene", scenes),
        ("snapshot", ArrayColumn::Counts(snapshots)),
        ("region", regions),
        ("baseline", answers),
    ];
    columns.extend(count_columns(&all));
    columns
}

/// The columns of counts and scores.
fn count_columns(all: &[Confusion]) -> Columns {
    let counts = |number: &dyn Fn(&Confusion) -> u64| {
        ArrayColumn::Counts(all.iter().map(|counts| number(counts) as i64).collect())
    };
    let mut columns = Columns::new();
    for (number, name) in COUNT_COLUMNS.into_iter().enumerate() {
        columns.push((name, counts(&|of| of.counts()[number])));
    }
    for (number, name) in DETECTION_COLUMNS.into_iter().enumerate() {
        columns.push((name, counts(&|of| of.detection.counts()[number])));
    }
    let missed = NameTable::new(all.iter().map(|of| of.detection.missed_names()));
    columns.push((MISSED_COLUMN, missed.column()));
    for score in scores() {
        let value = |of: &Confusion| score.evaluate(of).unwrap_or(f64::NAN);
        columns.push((score.name(), ArrayColumn::Scores(all.iter().map(value).collect())));
    }
    for (number, name) in OVERLAP_COLUMNS.into_iter().enumerate() {
        columns.push((name, counts(&|of| of.overlap.counts()[number])));
    }
    columns
}

/// Names, each once, and the number of each that was asked for.
pub(crate) struct NameTable {
    all: Vec<String>,
    of: Vec<i32>,
}

impl NameTable {
    pub(crate) fn new(names: impl Iterator<Item = String>) -> NameTable {
        let (mut known, mut all) = (HashMap::new(), Vec::new());
        let of = names.map(|name| {
            *known.entry(name).or_insert_with_key(|name| {
                all.push(name.clone());
                all.len() as i32 - 1
            })
        });
        let of = of.collect();
        NameTable { all, of }
    }

    /// All that were asked for.
    pub(crate) fn column(self) -> ArrayColumn {
        ArrayColumn::Names(self.of, self.all)
    }
}

/// How many there are before each.
fn running_totals(counts: impl Iterator<Item = usize>) -> Vec<usize> {
    let sum = |sum: &mut usize, count| Some(std::mem::replace(sum, *sum + count));
    counts.scan(0, sum).collect()
}
