//! Why no set passes: the fewest requirements that cannot be met together, with what stands in the way of each.

use super::passing::{EntryTooNear, PassingTest};
use super::report::ReasonReport;
use super::terms::{Terms, bounding, dead_in};
use super::ways::{SceneWays, WayIn};
use perirobot_march::Result;
use perirobot_march::voxel::{rounded_down, rounded_up};
use perirobot_study::study::{ApproachScore, Condition, Limit, Measure, Requirement, Study};

/// Why nothing passes some terms: the places of the fewest requirements that cannot be met together, if each is needed
/// for that. `is_possible` says whether any allowed set meets some of them.
///
/// # Errors
/// Those of a search.
pub(super) fn fewest(
    terms: &Terms,
    is_possible: &mut dyn FnMut(&Terms) -> Result<bool>,
) -> Result<Vec<usize>> {
    let all: Vec<usize> = (0..terms.requirements.len()).collect();
    let others = |kept: &[usize]| -> Vec<usize> {
        all.iter().copied().filter(|place| !kept.contains(place)).collect()
    };
    if all.len() == 1 {
        return Ok(all);
    }
    for &place in &all {
        if !is_possible(&terms.without(&others(&[place])))? {
            return Ok(vec![place]);
        }
    }
    let mut kept = all.clone();
    for &place in &all {
        let fewer: Vec<usize> = kept.iter().copied().filter(|&other| other != place).collect();
        if !is_possible(&terms.without(&others(&fewer)))? {
            kept = fewer;
        }
    }
    Ok(kept)
}

/// What stands in the way of a requirement that no set meets, and what could help; `name` names candidates.
pub(super) fn explain(
    study: &Study,
    requirement: &Requirement,
    test: &PassingTest,
    name: &dyn Fn(usize) -> String,
) -> String {
    if let Some(entry) = test.too_near_at_entry() {
        return too_near(study, &entry, test);
    }
    if let Some(way) = test.unnoticeable_way() {
        return unnoticed(study, way, &test.ways()[way.scene], requirement);
    }
    if let (Some((best, left_out)), Some((counted, limit))) =
        (test.missed_by_all(requirement), bounding(requirement))
    {
        let (score, region) = (counted.score.name(), &study.regions[counted.region].0);
        let (side, limit) = match limit {
            Limit::AtLeast(limit) => ("at least", limit.value()),
            Limit::AtMost(limit) => ("at most", limit.value()),
        };
        let without: Vec<String> = left_out.iter().map(|&item| name(item)).collect();
        let (without, cure) = match without.is_empty() {
            true => (String::new(), "list more places"),
            false => (format!(" but {}", without.join(" and ")), "list another place that sees what it sees"),
        };
        return format!(
            "all listed places{without} together have {score} {best:.4} in {region}, and {side} {limit} is required: \
             {cure}, or ask for less"
        );
    }
    format!("no allowed set meets it{}: {CURE}", conditions(requirement))
}

/// What helps where nothing else is known.
const CURE: &str = "allow more sensors, a larger budget or more places, or ask for less";

/// What a requirement asks that cannot be met with others.
pub(super) fn asked(study: &Study, requirement: &Requirement) -> String {
    let (side, limit) = match requirement.limit {
        Limit::AtLeast(limit) => ("at least", limit.value()),
        Limit::AtMost(limit) => ("at most", limit.value()),
    };
    let region = requirement.region().map(|region| format!(" in {}", study.regions[region].0));
    let region = region.unwrap_or_default();
    format!("{} {side} {limit}{region}{}", requirement.score_name(), conditions(requirement))
}

/// The reasons of some requirements, by their places.
pub(super) fn reports(
    terms: &Terms,
    places: &[usize],
    why: &dyn Fn(&Requirement) -> String,
) -> Vec<ReasonReport> {
    let one = |&place: &usize| {
        let requirement = &terms.requirements[place];
        ReasonReport { requirement: requirement.name.clone(), why: why(requirement) }
    };
    places.iter().map(one).collect()
}

/// Under which conditions besides the plan.
fn conditions(requirement: &Requirement) -> String {
    let besides = requirement.under.iter().filter(|&&condition| condition != Condition::AsPlanned);
    let names: Vec<&str> = besides.map(|condition| condition.name()).collect();
    if names.is_empty() { String::new() } else { format!(" under {}", names.join(", ")) }
}

fn too_near(study: &Study, entry: &EntryTooNear, test: &PassingTest) -> String {
    let passage = &test.ways()[entry.scene].passages[entry.passage];
    let begins_m = f64::from(entry.squared).sqrt() * study.voxel_size_m;
    let needed_m = test.needed_m(entry.requirement);
    let stopping = match &entry.requirement.measure {
        Measure::Nearness(nearness) if nearness.score == ApproachScore::ApproachMarginM => ", or stop faster",
        _ => "",
    };
    format!(
        "entry {:?} begins {} m from the hazard for body {:?}, and {} m are needed: no sensor helps; move the entry {} m \
         farther out{stopping}",
        passage.entry,
        rounded_down(begins_m, 2),
        passage.body,
        rounded_up(needed_m, 2),
        rounded_up(needed_m - begins_m, 2),
    )
}

fn unnoticed(study: &Study, way: &WayIn, ways: &SceneWays, requirement: &Requirement) -> String {
    let passage = &ways.passages[way.passage];
    let nearest_m = f64::from(way.squared).sqrt() * study.voxel_size_m;
    let [x, y, z] = ways.end_m(way);
    let dead = requirement.under.iter().filter_map(|&condition| dead_in(condition)).max().unwrap_or(0);
    let who = match way.noticed_by.len() {
        0 => "no listed place notices it".to_string(),
        few => format!("only {few} listed places notice it, and {} are needed", dead + 1),
    };
    let hidden = ways.hiding_object(way).map_or(String::new(), |name| format!(" behind {name:?}"));
    format!(
        "body {:?} comes from entry {:?} to {} m of the hazard{hidden}, over x {x:.2}, y {y:.2}, z {z:.2} m, and {who}: list \
         a place that sees there",
        passage.body,
        passage.entry,
        rounded_down(nearest_m, 2),
    )
}
