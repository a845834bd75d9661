//! `perirobot why`: why single poses miss voxels.

use std::process::ExitCode;

use clap::ValueEnum;
use perirobot_decide::view::{Choice, View, Viewer};
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_page::report::best_choice::best_choice;
use perirobot_page::report::reasons_file::ReasonsFile;
use perirobot_page::report::terminal::reasons;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::table::TableFormat;
use rayon::prelude::*;

use super::backend::BackendArgs;
use super::choice::RestArgs;
use super::progress::ProgressArgs;
use super::score::ScoreArg;
use super::stop::{StopAt, stop_code};
use super::swept::SweptArgs;

/// Explain why voxels stay unknown, and which object is to blame
///
/// Examines the best poses of a finished sweep again, voxel by voxel, and writes reasons.csv into its folder: the
/// number of unknown voxels of each region by reason, and the object to blame. With --pose it examines one choice of
/// poses, prints what it misses and what would help, and leaves the file alone.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
#[command(mut_arg("scene", |arg| arg.requires("pose")), mut_arg("snapshot", |arg| arg.requires("pose")))]
pub(super) struct Args {
    #[command(flatten)]
    swept: SweptArgs,
    /// Only these poses, as in the column `poses` of results.csv; for a sensor scored alone, the pose's name alone
    /// suffices
    #[arg(long, value_name = "POSES")]
    pose: Option<String>,
    #[command(flatten)]
    rest: RestArgs,
    /// The number of best poses, of each combination and representation in each region
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..), conflicts_with_all = ["pose", "all"])]
    best: u32,
    /// The score that ranks them [default: f1 and human_seen]
    #[arg(long, value_enum, conflicts_with_all = ["pose", "all"])]
    score: Option<ScoreArg>,
    /// All poses; takes some hundredths of a second for each pose, scene, snapshot, repeat and representation
    #[arg(long, conflicts_with = "pose")]
    all: bool,
    /// Format of the table of reasons
    #[arg(long, value_enum, default_value = "csv", conflicts_with = "pose")]
    table: ReasonTable,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

#[derive(Clone, Copy, ValueEnum)]
enum ReasonTable {
    /// Comma-separated text
    Csv,
    /// Apache Parquet
    #[cfg(feature = "parquet")]
    Parquet,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/quick.toml --out out/quick
  perirobot why out/quick
      reasons.csv of the best poses; the best in words
  perirobot why out/quick --pose right-wall/4/0
      one pose, in words

Reasons; a voxel has the first that applies to the ray nearest to its centre,
and of several sensors the latest in this list. Those with a star count as
monitored (the paper's: monitored, but occluded):
  out_of_view    no sensor looks there
  out_of_range   it is too far away
  silent       * a switch that is off, and certifies nothing
  between_rays   no ray crosses it: too sparse
  hidden       * an object is in front of it
  blind        * an object is too near to the lens
  no_return    * nothing behind it returned, which certifies nothing
  misread      * noise read the return elsewhere
  cancelled    * votes of sensors cancel each other";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    args.backend.start_threads()?;
    let (results, warnings) = Results::read(args.swept.folder())?;
    warnings.iter().for_each(|warning| say!("warning: {warning}"));
    // Opened first, so that a wrong path fails before the computation.
    let format = match args.table {
        ReasonTable::Csv => TableFormat::Csv,
        #[cfg(feature = "parquet")]
        ReasonTable::Parquet => TableFormat::Parquet,
    };
    let file = args.pose.is_none().then(|| ReasonsFile::create(args.swept.folder(), format)).transpose()?;
    let (study, worlds) = args.swept.load()?;
    let mut backend = args.backend.open()?;
    if let Some(poses) = &args.pose {
        let study = args.rest.with_set(study, poses);
        let looked = args.rest.look(poses, &study, &worlds)?;
        let view = Viewer::new(&looked.study, &mut *backend)?
            .view_regions(looked.world(), &[looked.choice])?
            .swap_remove(0);
        super::print(&describe(&view, 0..study.regions.len()))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut viewer = Viewer::new(&study, &mut *backend)?;
    let scores = args.score.map_or(vec![Score::F1, Score::HumanSeen], |arg| vec![arg.score()]);
    let explained = explained(args.score.map(|arg| arg.score()), &study, &results)?;
    let chosen = match args.all {
        true => every(&study),
        false => {
            let mut best = reasons::leaders(&results, args.best as usize, &scores)?;
            best.extend(
                explained
                    .iter()
                    .map(|(choice, _)| [choice.combination, choice.choice, choice.representation]),
            );
            best.sort_unstable();
            best.dedup();
            best
        }
    };
    if let Some(file) = file
        && let Some(why) = write(args, file, &study, &worlds, &chosen, &mut viewer)?
    {
        say!("{why}: no table was written; the same command starts over");
        return Ok(stop_code());
    }
    for (choice, regions) in explained {
        let view = viewer.view_regions(&worlds[0], &[choice])?.swap_remove(0);
        super::print(&describe(&view, regions))?;
    }
    if let [first, _, ..] = worlds.as_slice() {
        let (title, all) = (first.title(&study), worlds.len());
        super::print(&format!(
            "\nOnly {title} of {all} scenes and snapshots is explained here; see others with --pose, --scene and --snapshot.\n"
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The choices to explain in words, with their regions: the best of the study in all regions; with a score the best by it
/// in each.
fn explained(score: Option<Score>, study: &Study, results: &Results) -> Result<Vec<(Choice, Vec<usize>)>> {
    let regions = 0..study.regions.len();
    let Some(score) = score else {
        return Ok(best_choice(study, results)?
            .map(|choice| (choice, regions.collect()))
            .into_iter()
            .collect());
    };
    let of_region = |region: usize| {
        let leader = reasons::leader(results, region, score)?;
        Ok(leader.map(|[combination, choice, representation]| {
            (Choice { combination, choice, representation, repeat: 0 }, vec![region])
        }))
    };
    regions.filter_map(|region| of_region(region).transpose()).collect()
}

fn describe(view: &View, regions: impl IntoIterator<Item = usize>) -> String {
    reasons::render(view, &view.why_in_regions(), regions)
}

/// All choices, as combination, choice and representation.
fn every(study: &Study) -> Vec<[usize; 3]> {
    let choices = |(number, combination): (usize, &perirobot_study::input::Combination)| {
        let representations = combination.representation_count(&study.sensors);
        (0..combination.choices())
            .flat_map(move |choice| (0..representations).map(move |way| [number, choice, way]))
    };
    study.combinations.iter().enumerate().flat_map(choices).collect()
}

/// Views computed together, so that all cores are busy.
const AT_ONCE: usize = 64;

/// Writes the table of the given choices in all scenes, snapshots and repeats. Returns the reason if it was stopped.
fn write<'a>(
    args: &Args,
    mut file: ReasonsFile,
    study: &Study,
    worlds: &'a [World],
    chosen: &[[usize; 3]],
    viewer: &mut Viewer<'a, '_>,
) -> Result<Option<String>> {
    let stop = StopAt::listen(None)?;
    let views = worlds.len() * study.repeats as usize * chosen.len();
    let mut progress = args.progress.start("views", 0, views as u64);
    for world in worlds {
        for repeat in 0..study.repeats as usize {
            for some in chosen.chunks(AT_ONCE) {
                if let why @ Some(_) = stop.reason() {
                    return Ok(why);
                }
                let to_choice = |&[combination, choice, representation]: &[usize; 3]| Choice {
                    combination,
                    choice,
                    representation,
                    repeat,
                };
                let views = viewer.view_regions(world, &some.iter().map(to_choice).collect::<Vec<_>>())?;
                let missed: Vec<_> = views.par_iter().map(View::why_in_regions).collect();
                for (view, missed) in views.iter().zip(&missed) {
                    file.add(view, missed)?;
                }
                progress.inc(some.len() as u64);
            }
        }
    }
    progress.finish();
    let path = file.path().display().to_string();
    let rows = file.finish()?;
    super::print(&format!("{rows} rows of {} choices of poses in {path}\n", chosen.len()))?;
    Ok(None)
}
