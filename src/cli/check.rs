//! `perirobot check`: the contents of a study, how the rays of a few poses end, the estimated duration, and all errors.
//! Read in `input`, cast in `scoring::sample`, printed in `contents`.

use std::process::ExitCode;

use perirobot_decide::approach::{check_approach, check_resolution};
use perirobot_decide::judge::check_postures;
use perirobot_march::{Error, Result};
use perirobot_page::report::wording::count;
use perirobot_study::input::Study;
use perirobot_study::sensor::Sensor;
use perirobot_study::sensor::range::Along;
use perirobot_sweep::scoring::check::ONE_IN;
use perirobot_sweep::scoring::sample::{self, Checker, EndCounts};

use super::backend::BackendArgs;
use super::contents;
use super::sight;
use super::study::StudyArgs;

/// List what a study contains, its errors, and how long it takes
///
/// Reads the study, its scenes and all meshes, and lists scenes, objects, regions, sensors, poses and rows of results.
/// Casts a few poses of each sensor and prints how many of their rays return, end too near, end too far, or leave the
/// grid; warns, with a remedy, if most rays of a sensor do not return. Times a few more poses on the backend that would
/// sweep.
///
/// All independent errors are listed at once; the exit code is then 2. With warnings only it is 0.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot check scenes/quick.toml                   before it is swept
  perirobot check my.toml --poses 0                   cast nothing: only read")]
pub(super) struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// Poses of each sensor to cast, evenly spaced in the study's order; 0 casts and times nothing
    #[arg(long, value_name = "N", default_value_t = 8)]
    poses: usize,
    /// Print everything: each scene, object, region, sensor, combination and warning, even beyond one screen
    #[arg(long)]
    all: bool,
    #[command(flatten)]
    backend: BackendArgs,
}

/// The most warnings, errors and sensors printed without `--all`.
const FEW_WARNINGS: usize = 10;
const FEW_PROBLEMS: usize = 20;
const FEW_SENSORS: usize = 3;

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    args.backend.start_threads()?;
    let (study, worlds, mut problems) = match args.study.examine() {
        Ok((study, worlds, problems)) => (study, worlds, problems),
        Err(problems) => return Ok(refuse(&problems, args.all)),
    };
    super::print(&contents::tables(&study, &worlds, args.all))?;
    let few = |few: usize| if args.all { usize::MAX } else { few };
    let scene_warnings = worlds.iter().map(|world| (world.name.as_str(), world.warnings.as_slice()));
    let mut warnings = super::warn(scene_warnings, few(FEW_WARNINGS));
    for said in [check_postures(&study, &worlds), check_approach(&study, &worlds)] {
        match said {
            Ok(said) => {
                let messages = said.iter().map(|(scene, said)| (*scene, said.as_slice()));
                warnings += super::warn(messages, few(FEW_WARNINGS));
            }
            Err(problem) => problems.push(problem),
        }
    }
    if !problems.is_empty() {
        return Ok(refuse(&problems, args.all));
    }
    if let Some(world) = worlds.first() {
        let coarse = check_resolution(&study, world);
        warnings += super::warn([(world.name.as_str(), coarse.as_slice())].into_iter(), few(FEW_WARNINGS));
    }
    if args.poses > 0 {
        let mut backend = args.backend.open()?;
        let ends = sample::ends(&study, &worlds, args.poses, backend.as_mut())?;
        super::print(&rays(&study, &ends, few(FEW_SENSORS)))?;
        let sight = sight::lines(&study, &worlds, args.poses).into_iter();
        let sight = contents::first_of(sight, few(FEW_SENSORS), "", "sensor");
        super::print(&if sight.is_empty() { sight } else { sight + "\n" })?;
        if !worlds.iter().any(|world| world.is_filled) {
            warnings += advise(&study, &ends, few(FEW_WARNINGS));
        }
        let mut cpu = (backend.name() == "gpu").then(|| args.backend.cpu_beside()).transpose()?;
        let checker = cpu.as_mut().map(|cpu| Checker { backend: cpu, every: ONE_IN });
        let seconds = sample::seconds(&study, &worlds, backend.as_mut(), checker)?;
        super::print(&format!(
            "estimate: {} on {} ({}), from a few poses; without the time to prepare the scenes\n",
            contents::time(seconds),
            backend.name(),
            backend.device()
        ))?;
    }
    super::print(&format!("{}\n{}\n", contents::room(&study, args.backend.memory()), verdict(warnings)))?;
    let next = if study.choose.is_some() { "choose" } else { "sweep" };
    super::print_next(&[["perirobot", next].map(String::from).as_slice(), &args.study.words()].concat())?;
    Ok(ExitCode::SUCCESS)
}

/// The last line of a study without errors.
fn verdict(warnings: usize) -> String {
    match warnings {
        0 => "no problems".into(),
        1 => "no errors; 1 warning above".into(),
        more => format!("no errors; {more} warnings above"),
    }
}

/// Prints the errors, without `--all` only those that fit on a screen. The exit code is 3 if all are disk errors, since
/// those may be temporary.
fn refuse(problems: &[Error], all: bool) -> ExitCode {
    let (count, most) = (problems.len(), if all { usize::MAX } else { FEW_PROBLEMS });
    problems.iter().take(most).for_each(|problem| say!("error: {}", super::flags::to_text(problem)));
    if count > most {
        say!("and {} more (--all)", count - most);
    }
    say!("{count} problem{}", if count == 1 { "" } else { "s" });
    let is_wrong = problems.iter().any(|problem| matches!(problem, Error::Input(_)));
    ExitCode::from(if is_wrong { 2 } else { 3 })
}

/// How the rays of each sensor end.
fn rays(study: &Study, ends: &[EndCounts], most: usize) -> String {
    let line = |(sensor, ends): (&Sensor, &EndCounts)| {
        let percent = |some: u64| 100.0 * some as f64 / ends.rays() as f64;
        format!(
            "rays of {:?} at {}: {:.1} % return, {:.1} % end too near, {:.1} % too far, {:.1} % leave the grid\n",
            sensor.name,
            count(ends.poses as usize, "pose"),
            percent(ends.returns),
            percent(ends.too_near),
            percent(ends.too_far),
            percent(ends.left)
        )
    };
    let casting: Vec<_> = study.sensors.iter().zip(ends).filter(|(_, ends)| ends.rays() > 0).collect();
    let text = contents::first_of(casting.into_iter().map(line), most, "", "sensor");
    let (cast, all) = (sample::SENSORS, study.sensors.len());
    let rest = if all > cast { format!("{cast} of {all} sensors were cast\n") } else { String::new() };
    if text.is_empty() { text } else { text + &rest + "\n" }
}

/// Warns, with a remedy, of each sensor of which most rays do not return; prints at most `most` of them and returns
/// their number.
fn advise(study: &Study, ends: &[EndCounts], most: usize) -> usize {
    let cures = study
        .sensors
        .iter()
        .zip(ends)
        .filter_map(|(sensor, ends)| Some((sensor, cure(study, sensor, ends)?)));
    let cures: Vec<_> = cures.collect();
    cures.iter().take(most).for_each(|(sensor, cure)| say!("warning: sensor {:?}: {cure}", sensor.name));
    if cures.len() > most {
        say!("most rays of {} more sensors do not return either (--all)", cures.len() - most);
    }
    cures.len()
}

/// The remedy for the most frequent end of the rays.
fn cure(study: &Study, sensor: &Sensor, ends: &EndCounts) -> Option<String> {
    let most = |some: u64| 2 * some > ends.rays();
    let is_along_rays = sensor.kind.range().is_some_and(|range| range.along == Along::Ray);
    let depth = match is_along_rays && sensor.kind.name() == "rgbd" {
        true => " write range_along = \"axis\" if its data sheet gives depth,",
        false => "",
    };
    match ends {
        EndCounts { too_near, .. } if most(*too_near) => Some(
            "most rays are blind: something is nearer than range_m's first number; move the poses away from it, or, if it is \
             the sensor's own housing, write near_ignore_m"
                .into(),
        ),
        EndCounts { too_far, .. } if most(*too_far) => Some(format!(
            "most rays find nothing within range_m's second number and give no evidence: move the poses nearer, take a sensor \
             with a longer range,{depth} or, if it certifies what is empty, write no_return = \"free\""
        )),
        EndCounts { left, .. } if most(*left) && !study.backdrop => Some(
            "most rays leave the grid without a hit and give no evidence: model floor and walls (an object with room = { size_m \
             = ... }), or write outside = \"backdrop\" in [grid] if something beyond it returns them; are the poses turned \
             the right way?"
                .into(),
        ),
        _ => None,
    }
}
