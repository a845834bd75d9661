//! A study as Python has it: checked when it is made, its scenes in voxels from the first time they are needed.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use numpy::ndarray::ArrayView2;
use numpy::{IntoPyArray, PyArray3, PyArray6, PyReadonlyArray2, PyReadonlyArray3};
use perirobot_decide::view::{Choice, ChoiceSelector, find};
use perirobot_march::Error;
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::error::Issue;
use perirobot_scene::pose::{Pose, RotationFrame};
use perirobot_scene::source;
use perirobot_study::input::Overrides;
use perirobot_study::world::{World, share_kinds};
use perirobot_sweep::results::columns::{pose_names, representation_names};
use perirobot_sweep::results::jobs;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::backends::{BackendWords, LastBackends};
use crate::error::to_exception;
use crate::labels::{ViewNumbers, WorldGrid};
use crate::look::{AlterationWords, WishWords};
use crate::origin::{FileOrigin, MemoryFile, table};
use crate::recorded::{AskedWords, RecordedWords};
use crate::swept::Swept;
use crate::table::{Columns, baselines, columns};
use crate::watch::{Listener, run, warn};
use crate::{cheapest, choose, evaluate, folder, judge, labels, look, recorded, report, swept};

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
    backends: Arc<LastBackends>,
}

/// A file that was read, and its SHA-256.
pub(crate) type ReadFile = (String, String);

/// Labels, and whether a return comes from each voxel.
type LabelArrays<'py> = (Bound<'py, PyArray3<u8>>, Bound<'py, PyArray3<bool>>);

/// The names of a choice of poses: poses, combination, representation, scene; snapshot and repeat.
type ChoiceWords = (String, Option<String>, Option<String>, Option<String>, usize, usize);

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

    /// Finds the best set of sensors, and writes it into a folder.
    fn choose(
        &self,
        py: Python<'_>,
        out: PathBuf,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let worlds = self.worlds(py)?;
        run(py, progress.as_ref(), |listener| choose::search(&self.study, worlds, &backend, listener, &out))
    }

    /// Checks what [`Study::choose`] wrote: sets counted again; steps proven again, bounded, open.
    fn verify(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<[usize; 4]> {
        let worlds = self.worlds(py)?;
        run(py, progress.as_ref(), |listener| choose::check(&self.study, worlds, &backend, listener, &folder))
    }

    /// Finds the cheapest set that passes, and writes it into a folder.
    fn cheapest(
        &self,
        py: Python<'_>,
        out: PathBuf,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let worlds = self.worlds(py)?;
        run(py, progress.as_ref(), |listener| cheapest::search(&self.study, worlds, &backend, listener, &out))
    }

    /// Checks what [`Study::cheapest`] wrote: sets judged again, ways in followed again, claims searched again, open.
    fn verify_cheapest(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<[usize; 4]> {
        let worlds = self.worlds(py)?;
        run(py, progress.as_ref(), |listener| {
            cheapest::check(&self.study, worlds, &backend, listener, &folder)
        })
    }

    /// Judges what [`Study::choose`] wrote, and writes the verdicts beside it.
    fn judge(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let worlds = self.worlds(py)?;
        run(py, progress.as_ref(), |listener| judge::judge(&self.study, worlds, &backend, listener, &folder))
    }

    /// Scores a map or a point cloud in a file; the columns of the table, and of that of reasons.
    fn score_file(
        &self,
        py: Python<'_>,
        path: PathBuf,
        asked: AskedWords,
        words: RecordedWords,
    ) -> PyResult<[Columns; 2]> {
        let worlds = self.worlds(py)?;
        run(py, None, |listener| {
            let recording = recorded::file(&path, &asked, |remark| listener.warns_of_study(remark))?;
            recorded::score(&self.study, worlds, recording, words)
        })
    }

    /// Scores labels of voxels; the columns of the table, and of that of reasons.
    fn score_labels(
        &self,
        py: Python<'_>,
        labels: PyReadonlyArray3<'_, u8>,
        origin_m: [f64; 3],
        voxel_size_m: f64,
        words: RecordedWords,
    ) -> PyResult<[Columns; 2]> {
        let (worlds, labels) = (self.worlds(py)?, labels.as_array());
        run(py, None, |_| {
            recorded::score(&self.study, worlds, recorded::labels(labels, origin_m, voxel_size_m)?, words)
        })
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

    /// Why voxels stay unknown: in words, and the rows of `reasons.csv`.
    fn why(
        &self,
        py: Python<'_>,
        words: ChoiceWords,
        altered: AlterationWords,
        backend: BackendWords,
    ) -> PyResult<(String, Vec<u8>)> {
        let (worlds, wanted) = (self.worlds(py)?, selector(words));
        self.with_backend(py, backend, |_, backend| {
            look::why((&self.study, worlds), &wanted, look::alteration(altered), backend)
        })
    }

    /// How near bodies come unnoticed: the answers in words; the files are written into a folder.
    fn approach(
        &self,
        py: Python<'_>,
        words: ChoiceWords,
        altered: AlterationWords,
        out: PathBuf,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let (worlds, wanted) = (self.worlds(py)?, selector(words));
        run(py, progress.as_ref(), |listener| {
            look::approach((&self.study, worlds), &wanted, &look::alteration(altered), &out, listener)
        })
    }

    /// Writes what a choice of poses sees into a folder; names of files, and what they hold.
    fn export(
        &self,
        py: Python<'_>,
        words: ChoiceWords,
        altered: AlterationWords,
        out: PathBuf,
        backend: BackendWords,
    ) -> PyResult<Vec<(String, String)>> {
        let (worlds, wanted) = (self.worlds(py)?, selector(words));
        self.with_backend(py, backend, |_, backend| {
            look::export((&self.study, worlds), &wanted, look::alteration(altered), &out, backend)
        })
    }

    /// A picture of a scene, or of what a choice of poses makes of it: the bytes of a PNG or an SVG.
    fn render<'py>(
        &self,
        py: Python<'py>,
        words: ChoiceWords,
        altered: AlterationWords,
        wish: WishWords,
        backend: BackendWords,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let worlds = self.worlds(py)?;
        let (has_poses, wanted) = (!words.0.is_empty(), selector(words));
        let bytes = self.with_backend(py, backend, |_, backend| {
            let altered = look::alteration(altered);
            look::render((&self.study, worlds), (&wanted, has_poses), altered, &wish, backend)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes the page of a folder of results of this study.
    fn report(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        asked: (PathBuf, Option<usize>),
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let (worlds, (out, best)) = (self.worlds(py)?, asked);
        run(py, progress.as_ref(), |listener| {
            report::report((&self.study, worlds), &folder, (&out, best), &backend, listener)
        })
    }

    /// Judges a choice of poses, and writes the verdicts into a folder.
    fn judge_choice(
        &self,
        py: Python<'_>,
        words: ChoiceWords,
        out: PathBuf,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let (worlds, wanted) = (self.worlds(py)?, selector(words));
        run(py, progress.as_ref(), |listener| {
            judge::judge_choice((&self.study, worlds), &wanted, &backend, listener, &out)
        })
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

    /// Counts sensors at poses of Python's choice: the first of each entry together, the second of each and so on.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        poses: Vec<(String, PyReadonlyArray2<'py, f64>)>,
        is_optical: bool,
        backend: BackendWords,
    ) -> PyResult<Bound<'py, PyArray6<i64>>> {
        let worlds = self.worlds(py)?;
        let each = poses.iter().map(|(sensor, rows)| Ok((sensor, self.sensor(sensor)?, rows.as_array())));
        let each: Vec<(&String, usize, ArrayView2<f64>)> = each.collect::<PyResult<_>>()?;
        let frame = if is_optical { RotationFrame::Optical } else { RotationFrame::Link };
        let open = self.backends.take();
        let (counts, open) = run(py, None, |listener| {
            let poses = each.into_iter().map(|(name, sensor, rows)| {
                let poses = evaluate::poses(rows, frame);
                Ok((sensor, poses.map_err(|issue| issue.with_place(format!("sensor {name:?}")))?))
            });
            let poses: Vec<(usize, Vec<Pose>)> = poses.collect::<perirobot_march::Result<_>>()?;
            let study = self.study.elsewhere(&poses)?;
            let ways = |(sensor, _): &(usize, _)| study.sensors[*sensor].kind.representations().len();
            let ways = poses.iter().map(ways).product();
            worlds.iter().try_for_each(|world| world.examine_sensors(&study))?;
            let moved: Vec<World> = worlds.iter().map(|world| world.with_sensors(&study.sensors)).collect();
            open.use_backend(backend, listener, |backends| {
                evaluate::counts((&study, ways), &moved, backends, listener)
            })
        })?;
        self.backends.put(py, open);
        Ok(counts.into_pyarray(py))
    }

    /// Finds a choice of poses in a world by its names.
    fn find(&self, py: Python<'_>, words: ChoiceWords) -> PyResult<ViewNumbers> {
        let worlds = self.worlds(py)?;
        let (world, choice) =
            find(&self.study, worlds, &selector(words)).map_err(|error| to_exception(&error))?;
        let number = worlds.iter().position(|other| std::ptr::eq(other, world));
        let Choice { combination, choice, representation, repeat } = choice;
        Ok((number.expect("it is one of them"), [combination, choice, representation, repeat]))
    }

    /// The names of what a view looks at: scene, combination, poses and representation.
    fn names_of(&self, py: Python<'_>, view: ViewNumbers) -> PyResult<[String; 4]> {
        let (world, [combination, choice, representation, _]) = view;
        let (world, own) = (&self.worlds(py)?[world], &self.study.combinations[combination]);
        let representation = representation_names(&self.study, own).swap_remove(representation);
        Ok([world.name.clone(), own.name.clone(), pose_names(&self.study, own, choice), representation])
    }

    /// Of a world, scene and snapshot by number, the grid: its corner in metres, and how many voxels it has.
    fn grid(&self, py: Python<'_>, world: usize) -> PyResult<WorldGrid> {
        let worlds = self.worlds(py)?;
        let Some(world) = worlds.get(world) else {
            return Err(PyIndexError::new_err(format!("there is no world {world}")));
        };
        Ok(labels::grid(world))
    }

    /// The same of each world.
    fn grids(&self, py: Python<'_>) -> PyResult<Vec<WorldGrid>> {
        Ok(self.worlds(py)?.iter().map(labels::grid).collect())
    }

    /// What is truly there in a world, by its number: the planes of `labels::truth`.
    fn truth<'py>(&self, py: Python<'py>, world: usize) -> PyResult<Vec<Bound<'py, PyArray3<bool>>>> {
        let Some(world) = self.worlds(py)?.get(world) else {
            return Err(PyIndexError::new_err(format!("there is no world {world}")));
        };
        let planes = py.detach(|| labels::truth(world));
        planes.into_iter().map(|plane| labels::array(py, world.grid.size, plane)).collect()
    }

    /// The labels of whole grids, and which voxels returns come from; views of the same world follow each other.
    fn labels<'py>(
        &self,
        py: Python<'py>,
        views: Vec<ViewNumbers>,
        backend: BackendWords,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<LabelArrays<'py>>> {
        let worlds = self.worlds(py)?;
        let all = self.with_backend_shown(py, (backend, progress), |listener, backend| {
            labels::all(&self.study, worlds, &views, backend, listener)
        })?;
        let arrays = all
            .into_iter()
            .map(|(size, bytes, hits)| Ok((labels::array(py, size, bytes)?, labels::array(py, size, hits)?)));
        arrays.collect()
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
    fn with_backend<T: Send>(
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
    fn sensor(&self, name: &str) -> PyResult<usize> {
        let known = self.sensors();
        let found = self.study.sensors.iter().position(|sensor| sensor.name == name && known.contains(&name));
        found.ok_or_else(|| {
            PyValueError::new_err(format!("sensor = {name:?}: must be one that takes poses: {known:?}"))
        })
    }

    /// The scenes in voxels, made when they are first asked for; then what is odd about them is warned of.
    fn worlds(&self, py: Python<'_>) -> PyResult<&[World]> {
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

/// What is looked for, of its words.
fn selector((poses, combination, representation, scene, snapshot, repeat): ChoiceWords) -> ChoiceSelector {
    ChoiceSelector { poses, combination, representation, scene, snapshot, repeat }
}

/// What is odd about scenes: a scene's name and words, for each thing.
pub(crate) fn odd(worlds: &[World]) -> Vec<(&str, &str)> {
    let mut odd = Vec::new();
    for world in worlds {
        odd.extend(world.warnings.iter().map(|text| (world.name.as_str(), text.as_str())));
    }
    odd
}
