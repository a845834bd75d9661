//! The verdicts on the study's requirements for a choice: those of `judge`, if they match the current requirements;
//! without a judgement, those decided by the sweep. Undecided ones are OPEN.

use std::cmp::Ordering;

use maud::{Markup, html};

use crate::report::apart::Writing;
use crate::report::page::{ReportedSweep, measure};
use crate::report::wording::{describe_moments, words, worst_case};
use perirobot_decide::judge::{
    ConditionScore, Conditions, JsonNumber, JudgedSet, Judgement, RequirementVerdict, Summed, Value,
    tables_sha256,
};
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_study::input::{
    ApproachScore, Condition, ControllerScore, Limit, Measure, Nearness, Requirement, Study,
};

/// Why a requirement is open.
const NOT_YET: &str = "is not decided yet: judge it (see below)";
const OTHERWISE: &str =
    "was judged against other requirements, or with other tables of the study: run `perirobot judge` again";

/// A requirement under a condition.
#[derive(Clone, Debug)]
pub(crate) struct ShownVerdict {
    /// PASS, FAIL, or OPEN if it is undecided.
    pub(crate) verdict: &'static str,
    pub(crate) name: String,
    pub(crate) words: String,
    /// The verdict in a few words: `missed with one sensor dead (30 %)`.
    pub(super) brief: String,
}

/// The verdicts on a requirement, one for each of its conditions.
#[derive(Clone, Debug)]
pub(crate) struct ShownRequirement {
    pub(crate) name: String,
    /// The score and its limit.
    pub(crate) asked: String,
    /// The safety function that it represents.
    pub(crate) safety_function: Option<String>,
    pub(crate) verdicts: Vec<ShownVerdict>,
}

impl ShownRequirement {
    /// FAIL if it is missed under a condition, else OPEN if one is open, else PASS.
    pub(crate) fn verdict(&self) -> &'static str {
        let any =
            |wanted: &'static str| self.verdicts.iter().any(|one| one.verdict == wanted).then_some(wanted);
        any("FAIL").or(any("OPEN")).unwrap_or("PASS")
    }

    /// The safety function that it represents, if the study has one.
    pub(super) fn view_safety_function(&self) -> Markup {
        html! { @if let Some(words) = &self.safety_function { " " em { "for " (words) } } }
    }

    /// The results under each condition.
    pub(crate) fn describe_found(&self) -> String {
        self.verdicts.iter().map(|one| one.brief.as_str()).collect::<Vec<_>>().join(", ")
    }
}

/// The source of the verdicts on a choice without a judgement, and the verdicts, in the order of the study.
///
/// # Errors
/// If a journal cannot be read any more.
pub(super) fn not_judged(sweep: &ReportedSweep, looked: &Choice) -> Result<(String, Vec<ShownRequirement>)> {
    match sweep.study.requirements.is_empty() {
        true => {
            let note = "The study names no requirement ([[require]]), so nothing is decided.";
            Ok((note.into(), Vec::new()))
        }
        false => planned_verdicts(sweep, looked),
    }
}

/// The verdicts of `judge` on a choice that match the current requirements: their source, and the verdicts, in the
/// order of the study.
pub(crate) fn current_verdicts(
    sweep: &ReportedSweep,
    judged: &[RequirementVerdict],
) -> (String, Vec<ShownRequirement>) {
    let regions = &sweep.results.regions;
    let mut used = 0;
    let shown = |requirement: &Requirement| {
        let verdict = |&condition: &Condition| {
            let is_asked =
                |one: &&RequirementVerdict| one.requirement == requirement.name && one.condition == condition;
            match judged.iter().find(is_asked) {
                Some(one)
                    if is_judged_as(one, requirement, regions)
                        && rests_on_now(sweep.study, one, requirement) =>
                {
                    used += 1;
                    judged_verdict(sweep, requirement, one)
                }
                Some(_) => open(requirement, condition, OTHERWISE),
                None => open(requirement, condition, NOT_YET),
            }
        };
        requirement_verdicts(requirement, regions, requirement.under.iter().map(verdict).collect())
    };
    let shown = sweep.study.requirements.iter().map(shown).collect();
    let note = match used == judged.len() {
        true => "As decided by perirobot judge.",
        false => {
            "What perirobot judge has written into the folder was judged against other requirements than the study \
             has now, or with another [mounting_error], [postures], [approach] or [stopping]: run `perirobot judge` \
             again. Its verdicts are shown only if their inputs are unchanged."
        }
    };
    (note.into(), shown)
}

/// The verdicts of the sweep itself: requirements on its counts as planned.
fn planned_verdicts(sweep: &ReportedSweep, looked: &Choice) -> Result<(String, Vec<ShownRequirement>)> {
    let ReportedSweep { results, study, .. } = *sweep;
    let mut shown = Vec::new();
    for requirement in &study.requirements {
        let is_decided =
            |condition: Condition| condition == Condition::AsPlanned && requirement.counted_score().is_some();
        let mut verdicts = Vec::new();
        for &condition in &requirement.under {
            if !is_decided(condition) {
                verdicts.push(open(requirement, condition, NOT_YET));
                continue;
            }
            let planned = [Requirement { under: vec![condition], ..requirement.clone() }];
            let set =
                JudgedSet::new(&planned, results, looked, Conditions::from_results(study, results, looked)?);
            verdicts.extend(set.judgements.iter().map(|judgement| judgement_verdict(sweep, &set, judgement)));
        }
        shown.push(requirement_verdicts(requirement, &results.regions, verdicts));
    }
    let note = "With everything as planned; dead sensors, shifted mounts and approaches were not \
                judged.";
    Ok((note.into(), shown))
}

fn requirement_verdicts(
    requirement: &Requirement,
    regions: &[String],
    verdicts: Vec<ShownVerdict>,
) -> ShownRequirement {
    let asked = format!("{}, {}", what(requirement, regions), limit(requirement));
    let (name, safety_function) = (requirement.name.clone(), requirement.safety_function.clone());
    ShownRequirement { name, asked, safety_function, verdicts }
}

/// A requirement that is undecided under a condition: it must not look met.
fn open(requirement: &Requirement, condition: Condition, why: &str) -> ShownVerdict {
    let name = describe_score(requirement);
    ShownVerdict {
        verdict: "OPEN",
        name: requirement.name.clone(),
        words: format!("{name} ({}) {why}", words(condition)),
        brief: format!("not decided {}", when(condition)),
    }
}

fn judgement_verdict(sweep: &ReportedSweep, set: &JudgedSet, judgement: &Judgement) -> ShownVerdict {
    let requirement = judgement.requirement;
    let limit = requirement.limit.ratio();
    let found = judgement.value.as_ref().map(|value| (value.number(), value.cmp_ratio(limit)));
    let mut tail = String::new();
    let Judgement { values, of, condition, .. } = *judgement;
    if (1..of).contains(&values) {
        tail += &format!("; only {values} of {of} moments have a value");
    }
    if !(requirement.is_of_nearness() && judgement.value == Some(Value::Endless)) {
        tail += &worst_case(sweep.results, set, judgement);
    }
    shown_verdict(sweep, requirement, condition, (judgement.word(), found), &tail)
}

/// A verdict of `judge`.
fn judged_verdict(
    sweep: &ReportedSweep,
    requirement: &Requirement,
    one: &RequirementVerdict,
) -> ShownVerdict {
    let verdict = one.word();
    let limit = requirement.limit.ratio().value();
    let found = one.value.map(|JsonNumber(value)| {
        // The value differs from the limit by less than a number can represent.
        let order = match (value.total_cmp(&limit), one.is_met, &requirement.limit) {
            (Ordering::Equal, false, Limit::AtLeast(_)) => Ordering::Less,
            (Ordering::Equal, false, Limit::AtMost(_)) => Ordering::Greater,
            (order, ..) => order,
        };
        (value, order)
    });
    let mut tail = String::new();
    if one.cases > 1 {
        tail += &format!("; {} of {} cases fail", one.failed, one.cases);
    }
    let worst = [Some(&one.worst.case).filter(|case| !case.is_empty()), one.worst.scene.as_ref()];
    let worst: Vec<&str> = worst.into_iter().flatten().map(String::as_str).collect();
    if !worst.is_empty() {
        tail += &format!("; worst {}", worst.join(", in scene "));
    }
    if let (Some(body), Some(entry)) = (&one.worst.body, &one.worst.entry) {
        tail += &format!(", {body} from {entry}");
    }
    shown_verdict(sweep, requirement, one.condition, (verdict, found), &tail)
}

/// A verdict in words; `found` is the value and its comparison with the limit.
fn shown_verdict(
    sweep: &ReportedSweep,
    requirement: &Requirement,
    condition: Condition,
    (verdict, found): (&'static str, Option<(f64, Ordering)>),
    tail: &str,
) -> ShownVerdict {
    let (writing, unit) = writing(requirement);
    let value = match found {
        None => "no value".into(),
        Some((value, _)) if value.is_infinite() && requirement.is_of_controller() => {
            "a person is present but not measured".into()
        }
        Some((value, _)) if value.is_infinite() => "no body fits through an entry".into(),
        Some((value, order)) => {
            format!("{}{unit}", writing.apart(value, order, requirement.limit.ratio().value()))
        }
    };
    let is_of_moments = !requirement.is_of_nearness() && sweep.results.moments().len() > 1;
    let over =
        if is_of_moments { format!(", {}", describe_moments(requirement.scope())) } else { String::new() };
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

/// The requirement in words.
fn what(requirement: &Requirement, regions: &[String]) -> String {
    let region =
        requirement.region().map_or(String::new(), |region| format!(" in region {}", regions[region]));
    describe_score(requirement) + &region
}

/// The required score in words.
fn describe_score(requirement: &Requirement) -> String {
    let words = match &requirement.measure {
        Measure::Counted(counted) => return measure::title(counted.score),
        Measure::Nearness(Nearness { score, body, entry }) => {
            let words = match score {
                ApproachScore::NearestUnnoticedM => "how near a person gets unnoticed",
                ApproachScore::ApproachMarginM => "margin of the distance to people",
                ApproachScore::UnnoticedM2 => "floor on which a person stands unnoticed",
                ApproachScore::JoinedM2 => "floor that a person reaches unnoticed",
            };
            let body = body.as_ref().map_or(String::new(), |body| format!(", {body}"));
            let entry = entry.as_ref().map_or(String::new(), |entry| format!(", from {entry}"));
            return format!("{words}{body}{entry}");
        }
        Measure::Controller(ControllerScore::MissedM) => "excess of the measured distance of people",
        Measure::Controller(ControllerScore::NeedlessStops) => "moments with a needless stop",
    };
    words.into()
}

fn limit(requirement: &Requirement) -> String {
    let (writing, unit) = writing(requirement);
    let number = writing.exactly(requirement.limit.ratio().value());
    match requirement.limit {
        Limit::AtLeast(_) => format!("at least {number}{unit}"),
        Limit::AtMost(_) => format!("at most {number}{unit}"),
    }
}

/// The format of a requirement's values, and their unit.
fn writing(requirement: &Requirement) -> (Writing, &'static str) {
    match &requirement.measure {
        Measure::Counted(counted) if measure::is_share(counted.score) => (Writing::Percent, ""),
        Measure::Counted(_) => (Writing::Plain, ""),
        Measure::Nearness(nearness) if nearness.score.is_area() => (Writing::Plain, " m²"),
        Measure::Nearness(_) => (Writing::Down, " m"),
        Measure::Controller(ControllerScore::MissedM) => (Writing::Up, " m"),
        Measure::Controller(ControllerScore::NeedlessStops) => (Writing::Percent, ""),
    }
}

/// Whether a verdict was judged against the current requirement of this name.
fn is_judged_as(one: &RequirementVerdict, requirement: &Requirement, regions: &[String]) -> bool {
    let limits = match &requirement.limit {
        Limit::AtLeast(ratio) => (Some(ratio.value()), None),
        Limit::AtMost(ratio) => (None, Some(ratio.value())),
    };
    // For approaches, the worst body is known.
    let may_be = |wanted: &Option<String>, found: &Option<String>| {
        found.is_none() || wanted.is_none() || wanted == found
    };
    let is_of_body = match &requirement.measure {
        Measure::Counted(_) | Measure::Controller(_) => true,
        Measure::Nearness(near) => {
            may_be(&near.body, &one.worst.body) && may_be(&near.entry, &one.worst.entry)
        }
    };
    one.score == requirement.score_name()
        && one.region.as_ref() == requirement.region().map(|region| &regions[region])
        && one.over == requirement.scope()
        && (one.at_least, one.at_most) == limits
        && is_of_body
}

/// Whether the study's tables behind a verdict are unchanged.
fn rests_on_now(study: &Study, one: &RequirementVerdict, requirement: &Requirement) -> bool {
    one.tables_sha256 == tables_sha256(study, Summed::from_measure(&requirement.measure), one.condition)
}

/// The scores whose tables in the study are unchanged, and the others.
pub(super) fn parted_by_now<'s>(study: &Study, scores: &'s [ConditionScore]) -> [Vec<&'s ConditionScore>; 2] {
    let is_of_now = |one: &&ConditionScore| {
        let score = Summed::from_name(&one.score, 0);
        score.is_some_and(|score| one.tables_sha256 == tables_sha256(study, score, one.condition))
    };
    let (now, old) = scores.iter().partition(is_of_now);
    [now, old]
}
