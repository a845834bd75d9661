//! The native half of the Python package: studies, sweeps, and the command line. What Python's users see of it is
//! described in `perirobot/`, whose classes are thin covers of these.

mod arrow;
mod backends;
mod cell;
mod cheapest;
mod choose;
mod error;
mod evaluate;
mod folder;
mod judge;
mod labels;
mod look;
mod looks;
mod moments;
mod origin;
mod process;
mod recorded;
mod report;
mod searches;
mod study;
mod swept;
mod table;
mod views;
mod watch;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2, PyReadonlyArray3};
use perirobot_march::backend::factory::adapters;
use perirobot_study::input::Overrides;
use perirobot_sweep::scoring::reopen;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule};

/// The module `perirobot._perirobot`.
#[pymodule]
mod _perirobot {
    #[pymodule_export]
    use super::arrow_stream;
    #[pymodule_export]
    use super::cell_map;
    #[pymodule_export]
    use super::evaluate::evaluate;
    #[pymodule_export]
    use super::looks::{approach, export, judge_choice, render, report, why};
    #[pymodule_export]
    use super::moments::{Moments, disk_files, find_choice, identity, moments, write_labels};
    #[pymodule_export]
    use super::open_drivers;
    #[pymodule_export]
    use super::origin_of;
    #[pymodule_export]
    use super::purchase_sentence;
    #[pymodule_export]
    use super::recorded::{score_file, score_labels};
    #[pymodule_export]
    use super::results;
    #[pymodule_export]
    use super::run;
    #[pymodule_export]
    use super::score;
    #[pymodule_export]
    use super::searches::{cheapest, choose, judge, verify, verify_cheapest};
    #[pymodule_export]
    use super::study::Study;
    #[pymodule_export]
    use super::swept::Swept;
    #[pymodule_export]
    use super::views::{find, grid, grids, labels, names_of, truth};
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}

/// Runs a command line, the program's name its first word, and returns the exit code.
#[pyfunction]
fn run(py: Python<'_>, words: Vec<OsString>) -> u8 {
    number(py.detach(|| perirobot::cli::run(words)))
}

/// The voxels that are set as a map for [`study::Study::from_keys`], its first voxel at a key of the world; None where none is set.
#[pyfunction]
fn cell_map<'py>(
    py: Python<'py>,
    voxels: PyReadonlyArray3<'py, bool>,
    voxel_size_m: f64,
    key: [i32; 3],
) -> PyResult<Option<Bound<'py, PyBytes>>> {
    let voxels = voxels.as_array();
    let map = watch::run(py, None, |_| cell::map(voxels, voxel_size_m, key))?;
    Ok(map.map(|bytes| PyBytes::new(py, &bytes)))
}

/// A score of each row of counters; NaN where there is no value.
#[pyfunction]
fn score<'py>(
    py: Python<'py>,
    name: &str,
    rows: PyReadonlyArray2<'py, i64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let values = evaluate::score(name, rows.as_array());
    Ok(values.map_err(|error| error::to_exception(&error))?.into_pyarray(py))
}

/// The columns of a table as a stream of Arrow: a capsule for `__arrow_c_stream__`.
#[pyfunction]
fn arrow_stream<'py>(
    py: Python<'py>,
    columns: Vec<(String, arrow::GivenColumn<'py>)>,
) -> PyResult<Bound<'py, PyCapsule>> {
    arrow::stream(py, columns)
}

/// The columns of a finished sweep in a folder, and the sweep.
#[pyfunction]
fn results(py: Python<'_>, folder: PathBuf) -> PyResult<(table::Columns, swept::Swept)> {
    watch::run(py, None, |listener| folder::results(&folder, listener))
}

/// The answer of a folder with the cheapest set that passes, in one sentence.
#[pyfunction]
fn purchase_sentence(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    watch::run(py, None, |_| cheapest::sentence(&folder))
}

/// The study file of a folder of results, and how it was changed: edge of a voxel in metres, whether without noise.
#[pyfunction]
fn origin_of(py: Python<'_>, folder: PathBuf) -> PyResult<(PathBuf, Option<f64>, bool)> {
    let (file, Overrides { voxel_size_m, noiseless }) = watch::run(py, None, |_| reopen::origin(&folder))?;
    Ok((file, voxel_size_m, noiseless))
}

/// Opens the drivers of GPUs, which stay open as long as the process. No other thread of Python runs meanwhile, so that the
/// process is not forked.
#[pyfunction]
fn open_drivers() {
    adapters();
}

/// The number of an exit code, which the standard library does not tell.
fn number(code: ExitCode) -> u8 {
    (0..=u8::MAX).find(|&number| ExitCode::from(number) == code).unwrap_or(1)
}
