//! `perirobot judge`: whether requirements are met. Decided in `judge`, told in `report::judge`.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::ExitCode;

use perirobot::approach::{Ground, fusion_warning};
use perirobot::backend::Backend;
use perirobot::error::Issue;
use perirobot::judge::{
    Alteration, Conditions, Draws, JudgedSet, Judgement, Moment, Part, Speeds, WhatIf, at_each_speed,
    check_postures, conditions_csv, junit_xml, leaders, requirements_csv, separation_csv, speeds_csv,
};
use perirobot::results::Results;
use perirobot::results::columns::BETWEEN_MEMBERS;
use perirobot::results::files::{CONDITIONS, DRAWS, REQUIREMENTS, SEPARATION, SPEEDS, write_whole};
use perirobot::results::manifest::Fault;
use perirobot::study::{Condition, Requirement, Study};
use perirobot::sweep::Watch;
use perirobot::view::Choice;
use perirobot::world::{World, cut_warning};
use perirobot::{Error, Result, report, shell};

use super::backend::BackendArgs;
use super::choice::SetArgs;
use super::progress::{Progress, ProgressArgs, above_bar};
use super::stop::StopAt;
use super::swept::SweptArgs;

/// The exit code where a requirement is missed.
const MISSED: u8 = 4;

/// Decide whether requirements are met
///
/// A study with [[require]] says which scores sensors must reach in which region, as planned or also when
/// something is not. Prints for each requirement and condition whether it is met (PASS or FAIL), the value, where and
/// when it is the worst, and the command that draws it; writes requirements.csv and conditions.csv into the folder.
/// A study with [stopping] is also told how fast the robot may run, and what a controller would measure (speeds.csv, separation.csv).
/// Without --pose it judges the choice of poses that meets most requirements as planned. Requirements may be changed
/// or added after the sweep: they change no count. Files of an earlier judgement are removed first. The exit code is 4 if a requirement is missed.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(flatten)]
    swept: SweptArgs,
    #[command(flatten)]
    sets: SetArgs,
    /// How many choices of poses are judged: those that meet most requirements as planned
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "pose")]
    best: u32,
    /// Write the verdicts as JUnit XML, too, which build servers read
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
  A choice without a value (nobody is in the region, say) misses the
  requirement.";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    args.backend.start_threads()?;
    let folder = args.swept.folder();
    let (results, warnings) = Results::read(folder)?;
    warnings.iter().for_each(|warning| say!("warning: {warning}"));
    let (study, worlds) = args.swept.load()?;
    if study.requirements.is_empty() {
        args.forget()?;
        return Err(nothing_required(&study));
    }
    let choices = match args.sets.named(&study, &worlds)? {
        Some(choice) => vec![choice],
        None => leaders(&study.requirements, &results, args.best as usize, args.sets.among())?,
    };
    warn_of_regions(&study, &worlds);
    let stop = StopAt::listen(None)?;
    let (sets, draws) = args.judged(&study, &worlds, &results, &choices, &stop)?;
    // A file of poses is of one choice.
    if let ([draws], [_]) = (draws.as_slice(), choices.as_slice()) {
        draws.write(folder)?;
    }
    requirements_csv(folder, &study, &results, &sets)?;
    conditions_csv(folder, &study, &results, &sets)?;
    let at_speeds = args.at_speeds(&study, &results, &sets)?;
    let picture = |set: &JudgedSet, judgement: &Judgement| args.picture(&study, set, judgement);
    if let Some(path) = &args.junit {
        let told = |set: &JudgedSet, judgement: &Judgement| {
            let line = report::judge::line(&results, set, judgement);
            picture(set, judgement).map_or(line.clone(), |picture| format!("{line}\n{picture}"))
        };
        write_whole(path, junit_xml(&sets, &told).as_bytes())?;
    }
    for set in &sets {
        super::print(&report::judge::render(&results, set, &picture))?;
    }
    at_speeds.iter().try_for_each(|text| super::print(text))?;
    super::print(&format!("\n{}\ntables in {}\n", count(&sets), folder.display()))?;
    Ok(match sets.iter().all(JudgedSet::meets_all) {
        true => ExitCode::SUCCESS,
        false => ExitCode::from(MISSED),
    })
}

/// Repeats what the grid cuts off from the regions in which is decided.
fn warn_of_regions(study: &Study, worlds: &[World]) {
    let at_speeds = at_each_speed(study);
    let required = study.requirements.iter().chain(at_speeds.iter().map(|at| &at.requirement));
    let regions: BTreeSet<usize> = required.filter_map(Requirement::region).collect();
    let of_scenes = worlds.chunk_by(|one, next| one.scene == next.scene).map(|scene| {
        let cut = regions.iter().filter_map(|&region| cut_warning(study, scene, region));
        (scene[0].name.as_str(), cut.collect::<Vec<String>>())
    });
    let warnings: Vec<_> = of_scenes.collect();
    super::warn(warnings.iter().map(|(scene, cut)| (*scene, cut.as_slice())), super::MOST_WARNINGS);
}

/// What is wrong with a study that requires nothing.
fn nothing_required(study: &Study) -> Error {
    let region = study.regions.first().map_or("robot", |(name, _)| name.as_str());
    let example = format!(
        "[[require]] name = \"parts seen\", score = \"parts_detected\", region = {region:?}, at_least = 0.9"
    );
    Error::from(Issue::missing("require").at(&study.path))
        .wanted(format!("say what sensors must reach, as in {example}"))
}

/// How many verdicts there are of each kind.
fn count(sets: &[JudgedSet]) -> String {
    let all = || sets.iter().flat_map(|set| &set.judgements);
    let missed = all().filter(|judgement| !judgement.is_met).count();
    format!("{} of {} verdicts are PASS", all().count() - missed, all().count())
}

impl Args {
    /// Removes the files of an earlier judgement, so that none of them is taken for this one's, whatever ends it.
    fn forget(&self) -> Result<()> {
        let tables =
            [REQUIREMENTS, CONDITIONS, DRAWS, SEPARATION, SPEEDS].map(|name| self.swept.folder().join(name));
        let is_file = |path: &&PathBuf| path.symlink_metadata().is_ok_and(|found| found.is_file());
        for path in tables.iter().chain(&self.junit).filter(is_file) {
            std::fs::remove_file(path).map_err(|e| Error::io(path, "cannot be removed", e))?;
        }
        Ok(())
    }

    /// Choices with all that is counted of them, and their mounts as they were drawn. Nothing is removed before all
    /// that is asked is found good.
    fn judged<'s>(
        &self,
        study: &'s Study,
        worlds: &[World],
        results: &Results,
        choices: &[Choice],
        stop: &StopAt,
    ) -> Result<(Vec<JudgedSet<'s>>, Vec<Draws>)> {
        let all: Vec<WhatIf> = choices.iter().map(|choice| WhatIf::new(study, worlds, choice)).collect();
        let grounds: Vec<Vec<Ground>> = all.iter().map(WhatIf::grounds).collect::<Result<_>>()?;
        let near = choices.iter().zip(&grounds).filter(|(_, grounds)| !grounds.is_empty());
        let fused: BTreeSet<String> = near.filter_map(|(choice, _)| fusion_warning(study, choice)).collect();
        fused.iter().for_each(|warning| say!("warning: {warning}"));
        let cut = check_postures(study, worlds)?;
        super::warn(cut.iter().map(|(scene, cut)| (*scene, cut.as_slice())), super::MOST_WARNINGS);
        self.forget()?;
        let asked = WhatIf::asked(study);
        let planned = choices.iter().map(|choice| Conditions::as_planned(study, results, choice));
        let mut conditions: Vec<Conditions> = planned.collect::<Result<_>>()?;
        let mut draws = Vec::new();
        let each = all.iter().zip(&grounds);
        let total = each
            .map(|(what_if, grounds)| {
                what_if.total(&asked) + what_if.total_near(grounds) + what_if.total_measured()
            })
            .sum::<u64>();
        if total > 0 {
            let mut backends = if asked.is_empty() { None } else { Some(self.backend.backends()?) };
            let progress = self.progress.start("cases", 0, total);
            let mut watch = CaseWatch { progress, stop: stop.clone(), told: false };
            for ((what_if, grounds), conditions) in all.iter().zip(&grounds).zip(&mut conditions) {
                let drawn = match &mut backends {
                    Some(backends) => what_if.count(&asked, conditions, backends, &mut watch)?,
                    None => None,
                };
                what_if.come_near(grounds, conditions, drawn.as_ref(), &mut watch)?;
                if study.stopping.is_some() {
                    // Opened when the others have let go of the device.
                    let mut backend = self.backend.open()?;
                    what_if.measure(conditions, drawn.as_ref(), &mut *backend, &mut watch)?;
                }
                draws.extend(drawn);
            }
            watch.progress.finish();
        }
        // Who stands where is the same for each choice.
        let stood = conditions.first().map_or(&[][..], |conditions| conditions.of(Condition::Postures));
        stood.iter().flat_map(|case| &case.warnings).for_each(|warning| say!("warning: {warning}"));
        let sets = choices.iter().zip(conditions);
        let sets =
            sets.map(|(choice, conditions)| JudgedSet::new(&study.requirements, results, choice, conditions));
        Ok((sets.collect(), draws))
    }

    /// What depends on the robot's speed, where the study says how far people must be: writes speeds.csv and
    /// separation.csv, and tells it in words, with what was assumed.
    fn at_speeds(&self, study: &Study, results: &Results, sets: &[JudgedSet]) -> Result<Vec<String>> {
        let Some(stopping) = &study.stopping else { return Ok(Vec::new()) };
        let folder = self.swept.folder();
        let asked = at_each_speed(study);
        let speeds: Vec<(&JudgedSet, Speeds)> =
            sets.iter().filter_map(|set| Some((set, Speeds::new(&asked, results, set)?))).collect();
        if !speeds.is_empty() {
            speeds_csv(folder, results, &speeds, stopping)?;
        }
        separation_csv(folder, results, sets, stopping, study.voxel_size_m)?;
        let told = sets.iter().map(|set| {
            let heading = if sets.len() > 1 { format!("\n{}\n", set.poses) } else { String::new() };
            let own = speeds.iter().find(|(other, _)| std::ptr::eq(*other, set));
            let fast = own.map_or(String::new(), |(_, speeds)| report::speed::render(speeds, stopping));
            heading + &fast + &report::separation::render(results, set, stopping, study.voxel_size_m)
        });
        let assumed = std::iter::once(format!("\n{}\n", stopping.assumptions().join("\n")));
        Ok(told.chain(assumed).collect())
    }

    /// The command that draws the worst moment of a judgement, or finds the way of who comes nearest.
    fn picture(&self, study: &Study, set: &JudgedSet, judgement: &Judgement) -> Option<String> {
        let mut words = vec!["perirobot".to_string()];
        let part = judgement.worst.part?;
        words.push(if let Part::Moment(_) = part { "render" } else { "approach" }.into());
        words.extend([self.swept.folder().display().to_string(), "--pose".into(), set.poses.clone()]);
        words.extend(self.swept.folder_words());
        words.extend(["--combination".into(), set.combination.clone()]);
        words.extend(["--representation".into(), set.representation.clone()]);
        let repeat = match part {
            Part::Moment(moment) => {
                let Moment { scene, snapshot, repeat } = set.conditions.moments[moment];
                words.extend(["--scene".into(), study.scenes[scene].name.clone()]);
                if snapshot > 0 {
                    words.extend(["--snapshot".into(), snapshot.to_string()]);
                }
                repeat
            }
            Part::Passage(passage) => set.conditions.passages[passage].repeat,
        };
        if repeat > 0 {
            words.extend(["--repeat".into(), repeat.to_string()]);
        }
        match &set.conditions.of(judgement.condition)[judgement.worst.case].alteration {
            Alteration::None => {}
            // Nothing is left to be drawn.
            Alteration::Dead(sensors) if sensors.len() == set.poses.split(BETWEEN_MEMBERS).count() => {
                return None;
            }
            Alteration::Dead(sensors) => {
                words.extend(sensors.iter().flat_map(|sensor| ["--dead".into(), sensor.clone()]));
            }
            Alteration::Draw(draw) => words.extend(["--draw".into(), draw.to_string()]),
            Alteration::Posture(name) => words.extend(["--posture".into(), name.clone()]),
        }
        if let Part::Moment(_) = part {
            words.extend(["--out".into(), "worst.png".into()]);
        }
        Some(shell::command(&words))
    }
}

/// Shows how far it is, says once on what it runs, and knows when to stop.
struct CaseWatch {
    progress: Progress,
    stop: StopAt,
    told: bool,
}

impl Watch for CaseWatch {
    fn runs_on(&mut self, backend: &dyn Backend) {
        if !std::mem::replace(&mut self.told, true) {
            above_bar(|| say!("running on {}: {}", backend.name(), backend.device()));
        }
    }

    fn finished(&mut self, cases: u64) {
        self.progress.inc(cases);
    }

    fn failed(&mut self, Fault { what, instead, .. }: &Fault) {
        above_bar(|| say!("warning: {what}; the next cases were counted by {instead}"));
    }

    fn stop(&mut self) -> Option<String> {
        self.stop.reason()
    }
}
