//! Checks the tables of an answer: the plain oracle sweeps and judges the sets again, and every field is compared.

use std::path::Path;

use serde_json::Value;

use super::{ProofInput, open_oracle};
use crate::cheapest::report::{CHEAPEST, FILE, PurchaseReport};
use crate::choose::{SweptSets, is_written, sweep_again};
use crate::json_file::{Difference, first_difference};
use crate::judge::Judging;
use crate::view::Choice;
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_sweep::results::Results;
use perirobot_sweep::results::files::{
    CONDITIONS, DRAWS, JUDGE_JSON, REQUIREMENTS, SEPARATION, SPEEDS, read_regular,
};

/// The remedy for wrong tables.
const CURE: &str = "choose again";

/// Compares all tables of an answer.
///
/// # Errors
/// `Error::Input` that names file, row and column of a wrong field; `Error::Stopped`.
pub(super) fn verify_tables(folder: &Path, report: &PurchaseReport, input: ProofInput) -> Result<()> {
    let ProofInput { study, purchase, worlds, progress, .. } = input;
    is_written(&folder.join(CHEAPEST), Some(&report.csv()))?;
    let sets = report.study_of_sets(study, purchase);
    if sets.combinations.is_empty() {
        return nothing_more(folder, report);
    }
    let PurchaseReport { perirobot, study, .. } = report;
    let swept = SweptSets { folder, sets: &sets, worlds, file: FILE.name, about: [perirobot, study] };
    sweep_again(&swept, &mut Oracle::default(), progress)?;
    let (results, _) = Results::read(folder)?;
    let choice = |combination| Choice { combination, choice: 0, representation: 0, repeat: 0 };
    let choices: Vec<Choice> = (0..sets.combinations.len()).map(choice).collect();
    let judging = Judging::new(&sets, worlds, &results, &choices)?;
    let judged = judging.judge(&open_oracle, progress)?;
    let again = tempfile::tempdir()
        .map_err(|error| Error::io(&std::env::temp_dir(), "cannot hold a new folder", error))?;
    judging.write(again.path(), &judged)?;
    compare_verdicts(folder, again.path())?;
    for name in [REQUIREMENTS, CONDITIONS, DRAWS, SEPARATION, SPEEDS] {
        let expected = again.path().join(name);
        let expected = if expected.exists() { Some(read_regular(&expected)?) } else { None };
        is_written(&folder.join(name), expected.as_deref())?;
    }
    Ok(())
}

/// Fails if there are tables of sets, but no set was found.
fn nothing_more(folder: &Path, report: &PurchaseReport) -> Result<()> {
    let tables = ["results.csv", "scores.csv", "poses.csv", JUDGE_JSON, REQUIREMENTS];
    if let Some(name) = tables.into_iter().find(|name| folder.join(name).exists()) {
        let issue = Issue::damaged("exists, but no set was found").cure(CURE);
        return Err(issue.with_place(folder.join(name)).into());
    }
    if report.perirobot != env!("CARGO_PKG_VERSION") {
        let issue = Issue::damaged("is not the version of this program").cure(CURE);
        return Err(issue.with_place("perirobot").with_place(folder.join(FILE.name)).into());
    }
    Ok(())
}

/// Compares `judge.json` in two folders; another version of the program may have written the first.
fn compare_verdicts(folder: &Path, again: &Path) -> Result<()> {
    let path = folder.join(JUDGE_JSON);
    let read = |folder: &Path| -> Result<Value> {
        let path = folder.join(JUDGE_JSON);
        let read = serde_json::from_slice(&read_regular(&path)?);
        read.map_err(|e| Issue::damaged(e.to_string()).cure(CURE).with_place(&path).into())
    };
    let (own, mut right) = (read(folder)?, read(again)?);
    right["perirobot"] = own["perirobot"].clone();
    match first_difference(String::new(), &own, &right) {
        None => Ok(()),
        Some(Difference { place, own, other }) => {
            let what = format!("is {own}, but judged again it is {other}");
            Err(Issue::damaged(what).cure(CURE).with_place(place).with_place(path).into())
        }
    }
}
