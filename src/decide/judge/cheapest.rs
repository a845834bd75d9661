//! The cheapest of some sets.

use perirobot_study::input::Study;
use perirobot_study::sensor::Cost;

/// The place of the cheapest of some combinations, given by their indices: the lowest cost if all sensors have a cost,
/// else the fewest sensors; the first of equals. `None` if there are none.
pub fn cheapest(study: &Study, combinations: &[usize]) -> Option<usize> {
    let sensors = |combination: usize| {
        let members = study.combinations[combination].members.iter();
        members.map(|member| study.sensors[member.sensor].terms.cost)
    };
    let cost = |&combination: &usize| {
        sensors(combination).try_fold(Cost::ZERO, |sum, cost| cost.map(|cost| sum.plus(cost)))
    };
    let costs: Option<Vec<u64>> = combinations.iter().map(|one| cost(one).map(Cost::thousandths)).collect();
    let count = |&combination: &usize| sensors(combination).count() as u64;
    let ranks = costs.unwrap_or_else(|| combinations.iter().map(count).collect());
    (0..ranks.len()).min_by_key(|&place| ranks[place])
}
