//! Which sets are allowed, and what each is worth.

use super::evidence::{CandidateEvidence, Row, Union};
use super::layout::{BitLayout, MomentBits, Wanted};
use super::odds::Odds;
use super::worth::{MOST_VOXELS, Ratio, Worth};
use perirobot_march::metrics::{Confusion, Score};
use perirobot_march::{Error, Result};
use perirobot_study::sensor::{Cost, Setting};
use perirobot_study::study::{Across, Choose, Study};
use perirobot_study::world::World;

/// Two sensors are as far apart as they should be if this little is missing: lattices are made in floating
/// point.
const NEARLY_M: f64 = 1e-9;

/// What is searched: allowed sets of candidates, by their numbers in the evidence.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    pub(super) evidence: &'a CandidateEvidence,
    /// The score that is to be high, and of which counts.
    pub(super) goal: (Score, Across),
    /// What every set must reach.
    pub(super) require: Vec<(Score, Across, Ratio)>,
    /// How large a set may be.
    pub(super) limits: SetLimits,
    /// What each candidate costs, in thousandths.
    pub(super) cost: Vec<u64>,
    /// Candidates that are in every set.
    pub(super) always: Vec<usize>,
    /// For each candidate the others that are too near, a bit each.
    pub(super) near: Vec<Vec<u64>>,
    /// How many of a sensor a set may have.
    pub(super) most: Vec<usize>,
    /// How labels come to be, where that is not by unions.
    pub(super) odds: Option<Odds>,
}

/// Some candidates together, which others may join.
pub(super) enum Joint<'a> {
    Union(Union),
    /// What each says, where sums decide.
    Rows(Vec<(usize, Row<'a>)>),
}

/// How large a set may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetLimits {
    /// How many candidates it may have.
    pub at_most: usize,
    /// What it may cost, in thousandths.
    pub budget: Option<u64>,
}

impl SetLimits {
    /// What is known of the sets within them, in words: the best score so far, and what no set is above.
    pub fn in_words(&self, [best, above]: [Option<f64>; 2]) -> String {
        let cost = self.budget.map(Cost::from_thousandths).map(|budget| format!(" for {budget}"));
        let best = best.map_or("none found yet".into(), |best| format!("the best is {best:.4}"));
        let above = above.map(|above| format!(", none is above {above:.4}"));
        format!(
            "sets of at most {}{}: {best}{}",
            self.at_most,
            cost.unwrap_or_default(),
            above.unwrap_or_default()
        )
    }
}

/// How good a set is: first by what it lacks of the requirements, then by its worth. Larger is better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Merit {
    /// Zero where all requirements are met, else below.
    lacking: f64,
    pub(super) worth: Option<Worth>,
}

impl SetLimits {
    /// Whether a set may cost so much.
    pub(super) fn afford(&self, cost: u64) -> bool {
        self.budget.is_none_or(|budget| cost <= budget)
    }
}

/// A set and its worth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Candidates by their numbers in the evidence, lowest first.
    pub set: Vec<usize>,
    /// What it is worth.
    pub worth: Worth,
}

impl Eq for Merit {}

impl Ord for Merit {
    fn cmp(&self, other: &Merit) -> std::cmp::Ordering {
        self.lacking.total_cmp(&other.lacking).then(self.worth.cmp(&other.worth))
    }
}

impl PartialOrd for Merit {
    fn partial_cmp(&self, other: &Merit) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<'a> Problem<'a> {
    /// What a study asks for that passed [`examine`].
    pub fn new(
        study: &Study,
        choose: &Choose,
        worlds: &[World],
        evidence: &'a CandidateEvidence,
    ) -> Problem<'a> {
        let items = &evidence.items;
        let cost = |&[sensor, _]: &[usize; 2]| study.sensors[sensor].terms.cost.map_or(0, Cost::thousandths);
        let number = |wanted: &[usize; 2]| {
            items.iter().position(|item| item == wanted).expect("every candidate has evidence")
        };
        Problem {
            evidence,
            goal: (choose.objective, choose.over),
            require: choose.require.iter().map(|r| (r.score, r.over, Ratio::of(r.at_least))).collect(),
            limits: SetLimits { at_most: choose.at_most, budget: choose.budget.map(Cost::thousandths) },
            cost: items.iter().map(cost).collect(),
            always: choose.always.iter().map(number).collect(),
            near: too_near(items, worlds, choose.apart_m),
            most: study
                .sensors
                .iter()
                .map(|sensor| sensor.terms.at_most.map_or(usize::MAX, |most| most as usize))
                .collect(),
            odds: Odds::of(study, choose, evidence),
        }
        .without_idle_odds()
    }

    /// Sums change labels, and of some scores labels are no part.
    fn without_idle_odds(mut self) -> Self {
        self.odds = self.odds.take().filter(|_| self.wanted().labels);
        self
    }

    /// Whether sets can be searched to the end: what any of them sees is a union, and at hand.
    pub(super) fn is_searchable(&self) -> bool {
        self.odds.is_none() && !self.evidence.is_filed()
    }

    /// Whether labels are sums of what sensors say.
    pub(super) fn adds_up(&self) -> bool {
        self.odds.is_some()
    }

    /// The same sets, by another score and without requirements.
    pub(super) fn asking(&self, score: Score, over: Across) -> Problem<'a> {
        Problem { goal: (score, over), require: Vec::new(), ..self.clone() }.without_idle_odds()
    }

    /// Whether a candidate may join some others, whatever it costs.
    pub(super) fn may_join(&self, chosen: &[usize], item: usize) -> bool {
        let sensor = self.evidence.items[item][0];
        let of_it = || chosen.iter().filter(|&&other| self.evidence.items[other][0] == sensor).count();
        chosen.iter().all(|&other| other != item && !self.are_near(other, item))
            && of_it() < self.most[sensor]
    }

    fn are_near(&self, a: usize, b: usize) -> bool {
        self.near.get(a).is_some_and(|near| near[b / 64] >> (b % 64) & 1 == 1)
    }

    /// What a set costs, in thousandths.
    pub(crate) fn cost_of(&self, set: &[usize]) -> u64 {
        set.iter().map(|&item| self.cost[item]).sum()
    }

    /// The largest amount below some cost, above zero, that a set may cost: all of them are multiples of one amount.
    pub(super) fn below(&self, cost: u64) -> u64 {
        let common = self.cost.iter().fold(0, |a, &b| greatest_common_divisor(a, b)).max(1);
        (cost - 1) / common * common
    }

    /// How many sensors a budget pays for at most.
    pub(super) fn most_affordable(&self, limits: SetLimits) -> usize {
        let rest = limits.budget.map(|budget| budget.saturating_sub(self.cost_of(&self.always)));
        let free = (0..self.cost.len()).filter(|item| !self.always.contains(item));
        match (rest, free.map(|item| self.cost[item]).min()) {
            (Some(rest), Some(least @ 1..)) => self.always.len() + (rest / least) as usize,
            _ => usize::MAX,
        }
    }

    /// Some candidates together.
    pub(super) fn joint(&self, set: &[usize]) -> Joint<'a> {
        if self.odds.is_some() {
            return Joint::Rows(set.iter().map(|&item| (item, self.evidence.row(item))).collect());
        }
        let mut union = self.evidence.nothing();
        set.iter().for_each(|&item| union.add(self.evidence, item));
        Joint::Union(union)
    }

    /// What a set counts, moment by moment: as [`CandidateEvidence::counts`] has it, unless sums of what its sensors say
    /// decide.
    pub fn counts(&self, set: &[usize]) -> Vec<Confusion> {
        self.counts_with(&self.joint(set), None, Wanted::ALL)
    }

    /// What a set is worth, whatever is required; `None` where it has no value.
    pub(super) fn worth_of(&self, set: &[usize]) -> Option<Worth> {
        self.merit(&self.joint(set), None).worth
    }

    /// What counts are asked for.
    pub(super) fn wanted(&self) -> Wanted {
        Wanted::of(std::iter::once(self.goal.0).chain(self.require.iter().map(|require| require.0)))
    }

    /// How good counts are.
    fn merit_of(&self, counts: &[Confusion]) -> Merit {
        let lacking = |&(score, over, least): &(Score, Across, Ratio)| match Worth::of(score, over, counts) {
            Some(worth) if worth.reaches(least) => 0.0,
            Some(worth) => (worth.value() - least.value()).min(-1e-12),
            None => -2.0,
        };
        let (score, over) = self.goal;
        Merit { lacking: self.require.iter().map(lacking).sum(), worth: Worth::of(score, over, counts) }
    }

    /// How good some candidates are together, with one more or as they are.
    pub(super) fn merit(&self, joint: &Joint, more: Option<(usize, &Row)>) -> Merit {
        self.merit_of(&self.counts_with(joint, more, self.wanted()))
    }

    fn counts_with(&self, joint: &Joint, more: Option<(usize, &Row)>, wanted: Wanted) -> Vec<Confusion> {
        match (joint, &self.odds) {
            (Joint::Union(union), _) => self.evidence.counts_of(union, more.map(|(_, row)| row), wanted),
            (Joint::Rows(rows), Some(odds)) => {
                let rows = rows.iter().map(|(item, row)| (*item, row)).chain(more);
                let planes = odds.fused(self.evidence, &rows.collect::<Vec<_>>());
                self.evidence.counts_of_planes(&planes, |_| &[], wanted)
            }
            (Joint::Rows(_), None) => unreachable!("rows are kept where they are added up"),
        }
    }

    /// What a set is worth, if it has a value and meets every requirement.
    pub(super) fn found(&self, set: &[usize]) -> Option<Found> {
        let merit = self.merit(&self.joint(set), None);
        let mut set = set.to_vec();
        set.sort_unstable();
        merit.worth.filter(|_| merit.meets_all()).map(|worth| Found { set, worth })
    }
}

impl Merit {
    /// Whether every requirement is met.
    pub(super) fn meets_all(&self) -> bool {
        self.lacking == 0.0
    }
}

/// Whether the scores that a study asks for can have a value in its region, and an exact one, before anything is cast.
///
/// # Errors
/// When one cannot, or the region has too many voxels.
pub fn examine(study: &Study, choose: &Choose, worlds: &[World]) -> Result<()> {
    let layout = BitLayout::new(study, worlds, choose.region);
    let sum = |of: fn(&MomentBits) -> u64| layout.moments.iter().map(of).sum::<u64>();
    let name = &study.regions[choose.region].0;
    let voxels: u64 = layout.moments.iter().flat_map(|moment| moment.voxels).sum();
    if voxels > MOST_VOXELS {
        let what = format!("has {voxels} voxels in all scenes, snapshots and repeats together");
        let cure = "at most 2147483648 can be told apart exactly: use larger voxels";
        return Err(Error::input(format!("region {name:?}"), what).cure(cure));
    }
    let lacking = |score: Score| match score {
        Score::F1 | Score::Kappa if sum(|moment| moment.voxels[0]) == 0 => Some("an occupied voxel"),
        Score::Kappa if sum(|moment| moment.voxels[1]) == 0 => Some("a free voxel"),
        Score::HumanSeen if layout.parts().next().is_none() => Some("a voxel of a person"),
        Score::PeopleDetected | Score::PartsDetected
            if !layout.parts().any(|part| part.voxels >= layout.min_hits()) =>
        {
            Some("min_hits voxels of a part of a person")
        }
        _ => None,
    };
    let scores = std::iter::once(("objective".to_string(), choose.objective));
    let required = choose.require.iter().enumerate();
    let scores = scores.chain(required.map(|(i, require)| (format!("require[{i}].score"), require.score)));
    for (key, score) in scores {
        if let Some(what) = lacking(score) {
            let place = format!("choose.{key} = {:?}", score.name());
            let why = format!("region {name:?} is without {what} in any scene, so there is no such score");
            return Err(Error::input(place, why).wanted("take another region or score").at(&study.path));
        }
    }
    Ok(())
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// For each candidate a bit for each that is too near in some world; nothing where none can be.
fn too_near(items: &[[usize; 2]], worlds: &[World], apart_m: f64) -> Vec<Vec<u64>> {
    if apart_m <= NEARLY_M {
        return Vec::new();
    }
    let mut near = vec![vec![0u64; items.len().div_ceil(64)]; items.len()];
    for (number, world) in worlds.iter().enumerate() {
        // Most worlds have their sensors where the one before had them.
        if number > 0 && world.settings == worlds[number - 1].settings {
            continue;
        }
        let place = |&[sensor, candidate]: &[usize; 2]| match world.settings[sensor][candidate] {
            Setting::Pose(pose) => Some(pose.position_m),
            _ => None,
        };
        let places: Vec<_> = items.iter().map(place).collect();
        for (a, at) in places.iter().enumerate() {
            let Some(at) = at else { continue };
            for (b, other) in places.iter().enumerate().filter(|(b, _)| *b != a) {
                if other.is_some_and(|other| at.distance(other) < apart_m - NEARLY_M) {
                    near[a][b / 64] |= 1 << (b % 64);
                }
            }
        }
    }
    near
}
