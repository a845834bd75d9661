//! The end of a sweep or merge: writes the tables into the folder, prints the best poses.

use std::path::Path;

use clap::ValueEnum;
use perirobot_decide::judge::{Conditions, JudgedSet, LeaderScope, leaders};
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_page::report::terminal::{self, answer, best, places};
use perirobot_page::report::{ReportSelection, wording};
use perirobot_study::input::{Condition, Requirement, Study};
use perirobot_sweep::results::table::TableFormat;
use perirobot_sweep::results::{Results, rows, scores};

/// Tables with more rows than this are Parquet, unless a format is given.
#[cfg(feature = "parquet")]
const MOST_CSV_ROWS: u64 = 1_000_000;

#[derive(clap::Args)]
#[command(next_help_heading = "Results")]
pub(super) struct OutcomeArgs {
    /// Format of the tables `results` and `scores` [default: csv; parquet above a million rows of results, if this
    /// program supports it]
    #[arg(long, value_enum)]
    table: Option<TableChoice>,
    /// Print the best poses by each score in each region, with all baselines
    #[arg(long)]
    all: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum TableChoice {
    /// Comma-separated text
    Csv,
    /// Apache Parquet: typed columns, a quarter of the size
    #[cfg(feature = "parquet")]
    Parquet,
    /// Both of them
    #[cfg(feature = "parquet")]
    Both,
}

impl OutcomeArgs {
    /// The same arguments as words of a command line.
    pub(super) fn words(&self) -> Vec<String> {
        let named = self.table.and_then(|choice| choice.to_possible_value());
        let table = named.map_or(Vec::new(), |choice| vec!["--table".into(), choice.get_name().into()]);
        [table, if self.all { vec!["--all".into()] } else { Vec::new() }].concat()
    }

    /// Writes the tables. Tables of the other format, from an earlier end of the same sweep, have the same contents and
    /// stay.
    pub(super) fn write(&self, results: &Results, folder: &Path) -> Result<()> {
        let formats: &[TableFormat] = match self.table {
            Some(TableChoice::Csv) => &[TableFormat::Csv],
            #[cfg(feature = "parquet")]
            Some(TableChoice::Parquet) => &[TableFormat::Parquet],
            #[cfg(feature = "parquet")]
            Some(TableChoice::Both) => &[TableFormat::Csv, TableFormat::Parquet],
            #[cfg(feature = "parquet")]
            None if results.layout().rows() > MOST_CSV_ROWS => &[TableFormat::Parquet],
            None => &[TableFormat::Csv],
        };
        for &format in formats {
            rows::write(results, folder, format)?;
            scores::write(results, folder, format)?;
        }
        Ok(())
    }

    /// Prints the best poses: by the study's requirements, or by each score with --all or if the study is missing.
    pub(super) fn print_best(&self, study: Option<&Study>, results: &Results) -> Result<()> {
        match study.filter(|_| !self.all) {
            Some(study) => {
                super::print(&answer::render(study, results)?)?;
                super::print(&format!("All scores in {}: --all\n\n", all_regions(&results.regions)))?;
            }
            None => super::print(&format!("{}\n", best::render(results)?))?,
        }
        let all = ReportSelection::resolve(results, None, None, &[Score::F1, Score::HumanSeen])?;
        super::print(&places::render(results, &all)?)
    }
}

/// The regions in words; long lists are counted.
fn all_regions(regions: &[String]) -> String {
    match regions {
        [one] => format!("region {one}"),
        some if some.len() <= FEW_REGIONS => format!("regions {}", some.join(", ")),
        many => format!("all {} regions", many.len()),
    }
}

/// The most regions listed by name.
const FEW_REGIONS: usize = 6;

/// Prints whether the choice that meets most requirements meets those about the plan (for chosen sets, whether the best
/// set does), and the conditions that are not decided here. Returns the command that judges the same choice under all
/// conditions, with the arguments for the same files; without requirements, the command that reports.
pub(super) fn print_verdicts(
    study: &Study,
    results: &Results,
    best: Option<usize>,
    folder: &Path,
    packages: &[String],
) -> Result<Vec<String>> {
    if study.requirements.is_empty() {
        return Ok(look_at(folder, packages));
    }
    let choice = match best {
        Some(combination) => Some(Choice { combination, choice: 0, representation: 0, repeat: 0 }),
        // A sweep has no approach distances.
        None if study.requirements.iter().all(|requirement| requirement.counted_score().is_none()) => None,
        None => leaders(&study.requirements, results, 1, LeaderScope::default())?.pop(),
    };
    let mut words = on_folder("judge", folder, packages);
    let verdicts = match choice {
        None => {
            words.extend(["--pose", "POSES"].map(String::from));
            "Requirements\n".to_string()
        }
        Some(choice) => {
            let mut required = study.requirements.clone();
            required.retain(is_decided);
            required.iter_mut().for_each(|requirement| requirement.under = vec![Condition::AsPlanned]);
            let conditions = Conditions::from_results(study, results, &choice)?;
            let set = JudgedSet::new(&required, results, &choice, conditions);
            words.extend([
                "--pose".into(),
                set.poses.clone(),
                "--combination".into(),
                set.combination.clone(),
            ]);
            let which = if best.is_some() { "the best set" } else { "the choice that meets most of them" };
            let verdicts = terminal::judge::verdicts(results, &set, &|_, _| None);
            format!("Requirements, as planned, of {which}{verdicts}")
        }
    };
    super::print(&format!("{verdicts}{}\n", describe_undecided(study)))?;
    Ok(words)
}

/// The command that shows a folder of results, with its package arguments.
pub(super) fn look_at(folder: &Path, packages: &[String]) -> Vec<String> {
    on_folder(if cfg!(feature = "report") { "report" } else { "summary" }, folder, packages)
}

fn on_folder(command: &str, folder: &Path, packages: &[String]) -> Vec<String> {
    let words = ["perirobot", command, &folder.display().to_string()].map(String::from);
    [&words, packages].concat()
}

/// Whether the counts as planned decide a requirement.
fn is_decided(requirement: &Requirement) -> bool {
    requirement.counted_score().is_some() && requirement.under.contains(&Condition::AsPlanned)
}

/// A line with the requirements and conditions that the counts as planned do not decide.
fn describe_undecided(study: &Study) -> String {
    let open = study.requirements.iter().filter_map(|requirement| {
        let is_open =
            |condition: &&Condition| **condition != Condition::AsPlanned || !is_decided(requirement);
        let open = requirement.under.iter().filter(is_open).map(|&condition| wording::words(condition));
        let open = open.collect::<Vec<_>>().join(", ");
        (!open.is_empty()).then(|| format!("{} ({open})", requirement.name))
    });
    let open = open.collect::<Vec<_>>().join(", ");
    if open.is_empty() { open } else { format!("not decided here: {open}\n") }
}
