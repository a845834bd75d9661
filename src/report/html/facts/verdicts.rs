//! The verdicts on what a study requires of a choice: those of `judge`, as far as they are of what the study requires
//! now; where it has not judged the choice, what the sweep decides. What nothing decides is OPEN.

use super::kept::{Kept, Row, shortened};
use crate::Result;
use crate::judge::{Conditions, JudgedSet, tables_sha256};
use crate::report::html::ReportedSweep;
use crate::report::judge::{line, words};
use crate::results::files::REQUIREMENTS;
use crate::study::{Condition, Limit, Measure, Requirement};
use crate::view::Choice;

/// Why a requirement is open.
const NOT_YET: &str = "is not decided yet: judge it (see below)";
const OTHERWISE: &str =
    "was judged against other requirements, or with other tables of the study: run `perirobot judge` again";

/// A requirement under a condition.
#[derive(Debug)]
pub(in crate::report::html) struct ShownVerdict {
    /// PASS, FAIL, or OPEN where nothing has decided it.
    pub(in crate::report::html) verdict: &'static str,
    pub(in crate::report::html) name: String,
    pub(in crate::report::html) words: String,
}

/// Where the verdicts on a choice are from, and the verdicts, in the order of the study.
///
/// # Errors
/// When a file of the folder cannot be read, or is no table.
pub(super) fn verdicts(
    sweep: &ReportedSweep,
    looked: &Choice,
    own: &[String; 3],
) -> Result<(String, Vec<ShownVerdict>)> {
    if sweep.study.requirements.is_empty() {
        return Ok(("The study requires nothing ([[require]]), so nothing is decided.".into(), Vec::new()));
    }
    let [kept, _] = Kept::read(&sweep.folder.join(REQUIREMENTS))?.parted(|row| row.is_of(own));
    match kept.is_empty() {
        true => as_planned(sweep, looked),
        false => Ok(of_kept(sweep, &kept)),
    }
}

/// What `judge` has decided, as far as it is what the study requires.
fn of_kept(sweep: &ReportedSweep, kept: &Kept) -> (String, Vec<ShownVerdict>) {
    let (mut shown, mut used) = (Vec::new(), 0);
    for requirement in &sweep.study.requirements {
        let (mut otherwise, mut not_yet) = (Vec::new(), Vec::new());
        for &condition in &requirement.under {
            let is_asked = |row: &Row| {
                row.of("requirement") == requirement.name && row.of("condition") == condition.name()
            };
            match kept.rows().find(is_asked) {
                Some(row)
                    if is_judged_as(&row, requirement, &sweep.results.regions)
                        && row.of("tables_sha256") == tables_sha256(sweep.study, requirement, condition) =>
                {
                    shown.push(of_row(&row));
                    used += 1;
                }
                Some(_) => otherwise.push(condition),
                None => not_yet.push(condition),
            }
        }
        shown.extend(open(requirement, &otherwise, OTHERWISE));
        shown.extend(open(requirement, &not_yet, NOT_YET));
    }
    let note = match used == kept.rows().count() {
        true => "As perirobot judge has decided, whose tables are in the folder.",
        false => {
            "What perirobot judge has written into the folder was judged against other requirements than the study \
             has now, or with another [mounting_error], [postures], [approach] or [stopping]: run `perirobot judge` \
             again. Its verdicts are shown only where nothing that they rest on has changed."
        }
    };
    (note.into(), shown)
}

/// What the sweep decides by itself: scores of its counts as planned, where they are required so.
fn as_planned(sweep: &ReportedSweep, looked: &Choice) -> Result<(String, Vec<ShownVerdict>)> {
    let ReportedSweep { results, study, .. } = *sweep;
    let mut shown = Vec::new();
    for requirement in &study.requirements {
        let is_decided =
            |condition: &Condition| *condition == Condition::AsPlanned && requirement.counted().is_some();
        let (decided, not_yet): (Vec<Condition>, Vec<Condition>) =
            requirement.under.iter().partition(|condition| is_decided(condition));
        if !decided.is_empty() {
            let planned = [Requirement { under: decided, ..requirement.clone() }];
            let set =
                JudgedSet::new(&planned, results, looked, Conditions::as_planned(study, results, looked)?);
            shown.extend(set.judgements.iter().map(|judgement| {
                let told = line(results, &set, judgement);
                let words = told.split_once("): ").map_or(told.as_str(), |(_, words)| words).to_string();
                ShownVerdict { verdict: judgement.word(), name: requirement.name.clone(), words }
            }));
        }
        shown.extend(open(requirement, &not_yet, NOT_YET));
    }
    let note = "With everything as planned; nothing was judged of dead sensors, of mounts that are off and of how near \
                somebody comes.";
    Ok((note.into(), shown))
}

/// A requirement that nothing decides under some conditions, if there are any: it must not look as if it were met.
fn open(requirement: &Requirement, conditions: &[Condition], why: &str) -> Option<ShownVerdict> {
    let when: Vec<&str> = conditions.iter().map(|&condition| words(condition)).collect();
    (!when.is_empty()).then(|| ShownVerdict {
        verdict: "OPEN",
        name: requirement.name.clone(),
        words: format!("{} ({}) {why}", requirement.score_name(), when.join(", ")),
    })
}

/// Whether a row of requirements.csv was judged against a requirement of its name as the study has it now.
fn is_judged_as(row: &Row, requirement: &Requirement, regions: &[String]) -> bool {
    let limits = match &requirement.limit {
        Limit::AtLeast(ratio) => [Some(ratio.value()), None],
        Limit::AtMost(ratio) => [None, Some(ratio.value())],
    };
    let region = requirement.region().map_or("", |region| regions[region].as_str());
    // Of bodies that come near the table names the one that is the worst.
    let may_be = |wanted: &Option<String>, found: &str| {
        found.is_empty() || wanted.as_ref().is_none_or(|wanted| wanted == found)
    };
    let is_of_body = match &requirement.measure {
        Measure::Counted(_) | Measure::Controller(_) => true,
        Measure::Nearness(near) => may_be(&near.body, row.of("body")) && may_be(&near.entry, row.of("entry")),
    };
    row.of("score") == requirement.score_name()
        && row.of("region") == region
        && row.of("over") == requirement.over().name()
        && ["at_least", "at_most"].map(|name| row.of(name).parse().ok()) == limits
        && is_of_body
}

/// A row of requirements.csv as a verdict.
fn of_row(row: &Row) -> ShownVerdict {
    let value = if row.of("value").is_empty() { "no value".into() } else { shortened(row.of("value")) };
    let limit = match row.of("at_least") {
        "" => format!("at most {}", row.of("at_most")),
        least => format!("at least {least}"),
    };
    let what = match (row.of("region"), row.of("value")) {
        ("", "inf") if row.of("body").is_empty() && !row.of("scene").is_empty() => {
            format!("somebody is there of whom nothing is measured, {}", row.of("score"))
        }
        ("", "inf") => format!("nobody has room to come in, {}", row.of("score")),
        ("", _) => format!("{} is {value}", row.of("score")),
        (region, _) => format!("{} in region {region} is {value}", row.of("score")),
    };
    let mut words = format!("{what}, {limit} is required ({})", row.of("condition").replace('_', " "));
    if !matches!(row.of("cases"), "" | "1") {
        words += &format!("; {} of {} cases fail", row.of("failed"), row.of("cases"));
    }
    let worst: Vec<&str> =
        [row.of("case"), row.of("scene")].into_iter().filter(|part| !part.is_empty()).collect();
    if !worst.is_empty() {
        words += &format!("; worst {}", worst.join(", in scene "));
    }
    if !row.of("body").is_empty() {
        words += &format!(", {} from {}", row.of("body"), row.of("entry"));
    }
    let verdict = if row.of("verdict") == "PASS" { "PASS" } else { "FAIL" };
    ShownVerdict { verdict, name: row.of("requirement").into(), words }
}
