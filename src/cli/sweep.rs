//! `perirobot sweep`: the main job.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use perirobot::Result;
use perirobot::report::{Results, best, scores};
use perirobot::sweep::files::OutputFolder;
use perirobot::sweep::manifest::{Timings, manifest};
use perirobot::sweep::{jobs, run as run_sweep, table};

use super::backend::BackendArgs;
use super::study::StudyArgs;

/// Score every candidate pose of a study
///
/// Writes results.csv (counts and scores), scores.csv (scores over snapshots and repeats), poses.csv (where each pose
/// is) and manifest.json (what was run) into the output folder, each whole or not at all, and prints the best poses
/// beside what trivial answers would score. `perirobot summary DIR` prints more from the folder.
#[derive(clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Folder for the results; made if needed
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    backend: BackendArgs,
    /// Say afterwards, on standard error, what each stage of the backend's work took, where that is known
    #[arg(long)]
    timings: bool,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    args.backend.start_threads()?;
    let begin = Instant::now();
    let (study, worlds) = args.study.load()?;
    let mut backend = args.backend.open()?;
    let folder = OutputFolder::open(&args.out)?;
    let prepare_s = begin.elapsed().as_secs_f64();

    eprintln!("running on {}: {}", backend.name(), backend.device());
    let bar = super::progress(jobs(&study), "poses");
    let begin = Instant::now();
    let rows = run_sweep(&study, &worlds, backend.as_mut(), |poses| bar.inc(poses))?;
    bar.finish_and_clear();
    let timings = Timings { prepare_s, sweep_s: begin.elapsed().as_secs_f64() };

    if args.timings {
        print_timings(&backend.timings());
    }

    folder.write("poses.csv", &table::poses_csv(&study))?;
    folder.write("results.csv", &table::results_csv(&study, &rows))?;
    let results = Results::of_sweep(&study, &worlds, &rows);
    folder.write("scores.csv", &scores::render(&results))?;
    folder.write("manifest.json", &manifest(&study, &worlds, backend.as_ref(), timings))?;
    super::print(&best::render(&results))?;
    let (poses, seconds) = (jobs(&study), timings.sweep_s);
    super::print(&format!(
        "\n{poses} scene-poses in {seconds:.1} s ({:.1} poses/s) on {}: {}\nresults in {}\n",
        poses as f64 / seconds.max(1e-9),
        backend.name(),
        backend.device(),
        args.out.display()
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// A line a stage, in milliseconds.
fn print_timings(timings: &[(&str, Duration)]) {
    if timings.is_empty() {
        eprintln!("this backend does not know what its stages took");
    }
    for (stage, took) in timings {
        eprintln!("{stage:>8} {:10.1} ms", took.as_secs_f64() * 1e3);
    }
}
