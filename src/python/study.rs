//! A study as Python has it: checked when it is made, its scenes in voxels from the first time they are needed.

use std::path::PathBuf;
use std::sync::OnceLock;

use perirobot::backend::factory::{BackendChoice, BackendKind, ChosenBackends};
use perirobot::error::Issue;
use perirobot::results::columns::{pose_names, representation_names};
use perirobot::results::jobs;
use perirobot::source::Sources;
use perirobot::study::Overrides;
use perirobot::sweep;
use perirobot::world::World;
use perirobot::{Error, Result};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::raised;
use crate::table;
use crate::watch::{Listener, warn};

/// A checked study.
#[pyclass(frozen, module = "perirobot._perirobot")]
pub(crate) struct Study {
    study: perirobot::Study,
    worlds: OnceLock<Vec<World>>,
}

/// What computes: which backend, on which adapter, with how many threads.
type BackendWords = (String, Option<String>, Option<usize>);

#[pymethods]
impl Study {
    /// Reads and checks a study file and its scene files.
    #[staticmethod]
    fn load(
        path: PathBuf,
        voxel_size_m: Option<f64>,
        noiseless: bool,
        packages: Vec<(String, PathBuf)>,
        allow_outside: bool,
    ) -> PyResult<Study> {
        let beside = Sources::beside(&path);
        let sources = packages.iter().fold(beside, |all, (name, folder)| all.with_package(name, folder));
        let sources = if allow_outside { sources.allow_outside() } else { sources };
        let read = perirobot::Study::read(&path, &Overrides { voxel_size_m, noiseless }, sources);
        let mut study = read.map_err(|error| raised(&error))?;
        let packages = packages.iter().map(|(name, folder)| (name.as_str(), folder.as_path()));
        study.scenes.iter_mut().for_each(|scene| scene.use_packages(packages.clone()));
        Ok(Study { study, worlds: OnceLock::new() })
    }

    /// Edge of a voxel in metres.
    #[getter]
    fn voxel_size_m(&self) -> f64 {
        self.study.voxel_size_m
    }

    /// How often everything is scored.
    #[getter]
    fn repeats(&self) -> u32 {
        self.study.repeats
    }

    /// Names of the scenes, and how many snapshots each has.
    #[getter]
    fn scenes(&self) -> Vec<(&str, usize)> {
        self.study.scenes.iter().map(|scene| (scene.name.as_str(), scene.snapshots)).collect()
    }

    /// Names of the regions.
    #[getter]
    fn regions(&self) -> Vec<&str> {
        self.study.regions.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// Names of the combinations.
    #[getter]
    fn combinations(&self) -> Vec<&str> {
        self.study.combinations.iter().map(|combination| combination.name.as_str()).collect()
    }

    /// Names of the choices of poses of a combination, and of its representations.
    fn choices(&self, combination: usize) -> (Vec<String>, Vec<String>) {
        let combination = &self.study.combinations[combination];
        let poses = (0..combination.choices()).map(|choice| pose_names(&self.study, combination, choice));
        (poses.collect(), representation_names(&self.study, combination))
    }

    /// How many choices a sweep scores: each in each snapshot of each scene, in each repeat.
    #[getter]
    fn jobs(&self) -> u64 {
        jobs(&self.study)
    }

    /// Scores every choice of poses; the columns of the table.
    fn sweep<'py>(
        &self,
        py: Python<'py>,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let listener = Listener::new(progress);
        let worlds = self.worlds(py, &listener)?;
        let rows = listener.run(py, || {
            let mut backends = opened(backend)?;
            sweep::run_on(&self.study, worlds, &mut backends, &mut &listener)
        })?;
        table::columns(py, &self.study, &rows)
    }
}

impl Study {
    /// The scenes in voxels, made when they are first asked for; then what is odd about them is warned of.
    fn worlds(&self, py: Python<'_>, listener: &Listener) -> PyResult<&[World]> {
        if self.worlds.get().is_none() {
            let made = listener.run(py, || World::prepare_all_unless(&self.study, &|| listener.stop()))?;
            for world in &made {
                world.warnings.iter().try_for_each(|text| warn(py, &format!("{}: {text}", world.name)))?;
            }
            // Another thread may have been quicker; its worlds are the same.
            let _ = self.worlds.set(made);
        }
        Ok(self.worlds.get().expect("they were made"))
    }
}

/// The backend that is named, and its fallbacks.
fn opened((backend, adapter, threads): BackendWords) -> Result<ChosenBackends> {
    let kind = match backend.as_str() {
        "auto" => BackendKind::Auto,
        "cpu" => BackendKind::Cpu,
        "gpu" => BackendKind::Gpu,
        "oracle" => BackendKind::Oracle,
        _ => {
            let wanted = "must be \"auto\", \"cpu\", \"gpu\" or \"oracle\"";
            return Err(Issue::value("backend", format!("{backend:?}"), wanted).into());
        }
    };
    let adapter = adapter.map(|name| name.parse().map_err(|e| Error::input("adapter", format!("{e}"))));
    let choice = BackendChoice { kind, adapter: adapter.transpose()?, threads, memory_bytes: None };
    Ok(ChosenBackends::open(&choice)?.0)
}
