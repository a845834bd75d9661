//! `perirobot sweep`: the main job.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use perirobot_march::Result;
use perirobot_march::backend::StageTiming;
use perirobot_scene::shell;
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::results::{Results, Subject};
use perirobot_sweep::scoring::check::ONE_IN;
use perirobot_sweep::scoring::session::{Ending, RunReport, Session, folder_of};

use super::backend::BackendArgs;
use super::onlooker::{Onlooker, Shown};
use super::outcome::{OutcomeArgs, print_verdicts};
use super::progress::ProgressArgs;
use super::shard::ShardArg;
use super::stop::{StopAt, stop_code};
use super::study::StudyArgs;

/// Score every candidate pose of a study
///
/// Writes finished counts continuously into the output folder (counts.journal), with a description of the sweep
/// (manifest.json, poses.csv), and at the end the tables: results (counts and scores) and scores (over snapshots and
/// repeats). Prints the best poses with the scores of trivial answers; `perirobot summary DIR` prints more from the
/// folder.
///
/// If a run ends early for any reason, the same command resumes it, and the tables equal those of a single run, byte
/// for byte. A folder with another sweep is refused, with the differences.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Folder for the results; created if needed [default: out/ and the study's name]
    #[arg(long, value_name = "DIR", help_heading = "Results")]
    out: Option<PathBuf>,
    /// Start over: discard an earlier sweep in the folder
    #[arg(long, help_heading = "Results")]
    restart: bool,
    /// Stop, as on a signal, this long after the start of the program (90s, 30m, 1.5h, 2d); the current batch is
    /// finished
    #[arg(long, value_name = "TIME", value_parser = super::quantity::time, help_heading = "Parts of a sweep")]
    max_time: Option<Duration>,
    /// Only one of N parts, K from 0 to N-1, in the folder OUT/shard-K-of-N; auto/N takes K from SLURM_ARRAY_TASK_ID,
    /// HQ_TASK_ID or JOB_COMPLETION_INDEX. `perirobot merge OUT` merges them
    #[arg(long, value_name = "K/N", value_parser = super::shard::shard, help_heading = "Parts of a sweep")]
    shard: Option<ShardArg>,
    /// On a GPU, recount the first poses and then one in N on the CPU; a difference stops the run. 0 for none
    #[arg(long, value_name = "N", default_value_t = ONE_IN, help_heading = "Backend")]
    verify: u64,
    #[command(flatten)]
    outcome: OutcomeArgs,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    progress: ProgressArgs,
    /// At the end, print the time of each backend stage on standard error, if available
    #[arg(long, help_heading = "Progress")]
    timings: bool,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/quick.toml
      score all poses, into out/quick; repeat it to resume
  perirobot sweep my.toml --out out/my --max-time 8h
      stop in time, exit code 75 if anything is left
  perirobot sweep my.toml --out out/my --shard 0/4
      the first of four parts, on this machine
  perirobot merge out/my
      all four parts merged, equal to a single run

On Ctrl-C, SIGTERM, SIGUSR1 or --max-time the current batch is finished, and
the exit code is 75. A second signal ends the run at once; finished batches are
always kept.";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let stop = StopAt::listen(args.max_time)?;
    args.backend.start_threads()?;
    let begin = Instant::now();
    let part = args.shard.map(ShardArg::resolve).transpose()?;
    let out = args.out.clone().unwrap_or_else(|| args.study.usual_out(""));
    let folder = part.map_or_else(|| out.clone(), |part| folder_of(&out, part));
    let shard = part.unwrap_or(Shard::WHOLE);
    let load = || {
        let (study, worlds) = args.study.load_unless(&|| stop.reason().map(|why| not_begun(&why)))?;
        let subject = Subject::from_study(&study, &worlds);
        Ok((study, worlds, subject))
    };
    let ((study, worlds, subject), mut backends) = args.backend.backends_after(load)?;
    let mut session = Session::open(&study, &worlds, &folder, shard, args.restart, &command())?;
    if session.damaged > 0 {
        say!("warning: {}: {} rows are damaged and are counted again", folder.display(), session.damaged);
    }
    let (done, total) = (session.finished_count(), session.total());
    if args.out.is_none() {
        say!("results go to {}", folder.display());
    }
    if done > 0 {
        say!("{done} of {total} scene-poses are finished already");
    }
    let progress = args.progress.start("poses", done, total);
    let onlooker = Onlooker::new(Shown::Job(progress), Some(&stop), true);
    let mut report = None;
    if done < total || session.is_unchecked() {
        let prepare_s = begin.elapsed().as_secs_f64();
        let done = session.run(&mut backends, args.verify, prepare_s, &onlooker)?;
        if let Ending::Stopped(why) = &done.ending {
            onlooker.finish();
            tell(&done, args.timings)?;
            let (left, command) = (total - session.finished_count(), shell::command(&command()));
            say!("{why}: {left} of {total} scene-poses are left; to go on: {command}");
            return Ok(stop_code());
        }
        report = Some(done);
    }
    let results = part.is_none().then(|| Results::new(subject, session.into_pages()));
    if let Some(results) = &results {
        args.outcome.write(results, &folder)?;
    }
    onlooker.finish();
    if let Some(report) = &report {
        tell(report, args.timings)?;
    }
    match &results {
        Some(results) => {
            args.outcome.print_best(Some(&study), results)?;
            let next = print_verdicts(&study, results, None, &folder, &args.study.package_words())?;
            super::print(&format!("results in {}\n", folder.display()))?;
            super::print_next(&next)?;
        }
        None => {
            let (Shard { number, of }, folder, out) = (shard, folder.display(), out.display());
            super::print(&format!(
                "shard {number} of {of} is finished; results in {folder}\nnext, when all are: perirobot merge {out}\n"
            ))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The message of a run that was stopped while it prepared its scenes.
fn not_begun(why: &str) -> String {
    format!("{why} while scenes were made ready; to go on: {}", shell::command(&command()))
}

/// The command as typed, without the arguments that would start the sweep over or stop it again.
pub(super) fn command() -> Vec<String> {
    let mut words = super::words().iter().skip(1).map(|word| word.to_string_lossy().into_owned());
    let mut command = vec!["perirobot".to_string()];
    while let Some(word) = words.next() {
        match word.as_str() {
            "--restart" => {}
            "--max-time" => drop(words.next()),
            _ if word.starts_with("--max-time=") => {}
            _ => command.push(word),
        }
    }
    command
}

/// Prints a summary of the run, and with `--timings` a line per stage.
fn tell(report: &RunReport, timings: bool) -> Result<()> {
    let run = &report.run;
    if timings {
        print_timings(&report.timings);
    }
    if let Some(verified @ 1..) = run.verified {
        say!("{verified} scene-poses counted again on the CPU: no difference");
    }
    let (poses, sweep_s) = (run.poses.unwrap_or(0), run.sweep_s.unwrap_or(0.0));
    super::print(&format!(
        "{poses} scene-poses in {sweep_s:.1} s ({:.1} poses/s) on {}: {}\n",
        run.poses_per_s.unwrap_or(0.0),
        run.backend,
        run.device
    ))
}

/// A line per stage: milliseconds, dispatches, the mean number of placements or jobs per dispatch, and the total of
/// lanes.
fn print_timings(timings: &[StageTiming]) {
    if timings.is_empty() {
        say!("this backend does not measure its stages");
    }
    for StageTiming { stage, took, dispatches, rows, lanes } in timings {
        let (ms, a_dispatch) = (took.as_secs_f64() * 1e3, *rows as f64 / *dispatches as f64);
        say!("{stage:>14} {ms:10.1} ms {dispatches:>7} dispatches of {a_dispatch:.1} rows, {lanes} lanes");
    }
}
