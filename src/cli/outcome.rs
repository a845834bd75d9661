//! The end of a sweep or merge: tables in the folder, the best poses on the screen.

use std::path::Path;

use clap::ValueEnum;
use perirobot::judge::{Among, Conditions, JudgedSet, leaders};
use perirobot::report::best;
use perirobot::results::table::TableFormat;
use perirobot::results::{Results, rows, scores};
use perirobot::study::{Condition, Study};
use perirobot::view::Choice;
use perirobot::{Result, report, shell};

/// Tables with more rows than this are Parquet, unless the user says otherwise.
const MOST_CSV_ROWS: u64 = 1_000_000;

#[derive(clap::Args)]
#[command(next_help_heading = "Results")]
pub(super) struct OutcomeArgs {
    /// How the tables `results` and `scores` are written [default: csv, parquet above a million rows of
    /// results]
    #[arg(long, value_enum)]
    table: Option<TableChoice>,
}

#[derive(Clone, Copy, ValueEnum)]
enum TableChoice {
    /// Comma-separated text
    Csv,
    /// Apache Parquet: typed columns, a quarter of the size
    Parquet,
    /// Both of them
    Both,
}

impl OutcomeArgs {
    /// The same as on the command line.
    pub(super) fn words(&self) -> Vec<String> {
        let named = self.table.and_then(|choice| choice.to_possible_value());
        named.map_or(Vec::new(), |choice| vec!["--table".into(), choice.get_name().into()])
    }

    /// Writes the tables. Those of the other format, from an earlier end of the same sweep, are the same and
    /// stay.
    pub(super) fn write(&self, results: &Results, folder: &Path) -> Result<()> {
        let formats: &[TableFormat] = match self.table {
            Some(TableChoice::Csv) => &[TableFormat::Csv],
            Some(TableChoice::Parquet) => &[TableFormat::Parquet],
            Some(TableChoice::Both) => &[TableFormat::Csv, TableFormat::Parquet],
            None if results.layout().rows() > MOST_CSV_ROWS => &[TableFormat::Parquet],
            None => &[TableFormat::Csv],
        };
        for &format in formats {
            rows::write(results, folder, format)?;
            scores::write(results, folder, format)?;
        }
        Ok(())
    }
}

/// Prints the best poses.
pub(super) fn print_best(results: &Results) -> Result<()> {
    super::print(&format!("{}\n", best::render(results)?))
}

/// Prints whether the choice that meets most requirements of a study meets all of them as planned; of sets that were
/// chosen, whether the best one does; and the command that judges the same choice under all conditions, with the
/// arguments by which it reads the same files. Nothing where the study requires nothing.
pub(super) fn print_verdicts(
    study: &Study,
    results: &Results,
    best: Option<usize>,
    folder: &Path,
    packages: &[String],
) -> Result<()> {
    let mut required = study.requirements.clone();
    required.iter_mut().for_each(|requirement| requirement.under = vec![Condition::AsPlanned]);
    // How near bodies come is not known of a sweep.
    required.retain(|requirement| requirement.counted().is_some());
    if required.is_empty() {
        return Ok(());
    }
    let best = best.map(|combination| Choice { combination, choice: 0, representation: 0, repeat: 0 });
    let (which, choice) = match best {
        Some(choice) => ("the best set", Some(choice)),
        None => {
            ("the choice that meets most of them", leaders(&required, results, 1, Among::default())?.pop())
        }
    };
    let Some(choice) = choice else { return Ok(()) };
    let conditions = Conditions::as_planned(results, &choice)?;
    let set = JudgedSet::new(&required, results, &choice, conditions);
    let verdicts = report::judge::verdicts(results, &set, &|_, _| None);
    let mut words = ["perirobot", "judge", &folder.display().to_string()].map(String::from).to_vec();
    words.extend_from_slice(packages);
    words.extend(["--pose".into(), set.poses.clone(), "--combination".into(), set.combination.clone()]);
    let command = shell::command(&words);
    super::print(&format!("Requirements, as planned, of {which}{verdicts}more: {command}\n\n"))
}
