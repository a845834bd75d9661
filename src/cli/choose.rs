//! `perirobot choose`: the best set of sensors. Cast and searched in `choose`, told in `report::choose`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use perirobot::backend::oracle::Oracle;
use perirobot::choose::{self, CandidateEvidence, CastingWatch, Problem, Told, Verified};
use perirobot::study::Study;
use perirobot::{Error, Result, report};

use super::backend::BackendArgs;
use super::progress::{self, ProgressArgs};
use super::stop::{StopAt, stopped};
use super::study::StudyArgs;

/// Find the best set of sensors, and prove it
///
/// A study with [choose] says which score is to be as high as it can be, in which region, and what a set may
/// have and cost. Every pose is cast once; then all allowed sets are searched, and for each size and each
/// step of cost the best set is told, with what no set is above. What is proven holds of the listed poses, at
/// this voxel size, in these scenes. Writes front.csv, sets.csv and choose.json into the output folder.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Folder for the answer; made if needed [default: out/ and the study's name]
    #[arg(long, value_name = "DIR", help_heading = "Results")]
    out: Option<PathBuf>,
    /// Stop, as on a signal, this long after the start of the program (90s, 30m, 1.5h, 2d), and tell the best
    /// sets so far with what no set is above
    #[arg(long, value_name = "TIME", value_parser = super::quantity::time, help_heading = "Results")]
    max_time: Option<Duration>,
    /// Check the proof in this folder instead: its sets are counted again by the plain oracle, and that no set is
    /// better is searched again by other code; exit code 2 names what does not hold
    #[arg(long, value_name = "DIR", conflicts_with = "out", help_heading = "Results")]
    verify: Option<PathBuf>,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot choose scenes/choose.toml
      the best one, two and three sensors, into out/choose
  perirobot choose scenes/choose.toml --max-time 60s --out out/choose
      what a minute gives
  perirobot choose scenes/choose.toml --verify out/choose
      check it

On Ctrl-C, SIGTERM, SIGUSR1 or --max-time the best sets so far are told and
written, and the exit code is 75.";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let stop = StopAt::listen(args.max_time)?;
    args.backend.start_threads()?;
    let (study, worlds) = args.study.load_unless(&|| stop.reason())?;
    let choose = asked(&study)?;
    choose::examine(&study, choose, &worlds)?;
    let mut backend = args.backend.open()?;
    say!("running on {}: {}", backend.name(), backend.device());
    let memory = args.backend.memory().unwrap_or(choose::MEMORY_BYTES);
    let mut bar = Bar {
        progress: args.progress.start("poses", 0, CandidateEvidence::to_cast(&study, &worlds)),
        stop: &stop,
    };
    let of = (choose.region, choose.ways.as_slice());
    let evidence = CandidateEvidence::cast(&study, &worlds, of, memory, backend.as_mut(), &mut bar)?;
    bar.progress.finish();
    drop(backend);
    if let Some(folder) = &args.verify {
        let mut oracle = Oracle::default();
        let checked =
            choose::verify(folder, &study, choose, &worlds, &evidence, &mut oracle, &|| stop.reason())?;
        let Verified { sets, proven, open } = checked;
        let open = if open > 0 { format!("; {open} steps claim no proof") } else { String::new() };
        let text = format!("{sets} sets counted again, {proven} steps proven again{open}: all of it holds\n");
        super::print(&text)?;
        return Ok(ExitCode::SUCCESS);
    }
    let problem = Problem::new(&study, choose, &worlds, &evidence)?;
    let answer = choose::answer(&problem, &|| stop.reason().is_some())?;
    let why = stop.reason().filter(|_| !answer.complete);
    let told = Told::of(&study, &worlds, &problem, &answer);
    if let Some(why) = why.as_ref().filter(|_| told.steps.is_empty()) {
        say!("{why}: no set was found yet, and nothing is written");
        return Ok(stopped());
    }
    let out = args.out.clone().unwrap_or_else(|| args.study.usual_out());
    choose::write(&out, &study, choose, &worlds, &told)?;
    super::print(&report::choose::render(&study, choose, &told))?;
    super::print(&format!("\nresults in {}\n", out.display()))?;
    match why {
        Some(why) => {
            say!("{why}: not all sets were searched");
            Ok(stopped())
        }
        None => Ok(ExitCode::SUCCESS),
    }
}

/// What the study asks for.
fn asked(study: &Study) -> Result<&perirobot::study::Choose> {
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
}
