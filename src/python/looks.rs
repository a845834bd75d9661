//! What is said and drawn of one choice of poses of a study: the commands `why`, `approach`, `export`, `render`, `report`
//! and `judge`.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::backends::BackendWords;
use crate::look;
use crate::look::{AlterationWords, WishWords};
use crate::study::Study;
use crate::views::{ChoiceWords, selector};
use crate::watch::run;

/// Why voxels stay unknown: in words, and the rows of `reasons.csv`.
#[pyfunction]
pub(crate) fn why(
    py: Python<'_>,
    study: &Study,
    words: ChoiceWords,
    altered: AlterationWords,
    backend: BackendWords,
) -> PyResult<(String, Vec<u8>)> {
    let (worlds, wanted) = (study.worlds(py)?, selector(words));
    study.with_backend(py, backend, |_, backend| {
        look::why((&study.study, worlds), &wanted, look::alteration(altered), backend)
    })
}

/// How near bodies come unnoticed: the answers in words; the files are written into a folder.
#[pyfunction]
pub(crate) fn approach(
    py: Python<'_>,
    study: &Study,
    words: ChoiceWords,
    altered: AlterationWords,
    out: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let (worlds, wanted) = (study.worlds(py)?, selector(words));
    run(py, progress.as_ref(), |listener| {
        look::approach((&study.study, worlds), &wanted, &look::alteration(altered), &out, listener)
    })
}

/// Writes what a choice of poses sees into a folder; names of files, and what they hold.
#[pyfunction]
pub(crate) fn export(
    py: Python<'_>,
    study: &Study,
    words: ChoiceWords,
    altered: AlterationWords,
    out: PathBuf,
    backend: BackendWords,
) -> PyResult<Vec<(String, String)>> {
    let (worlds, wanted) = (study.worlds(py)?, selector(words));
    study.with_backend(py, backend, |_, backend| {
        look::export((&study.study, worlds), &wanted, look::alteration(altered), &out, backend)
    })
}

/// A picture of a scene, or of what a choice of poses makes of it: the bytes of a PNG or an SVG.
#[pyfunction]
pub(crate) fn render<'py>(
    py: Python<'py>,
    study: &Study,
    words: ChoiceWords,
    altered: AlterationWords,
    wish: WishWords,
    backend: BackendWords,
) -> PyResult<Bound<'py, PyBytes>> {
    let worlds = study.worlds(py)?;
    let (has_poses, wanted) = (!words.0.is_empty(), selector(words));
    let bytes = study.with_backend(py, backend, |_, backend| {
        let altered = look::alteration(altered);
        look::render((&study.study, worlds), (&wanted, has_poses), altered, &wish, backend)
    })?;
    Ok(PyBytes::new(py, &bytes))
}

/// Writes the page of a folder of results of this study.
#[pyfunction]
pub(crate) fn report(
    py: Python<'_>,
    study: &Study,
    folder: PathBuf,
    asked: (PathBuf, Option<usize>),
    backend: BackendWords,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let (worlds, (out, best)) = (study.worlds(py)?, asked);
    run(py, progress.as_ref(), |listener| {
        crate::report::report((&study.study, worlds), &folder, (&out, best), &backend, listener)
    })
}

/// Judges a choice of poses, and writes the verdicts into a folder.
#[pyfunction]
pub(crate) fn judge_choice(
    py: Python<'_>,
    study: &Study,
    words: ChoiceWords,
    out: PathBuf,
    backend: BackendWords,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let (worlds, wanted) = (study.worlds(py)?, selector(words));
    run(py, progress.as_ref(), |listener| {
        crate::judge::judge_choice((&study.study, worlds), &wanted, &backend, listener, &out)
    })
}
