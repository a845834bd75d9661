//! `perirobot bench`: speed of each backend on the whole job, as tables to paste. Measured in `scoring::bench`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::bench::{Race, casts, race};

use super::backend::BackendArgs;
use super::packages::PackageArgs;

/// Measure the speed of each backend, as a ratio to the oracle
///
/// Scores the same poses on the oracle (one thread, plain march), the CPU (one thread with each set of vector
/// instructions that the processor has, and all threads with none and with the most) and the GPU, exactly as `perirobot
/// sweep` does: cast, carve, fuse and count, in every representation and region of the study. Prints a Markdown table
/// for each voxel size and each combination that casts rays.
///
/// A line is the fastest round over all poses; rounds repeat for a second (--seconds), at least three times. The column
/// "load" is the time to make a scene ready for a backend, acceleration structures included, at the first use of a
/// scene or snapshot; no other column contains it. One-thread lines also have a single thread for the host's share of
/// the work; "no SIMD" uses only the vector instructions that every processor of the architecture has.
///
/// Times are unreliable while other programs run; ratios to the oracle, measured in the same minute, are more robust.
/// If any count differs from the oracle's, the first difference is printed, and the exit code is 1.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot bench
      the paper's camera and LIDAR; takes minutes
  perirobot bench --voxel-size 0.05 --poses 2
      only 5 cm voxels, two poses
  perirobot bench my.toml --backend cpu >> RESULTS.md
      your study, no GPU")]
pub(super) struct Args {
    /// Study files (TOML); the first scene of each is used, in all its snapshots
    #[arg(value_name = "STUDY", default_values = ["scenes/paper/exp1.toml", "scenes/paper/exp3.toml"])]
    studies: Vec<PathBuf>,
    /// Edges of a voxel in metres, instead of the study's
    #[arg(long, value_name = "METRES,…", value_delimiter = ',', default_values_t = [0.05, 0.02, 0.01])]
    voxel_size: Vec<f64>,
    /// Choices of poses of each combination, evenly spaced in the study's order
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..))]
    poses: u32,
    /// Repeat each measurement for this many seconds in total; 0 for a single round
    #[arg(long, value_name = "SECONDS", default_value_t = 1, value_parser = clap::value_parser!(u16))]
    seconds: u16,
    /// Ideal sensors: no noise, no lost returns, no mounting error, overriding the study
    #[arg(long)]
    noiseless: bool,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    packages: PackageArgs,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    args.backend.start_threads()?;
    let long_enough = Duration::from_secs(args.seconds.into());
    let mut contenders = args.backend.contenders()?;
    let mut first_difference = None;
    for path in &args.studies {
        for &voxel_size_m in &args.voxel_size {
            let overrides = Overrides { voxel_size_m: Some(voxel_size_m), noiseless: args.noiseless };
            let mut study = Study::read(path, &overrides, args.packages.sources(path))?;
            args.packages.apply(&mut study.scenes);
            let combinations = 0..study.combinations.len();
            let casting: Vec<usize> = combinations.filter(|&c| casts(&study, c)).collect();
            if casting.is_empty() {
                let what =
                    format!("{}: no combination casts rays, so there is nothing to measure", path.display());
                return Err(Issue::says(what).into());
            }
            let begin = Instant::now();
            let worlds = World::prepare(&study, 0)?;
            super::warn(
                worlds.iter().map(|world| (world.name.as_str(), world.warnings.as_slice())),
                super::MOST_WARNINGS,
            );
            super::print(&headline(&study, &worlds, begin.elapsed()))?;
            for combination in casting {
                let race =
                    race(&study, &worlds, combination, args.poses as usize, long_enough, &mut contenders)?;
                super::print(&table(&race))?;
                first_difference = first_difference.or(race.first_difference);
            }
            super::print(&memory())?;
        }
    }
    match first_difference {
        None => Ok(ExitCode::SUCCESS),
        Some(first) => {
            super::print(&format!("first difference: {first}\n"))?;
            Ok(ExitCode::FAILURE)
        }
    }
}

/// The measured study: its scene, grid and regions.
fn headline(study: &Study, worlds: &[World], prepare: Duration) -> String {
    let (world, [x, y, z]) = (&worlds[0], worlds[0].grid.size);
    let (size_cm, window) = (100.0 * study.voxel_size_m, window_of(&world.regions));
    let snapshots = match worlds.len() {
        1 => String::new(),
        many => format!(", {many} snapshots (voxels: of the first)"),
    };
    let regions: Vec<String> = world
        .regions
        .iter()
        .map(|region| format!("{} of {} voxels", region.name, region.voxels.count()))
        .collect();
    format!(
        "## {}, {size_cm} cm\n\nperirobot {}, scene {}{snapshots}, grid {x} × {y} × {z}. Regions: {}, in a window of {} voxels.\n\
         Scenes made ready in {:.2} s.\n\n",
        study.path.display(),
        env!("CARGO_PKG_VERSION"),
        world.name,
        regions.join(", "),
        window.volume(),
        prepare.as_secs_f64()
    )
}

/// The lines of one comparison.
fn table(race: &Race) -> String {
    let mut text = format!(
        "{}: {} scene-poses, {} rays\n\n\
         | backend | load, ms | ms/pose | poses/s | million rays/s | × oracle | rounds |\n\
         |---|---:|---:|---:|---:|---:|---:|\n",
        race.combination, race.poses, race.rays
    );
    let seconds = |work: Duration| work.as_secs_f64().max(1e-9);
    for line in &race.lines {
        let work_s = seconds(line.work);
        text += &format!(
            "| {} | {:.1} | {:.2} | {:.1} | {:.1} | {:.1} | {} |\n",
            line.name,
            1e3 * line.load.as_secs_f64(),
            1e3 * work_s / race.poses as f64,
            race.poses as f64 / work_s,
            1e-6 * race.rays as f64 / work_s,
            seconds(race.lines[0].work) / work_s,
            line.rounds
        );
    }
    let verdict =
        if race.first_difference.is_none() { "All counts equal the oracle's." } else { "COUNTS DIFFER." };
    text + &format!("\n{verdict}\n\n")
}

/// Peak memory of the process, if the system reports it.
fn memory() -> String {
    super::contents::held_mib()
        .map_or(String::new(), |mib| format!("Most memory held so far: {mib} MiB.\n\n"))
}
