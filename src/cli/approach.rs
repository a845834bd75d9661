//! `perirobot approach`: how close a body can come to the robot without being noticed.

use std::path::PathBuf;
use std::process::ExitCode;

use perirobot_decide::approach::{APPROACH, Approaching, fusion_warning};
use perirobot_decide::judge::alter;
use perirobot_decide::view::{Choice, ChoiceSelector, find, only_choice, with_set};
use perirobot_march::Result;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::files::OutputFolder;

use super::MOST_WARNINGS;
use super::backend::ThreadArgs;
use super::choice::AlterationArgs;
use super::onlooker::{Onlooker, Shown};
use super::progress::ProgressArgs;
use super::stop::end_tidily;
use super::study::StudyArgs;
use super::swept::StudyPlace;

/// Compute how close a body can come to the robot unnoticed
///
/// From the entries of the study's table [approach], floods all space that a body can reach unnoticed by the sensors of
/// one choice of poses. Reports the closest distance to the robot (or to a region) and the path: with an empty scene
/// and with the scene's people as cover, in each snapshot and in all snapshots at once. Writes approach.csv,
/// approach.json with the same values, the paths as paths.ply, and floor plans. A folder of results can replace the
/// study; its study and placements are then used. A planning aid: only the contents of the study count.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// The study file of a folder of results, if it was moved
    #[arg(id = "moved", long = "study", value_name = "FILE", help_heading = "Study")]
    moved: Option<PathBuf>,
    /// The poses, sensor:pose as `perirobot check` lists them, several joined by ";", or as in the column `poses` of
    /// results.csv [default: those of a study with one choice of poses]
    #[arg(long, value_name = "POSES")]
    pose: Option<String>,
    /// The combination, if several contain these poses
    #[arg(long, value_name = "NAME")]
    combination: Option<String>,
    /// The representation of the sensor data, as in results.csv [default: the first]
    #[arg(long, value_name = "NAME")]
    representation: Option<String>,
    /// The repeat, for sensors with noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    repeat: usize,
    #[command(flatten)]
    alteration: AlterationArgs,
    /// Folder for the files; made if needed. Files of the same names are replaced [default: out/, the study's
    /// name and -approach]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot approach scenes/approach.toml --pose wall/front --out out/near
      one camera: a person comes in through a shelf's shadow
  perirobot approach scenes/approach.toml \\
    --pose \"camera:wall/front;camera:wall/back\" --out out/both
      a second camera looks behind the shelf
  perirobot approach scenes/approach.toml \\
    --pose \"camera:wall/front;camera:wall/back\" --dead camera:wall/back \\
    --out out/dead
      the same where the second camera is dead";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    end_tidily()?;
    args.threads.start()?;
    let place = StudyPlace { named: args.moved.as_deref(), cure: ", or name the study: --study FILE" };
    let (study, worlds) = match args.study.load_folder(place)? {
        Some((study, worlds)) => {
            let warnings = worlds.iter().map(|world| (world.name.as_str(), world.warnings.as_slice()));
            super::warn(warnings, MOST_WARNINGS);
            (study, worlds)
        }
        None => args.study.load()?,
    };
    let poses = match &args.pose {
        Some(poses) => poses.clone(),
        None => only_choice(&study, args.combination.as_deref())?,
    };
    let study = with_set(study, &poses, args.combination.as_deref());
    let choice = args.find(poses, &study, &worlds)?;
    fusion_warning(&study, &choice).iter().for_each(|warning| say!("warning: {warning}"));
    let alteration = args.alteration.alteration();
    let (own_study, own_worlds, own) = alter(&study, &worlds, &choice, &alteration)?;
    let (planned, altered) = ((&study, worlds.as_slice(), choice), (&own_study, own_worlds.as_slice(), own));
    // All scenes are checked before anything is cast.
    let approaching = Approaching::new(planned, altered, &alteration)?;
    // If nothing can be written, a folder created here is removed again.
    let out = args.out.clone().unwrap_or_else(|| args.study.usual_out("-approach"));
    let folder = OutputFolder::open(&out)?;
    let shown = Shown::Job(args.progress.start("moments", 0, approaching.total()));
    let onlooker = Onlooker::new(shown, None, false);
    let approached = approaching.answer(&onlooker, &mut |words| super::print(words))?;
    onlooker.finish();
    if let Some(stopping) = &study.stopping {
        super::print(&format!("{}\n", stopping.assumptions(study.voxel_size_m).join("\n")))?;
    }
    for name in approached.write(&folder)? {
        say!("warning: {}: is no floor plan of this run", folder.path().join(name).display());
    }
    let rows = approached.approaches.rows.len();
    super::print(&format!("{rows} rows in {}\n", folder.path().join(APPROACH).display()))?;
    Ok(ExitCode::SUCCESS)
}

impl Args {
    fn find(&self, poses: String, study: &Study, worlds: &[World]) -> Result<Choice> {
        let wanted = ChoiceSelector {
            poses,
            combination: self.combination.clone(),
            representation: self.representation.clone(),
            repeat: self.repeat,
            ..ChoiceSelector::default()
        };
        Ok(find(study, worlds, &wanted)?.1)
    }
}
