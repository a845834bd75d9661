//! A device that fails, or counts wrongly, on cue. Failed work goes to another backend, nothing is lost and
//! all is written down; a wrong count stops the run, with both counts in a file. What is asked of Python is answered,
//! too.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::common;
use crate::common::program::Folder;
use crate::common::watch::Onlooker;
use perirobot_march::backend::adapter::AdapterChoice;
use perirobot_march::backend::factory::{BackendFactory, Fallback, KeptBackends};
use perirobot_march::backend::gpu::{Gpu, Stage, shader_source};
use perirobot_march::backend::{
    Backend, Evidence, Fusion, GridPose, Planes, Rays, Reading, Shot, Slot, StageTiming, VoxelScene,
    cpu::Cpu, oracle::Oracle, self_test,
};
use perirobot_march::error::Issue;
use perirobot_march::metrics::Confusion;
use perirobot_march::{Error, Result};
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::sensor::{self, Setting};
use perirobot_study::world::{World, ray_tables};
use perirobot_sweep::results::files::{DISAGREED, DISAGREEMENT, JOURNAL};
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::results::manifest::Manifest;
use perirobot_sweep::scoring::session::{Ending, RunReport, Session};
use perirobot_sweep::scoring::{run, run_on};

/// What a device is asked to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Call {
    Open,
    Load,
    Sense,
    Submit,
    Receive,
}

/// What it does instead.
#[derive(Clone, Copy)]
pub(crate) enum Trouble {
    Fails(&'static str),
    /// Is not there, or fits nothing: what would be the user's fault, had it not been there before.
    Gone,
    /// Answers, with a voxel of the first region more than there is.
    Lies,
    /// Answers less than it was asked for.
    Forgets,
    /// Panics in a worker thread, as a bug of its backend does.
    Panics(&'static str),
}

/// Says what goes wrong: told the call, the fallback, and how many such calls there were before in that
/// fallback.
type Cue = Box<dyn FnMut(Call, Fallback, usize) -> Option<Trouble> + Send>;

/// The cue, and the calls so far.
pub(crate) struct Script {
    cue: Cue,
    calls: Vec<(Call, Fallback)>,
}

impl Script {
    fn next(&mut self, call: Call, fallback: Fallback) -> Option<Trouble> {
        let before = self.calls.iter().filter(|earlier| **earlier == (call, fallback)).count();
        self.calls.push((call, fallback));
        (self.cue)(call, fallback, before)
    }
}

/// A CPU that passes for a device which does as its script says.
struct Actor {
    inner: Cpu,
    fallback: Fallback,
    script: Arc<Mutex<Script>>,
}

impl Actor {
    /// Whether it can do what it is asked.
    fn can(&self, call: Call) -> Result<()> {
        let trouble = self.script.lock().unwrap().next(call, self.fallback);
        match trouble {
            Some(Trouble::Panics(what)) => {
                rayon::join(|| (), || break_down(what));
                Ok(())
            }
            Some(Trouble::Fails(what)) => Err(Error::device(format!("adapter Actor: {what}"))),
            Some(Trouble::Gone) => Err(Issue::says("there is no adapter").into()),
            _ => Ok(()),
        }
    }
}

fn break_down(what: &str) {
    panic!("{what}");
}

impl Backend for Actor {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn device(&self) -> String {
        "Actor".into()
    }

    fn tables(&mut self, tables: &[Rays]) -> Result<()> {
        self.inner.tables(tables)
    }

    fn load(&mut self, scene: &VoxelScene) -> Result<()> {
        self.can(Call::Load)?;
        self.inner.load(scene)
    }

    fn slots(&self) -> usize {
        // Few, so that there are many batches.
        self.inner.slots().min(8)
    }

    fn first_hit_slots(&self) -> usize {
        self.inner.first_hit_slots()
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        self.can(Call::Sense)?;
        self.inner.sense(table, shots)
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        self.inner.upload(evidence)
    }

    fn submit(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        self.can(Call::Submit)?;
        self.inner.submit(fusion, jobs)
    }

    fn receive(&mut self) -> Result<Vec<Vec<Confusion>>> {
        let trouble = self.script.lock().unwrap().next(Call::Receive, self.fallback);
        let mut answer = self.inner.receive()?;
        match trouble {
            Some(Trouble::Fails(what)) => return Err(Error::device(format!("adapter Actor: {what}"))),
            Some(Trouble::Lies) => {
                answer[0][0].tp += 1;
            }
            Some(Trouble::Forgets) => {
                answer.pop();
            }
            Some(Trouble::Panics(what)) => panic!("{what}"),
            Some(Trouble::Gone) | None => {}
        }
        Ok(answer)
    }

    fn timings(&self) -> Vec<StageTiming> {
        self.inner.timings()
    }

    fn planes(&mut self, slots: &[Slot]) -> Result<Vec<Planes>> {
        self.inner.planes(slots)
    }

    fn read(&mut self, table: usize, placement: &GridPose) -> Result<Evidence> {
        self.inner.read(table, placement)
    }
}

/// The actor, and a CPU that steps in for it.
pub(crate) struct Troupe(Arc<Mutex<Script>>);

impl Troupe {
    pub(crate) fn new(cue: impl FnMut(Call, Fallback, usize) -> Option<Trouble> + Send + 'static) -> Troupe {
        Troupe(Arc::new(Mutex::new(Script { cue: Box::new(cue), calls: Vec::new() })))
    }
}

impl BackendFactory for Troupe {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        if fallback == Fallback::Cpu {
            self.0.lock().unwrap().next(Call::Open, fallback);
            return Ok(Box::new(Cpu::new(Some(1))?));
        }
        let actor = Actor { inner: Cpu::new(Some(1))?, fallback, script: self.0.clone() };
        actor.can(Call::Open)?;
        Ok(Box::new(actor))
    }

    fn needs_check(&self) -> bool {
        true
    }
}

/// The oracle, alone.
struct Alone;

impl BackendFactory for Alone {
    fn open(&mut self, _: Fallback) -> Result<Box<dyn Backend + Send>> {
        Ok(Box::new(Oracle::default()))
    }

    fn needs_check(&self) -> bool {
        false
    }
}

/// An actor that passes for the CPU: it has no fallback.
struct Undoubted(Troupe);

impl BackendFactory for Undoubted {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        self.0.open(fallback)
    }

    fn needs_check(&self) -> bool {
        false
    }
}

/// A study of 151 choices of poses in 2 scenes, each twice.
pub(crate) struct Theatre {
    folder: Folder,
    pub(crate) study: Study,
    pub(crate) worlds: Vec<World>,
}

impl Theatre {
    pub(crate) fn new() -> Theatre {
        Theatre::of(142, 2)
    }

    /// The same with so many random poses, so often.
    fn of(random: u32, repeats: u32) -> Theatre {
        let folder = Folder::new();
        folder.write("second.toml", fs::read(folder.path("cell.toml")).unwrap());
        folder.edit("second.toml", "position_m = [0.1, -0.45, 0.65]", "position_m = [0.3, -0.4, 0.65]");
        folder.edit(
            "study.toml",
            "[[region]]",
            "[[scene]]\nfile = \"second.toml\"\nname = \"second\"\n[[region]]",
        );
        folder.edit("study.toml", "seed = 7", &format!("seed = 7\nrepeats = {repeats}"));
        folder.edit("study.toml", "count = 2", &format!("count = {random}"));
        folder.edit("study.toml", "range_m = [0.1, 5.0]", "range_m = [0.1, 5.0]\nnoise = { std_m = 0.1 }");
        let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
        let worlds = World::prepare_all(&study).unwrap();
        Theatre { folder, study, worlds }
    }

    /// Sweeps into a folder of that name.
    pub(crate) fn sweep(
        &self,
        out: &str,
        backends: &mut dyn BackendFactory,
        verify: u64,
        watch: &Onlooker,
    ) -> Result<RunReport> {
        self.open(out, false)?.run(backends, verify, 0.0, watch)
    }

    fn open(&self, out: &str, restart: bool) -> Result<Session<'_>> {
        Session::open(&self.study, &self.worlds, &self.out(out), Shard::WHOLE, restart, &["perirobot".into()])
    }

    /// How many answers a sweep takes.
    fn answers(&self) -> usize {
        let mut honest = Troupe::new(|_, _, _| None);
        self.sweep("answers", &mut honest, 1, &Onlooker::default()).unwrap();
        let script = honest.0.lock().unwrap();
        script
            .calls
            .iter()
            .filter(|(call, fallback)| (*call, *fallback) == (Call::Receive, Fallback::None))
            .count()
    }

    pub(crate) fn out(&self, out: &str) -> PathBuf {
        self.folder.path(out)
    }

    pub(crate) fn journal(&self, out: &str) -> Vec<u8> {
        fs::read(self.out(out).join(JOURNAL)).unwrap()
    }
}

pub(crate) fn manifest(folder: &Path) -> serde_json::Value {
    serde_json::from_slice(&Manifest::read(folder).unwrap().bytes()).unwrap()
}

const SMALL: &str = "the same device in small batches";
const CPU: &str = "the CPU";
const SMALL_FOR_GOOD: &str = "the same device in small batches, and from then on the CPU";
const FOR_GOOD: &str = "the CPU, and from then on the CPU";

/// What fails, when, and who does the work instead, each time.
struct Case {
    name: &'static str,
    what: &'static str,
    cue: fn(Call, Fallback, usize) -> bool,
    instead: &'static [&'static str],
}

const CASES: &[Case] = &[
    Case {
        name: "the device is lost once",
        what: "device lost",
        cue: |call, fallback, before| (call, fallback, before) == (Call::Sense, Fallback::None, 7),
        instead: &[SMALL],
    },
    Case {
        name: "the first thing it is asked",
        what: "device lost",
        cue: |call, fallback, before| (call, fallback, before) == (Call::Load, Fallback::None, 0),
        instead: &[SMALL],
    },
    Case {
        name: "a large batch does not fit its memory, a small one does",
        what: "out of memory",
        cue: |call, fallback, before| (call, fallback) == (Call::Submit, Fallback::None) && before >= 5,
        instead: &[SMALL, SMALL, SMALL_FOR_GOOD],
    },
    Case {
        name: "an answer does not come",
        what: "no answer in time",
        cue: |call, fallback, before| (call, fallback, before) == (Call::Receive, Fallback::None, 9),
        instead: &[SMALL],
    },
    Case {
        name: "an answer does not come, not in small either",
        what: "no answer in time",
        cue: |call, fallback, before| call == Call::Receive && (fallback == Fallback::Small || before == 9),
        instead: &[CPU],
    },
    Case {
        name: "it comes back broken",
        what: "dispatched 5 workgroups, 4 ran",
        cue: |call, fallback, before| (call, fallback) == (Call::Receive, Fallback::None) && before >= 4,
        instead: &[SMALL, SMALL, SMALL_FOR_GOOD],
    },
    Case {
        name: "it never works",
        what: "device lost",
        cue: |call, _, _| call == Call::Sense,
        instead: &[CPU, CPU, FOR_GOOD],
    },
    Case {
        name: "it is lost and cannot be opened again",
        what: "device lost",
        cue: |call, fallback, before| match call {
            Call::Open => fallback == Fallback::Small || before > 0,
            call => call == Call::Sense && before == 7,
        },
        instead: &[FOR_GOOD],
    },
];

#[test]
fn what_fails_is_done_by_somebody_else_and_nothing_is_lost() {
    let theatre = Theatre::new();
    let quiet = Onlooker::default();
    theatre.sweep("quiet", &mut Alone, 0, &quiet).unwrap();
    let jobs = quiet.heard().finished;
    assert_eq!(jobs, 151 * 2 * 2);
    for (number, Case { name, what, cue, instead }) in CASES.iter().enumerate() {
        let out = format!("out-{number}");
        let mut troupe = Troupe::new(move |call, fallback, before| {
            cue(call, fallback, before).then_some(Trouble::Fails(what))
        });
        let watch = Onlooker::default();
        let report = theatre.sweep(&out, &mut troupe, 500, &watch).unwrap();
        let heard = watch.heard();
        assert_eq!(report.ending, Ending::Finished, "{name}");
        assert!(theatre.journal(&out) == theatre.journal("quiet"), "{name}: other counts than a quiet run's");
        assert_eq!(
            (heard.finished, report.run.poses),
            (jobs, Some(jobs)),
            "{name}: each choice is finished once"
        );

        let told: Vec<&str> = heard.faults.iter().map(|fault| fault.instead.as_str()).collect();
        assert_eq!(told, *instead, "{name}");
        for fault in &heard.faults {
            assert_eq!(fault.what, format!("adapter Actor: {what}"), "{name}");
            assert!(["cell", "second"].contains(&fault.scene.as_str()), "{name}: {}", fault.scene);
        }
        let run = &manifest(&theatre.out(&out))["runs"][0];
        assert_eq!(run["ended"], "finished", "{name}");
        assert_eq!(run["faults"], serde_json::json!(heard.faults), "{name}");
    }
}

/// A panic in the code of a device's backend, wherever it happens, is a failure of the device.
#[test]
fn a_backend_of_a_device_that_panics_is_replaced_and_nothing_is_lost() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    for (number, call) in [Call::Load, Call::Sense, Call::Submit, Call::Receive].into_iter().enumerate() {
        for (is_in_small, instead) in [(false, SMALL), (true, CPU)] {
            let out = format!("out-{number}-{is_in_small}");
            let mut troupe = Troupe::new(move |now, fallback, before| {
                let small = is_in_small && fallback == Fallback::Small;
                let first = fallback == Fallback::None && before == 1;
                (now == call && (small || first)).then_some(Trouble::Panics("index 7 of 3"))
            });
            let watch = Onlooker::default();
            let report = theatre.sweep(&out, &mut troupe, 500, &watch).unwrap();
            let heard = watch.heard();
            assert_eq!(report.ending, Ending::Finished, "{call:?}");
            assert!(theatre.journal(&out) == theatre.journal("quiet"), "{call:?}: other counts");
            let told: Vec<[&str; 2]> = heard.faults.iter().map(|f| [&*f.what, &*f.instead]).collect();
            assert_eq!(
                told,
                [["panicked: index 7 of 3; please report this with the command", instead]],
                "{call:?}"
            );
            assert_eq!(manifest(&theatre.out(&out))["runs"][0]["faults"], serde_json::json!(heard.faults));
        }
    }
    // Callers without a folder are answered as well.
    let Theatre { study, worlds, .. } = &theatre;
    let mut troupe = Troupe::new(|call, fallback, before| {
        ((call, fallback, before) == (Call::Sense, Fallback::None, 3))
            .then_some(Trouble::Panics("index 7 of 3"))
    });
    let watch = Onlooker::default();
    let rows = run_on(study, worlds, &mut troupe, &watch).unwrap();
    let heard = watch.heard();
    assert!(rows == run(study, worlds, &mut Oracle::default()).unwrap());
    assert_eq!(heard.faults.len(), 1);
}

/// Without another backend a panic ends the run with an error; finished rows are kept, and the same command goes on.
#[test]
fn a_panic_in_a_worker_of_the_cpu_is_a_bug_and_the_journal_is_intact() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    for call in [Call::Sense, Call::Receive] {
        let out = format!("{call:?}");
        let cue =
            move |now, _, before| (now == call && before == 7).then_some(Trouble::Panics("index 7 of 3"));
        let error =
            theatre.sweep(&out, &mut Undoubted(Troupe::new(cue)), 500, &Onlooker::default()).unwrap_err();
        assert!(matches!(&error, Error::Bug(_)), "{error:?}");
        assert_eq!(error.to_string(), "panicked: index 7 of 3");
        assert_eq!(manifest(&theatre.out(&out))["runs"][0]["ended"], "panicked: index 7 of 3");
        let session = theatre.open(&out, false).unwrap();
        assert_eq!(session.damaged, 0);
        assert!(
            session.finished_count() > 0 && session.finished_count() < session.total(),
            "{} done",
            session.finished_count()
        );
        drop(session);
        theatre.sweep(&out, &mut Alone, 0, &Onlooker::default()).unwrap();
        assert!(theatre.journal(&out) == theatre.journal("quiet"), "{call:?}: other counts");
    }
}

#[test]
fn whoever_asks_again_and_again_is_answered_by_others_and_then_by_a_device_opened_anew() {
    let theatre = Theatre::new();
    let Theatre { study, worlds, .. } = &theatre;
    let expected = run(study, worlds, &mut Oracle::default()).unwrap();
    // What is opened, from when a device works no more; what it cannot do; who does the rest.
    use Fallback::{Cpu, None, Small};
    type Fails = fn(Call, Fallback) -> bool;
    let cases: [(&[Fallback], Fails, &[&str]); 4] = [
        (&[None], |_, _| false, &[]),
        (
            &[None, Small, None, Small, None, Small, Cpu, None],
            |call, fallback| (call, fallback) == (Call::Sense, None),
            &[SMALL, SMALL, SMALL_FOR_GOOD],
        ),
        (
            &[None, Small, Cpu, None, Small, Cpu, None, Small, Cpu, Cpu, None],
            |call, _| call == Call::Sense,
            &[CPU, CPU, FOR_GOOD],
        ),
        (
            &[None, Small, Cpu, None, Small, Cpu, None, Small, Cpu, Cpu, None],
            |call, fallback| call == Call::Sense || (call, fallback) == (Call::Open, Small),
            &[CPU, CPU, FOR_GOOD],
        ),
    ];
    for (opened, fails, instead) in cases {
        for from in [0, 7] {
            let now = Arc::new(AtomicBool::new(false));
            let is_bad = now.clone();
            let troupe = Troupe::new(move |call, fallback, before| {
                let fails = is_bad.load(Ordering::Relaxed) && fails(call, fallback);
                (fails && (call == Call::Open || before >= from)).then_some(Trouble::Fails("device lost"))
            });
            let mut kept = KeptBackends::new(Troupe(troupe.0.clone()));
            for asked in 0..4 {
                // The first finds it well, the second not, and those after that again.
                now.store(asked == 1, Ordering::Relaxed);
                let watch = Onlooker::default();
                let rows = run_on(study, worlds, &mut kept, &watch).unwrap();
                let heard = watch.heard();
                assert!(rows == expected, "{instead:?}, asked {asked}: other counts");
                assert_eq!(heard.finished, 151 * 2 * 2, "{instead:?}: each choice is finished once");
                let told: Vec<&str> = heard.faults.iter().map(|fault| fault.instead.as_str()).collect();
                assert_eq!(told, if asked == 1 { instead } else { &[] });
            }
            let calls = &troupe.0.lock().unwrap().calls;
            let opens = calls.iter().filter(|(call, _)| *call == Call::Open).map(|(_, fallback)| *fallback);
            assert_eq!(opens.collect::<Vec<_>>(), opened, "{instead:?}, from {from}");
        }
    }
}

#[test]
fn a_device_that_is_gone_is_no_fault_of_the_users() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    // It falls off the bus, or has too little memory left for what fitted before.
    let gone: [fn(Call, Fallback, usize) -> bool; 2] = [
        |call, fallback, before| call == Call::Open && (fallback == Fallback::Small || before > 0),
        |call, fallback, _| call == Call::Load && fallback == Fallback::Small,
    ];
    for (number, gone) in gone.into_iter().enumerate() {
        let out = format!("out-{number}");
        let mut troupe = Troupe::new(move |call, fallback, before| match (call, fallback, before) {
            (Call::Sense, Fallback::None, 7) => Some(Trouble::Fails("device lost")),
            _ => gone(call, fallback, before).then_some(Trouble::Gone),
        });
        let watch = Onlooker::default();
        let report = theatre.sweep(&out, &mut troupe, 500, &watch).unwrap();
        let heard = watch.heard();
        assert_eq!(report.ending, Ending::Finished);
        assert!(theatre.journal(&out) == theatre.journal("quiet"));
        assert_eq!(heard.faults[0].instead, [FOR_GOOD, CPU][number]);
    }
}

#[test]
fn what_a_killed_run_left_unchecked_is_checked_later() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    // As if it had been killed before its first check: all rows are there, and its entry is as it was at the
    // beginning.
    let killed = |out: &str, mut troupe: Troupe| {
        theatre.sweep(out, &mut troupe, 0, &Onlooker::default()).unwrap();
        let path = theatre.out(out).join("manifest.json");
        let text = fs::read_to_string(&path).unwrap();
        let as_begun = text.replacen("\"ended\": \"finished\"", "\"ended\": \"killed\"", 1);
        assert_ne!(as_begun, text);
        fs::write(&path, as_begun).unwrap();
    };
    killed("honest", Troupe::new(|_, _, _| None));
    let report =
        theatre.sweep("honest", &mut Troupe::new(|_, _, _| None), 500, &Onlooker::default()).unwrap();
    assert_eq!((report.ending, report.run.poses, report.run.verified), (Ending::Finished, Some(0), Some(4)));
    assert!(theatre.journal("honest") == theatre.journal("quiet"));
    let again = theatre.open("honest", false).unwrap();
    assert!(!again.is_unchecked(), "once is enough");
    drop(again);

    // Whoever goes on, a liar's rows do not stay.
    let factories: [&mut dyn BackendFactory; 2] = [&mut Troupe::new(|_, _, _| None), &mut Alone];
    for (number, backends) in factories.into_iter().enumerate() {
        let out = format!("lied-{number}");
        killed(&out, liar(0));
        let error = theatre.sweep(&out, backends, 500, &Onlooker::default()).unwrap_err();
        assert!(matches!(error, Error::Disagreement(_)), "{error:?}");
        theatre.sweep(&out, &mut Alone, 500, &Onlooker::default()).unwrap();
        assert!(theatre.journal(&out) == theatre.journal("quiet"));
    }
}

#[test]
fn a_device_that_fails_now_and_then_stays_at_work() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    // Two failures are not three.
    let mut troupe = Troupe::new(|call, fallback, before| {
        let now = (call, fallback) == (Call::Sense, Fallback::None) && [3, 9].contains(&before);
        now.then_some(Trouble::Fails("device lost"))
    });
    let watch = Onlooker::default();
    theatre.sweep("out", &mut troupe, 500, &watch).unwrap();
    let heard = watch.heard();
    assert_eq!(heard.faults.len(), 2);
    assert_eq!(heard.ran_on.len(), 3, "it is told each time that the chosen backend begins");
    assert!(theatre.journal("out") == theatre.journal("quiet"));
    let last = troupe.0.lock().unwrap().calls.last().copied();
    assert_eq!(last, Some((Call::Receive, Fallback::None)), "it is asked again, to the end");
}

#[test]
fn an_answer_that_is_too_short_is_a_failure() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    let mut troupe = Troupe::new(|call, fallback, before| {
        ((call, fallback, before) == (Call::Receive, Fallback::None, 5)).then_some(Trouble::Forgets)
    });
    let watch = Onlooker::default();
    theatre.sweep("out", &mut troupe, 500, &watch).unwrap();
    let heard = watch.heard();
    assert!(theatre.journal("out") == theatre.journal("quiet"));
    assert!(heard.faults[0].what.contains("answered for"), "{:?}", heard.faults);
}

#[test]
fn without_a_device_to_doubt_a_failure_ends_the_run() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    let cue =
        |call, _, before| (call == Call::Sense && before == 7).then_some(Trouble::Fails("threads gone"));
    let error = theatre.sweep("out", &mut Undoubted(Troupe::new(cue)), 500, &Onlooker::default());
    assert!(
        matches!(&error, Err(Error::Device(what)) if what.to_string().contains("threads gone")),
        "{error:?}"
    );
    assert!(manifest(&theatre.out("out"))["runs"][0]["ended"].as_str().unwrap().contains("threads gone"));
    // What was finished is kept, and the rest follows.
    let session = theatre.open("out", false).unwrap();
    assert!(session.finished_count() > 0 && session.finished_count() < session.total());
    drop(session);
    theatre.sweep("out", &mut Alone, 0, &Onlooker::default()).unwrap();
    assert!(theatre.journal("out") == theatre.journal("quiet"));
}

/// Lies in every answer from that one on.
fn liar(from: usize) -> Troupe {
    Troupe::new(move |call, _, before| (call == Call::Receive && before >= from).then_some(Trouble::Lies))
}

#[test]
fn a_lie_stops_the_run_with_the_evidence_in_a_file() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    let error = theatre.sweep("out", &mut liar(0), 500, &Onlooker::default()).unwrap_err();
    let Error::Disagreement(what) = &error else { panic!("{error:?}") };
    for part in [
        "scene cell, snapshot 0, repeat 0",
        "in region robot",
        DISAGREEMENT,
        "All rows of this folder are set aside in disagreement.journal",
    ] {
        assert!(what.to_string().contains(part), "no {part:?} in {what}");
    }
    let out = theatre.out("out");
    let evidence: serde_json::Value =
        serde_json::from_slice(&fs::read(out.join(DISAGREEMENT)).unwrap()).unwrap();
    let columns = evidence["columns"].as_array().unwrap().len();
    let counts = |who: &str| -> Vec<u64> { serde_json::from_value(evidence[who].clone()).unwrap() };
    let (theirs, ours) = (counts("counted_by_device"), counts("counted_by_cpu"));
    assert_eq!((theirs.len(), ours.len()), (columns, columns));
    assert_eq!((theirs[0], &theirs[1..]), (ours[0] + 1, &ours[1..]));
    let run = &manifest(&out)["runs"][0];
    assert!(run["ended"].as_str().unwrap().contains("disagree"), "{run}");

    // Its rows are there for whoever wants to see them, but nobody goes on from them, nor merges them.
    let aside = fs::read(out.join(DISAGREED)).unwrap();
    assert!(aside.len() > theatre.journal("out").len(), "rows are kept");
    let session = theatre.open("out", false).unwrap();
    assert_eq!(session.finished_count(), 0);
    drop(session);
    theatre.sweep("out", &mut Alone, 0, &Onlooker::default()).unwrap();
    assert!(theatre.journal("out") == theatre.journal("quiet"));
}

#[test]
fn the_share_that_is_checked_finds_a_later_lie_and_nothing_else_does() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    // The first poses are honest.
    let error = theatre.sweep("some", &mut liar(6), 1, &Onlooker::default()).unwrap_err();
    assert!(matches!(error, Error::Disagreement(_)), "{error:?}");
    // What nobody checks is believed.
    theatre.sweep("none", &mut liar(6), 0, &Onlooker::default()).unwrap();
    assert!(theatre.journal("none") != theatre.journal("quiet"));
}

#[test]
fn an_honest_device_is_checked_three_times_and_then_for_a_share() {
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    // Of 604 choices, those numbered 0, 1, 2 and each five-hundredth or twentieth; or all of them; or none.
    for (verify, expected) in [(500, 3 + 1), (20, 3 + 30), (1, 604), (0, 0)] {
        let out = format!("one-in-{verify}");
        let report =
            theatre.sweep(&out, &mut Troupe::new(|_, _, _| None), verify, &Onlooker::default()).unwrap();
        assert_eq!(report.run.verified, Some(expected), "1 in {verify}");
        assert!(theatre.journal(&out) == theatre.journal("quiet"));
        assert_eq!(manifest(&theatre.out(&out))["runs"][0]["verified"], expected);
    }
}

/// Poses and repeats of which some are checked together, in no order but that in which they were picked.
#[test]
fn an_honest_device_is_believed_however_often_poses_are_repeated() {
    for (random, repeats) in [(1, 2), (2, 7)] {
        let theatre = Theatre::of(random, repeats);
        theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
        for verify in [1, 2, 500] {
            let out = format!("one-in-{verify}");
            let mut honest = Troupe::new(|_, _, _| None);
            let report = theatre.sweep(&out, &mut honest, verify, &Onlooker::default()).unwrap();
            let [verified, poses] = [report.run.verified, report.run.poses].map(Option::unwrap);
            assert!(verified >= poses / verify, "{verified} verified");
            assert!(theatre.journal(&out) == theatre.journal("quiet"));
        }
        // A lie in the last answer of all is found where all are checked.
        let answers = theatre.answers();
        let error = theatre.sweep("lied", &mut liar(answers - 1), 1, &Onlooker::default()).unwrap_err();
        assert!(matches!(error, Error::Disagreement(_)), "{error:?}");
    }
}

/// Only what passes is called exact by `perirobot devices`.
#[test]
fn a_device_that_lies_in_one_answer_fails_the_self_test() {
    let tested = |mut troupe: Troupe| self_test(&mut *troupe.open(Fallback::None).unwrap());
    tested(Troupe::new(|_, _, _| None)).unwrap();
    for answer in 0..2 {
        for trouble in [Trouble::Lies, Trouble::Forgets] {
            let now = move |call, before| (call, before) == (Call::Receive, answer);
            let error = tested(Troupe::new(move |call, _, before| now(call, before).then_some(trouble)));
            assert!(
                matches!(&error, Err(Error::Disagreement(what)) if what.to_string().starts_with("Actor: of 36")),
                "{error:?}"
            );
        }
    }
    let lost = |call, _, _| (call == Call::Sense).then_some(Trouble::Fails("device lost"));
    assert!(matches!(tested(Troupe::new(lost)), Err(Error::Device(_))));
}

#[test]
fn what_the_cpu_did_instead_is_not_checked_by_the_cpu() {
    let theatre = Theatre::new();
    // Every pose of the device is checked; it did those of two batches.
    let mut troupe = Troupe::new(|call, _, before| {
        (call == Call::Sense && before >= 6).then_some(Trouble::Fails("device lost"))
    });
    let report = theatre.sweep("out", &mut troupe, 1, &Onlooker::default()).unwrap();
    assert!(
        Some(0) < report.run.verified && report.run.verified < report.run.poses,
        "{:?}",
        report.run.verified
    );
}

/// A GPU whose driver ends loops early, in full batches or in all of them; and a CPU that steps in for it.
struct Cutting {
    adapter: AdapterChoice,
    in_small: bool,
}

impl BackendFactory for Cutting {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        // Rays turn at most twelve times on their way.
        let source = |stage| {
            let (whole, head) = (shader_source(stage), "        let leaves = crossing3_q16(ray.next_q16");
            let cut = whole.replacen(
                head,
                &format!("        if turns > 11u {{ break; }}\n        turns += 1u;\n{head}"),
                1,
            );
            assert_eq!(
                cut != whole,
                [Stage::StaticHits, Stage::Cast, Stage::CastListed].contains(&stage),
                "the loop of first hits"
            );
            cut.replace("var hit = NO_HIT;", "var hit = NO_HIT;\n    var turns = 0u;")
        };
        match fallback {
            Fallback::Cpu => Ok(Box::new(Cpu::new(Some(1))?)),
            Fallback::Small if !self.in_small => Ok(Box::new(Gpu::new(&self.adapter)?)),
            _ => Ok(Box::new(Gpu::with_sources(&self.adapter, &source)?)),
        }
    }

    fn needs_check(&self) -> bool {
        true
    }
}

#[test]
fn what_a_driver_cuts_short_is_done_again_and_told() {
    let Some(adapter) = common::adapter() else { return };
    let theatre = Theatre::new();
    theatre.sweep("quiet", &mut Alone, 0, &Onlooker::default()).unwrap();
    for (in_small, instead) in [(false, SMALL), (true, CPU)] {
        let out = format!("cut-{in_small}");
        let mut backends = Cutting { adapter: adapter.clone(), in_small };
        let watch = Onlooker::default();
        let report = theatre.sweep(&out, &mut backends, 1, &watch).unwrap();
        let heard = watch.heard();
        assert_eq!(report.ending, Ending::Finished);
        assert!(theatre.journal(&out) == theatre.journal("quiet"), "other counts than a quiet run's");
        let run = &manifest(&theatre.out(&out))["runs"][0];
        assert_eq!(run["faults"], serde_json::json!(heard.faults));
        let first = &heard.faults[0];
        assert!(first.what.contains("loops cut short: in ") && first.what.contains("`cast`"), "{first:?}");
        assert_eq!(first.instead, instead);
    }
}

/// A GPU that is closed under the hands of who works with it, and one that is not waited for.
#[test]
fn a_real_device_that_is_lost_or_late_is_a_failure_and_not_a_panic() {
    let Some(adapter) = common::adapter() else { return };
    let theatre = Theatre::new();
    let tables: Vec<Rays> = ray_tables(&theatre.study).into_iter().flatten().collect();
    let world = &theatre.worlds[0];
    let Setting::Pose(pose) = &world.settings[0][0] else { panic!("a camera has poses") };
    let placement = sensor::placement(&*theatre.study.sensors[0].kind, pose, &world.grid, 0);
    let scene = world.scene(window_of(&world.regions));
    let job = || vec![vec![Reading { slot: 0, volume: None, hit: 850, miss: -400, presence: false }]];
    let open = |patience: u64| {
        let mut gpu = Gpu::new(&adapter).unwrap().patience(Duration::from_secs(patience));
        gpu.tables(&tables).unwrap();
        gpu.load(&scene).unwrap();
        gpu
    };
    let work = |gpu: &mut Gpu| {
        gpu.sense(0, &[Shot::once(0, placement)])?;
        gpu.score(Fusion::OccupiedWins, &job())
    };
    assert!(work(&mut open(600)).is_ok());

    let mut gpu = open(600);
    gpu.lose();
    for _ in 0..2 {
        let error = work(&mut gpu).unwrap_err();
        assert!(matches!(error, Error::Device(_)), "{error:?}");
    }
    assert!(matches!(gpu.load(&scene), Err(Error::Device(_))));

    // It is lost with work under way.
    let mut gpu = open(600);
    gpu.sense(0, &[Shot::once(0, placement)]).unwrap();
    gpu.submit(Fusion::OccupiedWins, &job()).unwrap();
    gpu.lose();
    let error = gpu.receive().unwrap_err();
    assert!(matches!(error, Error::Device(_)), "{error:?}");

    // A device may have answered before anybody began to wait: a GPU in every try, if it is quick.
    let much = |gpu: &mut Gpu| {
        let shots = (0..gpu.slots().min(200) as u32).map(|slot| Shot::once(slot, placement));
        gpu.sense(0, &shots.collect::<Vec<_>>())?;
        gpu.score(Fusion::OccupiedWins, &job())
    };
    let Some(error) = (0..100).find_map(|_| much(&mut open(0)).err()) else {
        let device = open(0).device();
        assert!(!device.contains("software"), "{device} is never late");
        return common::say(&format!("SKIPPED: {device} is never late"));
    };
    assert!(
        matches!(&error, Error::Device(what) if what.to_string().contains("no answer in 0ns")),
        "{error:?}"
    );
}
