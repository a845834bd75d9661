//! A study as Python has it: checked when it is made, its scenes in voxels from the first time they are needed.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use perirobot_march::Error;
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::error::Issue;
use perirobot_scene::pose::Pose;
use perirobot_scene::source;
use perirobot_study::input::Overrides;
use perirobot_study::world::{World, share_kinds};
use perirobot_sweep::results::columns::{pose_names, representation_names};
use perirobot_sweep::results::jobs;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::backends::{BackendWords, LastBackends};
use crate::error::to_exception;
use crate::origin::{FileOrigin, MemoryFile, table};
use crate::swept::Swept;
use crate::table::{Columns, baselines, columns};
use crate::watch::{Listener, run, warn};
use crate::{folder, swept};

/// A checked study.
#[pyclass(frozen, module = "perirobot._perirobot")]
pub(crate) struct Study {
    pub(crate) study: perirobot_study::input::Study,
    /// Its files that are in memory only.
    pub(crate) files: Arc<Vec<(PathBuf, Vec<u8>)>>,
    /// Files and their hashes as they were when the study was pickled.
    before: Vec<ReadFile>,
    /// Those of the study that this one came from, where it only asks for something else.
    worlds: Arc<OnceLock<Vec<World>>>,
    pub(crate) backends: Arc<LastBackends>,
}

/// A file that was read, and its SHA-256.
pub(crate) type ReadFile = (String, String);

#[pymethods]
impl Study {
    /// Reads and checks a study file and its scene files; texts take the place of those of files, which are named from the
    /// folder of the study.
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "they are those of Python's Study.load")]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        voxel_size_m: Option<f64>,
        noiseless: bool,
        packages: Vec<(String, PathBuf)>,
        allow_outside: bool,
        xacro: bool,
        step: bool,
        texts: Vec<(PathBuf, String)>,
    ) -> PyResult<Study> {
        // STEP files are converted by the packages of this interpreter.
        let executable = || py.import("sys")?.getattr("executable")?.extract::<Option<PathBuf>>();
        let step_python = if step { executable()?.or(Some("python3".into())) } else { None };
        let overrides = Overrides { voxel_size_m, noiseless };
        let mut origin =
            FileOrigin::file(path.clone(), overrides, packages, allow_outside, xacro, step_python);
        let folder = path.parent().unwrap_or(Path::new(""));
        origin.files.extend(texts.into_iter().map(|(name, text)| (folder.join(name), text.into_bytes())));
        Study::read_checked(py, || Ok(origin))
    }

    /// The same study after it was pickled: its files must be those of that time, now and when they are read.
    fn restore(&self, before: Vec<ReadFile>) -> PyResult<Study> {
        let (study, files) = (self.study.clone(), self.files.clone());
        let study = Study { study, files, before, worlds: Arc::default(), backends: Arc::default() };
        study.check_files()?;
        Ok(study)
    }

    /// The files that were read so far, and their hashes.
    pub(crate) fn read_files(&self) -> Vec<ReadFile> {
        let name = |file: source::ReadFile| (file.path.display().to_string(), file.sha256);
        self.study.sources.read_files().into_iter().map(name).collect()
    }

    /// Writes a study that was made in memory into a folder, with the files that it reads.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        self.worlds(py)?;
        run(py, None, |_| folder::save(&self.study, &self.files, &folder))
    }

    /// What is odd about the scenes, as pairs of a scene's name and words.
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<(&str, &str)>> {
        Ok(odd(self.worlds(py)?))
    }

    /// Checks a study whose keys are given as JSON, beside files in memory that are named from a folder.
    #[staticmethod]
    fn from_keys(
        py: Python<'_>,
        keys: &str,
        folder: PathBuf,
        files: Vec<(PathBuf, MemoryFile)>,
    ) -> PyResult<Study> {
        Study::read_checked(py, || FileOrigin::memory(keys, &folder, files))
    }

    /// A study as [`Study::from_keys`] makes it, which takes over from this one what is ready of sensors that are the same:
    /// tables of rays, and the backend that is open.
    fn with_keys(
        &self,
        py: Python<'_>,
        keys: &str,
        folder: PathBuf,
        files: Vec<(PathBuf, MemoryFile)>,
    ) -> PyResult<Study> {
        let mut study = Study::from_keys(py, keys, folder, files)?;
        share_kinds(&self.study, &mut study.study);
        Ok(Study { backends: self.backends.clone(), ..study })
    }

    /// The same study with some keys of `[choose]`, given as JSON, instead of its own.
    fn asking(&self, py: Python<'_>, keys: &str) -> PyResult<Study> {
        let study = run(py, None, |_| self.study.asking(table(keys)?))?;
        let (files, before) = (self.files.clone(), self.before.clone());
        Ok(Study { study, files, before, worlds: self.worlds.clone(), backends: Arc::default() })
    }

    /// Edge of a voxel in metres.
    #[getter]
    fn voxel_size_m(&self) -> f64 {
        self.study.voxel_size_m
    }

    /// Whether it requires something.
    #[getter]
    fn has_requirements(&self) -> bool {
        !self.study.requirements.is_empty()
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

    /// Scores every choice of poses; the columns of the table, and the sweep.
    fn sweep(
        &self,
        py: Python<'_>,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Columns, Swept)> {
        let worlds = self.worlds(py)?;
        run(py, progress.as_ref(), |listener| {
            listener.begins("poses", jobs(&self.study));
            let (rows, swept) = swept::in_memory((&self.study, worlds), &backend, listener)?;
            Ok((columns((&self.study).into(), &rows), swept))
        })
    }

    /// Scores every choice of poses into a folder.
    fn sweep_into(
        &self,
        py: Python<'_>,
        out: PathBuf,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let worlds = self.worlds(py)?;
        run(py, progress.as_ref(), |listener| {
            swept::into_folder((&self.study, worlds), &out, &backend, listener)
        })
    }

    /// What simple answers score in each region at each moment; the columns of a table.
    fn baselines(&self, py: Python<'_>) -> PyResult<Columns> {
        Ok(baselines(&self.study, self.worlds(py)?))
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
}

impl Study {
    /// Reads and checks what comes from somewhere.
    fn read_checked(
        py: Python<'_>,
        origin: impl FnOnce() -> perirobot_march::Result<FileOrigin> + Send,
    ) -> PyResult<Study> {
        let (study, files) = run(py, None, |_| {
            let origin = origin()?;
            Ok((origin.read()?, Arc::new(origin.files)))
        })?;
        let (before, worlds, backends) = Default::default();
        Ok(Study { study, files, before, worlds, backends })
    }

    /// Does a job with the backend that is named, which is kept open.
    pub(crate) fn with_backend<T: Send>(
        &self,
        py: Python<'_>,
        backend: BackendWords,
        job: impl FnOnce(&Listener, &mut dyn Backend) -> perirobot_march::Result<T> + Send,
    ) -> PyResult<T> {
        self.with_backend_shown(py, (backend, None), job)
    }

    /// The same, and shows how far it is.
    pub(crate) fn with_backend_shown<T: Send>(
        &self,
        py: Python<'_>,
        (backend, progress): (BackendWords, Option<Py<PyAny>>),
        job: impl FnOnce(&Listener, &mut dyn Backend) -> perirobot_march::Result<T> + Send,
    ) -> PyResult<T> {
        let open = self.backends.take();
        let (done, open) = run(py, progress.as_ref(), |listener| {
            open.use_backend(backend, listener, |backends| {
                let mut backend = backends.open(Fallback::None)?;
                let done = job(listener, &mut *backend)?;
                backends.take_back(backend);
                Ok(done)
            })
        })?;
        self.backends.put(py, open);
        Ok(done)
    }

    /// Fails if a file is another than when the study was pickled.
    fn check_files(&self) -> PyResult<()> {
        let now = self.read_files();
        let differs =
            |(path, sha256): &&ReadFile| now.iter().any(|file| file.0 == *path && file.1 != *sha256);
        match self.before.iter().find(differs) {
            None => Ok(()),
            Some((path, _)) => {
                let what =
                    Issue::says("has changed since the study was pickled").with_advice("pickle it again");
                Err(to_exception(&Error::from(what.with_place(path.as_str()))))
            }
        }
    }

    /// The scenes in voxels, if they were made already.
    pub(crate) fn ready_worlds(&self) -> Option<&[World]> {
        self.worlds.get().map(Vec::as_slice)
    }

    /// The number of a sensor that takes poses.
    pub(crate) fn sensor(&self, name: &str) -> PyResult<usize> {
        let known = self.sensors();
        let found = self.study.sensors.iter().position(|sensor| sensor.name == name && known.contains(&name));
        found.ok_or_else(|| {
            PyValueError::new_err(format!("sensor = {name:?}: must be one that takes poses: {known:?}"))
        })
    }

    /// The scenes in voxels, made when they are first asked for; then what is odd about them is warned of.
    pub(crate) fn worlds(&self, py: Python<'_>) -> PyResult<&[World]> {
        if self.worlds.get().is_none() {
            let made = run(py, None, |listener| World::prepare_all_unless(&self.study, listener))?;
            self.check_files()?;
            let odd = odd(&made);
            if !odd.is_empty() {
                warn(py, "of_scenes", (odd,))?;
            }
            // Another thread may have been quicker; its worlds are the same.
            let _ = self.worlds.set(made);
        }
        Ok(self.worlds.get().expect("they were made"))
    }
}

/// What is odd about scenes: a scene's name and words, for each thing.
pub(crate) fn odd(worlds: &[World]) -> Vec<(&str, &str)> {
    let mut odd = Vec::new();
    for world in worlds {
        odd.extend(world.warnings.iter().map(|text| (world.name.as_str(), text.as_str())));
    }
    odd
}
