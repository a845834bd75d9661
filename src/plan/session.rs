//! A study that is open in the planner: its text, what is counted of it, and who may change it. Requests of the page are
//! answered here; `answers` has what they look like as JSON.

use std::collections::HashMap;
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::Duration;

use glam::DVec3;
use perirobot_march::backend::factory::{BackendChoice, ChosenBackends};
use perirobot_march::error::Issue;
use perirobot_march::metrics::Confusion;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Planned, PlannedAt, Study};
use perirobot_study::world::World;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::json;
use tempfile::TempDir;

use crate::answers::{
    CellAnswer, JudgeReply, MomentsReply, MoveRequest, SceneryReply, ScoreQuestion, ScoreReply, VoxelWord,
    WhyReply,
};
use crate::document::{Document, EditRequest, Known, PlacedName, rounded};
use crate::find::{FindEvent, FindRequest, find};
use crate::live::{Live, Resolution, ScoreRequest, coarse_voxel_m};
use crate::page;
use crate::problem::Problem;
use crate::server::{Body, Method, Request, Response};
use crate::state::{CellState, State};
use crate::study_file::{Saved, StudyFile};

/// Reads a study from a text that may differ from that of its file.
pub trait StudyReader: Sync {
    /// Reads and checks it; in voxels of this size, if one is given.
    ///
    /// # Errors
    /// All that is wrong with it.
    fn read(&self, text: &str, voxel_size_m: Option<f64>) -> Result<Study, Vec<Error>>;
}

/// A study that is open.
pub struct Session<'a> {
    reader: &'a dyn StudyReader,
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
    html: String,
    policy: String,
}

/// The study as a person edits it.
struct Desk {
    file: StudyFile,
    document: Document,
    version: u64,
    worlds: u64,
    was_saved: bool,
    problems: Vec<Problem>,
    notes: Vec<String>,
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

#[derive(Deserialize)]
struct SaveQuestion {
    #[serde(default)]
    overwrite: bool,
}

#[derive(Deserialize)]
struct WhyQuestion {
    #[serde(default)]
    n: u64,
    moment: usize,
    at_m: [f64; 3],
}

#[derive(Deserialize)]
struct JudgeQuestion {
    #[serde(default)]
    n: u64,
    #[serde(default)]
    dead: Option<usize>,
    /// Which window of the page asks.
    #[serde(default)]
    window: u64,
}

/// Locks, also after another thread has panicked: what is counted is made anew for each question.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Session<'a> {
    /// Opens a study. One with errors is open, too: the page shows them.
    ///
    /// # Errors
    /// When its file cannot be read; `Error::Busy` if another planner has it open; when no backend can be opened.
    pub fn open(
        path: &Path,
        reader: &'a dyn StudyReader,
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
            document,
            version: 0,
            worlds: 0,
            was_saved: false,
            problems: Vec::new(),
            notes: Vec::new(),
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
            (Method::Get, "/difference") => json_of(&locked(&self.desk).document.difference()),
            (Method::Get, "/scenery") => self.scenery(request),
            (Method::Get, "/cell") => self.cell(request),
            (Method::Get, "/eye") => self.eye(request),
            (Method::Get, "/listed") => self.listed(request),
            (Method::Post, "/score") => self.score(request),
            (Method::Post, "/judge") => self.judge(request),
            (Method::Post, "/moments") => self.moments(request),
            (Method::Post, "/why") => self.why(request),
            (Method::Post, "/edit") => self.edit(request),
            (Method::Post, "/undo") => self.step(Document::undo),
            (Method::Post, "/redo") => self.step(Document::redo),
            (Method::Post, "/save") => self.save(request),
            (Method::Post, "/reload") => self.reload(),
            (Method::Post, "/choose") => self.find(request),
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
        let read = self.reader.read(text, None).and_then(|study| {
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
        let coarse = self.reader.read(text, Some(coarse_m)).ok();
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
                let cell = Arc::new(CellState::new(&study, &worlds, &placed, coarse_m));
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
            name: path.file_name().unwrap_or_default().to_string_lossy().into(),
            path: shown,
            read_only: self.read_only,
            changed: desk.document.is_changed(),
            can_undo: desk.document.can_undo(),
            can_redo: desk.document.can_redo(),
            disk_changed: desk.file.is_changed_on_disk(),
            problems: desk.problems.clone(),
            notes: desk.notes.clone(),
            changed_index: desk.changed_index,
            saved: desk.was_saved,
            worlds: desk.worlds,
            cell: desk.loaded.as_ref().map_or_else(CellState::default, |loaded| (*loaded.cell).clone()),
        };
        Response::json(serde_json::to_vec(&state).expect("a state is JSON"))
    }

    fn text(&self) -> Answer<'_> {
        let desk = locked(&self.desk);
        let known = desk.loaded.as_ref().map_or_else(Arc::default, |loaded| loaded.known.clone());
        let plan = desk.document.plan_text(&known).unwrap_or_default();
        json_of(&json!({ "text": desk.document.text(), "plan": plan }))
    }

    fn scenery(&self, request: &Request) -> Answer<'_> {
        let moment = number(request, "moment")?;
        json_of(&SceneryReply::new(&self.lock_ready().parts()?.0.scenery(moment)?))
    }

    fn cell(&self, request: &Request) -> Answer<'_> {
        let moment = number(request, "moment")?;
        let wanted = match request.value("voxel") {
            Some("coarse") => Resolution::Coarse,
            _ => Resolution::Fine,
        };
        let mut ready = self.lock_ready();
        let (live, _) = ready.parts()?;
        let resolution = possible(live, wanted);
        let worlds = live.worlds(resolution)?;
        let world = worlds.get(moment).ok_or_else(|| no_moment(moment, worlds.len()))?;
        json_of(&CellAnswer::new(world))
    }

    fn eye(&self, request: &Request) -> Answer<'_> {
        let (index, moment) = (number(request, "index")?, number(request, "moment")?);
        let mut ready = self.lock_ready();
        let (live, loaded) = ready.parts()?;
        let plan = plan_of(loaded, None)?;
        if index >= plan.len() {
            return Err(no_sensor(index, plan.len()));
        }
        Ok(Response::new(200, "image/png", live.eye(&plan, index, moment)?))
    }

    /// What each listed pose of a sensor would see alone, a line each as it is counted. Whatever a person does goes first.
    fn listed(&self, request: &Request) -> Answer<'_> {
        let [sensor, moment, region] = ["sensor", "moment", "region"].map(|key| number(request, key));
        let (sensor, moment, region) = (sensor?, moment?, region?);
        let (loaded, version) = {
            let desk = locked(&self.desk);
            (desk.loaded.clone().ok_or_else(|| Refused(400, "the study has errors".into()))?, desk.version)
        };
        let Some(spec) = loaded.study.sensors.get(sensor) else {
            return Err(Refused(400, format!("there is no sensor {sensor} in the study")));
        };
        if region >= loaded.study.regions.len() || moment >= loaded.worlds.len() {
            return Err(Refused(400, "there is no such region or moment".into()));
        }
        let names: Vec<String> = spec.candidates.iter().map(|candidate| candidate.name.clone()).collect();
        let stream = move |out: &mut dyn Write| {
            for (pose, name) in names.iter().enumerate() {
                let Some(mut ready) = self.lock_ready_at_rest(version) else { return Ok(()) };
                let plan = vec![Planned { sensor, at: PlannedAt::Listed(pose) }];
                let resolution = possible(&mut ready.live, Resolution::Coarse);
                let ask = ScoreRequest { plan, moment, repeat: 0, resolution, dead: None };
                let counted = ready.live.score(&ask);
                drop(ready);
                let score = counted.ok().and_then(|answer| worth(answer.counts.get(region)?));
                writeln!(out, "{}", json!({ "pose": name, "score": score }))?;
            }
            Ok(())
        };
        Ok(Response { status: 200, content_type: LINES, body: Body::Stream(Box::new(stream)) })
    }

    /// What is counted, for something that nobody waits for; `None` if the study is another by now, or all ends.
    fn lock_ready_at_rest(&self, version: u64) -> Option<MutexGuard<'_, Ready>> {
        loop {
            if locked(&self.desk).version != version || self.is_ending.load(Ordering::Relaxed) {
                return None;
            }
            if self.waiting.load(Ordering::Relaxed) == 0 {
                return Some(locked(&self.ready));
            }
            std::thread::sleep(GIVES_WAY);
        }
    }

    fn score(&self, request: &Request) -> Answer<'_> {
        let mut question: ScoreQuestion = read(request)?;
        let mut ready = self.lock_ready();
        let (live, loaded) = ready.parts()?;
        let plan = plan_of(loaded, question.r#move.as_ref())?;
        check_dead(question.dead, &plan)?;
        let resolution = possible(live, question.voxel.resolution());
        if resolution == Resolution::Fine {
            question.voxel = VoxelWord::Fine;
        }
        let ask = ScoreRequest { plan, moment: question.moment, repeat: 0, resolution, dead: question.dead };
        let answer = live.score(&ask)?;
        // What each sensor adds: what is lost without it. Asked only of a plan at rest.
        let mut without = Vec::new();
        if question.r#move.is_none() && question.dead.is_none() && ask.plan.len() > 1 {
            for index in 0..ask.plan.len() {
                without.push(live.score(&ScoreRequest { dead: Some(index), ..ask.clone() })?.counts);
            }
        }
        let world = &live.worlds(resolution)?[question.moment];
        json_of(&ScoreReply::new(&question, &answer, &without, (&loaded.study, world)))
    }

    /// The counts of all moments.
    fn moments(&self, request: &Request) -> Answer<'_> {
        let JudgeQuestion { n, dead, window } = read(request)?;
        self.while_newest((&self.countings, window), |ready, progress| {
            let (live, loaded) = ready.parts()?;
            let plan = plan_of(loaded, None)?;
            check_dead(dead, &plan)?;
            let moments = live.moments(&plan, dead, progress)?;
            json_of(&MomentsReply::new(n, &moments, &loaded.study))
        })
    }

    fn judge(&self, request: &Request) -> Answer<'_> {
        let JudgeQuestion { n, dead, window } = read(request)?;
        self.while_newest((&self.judgings, window), |ready, progress| {
            let (live, loaded) = ready.parts()?;
            let plan = plan_of(loaded, None)?;
            check_dead(dead, &plan)?;
            let judged = live.judge(&plan, dead, progress)?;
            json_of(&JudgeReply::new(n, &judged, loaded.cell.budget, (&loaded.study, &loaded.worlds)))
        })
    }

    /// Does work of which only the newest is wanted. A request that waits goes first; then the work begins again.
    fn while_newest<'s>(
        &self,
        (asked, window): (&Mutex<HashMap<u64, u64>>, u64),
        work: impl Fn(&mut Ready, &dyn Progress) -> Result<Response<'s>, Refused>,
    ) -> Answer<'s> {
        let own = {
            let mut latest = locked(asked);
            let own = latest.entry(window).or_default();
            *own += 1;
            *own
        };
        let is_newest =
            || locked(asked).get(&window) == Some(&own) && !self.is_ending.load(Ordering::Relaxed);
        loop {
            let progress = || {
                let gives_way = self.waiting.load(Ordering::Relaxed) > 0;
                (!is_newest() || gives_way).then(|| "a newer question came".to_string())
            };
            match work(&mut locked(&self.ready), &progress) {
                Err(Refused(STOPPED, _)) if is_newest() => std::thread::sleep(GIVES_WAY),
                Err(Refused(STOPPED, _)) => return json_of(&json!({ "superseded": true })),
                done => return done,
            }
        }
    }

    fn why(&self, request: &Request) -> Answer<'_> {
        let WhyQuestion { n, moment, at_m } = read(request)?;
        let mut ready = self.lock_ready();
        let (live, loaded) = ready.parts()?;
        let plan = plan_of(loaded, None)?;
        let answer = live.why(&plan, moment, DVec3::from_array(at_m))?;
        json_of(&WhyReply::new(n, &answer))
    }

    fn edit(&self, request: &Request) -> Answer<'_> {
        self.may_write()?;
        let EditRequest { edit, gesture } = read(request)?;
        let is_typed = matches!(edit, crate::document::Edit::SetText { .. });
        let mut desk = locked(&self.desk);
        if !is_typed && !desk.problems.is_empty() {
            return Err(Refused(400, "the study has errors: repair its text first".into()));
        }
        let before = desk.document.clone();
        let known =
            desk.loaded.as_ref().map_or_else(|| Arc::new(Known::catalogue()), |one| one.known.clone());
        desk.changed_index = desk.document.apply(&edit, gesture, &known)?;
        let was_right = desk.problems.is_empty();
        self.load(&mut desk);
        if was_right && !is_typed && !desk.problems.is_empty() {
            let words = desk.problems[0].words.clone();
            desk.document = before;
            self.load(&mut desk);
            return Err(Refused(400, words));
        }
        let state = self.state(&desk);
        desk.changed_index = None;
        Ok(state)
    }

    fn step(&self, step: impl Fn(&mut Document) -> bool) -> Answer<'_> {
        self.may_write()?;
        let mut desk = locked(&self.desk);
        if step(&mut desk.document) {
            self.load(&mut desk);
        }
        Ok(self.state(&desk))
    }

    fn save(&self, request: &Request) -> Answer<'_> {
        self.may_write()?;
        let SaveQuestion { overwrite } = read(request)?;
        let mut desk = locked(&self.desk);
        let Desk { file, document, .. } = &mut *desk;
        match file.save(document.text(), overwrite)? {
            Saved::ChangedOnDisk => {
                let words = "another program has changed the file since it was opened";
                Ok(Response::new(
                    409,
                    "application/json",
                    json!({ "error": words, "changed_on_disk": true }).to_string(),
                ))
            }
            Saved::Written => {
                document.saved();
                desk.was_saved = true;
                Ok(self.state(&desk))
            }
        }
    }

    /// Takes the file as another program has written it, in place of what was edited here.
    fn reload(&self) -> Answer<'_> {
        self.may_write()?;
        let mut desk = locked(&self.desk);
        desk.file.reload()?;
        desk.document = Document::new(desk.file.text().to_string());
        self.load(&mut desk);
        Ok(self.state(&desk))
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
        Ok(Response { status: 200, content_type: LINES, body: Body::Stream(Box::new(stream)) })
    }

    fn may_write(&self) -> Result<(), Refused> {
        match self.read_only {
            true => Err(Refused(403, "the study is open to be read only".into())),
            false => Ok(()),
        }
    }
}

/// How much a pose shows of a region: of people's voxels, if there are any, else of all.
fn worth(counts: &Confusion) -> Option<f64> {
    counts.human_seen().or_else(|| counts.unknown().map(|unknown| 1.0 - unknown))
}

/// The wanted voxels, or those of the study if a thin region or zone has none of the larger ones.
fn possible(live: &mut Live, wanted: Resolution) -> Resolution {
    match wanted == Resolution::Coarse && live.worlds(Resolution::Coarse).is_ok() {
        true => Resolution::Coarse,
        false => Resolution::Fine,
    }
}

/// The indexes of placed sensors and their poses.
fn placed_of(study: &Study, names: &[PlacedName]) -> Result<Vec<[usize; 2]>> {
    let index = |PlacedName { sensor, pose }: &PlacedName| {
        let number = study.sensors.iter().position(|known| known.name == *sensor)?;
        let candidates = &study.sensors[number].candidates;
        Some([number, candidates.iter().position(|known| known.name == *pose)?])
    };
    let found = |name: &PlacedName| {
        index(name).ok_or_else(|| {
            let words = format!("has no pose {:?} of sensor {:?}", name.pose, name.sensor);
            Error::from(Issue::says(words).with_place(&study.path))
        })
    };
    names.iter().map(found).collect()
}

/// The plan, with the change that a person is about to make.
fn plan_of(loaded: &Loaded, change: Option<&MoveRequest>) -> Result<Vec<Planned>, Refused> {
    let Loaded { study, placed, .. } = loaded;
    let listed = |&[sensor, pose]: &[usize; 2]| Planned { sensor, at: PlannedAt::Listed(pose) };
    let mut plan: Vec<Planned> = placed.iter().map(listed).collect();
    let at = |sensor: usize, at: &crate::document::Pose6| -> Result<PlannedAt, Refused> {
        at.check()?;
        Ok(PlannedAt::Pose(rounded(at, study.sensors[sensor].kind.stance())))
    };
    match change {
        None => {}
        Some(MoveRequest { index: Some(index), at: to, pose, .. }) => {
            let Some(&[sensor, _]) = placed.get(*index) else { return Err(no_sensor(*index, placed.len())) };
            let named = pose.as_ref().and_then(|pose| {
                study.sensors[sensor].candidates.iter().position(|known| known.name == *pose)
            });
            plan[*index].at = match named {
                Some(pose) => PlannedAt::Listed(pose),
                None => at(sensor, to)?,
            };
        }
        Some(MoveRequest { add: Some(device), at: to, .. }) => {
            // A device of the catalogue has no rays before the study has it.
            let known = device.sensor.as_ref();
            let number = known.and_then(|name| study.sensors.iter().position(|sensor| sensor.name == *name));
            if let Some(sensor) = number {
                plan.push(Planned { sensor, at: at(sensor, to)? });
            }
        }
        Some(_) => return Err(Refused(400, "a move has an index of the plan, or what is added".into())),
    }
    Ok(plan)
}

fn check_dead(dead: Option<usize>, plan: &[Planned]) -> Result<(), Refused> {
    match dead {
        Some(dead) if dead >= plan.len() => Err(no_sensor(dead, plan.len())),
        _ => Ok(()),
    }
}

fn no_sensor(index: usize, count: usize) -> Refused {
    Refused(400, format!("there is no sensor {index}: {count} are placed"))
}

fn no_moment(moment: usize, count: usize) -> Refused {
    Refused(400, format!("there is no moment {moment}: the study has {count}"))
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
