//! Why no set passes: the fewest requirements that cannot be met together, with the cause of each.

use super::passing::{EntryTooNear, PassingTest};
use super::report::ReasonReport;
use super::terms::{Terms, bounding, dead_in};
use crate::choose::pose_name;
use crate::judge::Passage;
use perirobot_march::Result;
use perirobot_march::voxel::{rounded_down, rounded_up};
use perirobot_study::input::{ApproachScore, Condition, Limit, Measure, Requirement, Stopping, Study};

/// Why no set passes some terms: the places of a smallest group of requirements that cannot be met together, each of
/// which is necessary. `is_possible` decides whether any allowed set meets a group.
///
/// # Errors
/// Those of a search.
pub(super) fn fewest(
    terms: &Terms,
    is_possible: &mut dyn FnMut(&Terms) -> Result<bool>,
) -> Result<Vec<usize>> {
    let all: Vec<usize> = (0..terms.requirements.len()).collect();
    if all.len() == 1 {
        return Ok(all);
    }
    for &place in &all {
        if !is_possible(&terms.only(&[place]))? {
            return Ok(vec![place]);
        }
    }
    let mut kept = all.clone();
    for &place in &all {
        let fewer: Vec<usize> = kept.iter().copied().filter(|&other| other != place).collect();
        if !is_possible(&terms.only(&fewer))? {
            kept = fewer;
        }
    }
    Ok(kept)
}

/// Why no set meets a requirement.
pub(super) enum Obstacle<'o> {
    /// A body is already too near at its entry: its distance, squared in voxels.
    Entry { body: &'o str, entry: &'o str, squared: u32 },
    /// Fewer candidates notice a way in than a set needs.
    Way {
        body: &'o str,
        entry: &'o str,
        squared: u32,
        /// The body's centre at the end, in world metres.
        end_m: [f64; 3],
        /// The object in front of it.
        hidden_by: Option<String>,
        noticed_by: usize,
    },
    /// The score of all candidates together, or without these, misses the limit.
    Counts { best: f64, without: Vec<String> },
    /// No cause was found.
    Unknown,
}

impl<'o> Obstacle<'o> {
    /// The obstacle of the only tested requirement; `items` has sensor and candidate of each candidate.
    pub(super) fn new(
        requirement: &Requirement,
        test: &'o PassingTest,
        (study, items): (&Study, &[[usize; 2]]),
    ) -> Obstacle<'o> {
        if let Some(EntryTooNear { scene, passage, squared }) = test.too_near_at_entry() {
            let Passage { body, entry, .. } = &test.ways()[scene].passages[passage];
            return Obstacle::Entry { body, entry, squared };
        }
        if let Some(way) = test.unnoticeable_way() {
            let ways = &test.ways()[way.scene];
            let Passage { body, entry, .. } = &ways.passages[way.passage];
            let (end_m, hidden_by) = (ways.end_m(way), ways.hiding_object(way));
            let (squared, noticed_by) = (way.squared, way.noticed_by.len());
            return Obstacle::Way { body, entry, squared, end_m, hidden_by, noticed_by };
        }
        test.missed_by_all(requirement).map_or(Obstacle::Unknown, |(best, left_out)| {
            let without = left_out.iter().map(|&item| pose_name(study, items[item])).collect();
            Obstacle::Counts { best, without }
        })
    }

    /// In words, with a remedy; `stopping` gives the required distance.
    pub(super) fn words(
        &self,
        study: &Study,
        stopping: Option<&Stopping>,
        requirement: &Requirement,
    ) -> String {
        let metres = |squared: u32| f64::from(squared).sqrt() * study.voxel_size_m;
        match (self, bounding(requirement)) {
            (&Obstacle::Entry { body, entry, squared }, _) => {
                too_near(body, entry, metres(squared), needed_m(stopping, requirement), requirement)
            }
            (Obstacle::Way { body, entry, squared, end_m: [x, y, z], hidden_by, noticed_by }, _) => {
                let hidden = hidden_by.as_ref().map_or(String::new(), |name| format!(" behind {name:?}"));
                format!(
                    "body {body:?} comes from entry {entry:?} to {} m of the hazard{hidden}, over x {x:.2}, y {y:.2}, \
                     z {z:.2} m, and {}: list a place that sees there",
                    rounded_down(metres(*squared), 2),
                    who_notices(*noticed_by, requirement)
                )
            }
            (Obstacle::Counts { best, without }, Some((counted, limit))) => {
                let (name, region) = (counted.score.name(), &study.regions[counted.region].0);
                let (side, limit) = match limit {
                    Limit::AtLeast(limit) => ("at least", limit.value()),
                    Limit::AtMost(limit) => ("at most", limit.value()),
                };
                let (but, cure) = match without[..] {
                    [] => (String::new(), "list more places"),
                    _ => (
                        format!(" but {}", without.join(" and ")),
                        "list another place that sees what it sees",
                    ),
                };
                format!(
                    "all listed poses{but} together have {name} {best:.4} in {region}, and {side} {limit} is \
                     required: {cure}, or ask for less"
                )
            }
            (Obstacle::Counts { .. } | Obstacle::Unknown, _) => {
                format!("no allowed set meets it{}: {CURE}", conditions(requirement))
            }
        }
    }
}

/// The remedy if no cause was found.
const CURE: &str = "allow more sensors, a larger budget or more places, or ask for less";

/// A requirement that cannot be met together with others, in words.
pub(super) fn describe_demand(study: &Study, requirement: &Requirement) -> String {
    let (side, limit) = match requirement.limit {
        Limit::AtLeast(limit) => ("at least", limit.value()),
        Limit::AtMost(limit) => ("at most", limit.value()),
    };
    let region = requirement.region().map(|region| format!(" in {}", study.regions[region].0));
    let region = region.unwrap_or_default();
    format!("{} {side} {limit}{region}{}", requirement.score_name(), conditions(requirement))
}

/// The reasons for some requirements, by their places.
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

/// The conditions besides the plan.
fn conditions(requirement: &Requirement) -> String {
    let besides = requirement.under.iter().filter(|&&condition| condition != Condition::AsPlanned);
    let names: Vec<&str> = besides.map(|condition| condition.name()).collect();
    if names.is_empty() { String::new() } else { format!(" under {}", names.join(", ")) }
}

/// The required distance of a body, in metres.
fn needed_m(stopping: Option<&Stopping>, requirement: &Requirement) -> f64 {
    let Limit::AtLeast(limit) = requirement.limit else { return 0.0 };
    let besides =
        stopping.filter(|_| is_margin(requirement)).map_or(0.0, |stopping| stopping.fastest().needed_m);
    limit.value() + besides
}

fn is_margin(requirement: &Requirement) -> bool {
    matches!(&requirement.measure, Measure::Nearness(nearness)
        if nearness.score == ApproachScore::ApproachMarginM)
}

fn too_near(body: &str, entry: &str, begins_m: f64, needed_m: f64, requirement: &Requirement) -> String {
    let stopping = if is_margin(requirement) { ", or stop faster" } else { "" };
    format!(
        "entry {entry:?} begins {} m from the hazard for body {body:?}, and {} m are needed: no sensor helps; move the \
         entry {} m farther out{stopping}",
        rounded_down(begins_m, 2),
        rounded_up(needed_m, 2),
        rounded_up(needed_m - begins_m, 2)
    )
}

fn who_notices(noticed_by: usize, requirement: &Requirement) -> String {
    let dead = requirement.under.iter().filter_map(|&condition| dead_in(condition)).max().unwrap_or(0);
    match noticed_by {
        0 => "no listed place notices it".to_string(),
        few => format!("only {few} listed poses notice it, and {} are needed", dead + 1),
    }
}
