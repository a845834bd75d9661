//! `perirobot compare`: placements side by side, from the folder of a sweep or of two.

use std::path::PathBuf;
use std::process::ExitCode;

use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::metrics::Score;
use perirobot_page::report::terminal::placements::{PLACEMENTS, PlacementFilter, RankedPlacement, Sweeps};

use super::flags;
use super::score::ScoreArg;

/// Put placements of one sweep, or of two, side by side
///
/// Reads the folders of finished sweeps and prints, for each region, every score of each placement (one column a
/// placement), the difference if there are two, and the maxima over all positions of the study: over all scenes (mean,
/// worst and pooled), then for each scene. For two sweeps it also prints how they differ. Nothing is cast.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    /// Folder written by `perirobot sweep` or `perirobot choose`, and another, for a sweep of a changed study
    #[arg(value_name = "DIR", required = true, num_args = 1..=2)]
    folders: Vec<PathBuf>,
    /// A placement, as in the column `poses` of results.csv; for a sensor scored alone, the pose's name alone suffices.
    /// Repeat it for each
    #[arg(long, value_name = "POSES", required_unless_present = "best")]
    pose: Vec<String>,
    /// Instead of names: the number of best placements of each sweep in each region
    #[arg(long, value_name = "N", conflicts_with = "pose", value_parser = clap::value_parser!(u32).range(1..=26))]
    best: Option<u32>,
    /// The score that ranks them [default: f1]
    #[arg(long, value_enum, conflicts_with = "pose")]
    score: Option<ScoreArg>,
    /// Only placements of this combination [default: every combination with these poses]
    #[arg(long, value_name = "NAME")]
    combination: Option<String>,
    /// The representation of the sensor data, as in results.csv [default: the first for named placements, any for the
    /// best]
    #[arg(long, value_name = "NAME")]
    representation: Option<String>,
    /// Only this scene
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Only this region
    #[arg(long, value_name = "NAME")]
    region: Option<String>,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/quick.toml --out out/quick
  perirobot compare out/quick --pose right-wall/8/1 --pose ceiling/7/0
      two placements
  perirobot compare out/quick --best 3 --score parts_detected
      the three that detect most body parts, of each region
  perirobot sweep scenes/quick.toml --voxel-size 0.1 --out out/coarse
  perirobot compare out/quick out/coarse --pose right-wall/8/1
      one placement in two sweeps

How to read it:
  Lower unknown and false_alarm are better, higher values of all other scores.
  Read human_claimed together with its false_alarm.
  A score without a value (nothing of the kind is in the region) is a dash.";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let (sweeps, notes) = Sweeps::read(&args.folders, args.scene.as_deref())?;
    notes.iter().for_each(|note| say!("note: {note}"));
    let (regions, left_out) = sweeps.regions(args.region.as_deref())?;
    left_out.iter().for_each(|note| say!("note: {note}"));
    let filter = PlacementFilter {
        combination: args.combination.as_deref(),
        representation: args.representation.as_deref(),
    };
    let mut text = String::new();
    match args.best {
        Some(count) => {
            let score = args.score.map_or(Score::F1, ScoreArg::score);
            for region in regions {
                let best = check_count(sweeps.best(&region, score, count as usize, filter)?)?;
                text += &sweeps.key(&best);
                text += &sweeps.render(&region, &best)?;
            }
        }
        None => {
            let (placements, left_out) = sweeps.find_all(&args.pose, filter)?;
            left_out.iter().for_each(|error| say!("note: left out: {}", flags::to_text(error)));
            let placements = check_count(placements)?;
            text += &sweeps.key(&placements);
            for region in regions {
                text += &sweeps.render(&region, &placements)?;
            }
        }
    }
    super::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Checks that their number fits side by side.
fn check_count(placements: Vec<RankedPlacement>) -> Result<Vec<RankedPlacement>> {
    let (found, least, most) = (placements.len(), PLACEMENTS.start(), PLACEMENTS.end());
    if PLACEMENTS.contains(&found) {
        return Ok(placements);
    }
    Err(Issue::says(format!(
        "--pose, --best: {found} placements: must be {least} to {most}; change --pose or --best"
    ))
    .into())
}
