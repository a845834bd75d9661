//! Placed sensors that may disturb each other, by the rule of `[choose]`, or by that of lenses that face each other.

use perirobot_decide::choose::disturbing_pairs;
use perirobot_page::letters::letter;
use perirobot_study::input::{Disturb, Study, Wanted};
use perirobot_study::world::World;

/// Two placed sensors that may disturb each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisturbingPair {
    /// Their places in the plan.
    pub indexes: [usize; 2],
    /// In words, with what to do.
    pub words: String,
    /// Whether `disturb` of `[choose]` forbids them together.
    pub is_forbidden: bool,
}

/// The rule of the study, if it has one.
fn rule(study: &Study) -> Option<Disturb> {
    match study.choose.as_ref()? {
        Wanted::Best(choose) => choose.disturb,
        Wanted::Cheapest(purchase) => purchase.disturb,
    }
}

/// Those of some members, each with its place in the plan.
pub(super) fn disturbing(
    study: &Study,
    worlds: &[World],
    placed: &[(usize, [usize; 2])],
) -> Vec<DisturbingPair> {
    let own = rule(study);
    // What two sensors see together disturbs only by a limit, which a study must write.
    let rule = own.unwrap_or_default();
    let members: Vec<[usize; 2]> = placed.iter().map(|(_, member)| *member).collect();
    let describe = |pair: [usize; 2]| {
        let indexes = pair.map(|place| placed[place].0);
        let [one, other] = indexes.map(letter);
        let light = study.sensors[members[pair[0]][0]].emits.as_deref().unwrap_or_default();
        let why = match own {
            Some(_) => "disturb of [choose] forbids them together",
            None => "each is in the other's field of view",
        };
        let words = format!(
            "{one} and {other} may disturb each other: both emit {light:?}, and {why}. Synchronise them, or turn one away"
        );
        DisturbingPair { indexes, words, is_forbidden: own.is_some() }
    };
    disturbing_pairs(study, worlds, &members, rule).into_iter().map(describe).collect()
}
