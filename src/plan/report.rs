//! The report and the mounting sheets of the present plan, made of the study as the page shows it: swept into a temporary
//! folder, judged and reported, as `perirobot sweep`, `judge` and `report` do with the saved study.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use perirobot_decide::judge::Judging;
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_march::backend::factory::{BackendChoice, ChosenBackends};
use perirobot_march::progress::Progress;
use perirobot_page::report::page::{LOOKED_AT, ReportPage, ReportedSweep, mounting_sheets};
use perirobot_study::input::{PLANNED, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::results::manifest::Manifest;
use perirobot_sweep::results::{Results, Subject};
use perirobot_sweep::scoring::check::ONE_IN;
use perirobot_sweep::scoring::session::Session;
use serde::{Deserialize, Serialize};

/// Where a person would sweep the saved study to, as the commands on the page say.
const SWEPT_FOLDER: &str = "out/planned";

/// What a person takes along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Paper {
    /// The report, with everything.
    Report,
    /// The mounting sheets alone.
    Sheets,
}

/// What is sent while a paper is made, a line each.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PaperEvent {
    /// This many things of a stage are done.
    Stage {
        /// What they are.
        words: &'static str,
        /// How many are done.
        done: u64,
        /// Of how many.
        total: u64,
    },
    /// Where it is, as a path of this server.
    Ready(String),
    /// Why there is none.
    Error(String),
}

/// Makes a paper of the plan of a study, as HTML. `note` is said at its top; `words` are those of the command line that read
/// the same files.
///
/// # Errors
/// Those of the backend and of a temporary folder; `Error::Stopped`.
pub fn paper(
    (study, worlds): (&Study, &[World]),
    kind: Paper,
    backend: &BackendChoice,
    note: Option<&str>,
    (stop, emit): (&AtomicBool, &(dyn Fn(PaperEvent) + Sync)),
) -> Result<String> {
    // The sweep is of the plan only, whatever else the study scores.
    let planned = study.combinations.iter().filter(|one| one.name == PLANNED).cloned();
    let study = Study { combinations: planned.collect(), ..study.clone() };
    if kind == Paper::Sheets {
        return mounting_sheets(&study, worlds, 0, note);
    }
    let folder = tempfile::Builder::new().prefix("perirobot-plan-").tempdir();
    let folder =
        folder.map_err(|e| perirobot_march::Error::io(&std::env::temp_dir(), "cannot hold a folder", e))?;
    let begin = Instant::now();
    let path = study.path.display().to_string();
    let command = ["perirobot", "sweep", &path].map(String::from);
    let mut session = Session::open(&study, worlds, folder.path(), Shard::WHOLE, true, &command)?;
    let mut backends = ChosenBackends::open(backend)?.0;
    let counted = Stage::new("scene-poses", session.total(), stop, emit);
    session.run(&mut backends, ONE_IN, begin.elapsed().as_secs_f64(), &counted)?;
    counted.check_stop()?;
    let results = Results::new(Subject::from_study(&study, worlds), session.into_pages());
    judge((&study, worlds), &results, folder.path(), backend, (stop, emit))?;
    html((&study, worlds), &results, folder.path(), backend, note, (stop, emit))
}

/// Judges the plan, so that the report has the verdicts that the page shows.
fn judge(
    (study, worlds): (&Study, &[World]),
    results: &Results,
    folder: &Path,
    backend: &BackendChoice,
    (stop, emit): (&AtomicBool, &(dyn Fn(PaperEvent) + Sync)),
) -> Result<()> {
    if study.requirements.is_empty() {
        return Ok(());
    }
    let plan = [Choice { combination: 0, choice: 0, representation: 0, repeat: 0 }];
    let judging = Judging::new(study, worlds, results, &plan)?;
    let cases = Stage::new("cases", judging.total(), stop, emit);
    let judged = judging.judge(&|| Ok(ChosenBackends::open(backend)?.0), &cases)?;
    judging.write(folder, &judged).map(drop)
}

fn html(
    (study, worlds): (&Study, &[World]),
    results: &Results,
    folder: &Path,
    backend: &BackendChoice,
    note: Option<&str>,
    (stop, emit): (&AtomicBool, &(dyn Fn(PaperEvent) + Sync)),
) -> Result<String> {
    let manifest = Manifest::read(folder)?;
    let sweep = ReportedSweep {
        results,
        manifest: &manifest,
        study,
        worlds,
        folder,
        folder_in_commands: Path::new(SWEPT_FOLDER),
        chosen: None,
        purchase: None,
        words: &[],
        note,
    };
    let page = ReportPage::new(sweep, LOOKED_AT)?;
    let views = Stage::new("views", page.total(), stop, emit);
    page.html(&mut *backend.open()?.0, &views)
}

/// Reports how far a stage is.
struct Stage<'a> {
    words: &'static str,
    total: u64,
    done: AtomicU64,
    stop: &'a AtomicBool,
    emit: &'a (dyn Fn(PaperEvent) + Sync),
}

impl<'a> Stage<'a> {
    fn new(
        words: &'static str,
        total: u64,
        stop: &'a AtomicBool,
        emit: &'a (dyn Fn(PaperEvent) + Sync),
    ) -> Stage<'a> {
        emit(PaperEvent::Stage { words, done: 0, total });
        Stage { words, total, done: AtomicU64::new(0), stop, emit }
    }
}

impl Progress for Stage<'_> {
    fn stop_reason(&self) -> Option<String> {
        self.stop.load(Ordering::Relaxed).then(|| "the page was closed".into())
    }

    fn advance(&self, more: u64) {
        let done = self.done.fetch_add(more, Ordering::Relaxed) + more;
        (self.emit)(PaperEvent::Stage { words: self.words, done, total: self.total });
    }
}
