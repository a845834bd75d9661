//! Whether a study allows a set.

use super::disturbed::DisturbedPairs;
use crate::choose::problem::candidates_of;
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_study::input::{Choose, Study};
use perirobot_study::sensor::{Cost, Setting};
use perirobot_study::world::World;

pub(crate) fn pose_name(study: &Study, [sensor, candidate]: [usize; 2]) -> String {
    let sensor = &study.sensors[sensor];
    format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
}

/// Sensors and candidates by their names.
pub(crate) fn find_named(study: &Study, poses: &[String]) -> Result<Vec<[usize; 2]>, Issue> {
    let one = |pose: &String| {
        let mut all = candidates_of(study).into_iter();
        all.find(|&item| pose_name(study, item) == *pose)
            .ok_or_else(|| Issue::says(format!("{pose:?} is not a pose of the study")))
    };
    poses.iter().map(one).collect()
}

/// The rules of a study for sets.
#[derive(Clone, Copy)]
pub(crate) struct AllowedSets<'a> {
    pub(crate) study: &'a Study,
    pub(crate) worlds: &'a [World],
    pub(crate) at_most: usize,
    pub(crate) budget: Option<Cost>,
    pub(crate) always: &'a [[usize; 2]],
    pub(crate) apart_m: f64,
    pub(crate) disturbed: &'a DisturbedPairs,
}

impl<'a> AllowedSets<'a> {
    pub(super) fn from_choose(
        study: &'a Study,
        (choose, disturbed): (&'a Choose, &'a DisturbedPairs),
        worlds: &'a [World],
    ) -> AllowedSets<'a> {
        let Choose { at_most, budget, ref always, apart_m, .. } = *choose;
        AllowedSets { study, worlds, at_most, budget, always, apart_m, disturbed }
    }

    /// Why a set with a claimed cost is not allowed within some limits.
    pub(crate) fn not_allowed(
        &self,
        (at_most, budget): (usize, Option<Cost>),
        claimed: Option<Cost>,
        set: &[[usize; 2]],
    ) -> Option<String> {
        let study = self.study;
        let cost: u64 = set.iter().map(|&[sensor, _]| thousandths(study, sensor)).sum();
        let is_priced = set.iter().all(|&[sensor, _]| study.sensors[sensor].terms.cost.is_some());
        if claimed.map(Cost::thousandths) != Some(cost).filter(|_| is_priced) {
            return Some(format!("costs {}, not the stated amount", Cost::from_thousandths(cost)));
        }
        if budget.is_some_and(|budget| cost > budget.thousandths()) {
            return Some("costs more than the budget of its step".into());
        }
        if at_most > self.at_most || self.budget.is_some_and(|budget| cost > budget.thousandths()) {
            return Some("exceeds the limits of the study".into());
        }
        if set.len() > at_most || set.is_empty() {
            return Some(format!("has {} sensors, but at most {} are allowed", set.len(), at_most));
        }
        if let Some(missing) = self.always.iter().find(|always| !set.contains(always)) {
            return Some(format!("lacks {}, which is in every set", pose_name(study, *missing)));
        }
        self.clash(set)
    }

    /// Why some candidates cannot be in a set together.
    pub(crate) fn clash(&self, set: &[[usize; 2]]) -> Option<String> {
        let AllowedSets { study, worlds, always, apart_m, disturbed, .. } = *self;
        for (number, &a) in set.iter().enumerate() {
            let most = study.sensors[a[0]].terms.at_most.map_or(usize::MAX, |most| most as usize);
            if set.iter().filter(|other| other[0] == a[0]).count() > most {
                return Some(format!("has more of {:?} than the sensor's at_most", study.sensors[a[0]].name));
            }
            for &b in &set[number + 1..] {
                if a == b {
                    return Some(format!("has {} twice", pose_name(study, a)));
                }
                if always.contains(&a) && always.contains(&b) {
                    continue;
                }
                let near = worlds.iter().any(|world| {
                    let setting = |[sensor, candidate]: [usize; 2]| world.settings[sensor][candidate];
                    match (setting(a), setting(b)) {
                        (Setting::Pose(a), Setting::Pose(b)) => {
                            a.position_m.distance(b.position_m) < apart_m - 1e-9
                        }
                        _ => false,
                    }
                });
                if near {
                    return Some(format!(
                        "has {} and {} nearer than apart_m",
                        pose_name(study, a),
                        pose_name(study, b)
                    ));
                }
                if disturbed.has(a, b) {
                    let [a, b] = [a, b].map(|item| pose_name(study, item));
                    return Some(format!("has {a} and {b}, which disturb each other"));
                }
            }
        }
        None
    }
}

pub(crate) fn thousandths(study: &Study, sensor: usize) -> u64 {
    study.sensors[sensor].terms.cost.map_or(0, Cost::thousandths)
}
