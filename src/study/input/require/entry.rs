//! An entry of `[[require]]`, checked.

use serde::Deserialize;

use super::{ApproachScore, Condition, ControllerScore, Counted, Limit, Measure, Nearness, Requirement};
use crate::diagnostics::{Place, Problems, only_one};
use crate::input::approach::Approach;
use crate::input::choose::AcrossName;
use crate::input::stopping::EXAMPLE;
use crate::input::{RegionSpec, region};
use perirobot_march::error::Issue;
use perirobot_march::metrics::{Across, Ratio, Score};
use perirobot_march::{Error, Result};
use perirobot_scene::spelling::nearest;

/// Most characters of the words for a safety function.
const MOST_WORDS: usize = 200;

/// The farthest and largest that a limit on approaches may be, in metres and square metres.
const FARTHEST: f64 = 1e4;

/// What `perirobot judge` decides: a score that a choice of sensors must reach.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct RequirementFile {
    /// Its name in verdicts.
    name: String,
    /// The score: one of results.csv, of how near bodies come unnoticed, or of what a controller would measure.
    #[cfg_attr(test, schemars(with = "AnyScore"))]
    score: String,
    /// The name of the region in which it is counted; none for scores that results.csv does not have.
    region: Option<String>,
    /// Of bodies that come near: only this one of `[approach]`. Default all.
    body: Option<String>,
    /// Of bodies that come near: only by this entry of `[approach]`. Default all.
    entry: Option<String>,
    /// Of which counts: the worst or the mean of all scenes, snapshots and repeats, or their counts added up.
    /// Default "worst"; of "needless_stops" it is "mean", the share of moments.
    over: Option<AcrossName>,
    /// What it must be at least.
    at_least: Option<f64>,
    /// What it may be at most, instead of at_least.
    at_most: Option<f64>,
    /// Under which conditions. Default ["as_planned"].
    #[serde(default = "planned_condition")]
    under: Vec<Condition>,
    /// The safety function that it stands for, in the words of a risk assessment: a line of at most 200 characters, which
    /// answers repeat. It decides nothing.
    #[serde(rename = "for")]
    #[cfg_attr(test, schemars(length(min = 1, max = 200)))]
    safety_function: Option<String>,
}

/// A score that may be required, to the schema.
#[cfg(test)]
#[derive(schemars::JsonSchema)]
#[serde(untagged)]
#[schemars(inline)]
#[allow(dead_code)]
enum AnyScore {
    Counted(crate::input::schema::counted::ScoreName),
    Approach(ApproachScore),
    Controller(ControllerScore),
}

fn planned_condition() -> Vec<Condition> {
    vec![Condition::AsPlanned]
}

/// What requirements may name.
pub(crate) struct RequirementNames<'a> {
    pub(crate) regions: &'a [(String, RegionSpec)],
    pub(crate) approach: &'a Approach,
    /// Whether the study has a mounting error.
    pub(crate) has_draws: bool,
    /// Whether the study says who stands where.
    pub(crate) has_postures: bool,
    /// Whether it says how far people must be.
    pub(crate) has_stopping: bool,
}

/// The requirements that are right.
pub(crate) fn check(
    at: &Place,
    entries: Vec<RequirementFile>,
    known: &RequirementNames,
) -> Result<Vec<Requirement>, Vec<Error>> {
    let mut problems = Problems::default();
    let all: Vec<Requirement> =
        entries.into_iter().filter_map(|entry| problems.keep(one(at, entry, known))).collect();
    problems.keep(at.unique("requirement", all.iter().map(|requirement| requirement.name.as_str())));
    problems.none().map(|()| all)
}

fn one(at: &Place, mut entry: RequirementFile, known: &RequirementNames) -> Result<Requirement> {
    let at = &at.key(&format!("require {:?}", entry.name));
    let score = entry.score.as_str();
    let counted = Score::ALL.into_iter().find(|one| one.name() == score);
    let approach = ApproachScore::ALL.into_iter().find(|one| one.name() == score);
    let controller = ControllerScore::ALL.into_iter().find(|one| one.name() == score);
    let (measure, limit) = match (counted, approach, controller) {
        (Some(score), ..) => {
            (Measure::Counted(counted_in(at, &entry, score, known)?), limit(at, &entry, score)?)
        }
        (_, Some(score), _) => {
            (Measure::Nearness(nearness(at, &entry, score, known)?), approach_limit(at, &entry, score)?)
        }
        (.., Some(score)) => {
            (Measure::Controller(check_controller(at, &entry, score)?), controller_limit(at, &entry, score)?)
        }
        (None, None, None) => {
            let names = Score::ALL.map(Score::name).into_iter();
            let names = names.chain(ApproachScore::ALL.map(ApproachScore::name));
            let names = names.chain(ControllerScore::ALL.map(ControllerScore::name));
            let names: Vec<&str> = names.collect();
            let near = nearest(score, names.iter().copied());
            let near = near.map_or(String::new(), |near| format!(" (did you mean {near:?}?)"));
            let rule = format!("must be one of {}{near}", names.join(", "));
            return Err(at.wrong("score", format!("{score:?}"), &rule));
        }
    };
    let asks_distance = matches!(approach, Some(ApproachScore::ApproachMarginM)) || controller.is_some();
    if asks_distance && !known.has_stopping {
        let rule = format!("needs to know how far people must be: add a table to the study, as in {EXAMPLE}");
        return Err(at.wrong("score", format!("{score:?}"), &rule));
    }
    let under = std::mem::take(&mut entry.under);
    at.some("under", &under, "under = [\"as_planned\"]")?;
    if under.contains(&Condition::MountingError) && !known.has_draws {
        let example = "[mounting_error] draws = 20, position_m = 0.01, angle_deg = 0.5";
        let rule =
            format!("needs to know how far mounts may be off: add a table to the study, as in {example}");
        return Err(at.wrong("under", "\"mounting_error\"", &rule));
    }
    if under.contains(&Condition::Postures) {
        if let Measure::Nearness(nearness) = &measure {
            let rule = format!(
                "{} is of bodies that come in, beside whom only people of the scenes stand: leave it out, and put people into a scene",
                nearness.score.name()
            );
            return Err(at.wrong("under", "\"postures\"", &rule));
        }
        if !known.has_postures {
            let example = "[postures] people = [\"standing\"], spots = [[1.0, 0.5, 90]]";
            let rule = format!("needs to know who stands where: add a table to the study, as in {example}");
            return Err(at.wrong("under", "\"postures\"", &rule));
        }
    }
    let under = Condition::ALL.into_iter().filter(|condition| under.contains(condition)).collect();
    check_safety_function(at, entry.safety_function.as_deref())?;
    Ok(Requirement { name: entry.name, measure, limit, under, safety_function: entry.safety_function })
}

fn check_safety_function(at: &Place, words: Option<&str>) -> Result<()> {
    let Some(words) = words else { return Ok(()) };
    let is_line = !words.trim().is_empty() && !words.contains(char::is_control);
    match is_line && words.chars().count() <= MOST_WORDS {
        true => Ok(()),
        false => {
            let rule = format!(
                "must be a line of 1 to {MOST_WORDS} characters, as in \"SF3: stop before a person reaches the gripper\""
            );
            Err(at.wrong("for", format!("{words:?}"), &rule))
        }
    }
}

fn counted_in(
    at: &Place,
    entry: &RequirementFile,
    score: Score,
    known: &RequirementNames,
) -> Result<Counted> {
    for (key, name) in [("body", &entry.body), ("entry", &entry.entry)] {
        if let Some(name) = name {
            let rule =
                format!("{} is counted in a region, for all bodies and entries: leave it out", score.name());
            return Err(at.wrong(key, format!("{name:?}"), &rule));
        }
    }
    let Some(region) = &entry.region else {
        let names: Vec<&str> = known.regions.iter().map(|(name, _)| name.as_str()).collect();
        return Err(at.wrap(Issue::missing("region")).with_advice(format!(
            "say in which region of the study {} is counted: {names:?}",
            score.name()
        )));
    };
    let region = region::index(at, region, known.regions)?;
    Ok(Counted { score, region, over: entry.over.map_or(Across::Worst, AcrossName::to_across) })
}

fn nearness(
    at: &Place,
    entry: &RequirementFile,
    score: ApproachScore,
    known: &RequirementNames,
) -> Result<Nearness> {
    if let Some(region) = &entry.region {
        let rule = format!(
            "{} is of what bodies must not come near to, which [approach] says: leave it out",
            score.name()
        );
        return Err(at.wrong("region", format!("{region:?}"), &rule));
    }
    if let Some(over @ (Across::Mean | Across::Pooled)) = entry.over.map(AcrossName::to_across) {
        let rule = "must be \"worst\": who is noticed at the entry never comes near, and never has no mean";
        return Err(at.wrong("over", format!("{:?}", over.name()), rule));
    }
    let bodies = &known.approach.bodies;
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    check_name(at, "body", &entry.body, &names, "a body")?;
    let entries: Vec<&str> = known.approach.entries.iter().map(|entry| entry.name.as_str()).collect();
    check_name(at, "entry", &entry.entry, &entries, "an entry")?;
    let is_asked = |name: &str| entry.body.as_deref().is_none_or(|asked| asked == name);
    let stands = bodies.iter().any(|body| body.on_floor && is_asked(&body.name));
    if score.is_area() && !stands {
        let rule = "is an area of floor, and no body that is asked stands on the floor";
        return Err(at.wrong("score", format!("{:?}", score.name()), rule));
    }
    Ok(Nearness { score, body: entry.body.clone(), entry: entry.entry.clone() })
}

/// Fails unless a name is among those of `[approach]`, or none is given.
fn check_name(at: &Place, key: &str, name: &Option<String>, known: &[&str], what: &str) -> Result<()> {
    match name {
        Some(name) if !known.contains(&name.as_str()) => {
            Err(at.unknown_name(key, name, &format!("{what} of [approach]"), known))
        }
        _ => Ok(()),
    }
}

fn limit(at: &Place, entry: &RequirementFile, score: Score) -> Result<Limit> {
    let (key, value) = given_limit(at, entry)?;
    let least = if score == Score::Kappa { -1.0 } else { 0.0 };
    at.number(key, value, least..=1.0, &format!("a number from {least} to 1"))?;
    exact(at, key, value)
}

fn approach_limit(at: &Place, entry: &RequirementFile, score: ApproachScore) -> Result<Limit> {
    let (key, value) = given_limit(at, entry)?;
    let (wanted, unit) = match score.is_area() {
        true => ("at_most", "square metres"),
        false => ("at_least", "metres"),
    };
    given_as(at, wanted, key, value, score.name())?;
    at.number(key, value, 0.0..=FARTHEST, &format!("a number of {unit} from 0 to {FARTHEST}"))?;
    exact(at, key, value)
}

/// Checks what is asked of a controller besides the limit.
fn check_controller(at: &Place, entry: &RequirementFile, score: ControllerScore) -> Result<ControllerScore> {
    for (key, name) in [("region", &entry.region), ("body", &entry.body), ("entry", &entry.entry)] {
        if let Some(name) = name {
            let rule = format!("{} is of all people in all of the grid: leave it out", score.name());
            return Err(at.wrong(key, format!("{name:?}"), &rule));
        }
    }
    let (over, why) = match score {
        ControllerScore::MissedM => (Across::Worst, "one person who is missed is one too many"),
        ControllerScore::NeedlessStops => (Across::Mean, "it is a share of moments"),
    };
    match entry.over.map(AcrossName::to_across) {
        Some(other) if other != over => {
            let rule = format!("must be {:?}: {why}", over.name());
            Err(at.wrong("over", format!("{:?}", other.name()), &rule))
        }
        _ => Ok(score),
    }
}

fn controller_limit(at: &Place, entry: &RequirementFile, score: ControllerScore) -> Result<Limit> {
    let (key, value) = given_limit(at, entry)?;
    given_as(at, "at_most", key, value, score.name())?;
    let (most, what) = match score {
        ControllerScore::MissedM => (FARTHEST, "a number of metres"),
        ControllerScore::NeedlessStops => (1.0, "a share of moments"),
    };
    at.number(key, value, 0.0..=most, &format!("{what} from 0 to {most}"))?;
    exact(at, key, value)
}

/// Fails unless a limit is given by the key that fits the score.
fn given_as(at: &Place, wanted: &str, key: &str, value: f64, score: &str) -> Result<()> {
    match key == wanted {
        true => Ok(()),
        false => Err(at.wrong(key, value, &format!("of {score} the limit is given as {wanted}"))),
    }
}

/// The limit that is given, by its key.
fn given_limit(at: &Place, entry: &RequirementFile) -> Result<(&'static str, f64)> {
    let limits = vec![
        ("at_least", entry.at_least.map(|value| ("at_least", value))),
        ("at_most", entry.at_most.map(|value| ("at_most", value))),
    ];
    only_one(at, "limit", limits)
}

fn exact(at: &Place, key: &str, value: f64) -> Result<Limit> {
    let ratio = Ratio::from_f64(value);
    if ratio.value() != value {
        return Err(at.wrong(key, value, "must have at most nine digits after the point"));
    }
    Ok(if key == "at_least" { Limit::AtLeast(ratio) } else { Limit::AtMost(ratio) })
}
