//! `perirobot choose`: the best set of sensors. Cast and searched in `choose`, told in `report::terminal::choose`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use perirobot_cover::{CandidateEvidence, FrontStep, SearchWatch, SetLimits};
use perirobot_decide::choose::{
    self, Casting, CastingWatch, Chosen, Claims, FrontReport, Outcome, RefineWatch, Verified, VerifyWatch,
    problem_of,
};
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::metrics::Across;
use perirobot_march::{Error, Result};
use perirobot_page::report;
use perirobot_study::study::{Choose, Study};
use perirobot_sweep::results::manifest::Fault;

use super::backend::BackendArgs;
use super::outcome::print_verdicts;
use super::progress::{self, ProgressArgs, above_bar};
use super::stop::{StopAt, stopped};
use super::study::StudyArgs;
use super::sweep::{Onlooker, VERIFY, command};
use super::swept::{self, StudyPlace};

/// Find the best set of sensors, and prove it
///
/// A study with [choose] says which score is to be as high as it can be, in which region, and what a set may
/// have and cost. Every pose is cast once; then allowed sets are searched, all of them if there is time and
/// memory, and for each size and each step of cost the best set is told, with what no set is above. What is proven holds of the listed poses, at
/// this voxel size, in these scenes. Writes front.csv, sets.csv and choose.json into the output folder, and
/// what a sweep of the sets that were found would write, so that `summary`, `compare`, `why`, `render`,
/// `export` and `report` take the folder.
///
/// What is cast is kept there as soon as it is (evidence.journal): the same command goes on after whatever ended
/// a run, and another question about the same study (objective, budget, requirements) casts nothing. A folder
/// with evidence of something else is refused, with what has changed.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
#[command(mut_arg("study", |arg| arg.required(false).required_unless_present("verify")))]
#[command(mut_args(|arg| match arg.get_id().as_str() {
    "voxel_size" | "noiseless" | "packages" | "allow_outside" | "xacro" => arg.requires("study"),
    _ => arg,
}))]
pub(super) struct Args {
    #[command(flatten)]
    study: Option<StudyArgs>,
    /// Folder for the answer; made if needed [default: out/ and the study's name with -choose]
    #[arg(long, value_name = "DIR", help_heading = "Results")]
    out: Option<PathBuf>,
    /// Begin anew: what the folder holds of earlier casting is lost
    #[arg(long, help_heading = "Results")]
    restart: bool,
    /// Stop, as on a signal, this long after the start of the program (90s, 30m, 1.5h, 2d), and tell the best
    /// sets so far with what no set is above
    #[arg(long, value_name = "TIME", value_parser = super::quantity::time, help_heading = "Results")]
    max_time: Option<Duration>,
    /// Check the proof in this folder instead: its sets are counted again by the plain oracle, that no set is better is
    /// searched again by other code, with all poses cast again, refining is done again, and every value of choose.json
    /// and of the tables is compared; exit code 2 names what does not hold. The study is the folder's unless one is named
    #[arg(long, value_name = "DIR", conflicts_with_all = ["out", "restart"], help_heading = "Results")]
    verify: Option<PathBuf>,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot choose scenes/choose.toml
      the best one, two and three sensors, into out/choose-choose
  perirobot choose scenes/choose.toml --max-time 60s --out out/best
      what a minute gives
  perirobot choose --verify out/best
      check it
  perirobot report out/best
      look at it

On Ctrl-C, SIGTERM, SIGUSR1 or --max-time the best sets so far are told and
written, or what was cast is kept, and the exit code is 75.";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let stop = StopAt::listen(args.max_time)?;
    args.backend.start_threads()?;
    match (&args.verify, &args.study) {
        (Some(folder), _) => verify(args, folder, &stop),
        (None, Some(study)) => search(args, study, &stop),
        (None, None) => unreachable!("the parser asks for a study where no folder is verified"),
    }
}

/// Finds the sets, and writes and tells them.
fn search(args: &Args, study: &StudyArgs, stop: &StopAt) -> Result<ExitCode> {
    let begin = Instant::now();
    let out = args.out.clone().unwrap_or_else(|| study.usual_out("-choose"));
    let packages = study.package_words();
    let (study, worlds) = study.load_unless(&|| stop.reason())?;
    let choose = asked(&study)?;
    choose::examine(&study, choose, &worlds)?;
    let folder = Chosen::folder(&out, &study)?;
    let casting =
        Casting::begin(&study, choose, &worlds, args.evidence_bytes(), Some((folder.path(), args.restart)))?;
    let mut backends = args.backend.backends()?;
    let prepare_s = begin.elapsed().as_secs_f64();
    let evidence = cast(args, choose, casting, &mut backends, stop)?;
    let problem = problem_of(&study, choose, &worlds, &evidence);
    let shown = SearchBar { progress: args.progress.search(), stop };
    let answer = choose::answer(&problem, &shown)?;
    let why = stop.reason().filter(|_| !answer.complete);
    let mut told = FrontReport::new(&study, &worlds, &problem, &answer);
    if let Some(why) = why.as_ref().filter(|_| told.steps.is_empty()) {
        say!("{why}: no set was found yet, and nothing is written");
        return Ok(stopped());
    }
    evidence.was_read()?;
    let (mut with_poses, mut unrefined, mut failed) = (None, None, None);
    if choose.refine && why.is_none() {
        let (asked, found) = ((&study, choose, &*worlds), (&problem, &answer, &told));
        match choose::refine(asked, found, args.evidence_bytes(), &mut backends, &shown) {
            Ok(refinement) => {
                unrefined = stop.reason().filter(|_| !refinement.complete);
                with_poses = refinement.with_poses;
                told.refined = Some(refinement.told);
                told.refining_stopped = !refinement.complete;
            }
            // The answer is written before it is told.
            Err(error) => failed = Some(error),
        }
    }
    drop(shown);
    let outcome = Outcome::new((&study, choose, &worlds), told, with_poses);
    let progress = args.progress.start("sets", 0, outcome.total());
    let mut watch = Onlooker { progress, stop: None, names_backend: false };
    let results = outcome.write(folder, &mut backends, (VERIFY, prepare_s), &command(), &mut watch)?;
    watch.progress.finish();
    super::print(&report::terminal::choose::render(&outcome.chosen))?;
    if choose.over == Across::Mean && study.scenes.iter().any(|scene| scene.dwell_s.is_some()) {
        super::print(&format!("\n{}\n", report::PLAIN_MEANS))?;
    }
    super::print("\n")?;
    print_verdicts(&study, &results, outcome.chosen.report.best_set(), &out, &packages)?;
    super::print(&format!("results in {}\n", out.display()))?;
    if let Some(error) = failed {
        return Err(error);
    }
    match (why, unrefined) {
        (Some(why), _) => {
            say!("{why}: not all sets were searched");
            Ok(stopped())
        }
        (None, Some(why)) => {
            say!("{why}: all sets were searched, and not all were refined");
            Ok(stopped())
        }
        (None, None) => Ok(ExitCode::SUCCESS),
    }
}

/// Checks the proof in a folder.
fn verify(args: &Args, folder: &Path, stop: &StopAt) -> Result<ExitCode> {
    let (study, worlds) = match &args.study {
        Some(study) => study.load_unless(&|| stop.reason())?,
        None => {
            let place = StudyPlace { named: None, cure: ", or name it: perirobot choose STUDY --verify DIR" };
            swept::study_of(folder, place, &Default::default())?
        }
    };
    let choose = asked(&study)?;
    choose::examine(&study, choose, &worlds)?;
    let claims = Claims::read(folder, &study, choose, &worlds)?;
    let casting = Casting::begin(&study, choose, &worlds, args.evidence_bytes(), None)?;
    let mut backends = args.backend.backends()?;
    let evidence = cast(args, choose, casting, &mut backends, stop)?;
    let shown = SearchBar { progress: args.progress.search(), stop };
    let backends: (&mut dyn BackendFactory, u64) = (&mut backends, args.evidence_bytes());
    let Verified { sets, proven, bounded, open, stopped, refining_stopped } =
        choose::verify(&claims, (&study, choose, &worlds), &evidence, backends, (stop, &shown))?;
    drop(shown);
    let bounded = if bounded > 0 { format!(", {bounded} bounds added up again") } else { String::new() };
    let mut open = if open > 0 { format!("; {open} steps claim no proof") } else { String::new() };
    if stopped {
        open += "; the search was stopped, so that sizes and steps of cost may be missing";
    }
    if refining_stopped {
        open += "; refining was stopped, so that it was not searched again";
    }
    super::print(&format!(
        "{sets} sets counted again, {proven} steps proven again{bounded}, all tables compared{open}: all of it holds\n"
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// What every candidate says: what is there already, and the rest cast.
fn cast(
    args: &Args,
    choose: &Choose,
    mut casting: Casting,
    backends: &mut dyn BackendFactory,
    stop: &StopAt,
) -> Result<CandidateEvidence> {
    let (left, total) = (casting.left(), casting.total());
    if let Some(path) = casting.path().map(Path::display) {
        if casting.damaged > 0 {
            let damaged = casting.damaged;
            say!("warning: {path}: damaged in {damaged} places: what stood there is cast again");
        }
        match total - left {
            0 => {}
            done if done == total => say!("evidence of {total} scene-poses found in {path}: nothing is cast"),
            done => say!("evidence of {done} of {total} scene-poses found in {path}"),
        }
    }
    if left > 0 {
        let mut bar = Bar { progress: args.progress.start("poses", total - left, total), stop };
        casting.run_on(backends, &mut bar)?;
        bar.progress.finish();
    }
    if let Some(path) = casting.path().filter(|_| casting.is_filed()) {
        say!(
            "evidence may take more than --memory and is read from {}: sets come from adding and swapping single \
             sensors, with a bound by cuts",
            path.display()
        );
    }
    let (evidence, counted) = casting.checked(choose, backends, VERIFY)?;
    if let Some(counted) = counted {
        say!("{counted} poses counted again on the CPU: no difference");
    }
    Ok(evidence)
}

impl Args {
    /// How many bytes of evidence may be held.
    fn evidence_bytes(&self) -> u64 {
        self.backend.memory().unwrap_or(choose::MEMORY_BYTES)
    }
}

/// What the study asks for.
fn asked(study: &Study) -> Result<&Choose> {
    study.choose.as_ref().ok_or_else(|| {
        let example = "[choose] objective = \"f1\", region = \"robot\", at_most = 3";
        Error::input(&study.path, "no [choose]").wanted(format!("say what is looked for, as in {example}"))
    })
}

/// Shows how far the casting is, and knows when to stop.
struct Bar<'a> {
    progress: progress::Progress,
    stop: &'a StopAt,
}

impl CastingWatch for Bar<'_> {
    fn cast(&mut self, more: u64) {
        self.progress.inc(more);
    }

    fn stop(&mut self) -> Option<String> {
        self.stop.reason()
    }

    fn runs_on(&mut self, backend: &dyn Backend) {
        above_bar(|| say!("running on {}: {}", backend.name(), backend.device()));
    }

    fn failed(&mut self, Fault { what, instead, .. }: &Fault) {
        above_bar(|| say!("warning: {what}; what was left was done by {instead}"));
    }
}

impl VerifyWatch for StopAt {
    fn stop(&self) -> Option<String> {
        self.reason()
    }
}

/// Shows what a search has found, and knows when to stop.
struct SearchBar<'a> {
    progress: progress::SearchProgress,
    stop: &'a StopAt,
}

impl SearchWatch for SearchBar<'_> {
    fn stops(&self) -> bool {
        self.stop.reason().is_some()
    }

    fn finds(&self, limits: &SetLimits, best: Option<f64>) {
        self.progress.show(limits, [best, None]);
    }

    fn knows(&self, step: &FrontStep, _: f64) {
        self.progress.show(&step.limits, step.known());
    }
}

impl RefineWatch for SearchBar<'_> {
    fn failed(&self, Fault { what, instead, .. }: &Fault) {
        above_bar(|| say!("warning: {what}; what was left was done by {instead}"));
    }
}
