//! A study that is open in the planner: its text, what is counted of it, and who may change it. Requests of the page are
//! answered here: `counting` and `editing` have most of them, `answers` what they look like as JSON.

mod counting;
mod editing;
mod leaving;
mod plan;
mod scene_files;

use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::Duration;

use perirobot_march::backend::factory::{BackendChoice, ChosenBackends};
use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_study::world::World;
use serde::de::DeserializeOwned;
use serde_json::json;
use tempfile::TempDir;

use self::leaving::KeptPaper;
use self::plan::placed_of;
use self::scene_files::SceneFiles;
use crate::document::{Document, Known};
use crate::find::{FindEvent, FindRequest, find};
use crate::live::{Live, Resolution, coarse_voxel_m};
use crate::page;
use crate::problem::Problem;
use crate::server::{Method, PAPERS, Request, Response};
use crate::state::{CellState, State};
use crate::study_file::StudyFile;

/// Reads a study from texts that may differ from those of its files.
pub trait StudyReader: Send + Sync {
    /// Reads and checks it, with the texts of some of the files that it names, by their paths; in voxels of this size, if
    /// one is given.
    ///
    /// # Errors
    /// All that is wrong with it.
    fn read(
        &self,
        text: &str,
        files: &[(PathBuf, String)],
        voxel_size_m: Option<f64>,
    ) -> Result<Study, Vec<Error>>;
}

/// A study that is open.
pub struct Session<'a> {
    reader: Box<dyn StudyReader + 'a>,
    backend: BackendChoice,
    read_only: bool,
    desk: Mutex<Desk>,
    ready: Mutex<Ready>,
    /// Requests that wait for what is counted at once; judging gives way to them.
    waiting: AtomicUsize,
    /// The latest question of each window to judge, and to count all moments: only that is answered.
    judgings: Mutex<HashMap<u64, u64>>,
    countings: Mutex<HashMap<u64, u64>>,
    /// One search at a time, and what stops it.
    finding: Mutex<()>,
    stop_finding: AtomicBool,
    is_ending: AtomicBool,
    /// Where the evidence of searches is kept.
    evidence: TempDir,
    /// Reports and mounting sheets, the newest last.
    papers: Mutex<Vec<KeptPaper>>,
    html: String,
    policy: String,
}

/// The study as a person edits it.
struct Desk {
    file: StudyFile,
    /// The files of its scenes.
    scenes: SceneFiles,
    document: Document,
    version: u64,
    worlds: u64,
    was_saved: bool,
    problems: Vec<Problem>,
    /// Which sensor of the plan the edit under way changed.
    changed_index: Option<usize>,
    /// The last text that was right.
    loaded: Option<Loaded>,
}

/// What is counted, and the study that it is counted of: both change together.
struct Ready {
    live: Live,
    loaded: Option<Loaded>,
}

/// A study that was read and is ready to be counted.
#[derive(Clone)]
struct Loaded {
    study: Arc<Study>,
    worlds: Arc<Vec<World>>,
    known: Arc<Known>,
    /// Sensors and poses of the plan, in its order.
    placed: Vec<[usize; 2]>,
    cell: Arc<CellState>,
}

/// The status of work that was stopped, as newer work came.
const STOPPED: u16 = 409;

/// How long work that gives way waits before it looks again.
const GIVES_WAY: Duration = Duration::from_millis(20);

/// The type of an answer that grows line by line, each of them JSON.
const LINES: &str = "application/x-ndjson";

/// What is wrong with a request, and the status that says so.
struct Refused(u16, String);

impl From<Error> for Refused {
    fn from(error: Error) -> Refused {
        let status = match error {
            Error::Input(_) => 400,
            Error::Busy(_) | Error::Stopped(_) => STOPPED,
            _ => 500,
        };
        Refused(status, error.to_string())
    }
}

impl Ready {
    fn parts(&mut self) -> Result<(&mut Live, &Loaded), Refused> {
        let Ready { live, loaded } = self;
        let loaded = loaded.as_ref();
        Ok((live, loaded.ok_or_else(|| Refused(400, "the study has errors: repair them first".into()))?))
    }
}

type Answer<'s> = Result<Response<'s>, Refused>;

/// Locks, also after another thread has panicked: what is counted is made anew for each question.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Session<'a> {
    /// Opens a study. One with errors is open, too: the page shows them.
    ///
    /// # Errors
    /// When its file cannot be read; `Error::Busy` if another planner has it open; when no backend can be opened.
    pub fn open(
        path: &Path,
        reader: Box<dyn StudyReader + 'a>,
        backend: &BackendChoice,
        read_only: bool,
    ) -> Result<Session<'a>> {
        let file = StudyFile::open(path, read_only)?;
        let (backends, unused) = ChosenBackends::open(backend)?;
        if let Some(reason) = unused {
            log::warn!("{reason}; using the CPU instead");
        }
        let no_folder = |e| Error::io(&std::env::temp_dir(), "cannot hold a folder", e);
        let evidence = tempfile::Builder::new().prefix("perirobot-plan-").tempdir().map_err(no_folder)?;
        let (html, policy) = page::html();
        let document = Document::new(file.text().to_string());
        let desk = Desk {
            file,
            scenes: SceneFiles::default(),
            document,
            version: 0,
            worlds: 0,
            was_saved: false,
            problems: Vec::new(),
            changed_index: None,
            loaded: None,
        };
        let session = Session {
            reader,
            backend: backend.clone(),
            read_only,
            desk: Mutex::new(desk),
            ready: Mutex::new(Ready { live: Live::new(backends), loaded: None }),
            waiting: AtomicUsize::new(0),
            judgings: Mutex::default(),
            countings: Mutex::default(),
            finding: Mutex::new(()),
            stop_finding: AtomicBool::new(false),
            is_ending: AtomicBool::new(false),
            evidence,
            papers: Mutex::default(),
            html,
            policy,
        };
        session.load(&mut locked(&session.desk));
        Ok(session)
    }

    /// The Content-Security-Policy of the page.
    pub fn policy(&self) -> &str {
        &self.policy
    }

    /// Whether there are changes that were not saved.
    pub fn is_changed(&self) -> bool {
        locked(&self.desk).document.is_changed()
    }

    /// Ends searches that are under way.
    pub fn stop(&self) {
        self.is_ending.store(true, Ordering::Relaxed);
        self.stop_finding.store(true, Ordering::Relaxed);
    }

    /// Answers a request that was let in.
    pub fn answer(&self, request: &Request) -> Response<'_> {
        let answer = match (request.method, request.path.as_str()) {
            (Method::Get, "/") => Ok(Response::new(200, "text/html; charset=utf-8", self.html.clone())),
            (Method::Get, "/state") => Ok(self.state(&locked(&self.desk))),
            (Method::Get, "/text") => self.text(),
            (Method::Get, "/difference") => self.difference(),
            (Method::Get, "/scenery") => self.scenery(request),
            (Method::Get, "/cell") => self.cell(request),
            (Method::Get, "/eye") => self.eye(request),
            (Method::Get, "/listed") => self.listed(request),
            (Method::Post, "/score") => self.score(request),
            (Method::Post, "/judge") => self.judge(request),
            (Method::Post, "/moments") => self.moments(request),
            (Method::Post, "/why") => self.why(request),
            (Method::Post, "/edit") => self.edit(request),
            (Method::Post, "/undo") => self.step(request, Document::undo),
            (Method::Post, "/redo") => self.step(request, Document::redo),
            (Method::Post, "/save") => self.save(request),
            (Method::Post, "/reload") => self.reload(request),
            (Method::Post, "/choose") => self.find(request),
            (Method::Post, "/paper") => self.make_paper(request),
            (Method::Get, path) if path.starts_with(PAPERS) => self.show_paper(&path[PAPERS.len()..]),
            (Method::Post, "/stop") => {
                self.stop_finding.store(true, Ordering::Relaxed);
                Ok(Response::json("{}"))
            }
            _ => Err(Refused(404, format!("{} is not a part of the planner", request.path))),
        };
        answer.unwrap_or_else(|Refused(status, words)| Response::error(status, &words))
    }

    /// Reads the text as it is now. If it is wrong, the last one that was right stays to be looked at.
    fn load(&self, desk: &mut Desk) {
        desk.version += 1;
        let text = desk.document.text();
        let path = desk.file.path().to_path_buf();
        let problems = |errors: &[Error]| errors.iter().map(|e| Problem::new(e, &path, text)).collect();
        let files = desk.scenes.texts(&desk.document);
        let read = self.reader.read(text, &files, None).and_then(|study| {
            let known = Known::new(&study);
            let names = desk.document.plan(&known).map_err(|error| vec![error])?;
            let placed = placed_of(&study, &names).map_err(|error| vec![error])?;
            Ok((study, known, placed))
        });
        let (study, known, placed) = match read {
            Ok(read) => read,
            Err(errors) => {
                desk.problems = problems(&errors);
                return;
            }
        };
        let coarse_m = coarse_voxel_m(study.voxel_size_m);
        let coarse = self.reader.read(text, &files, Some(coarse_m)).ok();
        let mut ready = self.lock_ready();
        let study = Arc::new(study);
        let worlds =
            ready.live.set_study((*study).clone(), coarse, &|| self.ending_reason()).and_then(|is_new| {
                desk.worlds += u64::from(is_new);
                Ok(ready.live.worlds(Resolution::Fine)?.to_vec())
            });
        match worlds {
            Err(error) => desk.problems = problems(&[error]),
            Ok(worlds) => {
                let Desk { file, scenes, document, .. } = &mut *desk;
                scenes.meet(file.path(), &study, document, self.read_only);
                let (files, of_scenes) = scenes.states(&study, document);
                let cell = CellState::new(&study, &worlds, &placed, coarse_m);
                let cell = Arc::new(cell.with_files(files, &of_scenes));
                let (worlds, known) = (Arc::new(worlds), Arc::new(known));
                ready.loaded = Some(Loaded { study, worlds, known, placed, cell });
                desk.loaded = ready.loaded.clone();
                desk.problems = Vec::new();
            }
        }
    }

    fn ending_reason(&self) -> Option<String> {
        self.is_ending.load(Ordering::Relaxed).then(|| "the planner ends".to_string())
    }

    /// Locks what is counted for something that is done at once: judging gives way.
    fn lock_ready(&self) -> MutexGuard<'_, Ready> {
        self.waiting.fetch_add(1, Ordering::Relaxed);
        let ready = locked(&self.ready);
        self.waiting.fetch_sub(1, Ordering::Relaxed);
        ready
    }

    fn state(&self, desk: &Desk) -> Response<'_> {
        let path = desk.file.path();
        let shown = path.display().to_string();
        let state = State {
            version: desk.version,
            name: desk.file.name(),
            path: shown,
            read_only: self.read_only,
            changed: desk.document.is_changed(),
            can_undo: desk.document.can_undo(),
            can_redo: desk.document.can_redo(),
            disk_changed: !desk.changed_on_disk().is_empty(),
            problems: desk.problems.clone(),
            changed_index: desk.changed_index,
            saved: desk.was_saved,
            worlds: desk.worlds,
            cell: desk.loaded.as_ref().map_or_else(CellState::default, |loaded| (*loaded.cell).clone()),
        };
        Response::json(serde_json::to_vec(&state).expect("a state is JSON"))
    }

    fn difference(&self) -> Answer<'_> {
        let desk = locked(&self.desk);
        json_of(&desk.document.difference(&desk.file.name()))
    }

    fn text(&self) -> Answer<'_> {
        let desk = locked(&self.desk);
        let known = desk.loaded.as_ref().map_or_else(Arc::default, |loaded| loaded.known.clone());
        let plan = desk.document.plan_text(&known).unwrap_or_default();
        let scenes = desk.scenes.changed_texts(desk.file.path(), &desk.document);
        let text = desk.document.text();
        json_of(&json!({ "text": text, "plan": plan, "scenes": scenes, "version": desk.version }))
    }

    fn find(&self, request: &Request) -> Answer<'_> {
        let question: FindRequest = read(request)?;
        let loaded = self.lock_ready().parts()?.1.clone();
        let stream = move |out: &mut dyn Write| {
            // The search before gives way.
            self.stop_finding.store(true, Ordering::Relaxed);
            let _alone = locked(&self.finding);
            self.stop_finding.store(self.is_ending.load(Ordering::Relaxed), Ordering::Relaxed);
            let study = (&*loaded.study, loaded.worlds.as_slice());
            std::thread::scope(|scope| {
                let (sender, events) = mpsc::channel();
                scope.spawn(move || {
                    let emit = |event: FindEvent| drop(sender.send(event));
                    let folder = self.evidence.path();
                    if let Err(error) =
                        find(study, &question, &self.backend, folder, &self.stop_finding, &emit)
                    {
                        emit(FindEvent::Error(error.to_string()));
                    }
                });
                for event in events {
                    let line = serde_json::to_string(&event).expect("an event is JSON") + "\n";
                    if out.write_all(line.as_bytes()).is_err() {
                        self.stop_finding.store(true, Ordering::Relaxed);
                    }
                }
            });
            Ok(())
        };
        Ok(Response::stream(LINES, stream))
    }
}

/// A number of the query.
fn number(request: &Request, key: &str) -> Result<usize, Refused> {
    let found = request.value(key).and_then(|value| value.parse().ok());
    found.ok_or_else(|| Refused(400, format!("{key} must be a whole number")))
}

/// What a request says.
fn read<T: DeserializeOwned>(request: &Request) -> Result<T, Refused> {
    serde_json::from_slice(&request.body)
        .map_err(|e| Refused(400, format!("the request is not understood: {e}")))
}

fn json_of<'s>(answer: &impl serde::Serialize) -> Answer<'s> {
    Ok(Response::json(serde_json::to_vec(answer).expect("an answer is JSON")))
}
