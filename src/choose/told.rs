//! An answer in names and numbers: the front, what each sensor of a set is worth, and sets that are nearly as
//! good but look different. Tables, texts and files are made from it.

use super::front::Answer;
use super::problem::{Found, Problem};
use super::within::{Bound, FrontStep};
use super::worth::Worth;
use crate::results::columns::BETWEEN_MEMBERS;
use crate::sensor::{Cost, Setting};
use crate::study::Study;
use crate::world::World;
use crate::world::place::Places;

/// A set is nearly as good as another if it has this share of its score.
const NEARLY: f64 = 0.99;
/// Sets that are nearly as good and are told.
const MOST_TIES: usize = 3;

/// A set in names and numbers.
#[derive(Clone, Debug)]
pub struct ToldSet {
    /// Candidates by their numbers in the evidence.
    pub set: Vec<usize>,
    /// As in the columns `poses` of a sweep: `camera:wall/8/1;lidar:corners/0/0`.
    pub names: String,
    /// Its sensors.
    pub members: Vec<ToldMember>,
    /// What it costs, if the sensors have costs.
    pub cost: Option<Cost>,
    /// Its score.
    pub worth: Worth,
}

/// A sensor of a set.
#[derive(Clone, Debug)]
pub struct ToldMember {
    /// The sensor's name.
    pub sensor: String,
    /// The pose's name.
    pub pose: String,
    /// Where that is, in words.
    pub place: String,
    /// What it costs.
    pub cost: Option<Cost>,
    /// The score of the set without it, if that has one.
    pub without: Option<f64>,
}

/// A step of the front.
#[derive(Clone, Debug)]
pub struct ToldStep {
    /// How many sensors were allowed.
    pub at_most: usize,
    /// What the set could cost at most.
    pub budget: Option<Cost>,
    /// The best set that was found.
    pub best: ToldSet,
    /// What no set within these limits is worth more than.
    pub bound: Bound,
    /// By how much the score is above that of the best set of fewer sensors that costs no more, if there is
    /// one.
    pub gain: Option<f64>,
}

/// The whole answer.
#[derive(Clone, Debug)]
pub struct Told {
    /// The front: by size, and of each size from the dearest set down. Below the dearest, sets that are no
    /// better than a smaller one that costs no more are left out.
    pub steps: Vec<ToldStep>,
    /// Sets nearly as good as the best one, with at least one sensor somewhere else, the best first.
    pub ties: Vec<ToldSet>,
}

impl Told {
    /// The step of the best set: that of the most sensors and the largest budget.
    pub(crate) fn best(&self) -> Option<&ToldStep> {
        let most = self.steps.iter().map(|step| step.at_most).max()?;
        self.steps.iter().find(|step| step.at_most == most)
    }

    /// Tells an answer.
    pub fn of(study: &Study, worlds: &[World], problem: &Problem, answer: &Answer) -> Told {
        let teller = Teller { study, problem, places: Places::of(study, &worlds[0]), world: &worlds[0] };
        let worth_telling = |(number, step): &(usize, &FrontStep)| {
            let is_first = *number == 0 || answer.steps[number - 1].limits.at_most != step.limits.at_most;
            is_first || (!answer.complete && step.bound != Bound::Proven) || !teller.is_known(step, answer)
        };
        let steps = answer.steps.iter().enumerate().filter(worth_telling);
        let steps: Vec<ToldStep> = steps.filter_map(|(_, step)| teller.step(step, answer)).collect();
        // Of the steps of a size the first has the whole budget.
        let most = answer.steps.iter().map(|step| step.limits.at_most).max();
        let best = answer.steps.iter().find(|step| Some(step.limits.at_most) == most);
        let ties = best.map_or(Vec::new(), |step| teller.ties(step, answer));
        Told { steps, ties }
    }
}

struct Teller<'a> {
    study: &'a Study,
    problem: &'a Problem<'a>,
    places: Places<'a>,
    world: &'a World,
}

impl Teller<'_> {
    /// Whether fewer sensors that cost no more are as good.
    fn is_known(&self, step: &FrontStep, answer: &Answer) -> bool {
        let Some(best) = &step.best else { return true };
        let cost = self.problem.cost_of(&best.set);
        answer.steps.iter().filter(|other| other.limits.at_most < step.limits.at_most).any(|other| {
            let other = other.best.as_ref();
            other.is_some_and(|other| other.worth >= best.worth && self.problem.cost_of(&other.set) <= cost)
        })
    }

    fn step(&self, step: &FrontStep, answer: &Answer) -> Option<ToldStep> {
        let best = step.best.as_ref()?;
        let cost = self.problem.cost_of(&best.set);
        let smaller = answer.steps.iter().filter(|other| other.limits.at_most < step.limits.at_most);
        let smaller = smaller.filter_map(|other| other.best.as_ref());
        let before =
            smaller.filter(|other| self.problem.cost_of(&other.set) <= cost).map(|other| other.worth).max();
        Some(ToldStep {
            at_most: step.limits.at_most,
            budget: step.limits.budget.map(Cost::from_thousandths),
            best: self.set(best),
            bound: step.bound,
            gain: before.map(|before| best.worth.value() - before.value()),
        })
    }

    fn set(&self, found: &Found) -> ToldSet {
        let members: Vec<ToldMember> = found.set.iter().map(|&item| self.member(item, &found.set)).collect();
        let names: Vec<String> = members.iter().map(|one| format!("{}:{}", one.sensor, one.pose)).collect();
        let priced = members.iter().all(|member| member.cost.is_some());
        ToldSet {
            set: found.set.clone(),
            names: names.join(BETWEEN_MEMBERS),
            cost: priced.then(|| Cost::from_thousandths(self.problem.cost_of(&found.set))),
            worth: found.worth,
            members,
        }
    }

    fn member(&self, item: usize, set: &[usize]) -> ToldMember {
        let [sensor, candidate] = self.problem.evidence.items[item];
        let spec = &self.study.sensors[sensor];
        let others: Vec<usize> = set.iter().copied().filter(|&other| other != item).collect();
        ToldMember {
            sensor: spec.name.clone(),
            pose: spec.candidates[candidate].name.clone(),
            place: self.places.words(sensor, candidate),
            cost: spec.terms.cost,
            without: self.problem.worth_of(&others).map(Worth::value),
        }
    }

    /// Where a candidate is: two with the same answer share their mount.
    fn mount(&self, item: usize) -> (usize, [u64; 3]) {
        let [sensor, candidate] = self.problem.evidence.items[item];
        match self.world.settings[sensor][candidate] {
            Setting::Pose(pose) => (sensor, pose.position_m.to_array().map(f64::to_bits)),
            _ => (sensor, [candidate as u64; 3]),
        }
    }

    fn mounts(&self, set: &[usize]) -> Vec<(usize, [u64; 3])> {
        let mut mounts: Vec<_> = set.iter().map(|&item| self.mount(item)).collect();
        mounts.sort_unstable();
        mounts
    }

    fn ties(&self, step: &FrontStep, answer: &Answer) -> Vec<ToldSet> {
        let Some(best) = &step.best else { return Vec::new() };
        let near = |found: &&Found| {
            let fits = found.set.len() <= step.limits.at_most;
            fits && step.limits.afford(self.problem.cost_of(&found.set))
                && found.worth.value() >= NEARLY * best.worth.value()
        };
        let mut all: Vec<&Found> = answer.others.iter().filter(near).collect();
        all.sort_by(|a, b| b.worth.cmp(&a.worth).then(a.set.cmp(&b.set)));
        let mut shown = vec![self.mounts(&best.set)];
        let mut ties = Vec::new();
        for found in all {
            let mounts = self.mounts(&found.set);
            if ties.len() < MOST_TIES && !shown.contains(&mounts) {
                shown.push(mounts);
                ties.push(self.set(found));
            }
        }
        ties
    }
}
