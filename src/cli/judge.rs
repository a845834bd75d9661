//! `perirobot judge`: whether requirements are met. Decided in `judge`, told in `report::judge`.

use std::process::ExitCode;

use perirobot::error::Issue;
use perirobot::judge::{Conditions, JudgedSet, Judgement, conditions_csv, leaders, requirements_csv};
use perirobot::results::Results;
use perirobot::study::{Requirement, Study};
use perirobot::view::Choice;
use perirobot::{Error, Result, report, shell};

use super::choice::SetArgs;
use super::swept::SweptArgs;

/// The exit code where a requirement is missed.
const MISSED: u8 = 4;

/// Decide whether requirements are met
///
/// A study with [[require]] says which scores sensors must reach in which region, as planned or also when
/// something is not. Prints for each requirement and condition whether it is met (PASS or FAIL), the value, where and
/// when it is the worst, and the command that draws it; writes requirements.csv and conditions.csv into the folder.
/// Without --pose it judges the choice of poses that meets most requirements as planned. Requirements may be changed
/// or added after the sweep: they change no count. The exit code is 4 if a requirement is missed.
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
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/judge.toml --out out/judge
  perirobot judge out/judge || echo missed
      one requirement is met, one is missed

How to read it:
  Values are compared with limits as fractions of whole numbers, never rounded.
  A choice without a value (nobody is in the region, say) misses the
  requirement.";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let folder = args.swept.folder();
    let (results, warnings) = Results::read(folder)?;
    warnings.iter().for_each(|warning| say!("warning: {warning}"));
    let (study, worlds) = args.swept.load()?;
    let required = required(&study)?;
    let choices = match args.sets.named(&study, &worlds)? {
        Some(choice) => vec![choice],
        None => leaders(required, &results, args.best as usize, args.sets.among())?,
    };
    let judge = |choice: &Choice| {
        Ok(JudgedSet::new(required, &results, choice, Conditions::as_planned(&results, choice)?))
    };
    let sets: Vec<JudgedSet> = choices.iter().map(judge).collect::<Result<_>>()?;
    requirements_csv(folder, &results, &sets)?;
    conditions_csv(folder, &results, &sets)?;
    let picture = |set: &JudgedSet, judgement: &Judgement| args.picture(&study, set, judgement);
    for set in &sets {
        super::print(&report::judge::render(&results, set, &picture))?;
    }
    super::print(&format!("\n{}\ntables in {}\n", count(&sets), folder.display()))?;
    Ok(match sets.iter().all(JudgedSet::meets_all) {
        true => ExitCode::SUCCESS,
        false => ExitCode::from(MISSED),
    })
}

/// What the study requires.
fn required(study: &Study) -> Result<&[Requirement]> {
    if !study.requirements.is_empty() {
        return Ok(&study.requirements);
    }
    let region = study.regions.first().map_or("robot", |(name, _)| name.as_str());
    let example = format!(
        "[[require]] name = \"parts seen\", score = \"parts_detected\", region = {region:?}, at_least = 0.9"
    );
    Err(Error::from(Issue::missing("require").at(&study.path))
        .wanted(format!("say what sensors must reach, as in {example}")))
}

/// How many verdicts there are of each kind.
fn count(sets: &[JudgedSet]) -> String {
    let all = || sets.iter().flat_map(|set| &set.judgements);
    let missed = all().filter(|judgement| !judgement.is_met).count();
    format!("{} of {} verdicts are PASS", all().count() - missed, all().count())
}

impl Args {
    /// The command that draws the worst moment of a judgement.
    fn picture(&self, study: &Study, set: &JudgedSet, judgement: &Judgement) -> Option<String> {
        let moment = set.conditions.moments[judgement.worst.moment?];
        let mut words = ["perirobot", "render"].map(String::from).to_vec();
        words.extend([self.swept.folder().display().to_string(), "--pose".into(), set.poses.clone()]);
        words.extend(self.swept.words());
        words.extend(["--combination".into(), set.combination.clone()]);
        words.extend(["--representation".into(), set.representation.clone()]);
        words.extend(["--scene".into(), study.scenes[moment.scene].name.clone()]);
        for (flag, number) in [("--snapshot", moment.snapshot), ("--repeat", moment.repeat)] {
            if number > 0 {
                words.extend([flag.into(), number.to_string()]);
            }
        }
        words.extend(["--out".into(), "worst.png".into()]);
        Some(shell::command(&words))
    }
}
