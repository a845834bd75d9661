//! `perirobot choose`: the best set of sensors. Cast and searched in `choose`, printed in `report::terminal::choose`.

mod cheapest;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use perirobot_cover::CandidateEvidence;
use perirobot_decide::cheapest::PurchaseReport;
use perirobot_decide::choose::{
    CastEvidence, Casting, Choosing, Found, MEMORY_BYTES, SearchEnding, Verified,
};
use perirobot_march::Result;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::metrics::Across;
use perirobot_page::report;
use perirobot_study::input::Wanted;
use perirobot_sweep::scoring::check::ONE_IN;

use super::backend::BackendArgs;
use super::onlooker::{Onlooker, Shown};
use super::outcome::print_verdicts;
use super::progress::ProgressArgs;
use super::stop::{StopAt, stop_code};
use super::study::StudyArgs;
use super::sweep::command;
use super::swept::{self, StudyPlace};

/// Find the cheapest set that passes, or the best, and prove it
///
/// For a study with [[require]] and the cost of each sensor, finds the cheapest set that passes all requirements under
/// all their conditions. [choose] can limit the number of sensors and the cost, and request also the cheapest set at
/// each speed of the robot, without each requirement, or for each number of requirements (objective = "cost"). For a
/// study whose [choose] names a score, finds the best set of each size and each step of cost, with a proven upper
/// bound. Every pose is cast once; then allowed sets are searched. Proofs hold for the listed poses, at this voxel
/// size, in these scenes.
///
/// Writes cheapest.csv and cheapest.json with the verdicts of judge, or front.csv, sets.csv and choose.json, into the
/// output folder, and the files that a sweep of the found sets would write, so that `summary`, `compare`, `why`,
/// `render`, `export` and `report` take the folder. The exit code is 4 if no set passes.
///
/// The folder keeps the evidence of each pose (evidence.journal): after an interruption the same command continues, and
/// another question about the same study (objective, region, budget, requirements) casts nothing. A folder with the
/// evidence of another study is refused, with the differences.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
#[command(mut_arg("study", |arg| arg.required(false).required_unless_present("verify")))]
#[command(mut_args(|arg| match arg.get_id().as_str() {
    "voxel_size" | "noiseless" | "packages" | "allow_outside" | "xacro" | "step" => arg.requires("study"),
    _ => arg,
}))]
pub(super) struct Args {
    #[command(flatten)]
    study: Option<StudyArgs>,
    /// Folder for the answer; created if needed [default: out/ and the study's name with -choose]
    #[arg(long, value_name = "DIR", help_heading = "Results")]
    out: Option<PathBuf>,
    /// Start over: discard earlier casting in the folder
    #[arg(long, help_heading = "Results")]
    restart: bool,
    /// Stop, as on a signal, this long after the start of the program (90s, 30m, 1.5h, 2d), and report the best sets
    /// found with their bounds
    #[arg(long, value_name = "TIME", value_parser = super::quantity::time, help_heading = "Results")]
    max_time: Option<Duration>,
    /// Check the proof in this folder instead: all poses are cast again, the plain oracle counts the sets again, other
    /// code repeats the searches and the refining, and every value of choose.json and of the tables is compared; with
    /// exit code 2 the message names the first wrong claim. The study is the folder's unless one is named
    #[arg(long, value_name = "DIR", conflicts_with_all = ["out", "restart"], help_heading = "Results")]
    verify: Option<PathBuf>,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot choose scenes/cheapest.toml
      the cheapest set that passes, into out/cheapest-choose
  perirobot choose scenes/choose.toml
      the best one, two and three sensors, into out/choose-choose
  perirobot choose scenes/choose.toml --max-time 60s --out out/best
      the best sets found in a minute
  perirobot choose --verify out/best
      check it
  perirobot report out/best
      look at it

On Ctrl-C, SIGTERM, SIGUSR1 or --max-time the best sets so far are told and
written, or what was cast is kept, and the exit code is 75.";

/// The consequence of reading evidence from a file.
const FILED: &str = "sets come from adding and swapping single sensors, with a bound by cuts";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let stop = StopAt::listen(args.max_time)?;
    args.backend.start_threads()?;
    match (&args.verify, &args.study) {
        (Some(folder), _) => verify(args, folder, &stop),
        (None, Some(study)) => search(args, study, &stop),
        (None, None) => unreachable!("the parser asks for a study where no folder is verified"),
    }
}

/// Finds the sets, writes and prints them.
fn search(args: &Args, study: &StudyArgs, stop: &StopAt) -> Result<ExitCode> {
    let begin = Instant::now();
    let out = args.out.clone().unwrap_or_else(|| study.usual_out("-choose"));
    let packages = study.package_words();
    let (study, worlds) = study.load_unless(&|| stop.reason())?;
    if let Some(Wanted::Cheapest(purchase)) = &study.choose {
        return cheapest::search(args, (&out, &packages), (&study, purchase, &worlds), stop, begin);
    }
    let choosing = Choosing::new(&study, &worlds, args.evidence_bytes())?;
    PurchaseReport::forget(&out)?;
    let folder = choosing.open(&out)?;
    let casting = choosing.begin_casting(Some(folder.path()), args.restart)?;
    let mut backends = args.backend.backends()?;
    let prepare_s = begin.elapsed().as_secs_f64();
    let evidence = cast(args, casting, &mut backends, stop, FILED)?.remove(0);
    let onlooker = Onlooker::new(Shown::Search(args.progress.search()), Some(stop), false);
    let found = choosing.search(&evidence, &mut backends, &onlooker)?;
    onlooker.finish();
    let Some(Found { outcome, ending }) = found else {
        say!("{}: no set was found yet, so nothing was written", stop.reason().unwrap_or_default());
        return Ok(stop_code());
    };
    let progress = args.progress.start("sets", 0, outcome.total());
    // Results are written even if the search was stopped.
    let onlooker = Onlooker::new(Shown::Job(progress), None, false);
    let results = outcome.write(folder, &mut backends, (ONE_IN, prepare_s), &command(), &onlooker)?;
    onlooker.finish();
    super::print(&report::terminal::choose::render(&outcome.chosen))?;
    if outcome.chosen.asked.over == Across::Mean && study.scenes.iter().any(|scene| scene.dwell_s.is_some()) {
        super::print(&format!("\n{}\n", report::PLAIN_MEANS))?;
    }
    super::print("\n")?;
    let next = print_verdicts(&study, &results, outcome.chosen.report.best_set(), &out, &packages)?;
    super::print(&format!("results in {}\n", out.display()))?;
    super::print_next(&next)?;
    match ending {
        SearchEnding::Finished => return Ok(ExitCode::SUCCESS),
        SearchEnding::NotSearched(why) => say!("{why}: not all sets were searched"),
        SearchEnding::NotRefined(why) => say!("{why}: all sets were searched, and not all were refined"),
        SearchEnding::Failed(error) => return Err(error),
    }
    Ok(stop_code())
}

/// Where to find the study of a folder.
const PLACE: StudyPlace =
    StudyPlace { named: None, cure: ", or name the study: perirobot choose STUDY --verify DIR" };

/// Checks the proof in a folder.
fn verify(args: &Args, folder: &Path, stop: &StopAt) -> Result<ExitCode> {
    let (study, worlds) = match (&args.study, PurchaseReport::read(folder)?) {
        (Some(study), _) => study.load_unless(&|| stop.reason())?,
        (None, Some(report)) => {
            swept::load((report.study.clone().into(), report.overrides()), PLACE, &Default::default())?
        }
        (None, None) => swept::study_of(folder, PLACE, &Default::default())?,
    };
    if let Some(Wanted::Cheapest(purchase)) = &study.choose {
        return cheapest::verify(args, folder, (&study, purchase, &worlds), stop);
    }
    let choosing = Choosing::new(&study, &worlds, args.evidence_bytes())?;
    let claims = choosing.read_claims(folder)?;
    let casting = choosing.begin_casting(None, false)?;
    let mut backends = args.backend.backends()?;
    let evidence = cast(args, casting, &mut backends, stop, FILED)?.remove(0);
    let onlooker = Onlooker::new(Shown::Search(args.progress.search()), Some(stop), false);
    let Verified { sets, proven, bounded, open, stopped, refining_stopped } =
        choosing.verify(&claims, &evidence, &mut backends, &onlooker)?;
    onlooker.finish();
    let bounded = if bounded > 0 { format!(", {bounded} bounds added up again") } else { String::new() };
    let mut open = if open > 0 { format!("; {open} steps claim no proof") } else { String::new() };
    if stopped {
        open += "; the search was stopped, so sizes and steps of cost may be missing";
    }
    if refining_stopped {
        open += "; refining was stopped, so it was not repeated";
    }
    super::print(&format!(
        "{sets} sets counted again, {proven} steps proven again{bounded}, all tables compared{open}: all claims hold\n"
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// The evidence of every candidate in each requested region: read from the journal, or cast. `filed` describes the
/// consequence of reading it from a file.
fn cast(
    args: &Args,
    casting: Casting,
    backends: &mut dyn BackendFactory,
    stop: &StopAt,
    filed: &str,
) -> Result<Vec<CandidateEvidence>> {
    let (left, total) = (casting.remaining(), casting.total());
    if let Some(path) = casting.path().map(Path::display) {
        if casting.damaged > 0 {
            let damaged = casting.damaged;
            say!("warning: {path}: damaged in {damaged} places; the lost evidence is cast again");
        }
        match total - left {
            0 => {}
            done if done == total => say!("evidence of {total} scene-poses found in {path}: nothing is cast"),
            done => say!("evidence of {done} of {total} scene-poses found in {path}"),
        }
    }
    let shown = match left {
        0 => Shown::Nothing,
        _ => Shown::Job(args.progress.start("poses", total - left, total)),
    };
    let onlooker = Onlooker::new(shown, Some(stop), true);
    let CastEvidence { of_regions, file, checked } = casting.finish(backends, ONE_IN, &onlooker)?;
    onlooker.finish();
    if let Some(path) = file {
        say!("evidence may take more than --memory and is read from {}: {filed}", path.display());
    }
    if let Some(checked) = checked {
        say!("{checked} poses counted again on the CPU: no difference");
    }
    Ok(of_regions)
}

impl Args {
    /// Limit of evidence in memory, in bytes.
    fn evidence_bytes(&self) -> u64 {
        self.backend.memory().unwrap_or(MEMORY_BYTES)
    }
}
