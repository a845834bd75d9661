//! `perirobot sweep`: the main job.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use perirobot::Result;
use perirobot::study::Study;
use perirobot::sweep::files::OutputFolder;
use perirobot::sweep::manifest::{Timings, manifest};
use perirobot::sweep::{World, jobs, run as run_sweep, summary::summary, table};

use super::backend::BackendArgs;
use super::packages::PackageArgs;

/// Score every candidate pose of a study
///
/// Writes results.csv (counts and scores), poses.csv (where each pose is) and manifest.json (what was run) into the
/// output folder, each whole or not at all, and prints the best poses beside what trivial answers would score.
#[derive(clap::Args)]
pub(super) struct Args {
    /// The study file (TOML)
    study: PathBuf,
    /// Folder for the results; made if needed
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Edge of a voxel in metres, instead of the study's
    #[arg(long, value_name = "METRES")]
    voxel_size: Option<f64>,
    #[command(flatten)]
    packages: PackageArgs,
    #[command(flatten)]
    backend: BackendArgs,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let begin = Instant::now();
    let mut study = Study::load(&args.study, args.voxel_size)?;
    args.packages.apply(&mut study.scenes);
    let worlds =
        study.scenes.iter().map(|scene| World::prepare(&study, scene)).collect::<Result<Vec<_>>>()?;
    super::warn(worlds.iter().map(|world| (world.name.as_str(), world.warnings.as_slice())));
    let mut backend = args.backend.open()?;
    let folder = OutputFolder::open(&args.out)?;
    let prepare_s = begin.elapsed().as_secs_f64();

    eprintln!("running on {}: {}", backend.name(), backend.device());
    let bar = super::progress(jobs(&study), "poses");
    let begin = Instant::now();
    let rows = run_sweep(&study, &worlds, backend.as_mut(), |poses| bar.inc(poses))?;
    bar.finish_and_clear();
    let timings = Timings { prepare_s, sweep_s: begin.elapsed().as_secs_f64() };

    folder.write("poses.csv", &table::poses_csv(&study))?;
    folder.write("results.csv", &table::results_csv(&study, &rows))?;
    folder.write("manifest.json", &manifest(&study, &worlds, backend.as_ref(), timings))?;
    super::print(&summary(&study, &worlds, &rows))?;
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
