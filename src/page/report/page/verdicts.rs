//! The verdicts on what a study requires of a choice: those of `judge`, as far as they are of what the study requires
//! now; where it has not judged the choice, what the sweep decides. What nothing decides is OPEN.

use std::cmp::Ordering;

use super::kept::{Kept, Row};
use crate::report::apart::Writing;
use crate::report::page::{ReportedSweep, measure};
use crate::report::wording::{of_which, whereabouts, words};
use perirobot_decide::judge::{Conditions, JudgedSet, Judgement, Summed, Value, tables_sha256};
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_study::study::{
    ApproachScore, Condition, ControllerScore, Limit, Measure, Nearness, Requirement, Study,
};

/// Why a requirement is open.
const NOT_YET: &str = "is not decided yet: judge it (see below)";
const OTHERWISE: &str =
    "was judged against other requirements, or with other tables of the study: run `perirobot judge` again";

/// A requirement under a condition.
#[derive(Clone, Debug)]
pub(crate) struct ShownVerdict {
    /// PASS, FAIL, or OPEN where nothing has decided it.
    pub(crate) verdict: &'static str,
    pub(crate) name: String,
    pub(crate) words: String,
    /// The verdict in few words: `missed with one sensor dead (30 %)`.
    pub(super) brief: String,
}

/// The verdicts on a requirement, one for each of its conditions, and all of them together.
#[derive(Clone, Debug)]
pub(crate) struct ShownRequirement {
    pub(crate) name: String,
    /// The score and its limit.
    pub(crate) asked: String,
    pub(crate) verdicts: Vec<ShownVerdict>,
}

impl ShownRequirement {
    /// FAIL if it is missed under a condition, else OPEN if one is open, else PASS.
    pub(crate) fn verdict(&self) -> &'static str {
        let any =
            |wanted: &'static str| self.verdicts.iter().any(|one| one.verdict == wanted).then_some(wanted);
        any("FAIL").or(any("OPEN")).unwrap_or("PASS")
    }

    /// What was found under each condition.
    pub(crate) fn found(&self) -> String {
        self.verdicts.iter().map(|one| one.brief.as_str()).collect::<Vec<_>>().join(", ")
    }
}

/// Where the verdicts on a choice that was not judged are from, and the verdicts, in the order of the study.
///
/// # Errors
/// When a journal cannot be read any more.
pub(super) fn not_judged(sweep: &ReportedSweep, looked: &Choice) -> Result<(String, Vec<ShownRequirement>)> {
    match sweep.study.requirements.is_empty() {
        true => {
            let note = "The study names no requirement ([[require]]), so nothing is decided.";
            Ok((note.into(), Vec::new()))
        }
        false => as_planned(sweep, looked),
    }
}

/// What `judge` has decided of a choice, as far as it is what the study requires: where that is from, and the verdicts,
/// in the order of the study.
pub(crate) fn of_kept(sweep: &ReportedSweep, kept: &Kept) -> (String, Vec<ShownRequirement>) {
    let regions = &sweep.results.regions;
    let mut used = 0;
    let shown = |requirement: &Requirement| {
        let verdict = |&condition: &Condition| {
            let is_asked = |row: &Row| {
                row.of("requirement") == requirement.name && row.of("condition") == condition.name()
            };
            match kept.rows().find(is_asked) {
                Some(row)
                    if is_judged_as(&row, requirement, &sweep.results.regions)
                        && rests_on_now(
                            sweep.study,
                            &row,
                            Summed::from_measure(&requirement.measure),
                            condition,
                        ) =>
                {
                    used += 1;
                    of_row(requirement, condition, &row, sweep)
                }
                Some(_) => open(requirement, condition, OTHERWISE),
                None => open(requirement, condition, NOT_YET),
            }
        };
        of_requirement(requirement, regions, requirement.under.iter().map(verdict).collect())
    };
    let shown = sweep.study.requirements.iter().map(shown).collect();
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
fn as_planned(sweep: &ReportedSweep, looked: &Choice) -> Result<(String, Vec<ShownRequirement>)> {
    let ReportedSweep { results, study, .. } = *sweep;
    let mut shown = Vec::new();
    for requirement in &study.requirements {
        let is_decided =
            |condition: Condition| condition == Condition::AsPlanned && requirement.counted().is_some();
        let mut verdicts = Vec::new();
        for &condition in &requirement.under {
            if !is_decided(condition) {
                verdicts.push(open(requirement, condition, NOT_YET));
                continue;
            }
            let planned = [Requirement { under: vec![condition], ..requirement.clone() }];
            let set =
                JudgedSet::new(&planned, results, looked, Conditions::as_planned(study, results, looked)?);
            verdicts.extend(set.judgements.iter().map(|judgement| of_judgement(sweep, &set, judgement)));
        }
        shown.push(of_requirement(requirement, &results.regions, verdicts));
    }
    let note = "With everything as planned; nothing was judged of dead sensors, of mounts that are off and of how near \
                somebody comes.";
    Ok((note.into(), shown))
}

fn of_requirement(
    requirement: &Requirement,
    regions: &[String],
    verdicts: Vec<ShownVerdict>,
) -> ShownRequirement {
    let asked = format!("{}, {}", what(requirement, regions), limit(requirement));
    ShownRequirement { name: requirement.name.clone(), asked, verdicts }
}

/// A requirement that nothing decides under a condition: it must not look as if it were met.
fn open(requirement: &Requirement, condition: Condition, why: &str) -> ShownVerdict {
    let name = called(requirement);
    ShownVerdict {
        verdict: "OPEN",
        name: requirement.name.clone(),
        words: format!("{name} ({}) {why}", words(condition)),
        brief: format!("not decided {}", when(condition)),
    }
}

fn of_judgement(sweep: &ReportedSweep, set: &JudgedSet, judgement: &Judgement) -> ShownVerdict {
    let requirement = judgement.requirement;
    let limit = requirement.limit.ratio();
    let found = judgement.value.as_ref().map(|value| (value.number(), value.cmp_ratio(limit)));
    let mut tail = String::new();
    let Judgement { values, of, condition, .. } = *judgement;
    if (1..of).contains(&values) {
        tail += &format!("; only {values} of {of} moments have a value");
    }
    if !(requirement.is_of_nearness() && judgement.value == Some(Value::Endless)) {
        tail += &whereabouts(sweep.results, set, condition, &judgement.worst);
    }
    shown(sweep, requirement, condition, (judgement.word(), found), &tail)
}

/// A row of requirements.csv as a verdict.
fn of_row(requirement: &Requirement, condition: Condition, row: &Row, sweep: &ReportedSweep) -> ShownVerdict {
    let verdict = if row.of("verdict") == "PASS" { "PASS" } else { "FAIL" };
    let limit = requirement.limit.ratio().value();
    let found = row.of("value").parse::<f64>().ok().map(|value| {
        // What differs from the limit by less than the digits of the table tell.
        let order = match (value.total_cmp(&limit), verdict, &requirement.limit) {
            (Ordering::Equal, "FAIL", Limit::AtLeast(_)) => Ordering::Less,
            (Ordering::Equal, "FAIL", Limit::AtMost(_)) => Ordering::Greater,
            (order, ..) => order,
        };
        (value, order)
    });
    let mut tail = String::new();
    if !matches!(row.of("cases"), "" | "1") {
        tail += &format!("; {} of {} cases fail", row.of("failed"), row.of("cases"));
    }
    let worst: Vec<&str> =
        [row.of("case"), row.of("scene")].into_iter().filter(|part| !part.is_empty()).collect();
    if !worst.is_empty() {
        tail += &format!("; worst {}", worst.join(", in scene "));
    }
    if !row.of("body").is_empty() {
        tail += &format!(", {} from {}", row.of("body"), row.of("entry"));
    }
    shown(sweep, requirement, condition, (verdict, found), &tail)
}

/// A verdict in words; `found` is the value and how it compares with the limit.
fn shown(
    sweep: &ReportedSweep,
    requirement: &Requirement,
    condition: Condition,
    (verdict, found): (&'static str, Option<(f64, Ordering)>),
    tail: &str,
) -> ShownVerdict {
    let (writing, unit) = written(requirement);
    let value = match found {
        None => "no value".into(),
        Some((value, _)) if value.is_infinite() && requirement.is_of_controller() => {
            "somebody is there of whom nothing is measured".into()
        }
        Some((value, _)) if value.is_infinite() => "nobody has room to come in".into(),
        Some((value, order)) => {
            format!("{}{unit}", writing.apart(value, order, requirement.limit.ratio().value()))
        }
    };
    let is_of_moments = !requirement.is_of_nearness() && sweep.results.moments().len() > 1;
    let over = if is_of_moments { format!(", {}", of_which(requirement.over())) } else { String::new() };
    let (what, limit) = (what(requirement, &sweep.results.regions), limit(requirement));
    ShownVerdict {
        verdict,
        name: requirement.name.clone(),
        words: format!("{what}: {value}, {limit} is required ({}{over}){tail}", words(condition)),
        brief: format!("{} {} ({value})", if verdict == "PASS" { "met" } else { "missed" }, when(condition)),
    }
}

/// A condition in a sentence.
fn when(condition: Condition) -> String {
    match condition {
        Condition::AsPlanned => words(condition).into(),
        _ => format!("with {}", words(condition)),
    }
}

/// What is required, in words.
fn what(requirement: &Requirement, regions: &[String]) -> String {
    let region =
        requirement.region().map_or(String::new(), |region| format!(" in region {}", regions[region]));
    called(requirement) + &region
}

/// The score that is required, in words.
fn called(requirement: &Requirement) -> String {
    let words = match &requirement.measure {
        Measure::Counted(counted) => return measure::title(counted.score),
        Measure::Nearness(Nearness { score, body, entry }) => {
            let words = match score {
                ApproachScore::NearestUnnoticedM => "how near somebody comes unnoticed",
                ApproachScore::ApproachMarginM => "how much farther than they must people stay",
                ApproachScore::UnnoticedM2 => "floor on which somebody stands unnoticed",
                ApproachScore::JoinedM2 => "floor to which somebody comes unnoticed",
            };
            let body = body.as_ref().map_or(String::new(), |body| format!(", {body}"));
            let entry = entry.as_ref().map_or(String::new(), |entry| format!(", from {entry}"));
            return format!("{words}{body}{entry}");
        }
        Measure::Controller(ControllerScore::MissedM) => "how much too far away somebody is measured",
        Measure::Controller(ControllerScore::NeedlessStops) => "moments with a needless stop",
    };
    words.into()
}

fn limit(requirement: &Requirement) -> String {
    let (writing, unit) = written(requirement);
    let number = writing.exactly(requirement.limit.ratio().value());
    match requirement.limit {
        Limit::AtLeast(_) => format!("at least {number}{unit}"),
        Limit::AtMost(_) => format!("at most {number}{unit}"),
    }
}

/// How values of a requirement are written, and their unit.
fn written(requirement: &Requirement) -> (Writing, &'static str) {
    match &requirement.measure {
        Measure::Counted(counted) if measure::is_share(counted.score) => (Writing::Percent, ""),
        Measure::Counted(_) => (Writing::Plain, ""),
        Measure::Nearness(nearness) if nearness.score.is_area() => (Writing::Plain, " m²"),
        Measure::Nearness(_) => (Writing::Down, " m"),
        Measure::Controller(ControllerScore::MissedM) => (Writing::Up, " m"),
        Measure::Controller(ControllerScore::NeedlessStops) => (Writing::Percent, ""),
    }
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

/// Whether the tables of the study that a row of `judge` rests on are as they were.
fn rests_on_now(study: &Study, row: &Row, score: Summed, condition: Condition) -> bool {
    row.of("tables_sha256") == tables_sha256(study, score, condition)
}

/// The rows of conditions.csv that rest on tables of the study as they are now, and the others.
pub(super) fn parted_by_now(study: &Study, conditions: &Kept) -> [Kept; 2] {
    conditions.parted(|row| {
        let condition = Condition::ALL.into_iter().find(|known| known.name() == row.of("condition"));
        let known = Summed::named(row.of("score"), 0).zip(condition);
        known.is_some_and(|(score, condition)| rests_on_now(study, row, score, condition))
    })
}
