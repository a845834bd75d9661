//! A study as Python has it: checked when it is made, its scenes in voxels from the first time they are needed.

use std::path::PathBuf;
use std::sync::OnceLock;

use numpy::{IntoPyArray, PyArray3, PyArray6, PyReadonlyArray2};
use perirobot::Pose;
use perirobot::results::columns::{pose_names, representation_names};
use perirobot::results::jobs;
use perirobot::study::Overrides;
use perirobot::sweep;
use perirobot::view::{Choice, Names, find};
use perirobot::world::World;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::backends::{BackendWords, LastBackend, opened};
use crate::error::raised;
use crate::origin::{File, Origin};
use crate::watch::{Listener, warn};
use crate::{choose, evaluate, labels, table};

/// A checked study.
#[pyclass(frozen, module = "perirobot._perirobot")]
pub(crate) struct Study {
    origin: Origin,
    study: perirobot::Study,
    worlds: OnceLock<Vec<World>>,
    backend: LastBackend,
}

/// A choice of poses in one world: the world's number, and those of combination, choice, representation and repeat.
type View = (usize, [usize; 4]);

/// The numbers of a scene and a snapshot, and their grid.
type WorldGrid = (usize, usize, [f64; 3], [u32; 3]);

/// The names of a choice of poses: poses, combination, representation, scene; snapshot and repeat.
type ChoiceWords = (String, Option<String>, Option<String>, Option<String>, usize, usize);

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
        let overrides = Overrides { voxel_size_m, noiseless };
        Study::read(Origin::file(path, overrides, packages, allow_outside))
    }

    /// Checks a study whose keys are given as JSON, beside files in memory that are named from a folder.
    #[staticmethod]
    fn of(keys: &str, folder: PathBuf, files: Vec<(PathBuf, File)>) -> PyResult<Study> {
        Study::read(Origin::memory(keys, &folder, files).map_err(|error| raised(&error))?)
    }

    /// The same study with some keys of `[choose]`, given as JSON, instead of its own.
    fn asking(&self, keys: &str) -> PyResult<Study> {
        let origin = self.origin.asking(&self.study.text, keys).map_err(|error| raised(&error))?;
        Ok(Study { worlds: self.worlds.clone(), ..Study::read(origin)? })
    }

    /// Finds the best set of sensors, and writes it into a folder.
    fn choose(
        &self,
        py: Python<'_>,
        out: PathBuf,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let listener = Listener::new(progress);
        let worlds = self.worlds(py, &listener)?;
        listener.run(py, || choose::search(&self.study, worlds, &backend, &listener, &out))
    }

    /// Checks what [`Study::choose`] wrote: sets counted again; steps proven again, bounded, open.
    fn verify(&self, py: Python<'_>, folder: PathBuf, backend: BackendWords) -> PyResult<[usize; 4]> {
        let listener = Listener::new(None);
        let worlds = self.worlds(py, &listener)?;
        listener.run(py, || choose::check(&self.study, worlds, &backend, &listener, &folder))
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
            let mut backends = opened(&backend)?;
            sweep::run_on(&self.study, worlds, &mut backends, &mut &listener)
        })?;
        table::columns(py, &self.study, &rows)
    }

    /// Names of the sensors that take poses.
    #[getter]
    fn sensors(&self) -> Vec<&str> {
        let posed = self.study.sensors.iter().filter(|sensor| sensor.kind.takes_poses());
        posed.map(|sensor| sensor.name.as_str()).collect()
    }

    /// Names of a sensor's poses, and position and quaternion (w, x, y, z) of each.
    fn poses(&self, sensor: &str) -> PyResult<(Vec<&str>, Vec<[f64; 7]>)> {
        let spec = &self.study.sensors[self.sensor(sensor)?];
        let rows = spec.candidates.iter().map(|candidate| {
            let Pose { position_m: p, rotation: q } = candidate.setting.pose();
            [p.x, p.y, p.z, q.w, q.x, q.y, q.z]
        });
        let names = spec.candidates.iter().map(|candidate| candidate.name.as_str());
        Ok((names.collect(), rows.collect()))
    }

    /// Counts one sensor at poses of Python's choice.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        sensor: &str,
        poses: PyReadonlyArray2<'py, f64>,
        backend: BackendWords,
    ) -> PyResult<Bound<'py, PyArray6<i64>>> {
        let sensor = self.sensor(sensor)?;
        let poses = evaluate::poses(&poses).map_err(|error| raised(&error))?;
        let listener = Listener::new(None);
        let worlds = self.worlds(py, &listener)?;
        let counts = listener.run(py, || {
            let study = self.study.elsewhere(sensor, &poses)?;
            worlds.iter().try_for_each(|world| world.examine_sensors(&study))?;
            let moved: Vec<World> = worlds.iter().map(|world| world.with_sensors(&study.sensors)).collect();
            self.backend.with(&backend, |backend| evaluate::counts(&study, &moved, backend, &listener))
        })?;
        Ok(counts.into_pyarray(py))
    }

    /// Finds a choice of poses in a world by its names.
    fn find(&self, py: Python<'_>, words: ChoiceWords) -> PyResult<View> {
        let (poses, combination, representation, scene, snapshot, repeat) = words;
        let names = Names { poses, combination, representation, scene, snapshot, repeat };
        let worlds = self.worlds(py, &Listener::new(None))?;
        let (world, choice) = find(&self.study, worlds, &names).map_err(|error| raised(&error))?;
        let number = worlds.iter().position(|other| std::ptr::eq(other, world));
        let Choice { combination, choice, representation, repeat } = choice;
        Ok((number.expect("it is one of them"), [combination, choice, representation, repeat]))
    }

    /// Of each world, scene and snapshot by number, the grid: its corner in metres, and how many voxels it has.
    fn grids(&self, py: Python<'_>) -> PyResult<Vec<WorldGrid>> {
        let worlds = self.worlds(py, &Listener::new(None))?;
        let grid = |world: &World| {
            (world.scene, world.snapshot, world.grid.corner_m([0; 3]).to_array(), world.grid.size)
        };
        Ok(worlds.iter().map(grid).collect())
    }

    /// The labels of whole grids; views of the same world follow each other.
    fn labels<'py>(
        &self,
        py: Python<'py>,
        views: Vec<View>,
        backend: BackendWords,
    ) -> PyResult<Vec<Bound<'py, PyArray3<u8>>>> {
        let listener = Listener::new(None);
        let worlds = self.worlds(py, &listener)?;
        let all = listener.run(py, || {
            self.backend
                .with(&backend, |backend| labels::all(&self.study, worlds, &views, backend, &listener))
        })?;
        all.into_iter().map(|(size, bytes)| labels::array(py, size, bytes)).collect()
    }
}

impl Study {
    fn read(origin: Origin) -> PyResult<Study> {
        let study = origin.read().map_err(|error| raised(&error))?;
        Ok(Study { origin, study, worlds: OnceLock::new(), backend: LastBackend::default() })
    }

    /// The number of a sensor that takes poses.
    fn sensor(&self, name: &str) -> PyResult<usize> {
        let known = self.sensors();
        let found = self.study.sensors.iter().position(|sensor| sensor.name == name && known.contains(&name));
        found.ok_or_else(|| {
            PyValueError::new_err(format!("sensor = {name:?}: must be one that takes poses: {known:?}"))
        })
    }

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
