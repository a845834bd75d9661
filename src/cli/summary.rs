//! `perirobot summary`: the tables behind the paper's figures, from the folder of a sweep.

use std::path::PathBuf;
use std::process::ExitCode;

use perirobot_decide::choose::Chosen;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_page::report::ReportSelection;
use perirobot_page::report::terminal::{self, distribution, groups, maxima, moving_scenes, places};
use perirobot_sweep::results::Results;

use super::score::ScoreArg;

/// Print the tables behind the paper's figures from a sweep
///
/// Reads counts.journal, poses.csv and manifest.json of an output folder and prints the tables that apply: the
/// distribution of the scores over all choices of poses (per scene, region, combination and representation, with the
/// baselines of the region); the maximum of each combination of sensors, and its share of the largest combination's
/// maximum; the best pose of each group of poses (a wall, the ceiling); the best choices over the snapshots of moving
/// scenes, by mean and by worst. For chosen sets of sensors, their front comes first.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    /// Folder written by `perirobot sweep` or `perirobot choose`
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Only this region
    #[arg(long, value_name = "NAME")]
    region: Option<String>,
    /// Only this combination (for a sensor alone, its name)
    #[arg(long, value_name = "NAME")]
    combination: Option<String>,
    /// Only this score [default: f1 and kappa]
    #[arg(long, value_enum)]
    score: Option<ScoreArg>,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/quick.toml --out out/quick
  perirobot summary out/quick
      all tables that apply
  perirobot summary out/quick --region human --score f1
      one score in one region

How to read it:
  A score without a value (nothing of the kind is in the region) is a dash, and
  is left out of means, never 0.
  Compare every score with the baselines: a sensor stuck at `occupied` has a
  better F1 than many poses.
  The same numbers for pandas, one row a choice of poses: scores.csv in the
  folder.";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let (results, warnings) = Results::read(&args.folder)?;
    for warning in warnings {
        say!("warning: {warning}");
    }
    let scores = args.score.map_or(&[Score::F1, Score::Kappa][..], ScoreArg::scores);
    let (region, combination) = (args.region.as_deref(), args.combination.as_deref());
    let selection = ReportSelection::resolve(&results, region, combination, scores)?;
    if let Some(chosen) = Chosen::read(&args.folder)? {
        super::print(&terminal::choose::overview(&chosen))?;
    }
    for render in
        [places::render, distribution::render, maxima::render, groups::render, moving_scenes::render]
    {
        super::print(&render(&results, &selection)?)?;
    }
    Ok(ExitCode::SUCCESS)
}
