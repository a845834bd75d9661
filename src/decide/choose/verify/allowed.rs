//! Whether a set is one that a study allows, judged from the study.

use crate::choose::problem::candidates_of;
use crate::choose::report::SetReport;
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_study::sensor::{Cost, Setting};
use perirobot_study::study::{Choose, Study};
use perirobot_study::world::World;

pub(super) fn name(study: &Study, [sensor, candidate]: [usize; 2]) -> String {
    let sensor = &study.sensors[sensor];
    format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
}

/// Sensors and candidates by their names.
pub(super) fn find_named(study: &Study, poses: &[String]) -> Result<Vec<[usize; 2]>, Issue> {
    let one = |pose: &String| {
        let mut all = candidates_of(study).into_iter();
        all.find(|&item| name(study, item) == *pose)
            .ok_or_else(|| Issue::says(format!("{pose:?} is no pose of the study")))
    };
    poses.iter().map(one).collect()
}

/// Why a set that is told within some limits is not allowed.
pub(super) fn not_allowed(
    study: &Study,
    choose: &Choose,
    worlds: &[World],
    (at_most, budget, told): (usize, Option<Cost>, &SetReport),
    set: &[[usize; 2]],
) -> Option<String> {
    let cost: u64 = set.iter().map(|&[sensor, _]| thousandths(study, sensor)).sum();
    let is_priced = set.iter().all(|&[sensor, _]| study.sensors[sensor].terms.cost.is_some());
    if told.cost.map(Cost::thousandths) != Some(cost).filter(|_| is_priced) {
        return Some(format!("costs {}, not what is said", Cost::from_thousandths(cost)));
    }
    if budget.is_some_and(|budget| cost > budget.thousandths()) {
        return Some("costs more than the budget of its step".into());
    }
    if at_most > choose.at_most || choose.budget.is_some_and(|budget| cost > budget.thousandths()) {
        return Some("is beyond what the study allows".into());
    }
    if set.len() > at_most || set.is_empty() {
        return Some(format!("has {} sensors, and at most {} are allowed", set.len(), at_most));
    }
    if let Some(missing) = choose.always.iter().find(|always| !set.contains(always)) {
        return Some(format!("lacks {}, which is in every set", name(study, *missing)));
    }
    clash(study, choose, worlds, set)
}

pub(super) fn thousandths(study: &Study, sensor: usize) -> u64 {
    study.sensors[sensor].terms.cost.map_or(0, Cost::thousandths)
}

/// Why some candidates cannot be in a set together.
pub(super) fn clash(study: &Study, choose: &Choose, worlds: &[World], set: &[[usize; 2]]) -> Option<String> {
    for (number, &a) in set.iter().enumerate() {
        let most = study.sensors[a[0]].terms.at_most.map_or(usize::MAX, |most| most as usize);
        if set.iter().filter(|other| other[0] == a[0]).count() > most {
            return Some(format!("has more of {:?} than the sensor's at_most", study.sensors[a[0]].name));
        }
        for &b in &set[number + 1..] {
            if a == b {
                return Some(format!("has {} twice", name(study, a)));
            }
            if choose.always.contains(&a) && choose.always.contains(&b) {
                continue;
            }
            let near = worlds.iter().any(|world| {
                let setting = |[sensor, candidate]: [usize; 2]| world.settings[sensor][candidate];
                match (setting(a), setting(b)) {
                    (Setting::Pose(a), Setting::Pose(b)) => {
                        a.position_m.distance(b.position_m) < choose.apart_m - 1e-9
                    }
                    _ => false,
                }
            });
            if near {
                return Some(format!("has {} and {} nearer than apart_m", name(study, a), name(study, b)));
            }
        }
    }
    None
}
