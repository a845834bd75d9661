//! Whether the latches of a choice hold, for verdicts that count people in their zones as detected.

use std::collections::{BTreeMap, BTreeSet};

use super::ground::Ground;
use super::moments::at_once;
use crate::view::Choice;
use crate::view::watched::Watchers;
use perirobot_march::Result;
use perirobot_study::input::Study;

/// A sentence for each sensor of a choice that latches, where no approach is asked that could prove its latch.
pub(crate) fn unproven_latches(study: &Study, choice: &Choice) -> Vec<String> {
    let watchers = Watchers::new(study, *choice);
    let sentence = |sensor| {
        format!(
            "sensor {:?}: its latch is not proven: verdicts count people in its zone as detected, which holds only if nobody gets \
             in without tripping it; require nearest_unnoticed_m, or run perirobot approach",
            watchers.name(sensor)
        )
    };
    watchers.latching().into_iter().map(sentence).collect()
}

/// A sentence for each sensor of a choice that latches and into whose zone a body gets without tripping it. `grounds` are the
/// scenes in which approaches are asked.
///
/// # Errors
/// When a snapshot has no hazard.
pub(crate) fn passed_latches(study: &Study, choice: &Choice, grounds: &[Ground]) -> Result<Vec<String>> {
    let watchers = Watchers::new(study, *choice);
    if watchers.latching().is_empty() {
        return Ok(Vec::new());
    }
    let mut passed: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for ground in grounds {
        for answer in at_once(ground, ground.worlds, &watchers)? {
            let way = || {
                let [body, entry] =
                    [&ground.bodies[answer.body].name, &study.approach.entries[answer.entry].name];
                format!("{body} from {entry}")
            };
            let through = answer.latches.iter().filter(|(_, is_passed)| *is_passed);
            through.for_each(|(sensor, _)| {
                passed.entry(sensor.clone()).or_default().insert(way());
            });
        }
    }
    let sentence = |(sensor, ways): (String, BTreeSet<String>)| {
        let ways: Vec<String> = ways.into_iter().collect();
        format!(
            "sensor {sensor:?}: its latch does not hold: without tripping it people get into its zone ({}), and verdicts count \
             people there as detected all the same",
            ways.join(", ")
        )
    };
    Ok(passed.into_iter().map(sentence).collect())
}
