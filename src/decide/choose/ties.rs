//! Sets that are nearly as good as the best one, but different: their mounts may be easier.

use rayon::prelude::*;

use perirobot_cover::{FoundSet, FrontAnswer, FrontStep, JointCandidates, Problem};
use perirobot_study::sensor::Setting;
use perirobot_study::world::World;

/// A set is nearly as good as another if it has this share of its score.
const NEARLY: f64 = 0.99;
/// The most sets reported.
const MOST_TIES: usize = 3;

/// Sensor and mount of each sensor of a set: sets with the same answer count as equal.
type Mounts = Vec<(usize, [u64; 3])>;

/// The best of the sets that are nearly as good as the best one of a step and have a sensor at another mount, each with
/// different mounts. Candidates are the sets judged during the search, and those that differ from the best one in one
/// sensor.
pub(super) fn ties(
    problem: &Problem,
    worlds: &[World],
    step: &FrontStep,
    answer: &FrontAnswer,
) -> Vec<FoundSet> {
    let Some(best) = &step.best else { return Vec::new() };
    let is_near = |found: &FoundSet| {
        let fits = found.set.len() <= step.limits.at_most;
        fits && step.limits.afford(problem.rules.cost_of(&found.set))
            && found.worth.value() >= NEARLY * best.worth.value()
    };
    let mut near: Vec<FoundSet> = answer.others.iter().filter(|found| is_near(found)).cloned().collect();
    near.extend(swaps(problem, &best.set).into_iter().filter(is_near));
    near.sort_by(|a, b| b.worth.cmp(&a.worth).then(a.set.cmp(&b.set)));
    let mut shown = vec![mounts(problem, &worlds[0], &best.set)];
    near.retain(|found| {
        let mounts = mounts(problem, &worlds[0], &found.set);
        let is_new = shown.len() <= MOST_TIES && !shown.contains(&mounts);
        if is_new {
            shown.push(mounts);
        }
        is_new
    });
    near
}

/// All allowed sets that replace one candidate by another.
fn swaps(problem: &Problem, set: &[usize]) -> Vec<FoundSet> {
    let free: Vec<usize> = set.iter().copied().filter(|item| !problem.rules.always.contains(item)).collect();
    let without = |&left: &usize| {
        let rest: Vec<usize> = set.iter().copied().filter(|&item| item != left).collect();
        let joint = problem.joint(&rest);
        (left, rest, joint)
    };
    let all: Vec<_> = free.iter().map(without).collect();
    let with = |item: usize| {
        let row = problem.evidence.row(item);
        let joins = |(left, rest, _): &&(usize, Vec<usize>, JointCandidates)| {
            item != *left && problem.rules.may_join(rest, item)
        };
        let found = |(_, rest, joint): &(usize, Vec<usize>, JointCandidates)| {
            let merit = problem.merit(joint, Some((item, &row)));
            let mut set = [&rest[..], &[item]].concat();
            set.sort_unstable();
            merit.worth.filter(|_| merit.meets_all()).map(|worth| FoundSet { set, worth })
        };
        all.iter().filter(joins).filter_map(found).collect::<Vec<FoundSet>>()
    };
    (0..problem.evidence.count()).into_par_iter().flat_map_iter(with).collect()
}

fn mounts(problem: &Problem, world: &World, set: &[usize]) -> Mounts {
    let mount = |&item: &usize| {
        let [sensor, candidate] = problem.evidence.items[item];
        match world.settings[sensor][candidate] {
            Setting::Pose(pose) => (sensor, pose.position_m.to_array().map(f64::to_bits)),
            _ => (sensor, [candidate as u64; 3]),
        }
    };
    let mut mounts: Mounts = set.iter().map(mount).collect();
    mounts.sort_unstable();
    mounts
}
