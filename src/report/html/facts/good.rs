//! Is it good enough? The verdicts on what a study requires, what scores are under each condition, and how near
//! somebody comes unnoticed: from the files that `judge` and `approach` have written into the folder, and where there
//! are none, the verdicts with everything as planned.

use std::fs;
use std::path::Path;

use base64::{Engine, prelude::BASE64_STANDARD as STANDARD};

use super::Titled;
use crate::approach::{APPROACH, is_named_as_plan};
use crate::judge::{Conditions, JudgedSet};
use crate::report::html::ReportedSweep;
use crate::report::html::ranking::Ranking;
use crate::report::html::recommended::{Recommended, as_planned};
use crate::report::judge::line;
use crate::report::table::Table;
use crate::results::files::{CONDITIONS, REQUIREMENTS};
use crate::shell;
use crate::view::Choice;
use crate::{Error, Result};

/// The largest floor plan that is put into the page.
const MOST_BYTES: u64 = 2_000_000;

/// Whether it is good enough.
#[derive(Debug, Default)]
pub(in crate::report::html) struct Good {
    /// Where the verdicts are from, and what is not decided.
    pub(in crate::report::html) note: String,
    pub(in crate::report::html) verdicts: Vec<ShownVerdict>,
    /// What scores are under each condition, and the ways in.
    pub(in crate::report::html) tables: Vec<Titled>,
    /// Floor plans of approach: their names, and the pictures as addresses.
    pub(in crate::report::html) plans: Vec<(String, String)>,
    /// How more is found out: commands.
    pub(in crate::report::html) commands: Vec<(String, String)>,
}

/// A requirement under a condition.
#[derive(Debug)]
pub(in crate::report::html) struct ShownVerdict {
    /// PASS, FAIL, or OPEN where nothing has decided it.
    pub(in crate::report::html) verdict: &'static str,
    pub(in crate::report::html) name: String,
    pub(in crate::report::html) words: String,
}

/// What is known of the recommended choice.
///
/// # Errors
/// When a file of the folder cannot be read, or is none of these tables.
pub(super) fn good(sweep: &ReportedSweep, rankings: &[Ranking], recommended: &Recommended) -> Result<Good> {
    let ReportedSweep { results, study, folder, .. } = *sweep;
    let series = rankings[recommended.series].series;
    let poses = results.combinations[series.combination].name_of(recommended.choice);
    let mut good = Good::default();
    let judged = rows_of(&folder.join(REQUIREMENTS), &poses)?;
    if study.requirements.is_empty() {
        good.note = "The study requires nothing ([[require]]), so nothing is decided.".into();
    } else if let Some((names, rows)) = judged.filter(|(_, rows)| !rows.is_empty()) {
        good.note = "As perirobot judge has decided, whose tables are in the folder.".into();
        good.verdicts = rows.iter().map(|row| of_row(&names, row)).collect();
    } else {
        good.note =
            "With everything as planned; nothing was judged of dead sensors, of mounts that are off and of how near \
             somebody comes."
                .into();
        let Recommended { choice, .. } = *recommended;
        let looked = Choice {
            combination: series.combination,
            choice,
            representation: series.representation,
            repeat: 0,
        };
        let required = as_planned(&study.requirements);
        let set = JudgedSet::new(&required, results, &looked, Conditions::as_planned(results, &looked)?);
        good.verdicts = set
            .judgements
            .iter()
            .map(|judgement| {
                let told = line(results, &set, judgement);
                let name = judgement.requirement.name.clone();
                let words = told.split_once("): ").map_or(told.as_str(), |(_, words)| words).to_string();
                ShownVerdict { verdict: judgement.word(), name, words }
            })
            .collect();
    }
    // What a sweep does not count, and nobody has judged yet, must not look as if it were met.
    for requirement in &study.requirements {
        if !good.verdicts.iter().any(|verdict| verdict.name == requirement.name) {
            let words = format!("{} is not decided yet: judge it (see below)", requirement.score_name());
            good.verdicts.push(ShownVerdict { verdict: "OPEN", name: requirement.name.clone(), words });
        }
    }
    if let Some((names, rows)) =
        rows_of(&folder.join(CONDITIONS), &poses)?.filter(|(_, rows)| !rows.is_empty())
    {
        let wanted =
            ["condition", "region", "score", "best", "mean", "quantile_05", "worst", "case", "scene"];
        good.tables.push(("What if: each score under each condition".into(), table(&names, &rows, &wanted)));
    }
    if let Some((names, rows)) = rows_of(&folder.join(APPROACH), &poses)?.filter(|(_, rows)| !rows.is_empty())
    {
        let wanted = [
            "scene",
            "snapshot",
            "people",
            "body",
            "entry",
            "at_entry",
            "deepest_m",
            "needed_m",
            "margin_m",
            "path_m",
            "shadowed_by",
            "unnoticed_m2",
        ];
        let title = "How near somebody comes unnoticed, as perirobot approach has found";
        good.tables.push((title.into(), table(&names, &rows, &wanted)));
        good.plans = plans(folder)?;
    }
    let words = |command: &str| {
        let folder = folder.display().to_string();
        let mut words =
            vec!["perirobot".to_string(), command.into(), folder.clone(), "--pose".into(), poses.clone()];
        if command == "approach" {
            words.extend(["--out".into(), folder]);
        }
        shell::command(&words)
    };
    if !study.requirements.is_empty() {
        good.commands.push(("judge it also with a sensor dead or a mount knocked".into(), words("judge")));
    }
    good.commands.push(("ask how near somebody comes unnoticed".into(), words("approach")));
    Ok(good)
}

/// Names of columns, and rows.
type Rows = (Vec<String>, Vec<Vec<String>>);

/// The rows of a table that are of some poses, or all where it names none; `None` where there is no such file.
fn rows_of(path: &Path, poses: &str) -> Result<Option<Rows>> {
    if !path.exists() {
        return Ok(None);
    }
    let wrong = |e: csv::Error| Error::input(path, format!("cannot be read: {e}")).wanted("make it again");
    let mut csv = csv::Reader::from_path(path).map_err(wrong)?;
    let names: Vec<String> = csv.headers().map_err(wrong)?.iter().map(String::from).collect();
    let column = names.iter().position(|name| name == "poses");
    let mut rows = Vec::new();
    for row in csv.records() {
        let row: Vec<String> = row.map_err(wrong)?.iter().map(String::from).collect();
        if column.is_none_or(|column| row[column] == poses) {
            rows.push(row);
        }
    }
    Ok(Some((names, rows)))
}

fn field<'r>(names: &[String], row: &'r [String], name: &str) -> &'r str {
    let column = names.iter().position(|known| known == name);
    column.map_or("", |column| row[column].as_str())
}

/// A row of requirements.csv as a verdict.
fn of_row(names: &[String], row: &[String]) -> ShownVerdict {
    let of = |name: &str| field(names, row, name);
    let value = if of("value").is_empty() { "no value".into() } else { shortened(of("value")) };
    let limit = match of("at_least") {
        "" => format!("at most {}", of("at_most")),
        least => format!("at least {least}"),
    };
    let what = match (of("region"), of("value")) {
        ("", "inf") => format!("nobody comes in unnoticed, {}", of("score")),
        ("", _) => format!("{} is {value}", of("score")),
        (region, _) => format!("{} in region {region} is {value}", of("score")),
    };
    let mut words = format!("{what}, {limit} is required ({})", of("condition").replace('_', " "));
    if !matches!(of("cases"), "" | "1") {
        words += &format!("; {} of {} cases fail", of("failed"), of("cases"));
    }
    let worst: Vec<&str> = [of("case"), of("scene")].into_iter().filter(|part| !part.is_empty()).collect();
    if !worst.is_empty() {
        words += &format!("; worst {}", worst.join(", in scene "));
    }
    if !of("body").is_empty() {
        words += &format!(", {} from {}", of("body"), of("entry"));
    }
    let verdict = if of("verdict") == "PASS" { "PASS" } else { "FAIL" };
    ShownVerdict { verdict, name: of("requirement").into(), words }
}

/// A number with at most four digits after the point, as far as it is one.
fn shortened(text: &str) -> String {
    match text.parse::<f64>() {
        Ok(value) if text.len() > 6 => format!("{value:.4}"),
        _ => text.into(),
    }
}

/// Some columns of a table, those that it has.
fn table(names: &[String], rows: &[Vec<String>], wanted: &[&str]) -> Table {
    let found: Vec<usize> =
        wanted.iter().filter_map(|name| names.iter().position(|known| known == name)).collect();
    let columns: Vec<String> =
        found.iter().map(|&column| format!("<{}", names[column].replace('_', " "))).collect();
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    for row in rows {
        table.row(found.iter().map(|&column| shortened(&row[column])));
    }
    table
}

/// The floor plans of a folder, as pictures.
fn plans(folder: &Path) -> Result<Vec<(String, String)>> {
    let cannot = |e: std::io::Error| Error::input(folder, format!("cannot be read: {e}"));
    let mut plans = Vec::new();
    for entry in fs::read_dir(folder).map_err(cannot)? {
        let entry = entry.map_err(cannot)?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        let is_small = entry.metadata().is_ok_and(|found| found.is_file() && found.len() <= MOST_BYTES);
        if is_named_as_plan(&name) && is_small {
            let bytes = fs::read(entry.path()).map_err(cannot)?;
            plans.push((name, format!("data:image/svg+xml;base64,{}", STANDARD.encode(bytes))));
        }
    }
    plans.sort();
    Ok(plans)
}
