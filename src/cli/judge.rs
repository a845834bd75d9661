//! `perirobot judge`: whether requirements are met. Decided in `judge`, printed in `report::terminal::judge`.

use std::path::PathBuf;
use std::process::ExitCode;

use perirobot_decide::judge::{
    Alteration, CasePart, JudgedSet, Judgement, Judging, Moment, Speeds, cheapest, chosen_sets, forget,
    junit_xml, leaders, requires_something,
};
use perirobot_march::Result;
use perirobot_page::report::terminal;
use perirobot_page::report::wording;
use perirobot_scene::shell;
use perirobot_study::input::Study;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::columns::BETWEEN_MEMBERS;
use perirobot_sweep::results::files::write_whole;

use super::backend::BackendArgs;
use super::choice::SetArgs;
use super::onlooker::{Onlooker, Shown};
use super::outcome::look_at;
use super::progress::ProgressArgs;
use super::stop::StopAt;
use super::swept::SweptArgs;

/// The exit code if a requirement is missed.
const MISSED: u8 = 4;

/// Decide whether requirements are met
///
/// [[require]] in a study sets the scores that sensors must reach in a region, as planned or with an alteration. Prints
/// for each requirement and condition whether it is met (PASS or FAIL), the value, the worst place and moment, and the
/// command that draws it; writes requirements.csv, conditions.csv and judge.json, which has the values of both, into
/// the folder. For a study with [stopping] it also reports how fast the robot may run, and what a controller would
/// measure (speeds.csv, separation.csv). Without --pose it judges the choice of poses that meets most requirements as
/// planned, and for a folder of `perirobot choose` all sets (--set for one). Requirements may be changed or added after
/// the sweep: they do not affect the counts. Files of an earlier judgement are removed first. The exit code is 4 if a
/// requirement is missed; if all sets of `perirobot choose` are judged, only if each of them misses one.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(flatten)]
    swept: SweptArgs,
    #[command(flatten)]
    sets: SetArgs,
    /// The number of judged choices of poses: those that meet most requirements as planned [default: 1; for a folder of
    /// `perirobot choose` all sets]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "pose")]
    best: Option<u32>,
    /// Write the verdicts as JUnit XML as well, for build servers
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/judge.toml --out out/judge
  perirobot judge out/judge || echo missed
      one requirement is met, one is missed
  perirobot judge out/judge --best 3 --junit verdicts.xml || echo missed
      three choices of poses, also as a file for a build server

How to read it:
  Values are compared with limits as fractions of whole numbers, never rounded.
  A choice without a value (no person in the region, say) misses the
  requirement. How fast the robot may run changes no exit code: to require a
  speed, require approach_margin_m, or a score in a region of that speed.";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    args.backend.start_threads()?;
    let folder = args.swept.folder();
    let (results, warnings) = Results::read(folder)?;
    warnings.iter().for_each(|warning| say!("warning: {warning}"));
    let (study, worlds) = args.swept.load()?;
    let study = args.sets.with_set(study);
    if let Err(nothing) = requires_something(&study) {
        forget(folder, args.junit.as_deref())?;
        return Err(nothing);
    }
    let asks_for_all = args.best.is_none() && args.sets.is_any();
    let front = if asks_for_all { chosen_sets(folder, &results)? } else { None };
    let is_front = front.is_some();
    let choices = match (args.sets.find_choice(&study, &worlds)?, front) {
        (Some(choice), _) => vec![choice],
        (None, Some(sets)) => sets,
        (None, None) => {
            let best = args.best.unwrap_or(1) as usize;
            leaders(&study.requirements, &results, best, args.sets.filter())?
        }
    };
    let stop = StopAt::listen(None)?;
    // Nothing is removed before all arguments are checked.
    let judging = Judging::new(&study, &worlds, &results, &choices)?;
    judging.warnings.iter().for_each(|warning| say!("warning: {warning}"));
    let cut_off = judging.cut_off.iter().map(|(scene, cut)| (*scene, cut.as_slice()));
    super::warn(cut_off, super::MOST_WARNINGS);
    forget(folder, args.junit.as_deref())?;
    let total = judging.total();
    let shown = if total > 0 { Shown::Job(args.progress.start("cases", 0, total)) } else { Shown::Nothing };
    let onlooker = Onlooker::new(shown, Some(&stop), true);
    let judged = judging.judge(&|| args.backend.backends(), &onlooker)?;
    onlooker.finish();
    judged.warnings.iter().for_each(|warning| say!("warning: {warning}"));
    judging.write(folder, &judged)?;
    let sets = &judged.sets;
    // Judgements with the same worst moment share a picture, with the number of the first.
    let each = sets.iter().flat_map(|set| set.judgements.iter().map(move |one| (set, one)));
    let pictures: Vec<(&Judgement, Option<Vec<String>>)> =
        each.map(|(set, one)| (one, args.picture(&study, &results, set, one))).collect();
    let number = |judgement: &Judgement| pictures.iter().position(|(one, _)| std::ptr::eq(*one, judgement));
    let first = |number: usize| pictures.iter().position(|(_, words)| *words == pictures[number].1);
    let picture = |_: &JudgedSet, judgement: &Judgement| {
        let first = first(number(judgement)?)?;
        Some(command(pictures[first].1.as_ref()?, first + 1))
    };
    let picture_once = |set: &JudgedSet, judgement: &Judgement| {
        let own = number(judgement)?;
        match first(own)? {
            first if first == own => picture(set, judgement),
            first => pictures[own].1.as_ref().map(|_| describe_same(pictures[first].0)),
        }
    };
    if let Some(path) = &args.junit {
        let describe = |set: &JudgedSet, judgement: &Judgement| {
            let line = terminal::judge::line(&results, set, judgement);
            let line = set.caveats.iter().fold(line, |text, caveat| format!("{text}\nbut: {caveat}"));
            picture(set, judgement).map_or(line.clone(), |picture| format!("{line}\n{picture}"))
        };
        write_whole(path, junit_xml(sets, &describe).as_bytes())?;
    }
    for set in sets {
        super::print(&terminal::judge::render(&results, set, &picture_once))?;
    }
    super::print(&at_speeds(&study, &results, sets, &judging.speeds(sets)))?;
    super::print(&format!("\n{}\n", count(sets)))?;
    let passing: Vec<usize> = (0..sets.len()).filter(|&number| sets[number].meets_all()).collect();
    if is_front {
        super::print(&recommend(&study, sets, &passing))?;
    }
    super::print(&format!("tables in {}\n", folder.display()))?;
    super::print_next(&look_at(folder, &args.swept.folder_words()))?;
    Ok(match if is_front { !passing.is_empty() } else { passing.len() == sets.len() } {
        true => ExitCode::SUCCESS,
        false => ExitCode::from(MISSED),
    })
}

/// The cheapest set of a front that meets all requirements; sets are numbered as their combinations.
fn recommend(study: &Study, sets: &[JudgedSet], passing: &[usize]) -> String {
    match cheapest(study, passing) {
        None => format!("none of the {} sets meets all requirements\n", sets.len()),
        Some(place) => {
            let JudgedSet { combination, poses, .. } = &sets[passing[place]];
            format!("recommended: {combination} ({poses}), the cheapest set that meets all requirements\n")
        }
    }
}

/// The number of requirements that are met, and of PASS verdicts: one for each condition of a requirement.
fn count(sets: &[JudgedSet]) -> String {
    let all = || sets.iter().flat_map(|set| &set.judgements);
    let (pass, verdicts) = (all().filter(|judgement| judgement.is_met).count(), all().count());
    let each = |set: &JudgedSet| {
        let one = |all: &[Judgement]| all.iter().all(|judgement| judgement.is_met);
        let met = set.judgements.chunk_by(|a, b| a.requirement.name == b.requirement.name).map(one);
        met.collect::<Vec<bool>>()
    };
    let required: Vec<bool> = sets.iter().flat_map(each).collect();
    let met = required.iter().filter(|met| **met).count();
    let of = if sets.len() > 1 { format!(" of {} choices", sets.len()) } else { String::new() };
    let many = if required.len() == 1 { "" } else { "s" };
    let text = format!("{met} of {} requirement{many}{of} met", required.len());
    match verdicts == required.len() {
        true => text,
        false => format!("{text} ({pass} of {verdicts} verdicts are PASS)"),
    }
}

/// Results that depend on the robot's speed, with their assumptions; empty for a study without a required distance.
fn at_speeds(
    study: &Study,
    results: &Results,
    sets: &[JudgedSet],
    speeds: &[(&JudgedSet, Speeds)],
) -> String {
    let Some(stopping) = &study.stopping else { return String::new() };
    let texts = sets.iter().map(|set| {
        let heading = if sets.len() > 1 { format!("\n{}\n", set.poses) } else { String::new() };
        let own = speeds.iter().find(|(other, _)| std::ptr::eq(*other, set));
        let fast = own.map_or(String::new(), |(_, speeds)| terminal::speed::render(speeds, stopping));
        heading + &fast + &terminal::separation::render(results, set, stopping, study.voxel_size_m)
    });
    texts.collect::<String>() + &format!("\n{}\n", stopping.assumptions(study.voxel_size_m).join("\n"))
}

/// A command; a picture is named by its number.
fn command(words: &[String], number: usize) -> String {
    let mut words = words.to_vec();
    if words[1] == RENDER {
        words.extend(["--out".into(), format!("worst-{number}.png")]);
    }
    shell::command(&words)
}

/// The note in place of a command that is printed above.
fn describe_same(first: &Judgement) -> String {
    format!("(same command as for {}, {})", first.requirement.name, wording::words(first.condition))
}

/// The subcommand that draws pictures.
const RENDER: &str = "render";

impl Args {
    /// The command that draws the worst moment of a judgement, without the name of the picture, or finds the path of the
    /// body that comes closest.
    fn picture(
        &self,
        study: &Study,
        results: &Results,
        set: &JudgedSet,
        judgement: &Judgement,
    ) -> Option<Vec<String>> {
        let mut words = vec!["perirobot".to_string()];
        let part = judgement.worst.part?;
        words.push(if let CasePart::Moment(_) = part { RENDER } else { "approach" }.into());
        words.extend([self.swept.folder().display().to_string(), "--pose".into(), set.poses.clone()]);
        words.extend(self.swept.folder_words());
        // Without a combination, its poses identify the set.
        let known = results.combinations.iter().find(|known| known.name == set.combination);
        if known.is_some() {
            words.extend(["--combination".into(), set.combination.clone()]);
        }
        if known.is_none_or(|known| known.representations[0] != set.representation) {
            words.extend(["--representation".into(), set.representation.clone()]);
        }
        let repeat = match part {
            CasePart::Moment(moment) => {
                let Moment { scene, snapshot, repeat } = set.conditions.moments[moment];
                words.extend(["--scene".into(), study.scenes[scene].name.clone()]);
                if snapshot > 0 {
                    words.extend(["--snapshot".into(), snapshot.to_string()]);
                }
                repeat
            }
            CasePart::Passage(passage) => set.conditions.passages[passage].repeat,
        };
        if repeat > 0 {
            words.extend(["--repeat".into(), repeat.to_string()]);
        }
        match &set.conditions.cases(judgement.condition)[judgement.worst.case].alteration {
            Alteration::None => {}
            // No moment is left to draw.
            Alteration::Dead(sensors) if sensors.len() == set.poses.split(BETWEEN_MEMBERS).count() => {
                return None;
            }
            Alteration::Dead(sensors) => {
                words.extend(sensors.iter().flat_map(|sensor| ["--dead".into(), sensor.clone()]));
            }
            Alteration::Draw(draw) => words.extend(["--draw".into(), draw.to_string()]),
            Alteration::Posture(name) => words.extend(["--posture".into(), name.clone()]),
        }
        Some(words)
    }
}
