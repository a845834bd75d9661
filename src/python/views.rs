//! Choices of poses in moments of a study: found by name, and looked at voxel by voxel.

use numpy::PyArray3;
use perirobot_decide::view::{self, Choice, ChoiceSelector};
use perirobot_sweep::results::columns::{pose_names, representation_names};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;

use crate::backends::BackendWords;
use crate::error::to_exception;
use crate::labels::{ViewNumbers, WorldGrid, array, grid as grid_of};
use crate::study::Study;

/// Labels, and whether a return comes from each voxel.
type LabelArrays<'py> = (Bound<'py, PyArray3<u8>>, Bound<'py, PyArray3<bool>>);

/// The names of a choice of poses: poses, combination, representation, scene; snapshot and repeat.
pub(crate) type ChoiceWords = (String, Option<String>, Option<String>, Option<String>, usize, usize);

/// Finds a choice of poses in a world by its names.
#[pyfunction]
pub(crate) fn find(py: Python<'_>, study: &Study, words: ChoiceWords) -> PyResult<ViewNumbers> {
    let worlds = study.worlds(py)?;
    let (world, choice) =
        view::find(&study.study, worlds, &selector(words)).map_err(|error| to_exception(&error))?;
    let number = worlds.iter().position(|other| std::ptr::eq(other, world));
    let Choice { combination, choice, representation, repeat } = choice;
    Ok((number.expect("it is one of them"), [combination, choice, representation, repeat]))
}

/// The names of what a view looks at: scene, combination, poses and representation.
#[pyfunction]
pub(crate) fn names_of(py: Python<'_>, study: &Study, view: ViewNumbers) -> PyResult<[String; 4]> {
    let (world, [combination, choice, representation, _]) = view;
    let (world, own) = (&study.worlds(py)?[world], &study.study.combinations[combination]);
    let representation = representation_names(&study.study, own).swap_remove(representation);
    Ok([world.name.clone(), own.name.clone(), pose_names(&study.study, own, choice), representation])
}

/// Of a world, scene and snapshot by number, the grid: its corner in metres, and how many voxels it has.
#[pyfunction]
pub(crate) fn grid(py: Python<'_>, study: &Study, world: usize) -> PyResult<WorldGrid> {
    let worlds = study.worlds(py)?;
    let Some(world) = worlds.get(world) else {
        return Err(PyIndexError::new_err(format!("there is no world {world}")));
    };
    Ok(grid_of(world))
}

/// The same of each world.
#[pyfunction]
pub(crate) fn grids(study: &Study, py: Python<'_>) -> PyResult<Vec<WorldGrid>> {
    Ok(study.worlds(py)?.iter().map(grid_of).collect())
}

/// What is truly there in a world, by its number: the planes of `labels::truth`.
#[pyfunction]
pub(crate) fn truth<'py>(
    py: Python<'py>,
    study: &Study,
    world: usize,
) -> PyResult<Vec<Bound<'py, PyArray3<bool>>>> {
    let Some(world) = study.worlds(py)?.get(world) else {
        return Err(PyIndexError::new_err(format!("there is no world {world}")));
    };
    let planes = py.detach(|| crate::labels::truth(world));
    planes.into_iter().map(|plane| array(py, world.grid.size, plane)).collect()
}

/// The labels of whole grids, and which voxels returns come from; views of the same world follow each other.
#[pyfunction]
pub(crate) fn labels<'py>(
    py: Python<'py>,
    study: &Study,
    views: Vec<ViewNumbers>,
    backend: BackendWords,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<LabelArrays<'py>>> {
    let worlds = study.worlds(py)?;
    let all = study.with_backend_shown(py, (backend, progress), |listener, backend| {
        crate::labels::all(&study.study, worlds, &views, backend, listener)
    })?;
    let arrays =
        all.into_iter().map(|(size, bytes, hits)| Ok((array(py, size, bytes)?, array(py, size, hits)?)));
    arrays.collect()
}

/// What is looked for, of its words.
pub(crate) fn selector(
    (poses, combination, representation, scene, snapshot, repeat): ChoiceWords,
) -> ChoiceSelector {
    ChoiceSelector { poses, combination, representation, scene, snapshot, repeat }
}
