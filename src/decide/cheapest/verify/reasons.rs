//! The text of reasons, made again without the search.

use super::counted::Bar;
use super::judged::{judge, restricted_study};
use super::ways::{FollowedWay, NearFacts};
use super::{ProofInput, open_oracle};
use crate::cheapest::passing::{left_out_of_all, living_members};
use crate::cheapest::reasons::{Obstacle, describe_demand};
use crate::cheapest::report::ReasonReport;
use crate::cheapest::terms::Terms;
use crate::choose::pose_name;
use crate::judge::Value;
use perirobot_march::metrics::Score;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Condition, Counted, Requirement};

/// Checks the text of the reasons why no set passes some terms; `place` is their path in the file.
///
/// # Errors
/// A wrong text, with the correct one.
pub(super) fn verify_words(
    (input, place): (ProofInput, &str),
    facts: &NearFacts,
    terms: &Terms,
    reasons: &[ReasonReport],
) -> Result<()> {
    for (number, reason) in reasons.iter().enumerate() {
        let named = terms.requirements.iter().filter(|one| one.name == reason.requirement);
        let words = |one| match reasons {
            [_] => words_of_one(input, facts, terms, one),
            _ => Ok(vec![describe_demand(input.study, one)]),
        };
        let possible: Vec<String> = named.map(words).collect::<Result<Vec<_>>>()?.concat();
        if !possible.contains(&reason.why) {
            let right = possible.join(", or ");
            let what = format!("is {:?}, but made again it is {right:?}", reason.why);
            return Err(Error::input(format!("{place}reasons[{number}].why"), what));
        }
    }
    Ok(())
}

/// The texts of a requirement that cannot be met alone. Some ways in may have been unknown at the time of writing, so
/// two texts may be correct.
fn words_of_one(
    input: ProofInput,
    facts: &NearFacts,
    terms: &Terms,
    requirement: &Requirement,
) -> Result<Vec<String>> {
    let only = Terms { requirements: vec![requirement.clone()], stopping: terms.stopping.clone() };
    let words = |obstacle: Obstacle| obstacle.words(input.study, terms.stopping.as_ref(), requirement);
    if let Some((at, _)) = facts.too_near_at_entry(input, &only) {
        let (body, entry) = (&at.passage.body, &at.passage.entry);
        return Ok(vec![words(Obstacle::Entry { body, entry, squared: at.squared })]);
    }
    let noticed_by = |way: &FollowedWay| way.noticed_by.iter().filter(|is| **is).count();
    let is_out_of_reach =
        |way: &&FollowedWay| facts.needed(input, &only, way).is_some_and(|least| least > noticed_by(way));
    let way = facts.ways.iter().find(is_out_of_reach).map(|way| {
        let (end_m, hidden_by) = facts.end_of(input, way);
        let (body, entry) = (&way.passage.body, &way.passage.entry);
        let (squared, noticed_by) = (way.squared, noticed_by(way));
        words(Obstacle::Way { body, entry, squared, end_m, hidden_by, noticed_by })
    });
    let rest = missed_by_all(input, requirement)?.unwrap_or(Obstacle::Unknown);
    Ok(way.into_iter().chain([words(rest)]).collect())
}

/// The score of all candidates together, or without as few as may be dead, if it misses a requirement of counts.
fn missed_by_all(input: ProofInput, requirement: &Requirement) -> Result<Option<Obstacle<'static>>> {
    let counted = requirement.counted_score().filter(|counted| counted.score != Score::SeenTwice);
    let Some(&Counted { score, over, region }) = counted else { return Ok(None) };
    let reach = input.reach((score, over, region), Bar::Keeps(requirement.limit), 0);
    let all: Vec<usize> = (0..input.items.len()).collect();
    for out in left_out_of_all(requirement, all.len()) {
        let set = living_members(&all, &out);
        let counts = match &reach {
            Some(reach) if !reach.adds_up => reach.counts_of_set(&set),
            _ => {
                let planned = Requirement { under: vec![Condition::AsPlanned], ..requirement.clone() };
                let study = restricted_study(input.study, vec![planned], None);
                judge(input, &study, &set, &open_oracle)?.counts.swap_remove(region)
            }
        };
        let value = Value::from_counts(score, over, &requirement.limit, &counts);
        if let Some(value) = value.filter(|value| !value.meets(&requirement.limit)) {
            let without = out.iter().map(|&item| pose_name(input.study, input.items[item])).collect();
            return Ok(Some(Obstacle::Counts { best: value.number(), without }));
        }
    }
    Ok(None)
}
