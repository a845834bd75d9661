//! Searches for sets of sensors of a study, their proofs and verdicts, each in a folder.

use std::path::PathBuf;

use pyo3::prelude::*;

use crate::backends::BackendWords;
use crate::study::Study;
use crate::watch::run;

/// Finds the best set of sensors, and writes it into a folder.
#[pyfunction]
pub(crate) fn choose(
    py: Python<'_>,
    study: &Study,
    out: PathBuf,
    backend: BackendWords,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let worlds = study.worlds(py)?;
    run(py, progress.as_ref(), |listener| {
        crate::choose::search(&study.study, worlds, &backend, listener, &out)
    })
}

/// Checks what `choose` wrote: sets counted again; steps proven again, bounded, open.
#[pyfunction]
pub(crate) fn verify(
    py: Python<'_>,
    study: &Study,
    folder: PathBuf,
    backend: BackendWords,
    progress: Option<Py<PyAny>>,
) -> PyResult<[usize; 4]> {
    let worlds = study.worlds(py)?;
    run(py, progress.as_ref(), |listener| {
        crate::choose::check(&study.study, worlds, &backend, listener, &folder)
    })
}

/// Finds the cheapest set that passes, and writes it into a folder.
#[pyfunction]
pub(crate) fn cheapest(
    py: Python<'_>,
    study: &Study,
    out: PathBuf,
    backend: BackendWords,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let worlds = study.worlds(py)?;
    run(py, progress.as_ref(), |listener| {
        crate::cheapest::search(&study.study, worlds, &backend, listener, &out)
    })
}

/// Checks what `cheapest` wrote: sets judged again, ways in followed again, claims searched again, open.
#[pyfunction]
pub(crate) fn verify_cheapest(
    py: Python<'_>,
    study: &Study,
    folder: PathBuf,
    backend: BackendWords,
    progress: Option<Py<PyAny>>,
) -> PyResult<[usize; 4]> {
    let worlds = study.worlds(py)?;
    run(py, progress.as_ref(), |listener| {
        crate::cheapest::check(&study.study, worlds, &backend, listener, &folder)
    })
}

/// Judges what `choose` wrote, and writes the verdicts beside it.
#[pyfunction]
pub(crate) fn judge(
    py: Python<'_>,
    study: &Study,
    folder: PathBuf,
    backend: BackendWords,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let worlds = study.worlds(py)?;
    run(py, progress.as_ref(), |listener| {
        crate::judge::judge(&study.study, worlds, &backend, listener, &folder)
    })
}
