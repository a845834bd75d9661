//! `perirobot verify-backends`: proves that every backend returns the oracle's integers.

use std::process::ExitCode;

use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_sweep::scoring::compare::{
    ComparedLine, Comparison, PoseSelection, compare, compare_combination, select, select_choices,
};

use super::backend::BackendArgs;
use super::progress::ProgressArgs;
use super::study::StudyArgs;

/// Prove that every backend gives the same integers
///
/// Compares counts, bit planes over the whole grid and the end of every ray with the oracle, the plain reference;
/// counts in the batches of a sweep. Exits 1 on any difference and names the first: scene, pose, ray, voxel. Times
/// below half a second are not compared: `perirobot bench` measures speed.
#[derive(clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Poses of each scene and sensor, and choices of each combination, evenly spaced
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    poses: u32,
    /// Shift the selected poses by this many places in study order
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with_all = ["pose", "all"])]
    turn: u32,
    /// Compare only counts, in the batches of a sweep; neither planes nor rays
    #[arg(long)]
    counts: bool,
    /// One pose by its name, as in poses.csv
    #[arg(long, value_name = "NAME", conflicts_with = "poses")]
    pose: Option<String>,
    /// All poses
    #[arg(long, conflicts_with_all = ["poses", "pose"])]
    all: bool,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    args.backend.start_threads()?;
    let (study, worlds) = args.study.load()?;
    let selection = match (&args.pose, args.all) {
        (Some(name), _) => PoseSelection::Named(name.clone()),
        (None, true) => PoseSelection::All,
        (None, false) => PoseSelection::Spread { number: args.poses as usize, turn: args.turn as usize },
    };
    let no_pose = study.sensors.iter().all(|sensor| select(&selection, sensor).is_empty());
    if no_pose && study.combinations.iter().all(|c| select_choices(&selection, &study, c).is_empty()) {
        let name = args.pose.as_deref().unwrap_or_default();
        let what =
            format!("--pose {name}: unknown pose name (poses.csv and results.csv of a sweep list them)");
        return Err(Issue::says(what).into());
    }
    let mut backends = args.backend.open_all()?;
    for backend in &backends {
        say!("comparing {}: {}", backend.name(), backend.device());
    }
    let sensors = if args.counts { 0 } else { study.sensors.len() };
    let steps = worlds.len() * sensors + study.scenes.len() * study.combinations.len();
    let mut progress = args.progress.start("sensors and combinations", 0, steps as u64);
    let mut report = Comparison::default();
    for world in &worlds {
        for sensor in 0..sensors {
            compare(&study, world, sensor, &selection, &mut backends, &mut report)?;
            progress.inc(1);
        }
    }
    for of_scene in worlds.chunk_by(|a, b| a.scene == b.scene) {
        for combination in 0..study.combinations.len() {
            compare_combination(&study, of_scene, combination, &selection, &mut backends, &mut report)?;
            progress.inc(1);
        }
    }
    progress.finish();
    super::print(&table(&report.lines))?;
    match report.first_difference {
        None => {
            let names: Vec<_> = backends.iter().map(|backend| backend.name()).collect();
            super::print(&format!("\n0 differences between oracle and {}\n", names.join(", ")))?;
            Ok(ExitCode::SUCCESS)
        }
        Some(first) => {
            super::print(&format!("\nfirst difference: {first}\n"))?;
            Ok(ExitCode::FAILURE)
        }
    }
}

/// Below this time, the oracle is too fast for a comparison.
const COMPARED_S: f64 = 0.5;

fn table(lines: &[ComparedLine]) -> String {
    let mut text = format!(
        "{:<14} {:<24} {:<8} {:>6} {:>12} {:>12} {:>12} {:>10} {:>8}\n",
        "scene",
        "sensor or = combination",
        "backend",
        "poses",
        "rays",
        "voxels",
        "differences",
        "ms/pose",
        "× oracle"
    );
    let mut oracle_s = 0.0;
    for line in lines {
        let seconds = line.time.as_secs_f64();
        if line.backend == "oracle" {
            oracle_s = seconds;
        }
        let ratio = match oracle_s < COMPARED_S {
            true => "–".to_string(),
            false => format!("{:.2}", oracle_s / seconds.max(1e-9)),
        };
        text += &format!(
            "{:<14} {:<24} {:<8} {:>6} {:>12} {:>12} {:>12} {:>10.1} {:>8}\n",
            line.scene,
            line.what,
            line.backend,
            line.poses,
            line.rays,
            line.voxels,
            line.differences,
            1e3 * seconds / line.poses as f64,
            ratio
        );
    }
    text
}
