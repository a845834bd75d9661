//! Moments of some scenes of a study, in voxels as long as they are needed: a data set goes through many scenes.

use std::collections::HashSet;

use numpy::{PyArray3, PyReadwriteArray2};
use perirobot_decide::view::{Choice, ChoiceSelector, find};
use perirobot_scene::source::sha256;
use perirobot_study::world::World;
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::results::manifest::{Identity, Manifest};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;

use crate::backends::BackendWords;
use crate::error::to_exception;
use crate::labels::{self, ViewNumbers, WorldGrid};
use crate::study::{ReadFile, Study, odd};
use crate::watch::run;

/// The moments of some scenes.
#[pyclass(frozen, module = "perirobot._perirobot")]
pub(crate) struct Moments {
    worlds: Vec<World>,
}

/// Makes the moments of some scenes of a study: the number of the first, and how many.
#[pyfunction]
pub(crate) fn moments(py: Python<'_>, study: &Study, first: usize, count: usize) -> PyResult<Moments> {
    let end = study.study.scenes.len().min(first.saturating_add(count));
    let scenes = first.min(end)..end;
    let worlds = match study.ready_worlds() {
        Some(all) => all.iter().filter(|world| scenes.contains(&world.scene)).cloned().collect(),
        None => run(py, None, |listener| World::prepare_scenes(&study.study, scenes, listener))?,
    };
    Ok(Moments { worlds })
}

/// Finds a choice of poses by its name: the numbers of combination, choice, representation and repeat. The moments are
/// those of the study's first scene.
#[pyfunction]
pub(crate) fn find_choice(
    study: &Study,
    moments: &Moments,
    poses: String,
    combination: Option<String>,
    representation: Option<String>,
) -> PyResult<[usize; 4]> {
    let wanted = ChoiceSelector { poses, combination, representation, ..ChoiceSelector::default() };
    let found = find(&study.study, &moments.worlds, &wanted).map_err(|error| to_exception(&error))?;
    let Choice { combination, choice, representation, repeat } = found.1;
    Ok([combination, choice, representation, repeat])
}

/// What decides the labels of a study, as JSON: what it says, without its scenes, by which rules, and hashes of what its
/// scenes say and of its files in memory. The moments are those of its first scene.
#[pyfunction]
pub(crate) fn identity(py: Python<'_>, study: &Study, moments: &Moments) -> PyResult<String> {
    let Study { study, files, .. } = study;
    run(py, None, |_| {
        let Identity { semantics_version, study: mut says, scene_files, seed, sensors, .. } =
            Manifest::new(study, &moments.worlds, Shard::WHOLE, &[]).identity;
        if let Some(keys) = says.as_object_mut() {
            keys.remove("scene");
        }
        let of_files = files.iter().filter(|(path, _)| *path != study.path);
        let named = of_files.map(|(path, bytes)| [study.sources.name(path), sha256([&**bytes])].concat());
        let cells = serde_json::json!([scene_files, named.collect::<Vec<_>>()]).to_string();
        let whole = serde_json::json!({
            "semantics_version": semantics_version,
            "study": says,
            "noiseless": study.noiseless,
            "seed": seed,
            "sensors": sensors,
            "cells_sha256": sha256([cells.as_bytes()]),
        });
        Ok(whole.to_string())
    })
}

/// Writes the labels of choices of poses into the rows of an array, and into those of another whether a return comes from
/// each voxel; a row has the voxels of a moment, x the fastest. Returns how many of each row are free, occupied and unknown.
#[pyfunction]
pub(crate) fn write_labels(
    py: Python<'_>,
    study: &Study,
    moments: &Moments,
    views: Vec<ViewNumbers>,
    mut rows: (PyReadwriteArray2<'_, u8>, Option<PyReadwriteArray2<'_, bool>>),
    backend: BackendWords,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<[u64; 3]>> {
    let wrong = |what: &str| PyValueError::new_err(format!("rows: {what}"));
    let labels = rows.0.as_slice_mut().map_err(|_| wrong("are not contiguous"))?;
    let hits = rows.1.as_mut().map(|rows| rows.as_slice_mut()).transpose();
    let hits = hits.map_err(|_| wrong("are not contiguous"))?;
    let voxels =
        |&(world, _): &ViewNumbers| moments.worlds.get(world).map(|world| world.grid.window().volume());
    let row = (labels.len() / views.len().max(1)) as u64;
    let is_of = |bytes: usize| bytes as u64 == row * views.len() as u64;
    if !views.iter().all(|view| voxels(view) == Some(row))
        || !is_of(labels.len())
        || !hits.as_ref().is_none_or(|hits| is_of(hits.len()))
    {
        return Err(wrong("must have a byte for each voxel of each view"));
    }
    study.with_backend_shown(py, (backend, progress), |listener, backend| {
        labels::write((&study.study, &moments.worlds), &views, (labels, hits), backend, listener)
    })
}

#[pymethods]
impl Moments {
    /// Scene, snapshot and grid of each moment.
    fn grids(&self) -> Vec<WorldGrid> {
        self.worlds.iter().map(labels::grid).collect()
    }

    /// What is odd about the scenes, as pairs of a scene's name and words.
    fn warnings(&self) -> Vec<(&str, &str)> {
        odd(&self.worlds)
    }

    /// What is truly there at a moment: the planes of `labels::truth`.
    fn truth<'py>(&self, py: Python<'py>, moment: usize) -> PyResult<Vec<Bound<'py, PyArray3<bool>>>> {
        let Some(world) = self.worlds.get(moment) else {
            return Err(PyIndexError::new_err(format!("there is no moment {moment}")));
        };
        let planes = py.detach(|| labels::truth(world));
        planes.into_iter().map(|plane| labels::array(py, world.grid.size, plane)).collect()
    }
}

/// The files on the disk that a study has read so far, with their hashes, but for the study file and its scene files,
/// whose contents are compared.
#[pyfunction]
pub(crate) fn disk_files(study: &Study) -> Vec<ReadFile> {
    let Study { study: read, files, .. } = study;
    let texts = read.scenes.iter().map(|scene| &scene.path).chain([&read.path]);
    let in_memory = files.iter().map(|(path, _)| path);
    let left_out: HashSet<String> = texts.chain(in_memory).map(|path| read.sources.name(path)).collect();
    study.read_files().into_iter().filter(|(name, _): &ReadFile| !left_out.contains(name)).collect()
}
