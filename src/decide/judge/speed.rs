//! How fast the robot may run: the highest listed speed up to which the requirements are met in the region that
//! people must keep out of at that speed.
//!
//! # Theory
//! A requirement whose region is a `separation` is judged in the region of each speed that belongs to the same entry
//! of the study, all else the same. A robot that may run at a speed also runs slower, so a speed is allowed only
//! if all requirements are met at it and at each slower listed speed. One without a value at any moment (for example
//! without a person so close) decides nothing, and then no speed is allowed. If the study lists bodies that approach, none
//! may come closer unnoticed than people need at the speed.

use std::path::Path;

use super::judged::JudgedSet;
use super::scope::{approach_conditions, asks_how_near_at_speeds};
use super::verdict::{Judgement, judgements};
use perirobot_march::Result;
use perirobot_study::input::{
    ApproachScore, AtSpeed, Limit, Measure, Nearness, RegionSpec, Requirement, Stopping, Study,
};
use perirobot_sweep::results::files::SPEEDS;
use perirobot_sweep::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};
use perirobot_sweep::results::{Results, Subject};

/// The requirement on approaches at each speed, as in the column `requirement`.
const FAR_ENOUGH: &str = "nobody comes nearer unnoticed than is needed";

/// A requirement at a speed: in its region, or on the needed distance.
#[derive(Clone, Debug)]
pub(super) struct AtEachSpeed {
    /// The index of the speed in [`Stopping::speeds`].
    pub speed: usize,
    /// The requirement at this speed.
    pub requirement: Requirement,
}

/// Each requirement whose region belongs to a speed, in the regions of all speeds of the same entry, requirement by
/// requirement, slowest speed first; then the approaches at each speed, if required.
pub(super) fn at_each_speed(study: &Study) -> Vec<AtEachSpeed> {
    let family_of = |region: usize| match &study.regions[region].1 {
        RegionSpec::Separation { family, speed, .. } => Some((family, *speed)),
        _ => None,
    };
    let shells = |requirement: &Requirement| -> Vec<AtEachSpeed> {
        let Some((family, _)) = requirement.region().and_then(family_of) else { return Vec::new() };
        let regions = (0..study.regions.len()).filter_map(|region| Some((region, family_of(region)?)));
        let own = regions.filter(|(_, (other, _))| *other == family);
        own.map(|(region, (_, speed))| AtEachSpeed { speed, requirement: requirement.with_region(region) })
            .collect()
    };
    let shells = study.requirements.iter().flat_map(shells);
    let stopping = study.stopping.as_ref().filter(|_| asks_how_near_at_speeds(study));
    let speeds = stopping.iter().flat_map(|stopping| stopping.speeds.iter().enumerate());
    shells.chain(speeds.map(|(speed, at)| far_enough(study, speed, at))).collect()
}

/// The requirements of each robot speed, by its index: those of [`at_each_speed`].
pub(crate) fn requirements_at_speeds(study: &Study) -> Vec<(usize, Requirement)> {
    at_each_speed(study).into_iter().map(|at| (at.speed, at.requirement)).collect()
}

/// The requirement that no body comes closer unnoticed than this.
fn far_enough(study: &Study, speed: usize, at: &AtSpeed) -> AtEachSpeed {
    let requirement = Requirement {
        name: FAR_ENOUGH.into(),
        measure: Measure::Nearness(Nearness {
            score: ApproachScore::NearestUnnoticedM,
            body: None,
            entry: None,
        }),
        limit: Limit::AtLeast(at.needed_distance()),
        under: approach_conditions(study),
        safety_function: None,
    };
    AtEachSpeed { speed, requirement }
}

/// The verdicts on a set at each speed.
pub struct Speeds<'a> {
    /// The index of the speed, and the verdict there.
    pub judgements: Vec<(usize, Judgement<'a>)>,
    /// The index of the highest allowed speed; `None` if the slowest is not allowed.
    pub fastest: Option<usize>,
    /// Missed requirements that depend on no speed.
    pub missed_at_all: Vec<Judgement<'a>>,
}

impl<'a> Speeds<'a> {
    /// The speeds of a judged set; `None` if no requirement depends on a speed.
    pub(super) fn new(
        asked: &'a [AtEachSpeed],
        results: &Results,
        set: &JudgedSet<'a>,
    ) -> Option<Speeds<'a>> {
        let one = |at: &'a AtEachSpeed| {
            let found =
                judgements(std::slice::from_ref(&at.requirement), &results.baselines, &set.conditions);
            found.into_iter().map(move |judgement| (at.speed, judgement))
        };
        let judgements: Vec<_> = asked.iter().flat_map(one).collect();
        let mut speeds: Vec<usize> = judgements.iter().map(|(speed, _)| *speed).collect();
        speeds.sort_unstable();
        speeds.dedup();
        let is_met = |at: &usize| judgements.iter().all(|(speed, judgement)| speed != at || judgement.is_met);
        let fastest = speeds.iter().copied().take_while(is_met).last();
        // Names are unique in the study; other requirements have no region.
        let has_speed = |own: &Requirement| {
            asked.iter().any(|at| at.requirement.region().is_some() && at.requirement.name == own.name)
        };
        let missed = set.judgements.iter().filter(|one| !one.is_met && !has_speed(one.requirement));
        let missed_at_all = missed.cloned().collect();
        (!speeds.is_empty()).then_some(Speeds { judgements, fastest, missed_at_all })
    }
}

/// Writes `speeds.csv`, a row for each set, speed, requirement and condition.
pub(super) fn speeds_csv(
    folder: &Path,
    subject: &Subject,
    sets: &[(&JudgedSet, Speeds)],
    stopping: &Stopping,
) -> Result<()> {
    use ColumnKind::{Count, Score, Text};
    let columns = [
        ("combination", Text),
        ("poses", Text),
        ("representation", Text),
        ("speed_m_s", Score),
        ("needed_m", Score),
        ("requirement", Text),
        ("condition", Text),
        ("region", Text),
        ("verdict", Text),
        ("value", Score),
        ("fast_enough", Count),
    ];
    let columns = columns.map(|(name, kind)| Column::new(name, kind));
    let mut table = TableFile::create(&folder.join(SPEEDS), TableFormat::Csv, &columns)?;
    for (set, speeds) in sets {
        for (speed, judgement) in &speeds.judgements {
            let at = &stopping.speeds[*speed];
            let requirement = judgement.requirement;
            let region = requirement.region().map_or("", |region| subject.regions[region].as_str());
            let mut row =
                [&set.combination, &set.poses, &set.representation].map(|name| Datum::Text(name)).to_vec();
            row.extend([at.speed_m_s, at.needed_m].map(|number| Datum::Score(Some(number))));
            let verdict = if judgement.values == 0 { "not decided" } else { judgement.word() };
            let texts = [&requirement.name, judgement.condition.name(), region, verdict];
            row.extend(texts.map(Datum::Text));
            row.push(Datum::Score(judgement.value.as_ref().map(|value| value.number())));
            row.push(Datum::Count(u64::from(speeds.fastest.is_some_and(|fastest| *speed <= fastest))));
            table.row(&row)?;
        }
    }
    table.finish()
}
