//! The choices of a sweep that meet most requirements as planned.

use std::cmp::Ordering;
use std::path::Path;

use super::cases::counts;
use super::value::Value;
use super::verdict::counted_value;
use crate::choose::Chosen;
use crate::purchased_sets::are_results_of_purchase;
use crate::view::Choice;
use crate::view::names::unknown;
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::metrics::Score;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Counted, Limit, Requirement};
use perirobot_sweep::results::{Results, RowKey};

/// A filter of choices.
#[derive(Clone, Copy, Debug, Default)]
pub struct LeaderScope<'a> {
    /// This combination; all if `None`.
    pub combination: Option<&'a str>,
    /// This representation; the first of each combination if `None`.
    pub representation: Option<&'a str>,
}

/// A choice with its values, one for each requirement on counts.
type Valued = (Choice, Vec<Option<Value>>);

/// The sets in a folder of results, if `choose` wrote them: the best by a score, or the cheapest that pass.
///
/// # Errors
/// Those of [`Chosen::read`], and of `cheapest.json`.
pub fn chosen_sets(folder: &Path, results: &Results) -> Result<Option<Vec<Choice>>> {
    let of_set = |combination| Choice { combination, choice: 0, representation: 0, repeat: 0 };
    let is_chosen = Chosen::read(folder)?.is_some_and(|chosen| chosen.is_of(results))
        || are_results_of_purchase(folder, results)?;
    Ok(is_chosen.then(|| (0..results.combinations.len()).map(of_set).collect()))
}

/// The choices that meet most requirements as planned, this many, best first. Among choices that meet equally many, the
/// one that is better by the first requirement comes first, then by the next, then by F1, then in study order. Only
/// requirements on scores of a sweep count.
///
/// # Errors
/// If no requirement has such a score; if a name is unknown; those of [`Results::counts`].
pub fn leaders(
    requirements: &[Requirement],
    results: &Results,
    count: usize,
    among: LeaderScope,
) -> Result<Vec<Choice>> {
    let requirements: Vec<(&Requirement, &Counted)> =
        requirements.iter().filter_map(|one| Some((one, one.counted_score()?))).collect();
    if requirements.is_empty() {
        let what = "no requirement has a score that a sweep counts, so choices cannot be ranked";
        return Err(
            Error::from(Issue::says(what)).with_advice(Words::from("choose one with ") + Argument("pose"))
        );
    }
    let mut all: Vec<Valued> = Vec::new();
    for (combination, representation) in scope_numbers(results, among)? {
        for choice in 0..results.combinations[combination].choices() {
            let choice = Choice { combination, choice, representation, repeat: 0 };
            let value = |&(requirement, counted): &(&Requirement, &Counted)| {
                Ok(counted_value(requirement, counted, &counts(results, &choice, counted.region)?))
            };
            all.push((choice, requirements.iter().map(value).collect::<Result<_>>()?));
        }
    }
    let met = |(_, values): &Valued| {
        let each = requirements.iter().zip(values);
        each.filter(|((requirement, _), value)| {
            value.as_ref().is_some_and(|value| value.meets(&requirement.limit))
        })
        .count()
    };
    let better = |a: &Valued, b: &Valued| {
        let each = requirements.iter().zip(&a.1).zip(&b.1);
        each.map(|(((requirement, _), a), b)| better(&requirement.limit, a, b)).find(|order| order.is_ne())
    };
    all.sort_by(|a, b| met(b).cmp(&met(a)).then_with(|| better(a, b).unwrap_or(Ordering::Equal)));
    // Only ties that reach into what is taken are decided by F1.
    let equal = |a: &Valued, b: &Valued| met(a) == met(b) && better(a, b).is_none();
    let last = all.get(count.min(all.len()).saturating_sub(1));
    let end = last.map_or(0, |last| all.iter().rposition(|one| equal(one, last)).map_or(0, |at| at + 1));
    let region = requirements[0].1.region;
    let f1 = |(choice, _): &Valued| {
        let &Choice { combination, choice, representation, .. } = choice;
        let key = RowKey { combination, choice, representation, region };
        let over = results.summarize(results.moments(), key, Score::F1)?;
        Ok(over.map_or(f64::NEG_INFINITY, |over| over.mean))
    };
    let f1: Vec<f64> = all[..end].iter().map(f1).collect::<Result<_>>()?;
    let mut order: Vec<usize> = (0..end).collect();
    order.sort_by(|&a, &b| match equal(&all[a], &all[b]) {
        true => f1[b].total_cmp(&f1[a]),
        false => a.cmp(&b),
    });
    Ok(order.into_iter().take(count).map(|place| all[place].0).collect())
}

/// Compares two values, the better one first; a missing value is the worst.
fn better(limit: &Limit, a: &Option<Value>, b: &Option<Value>) -> Ordering {
    match (a, b, limit) {
        (Some(a), Some(b), Limit::AtLeast(_)) => b.cmp(a),
        (Some(a), Some(b), Limit::AtMost(_)) => a.cmp(b),
        _ => b.is_some().cmp(&a.is_some()),
    }
}

/// Combinations and representations by their indices.
fn scope_numbers(results: &Results, among: LeaderScope) -> Result<Vec<(usize, usize)>> {
    let known: Vec<&str> = results.combinations.iter().map(|one| one.name.as_str()).collect();
    if let Some(name) = among.combination.filter(|name| !known.contains(name)) {
        return Err(unknown(Argument("combination"), Some(name), &known));
    }
    let combinations = (0..known.len()).filter(|&c| among.combination.is_none_or(|name| known[c] == name));
    let representations = |combination: usize| {
        let names = &results.combinations[combination].representations;
        let wanted = |name: &str| names.iter().position(|known| known == name);
        Some((combination, among.representation.map_or(Some(0), wanted)?))
    };
    let found: Vec<(usize, usize)> = combinations.clone().filter_map(representations).collect();
    if found.is_empty() {
        let names = combinations.flat_map(|c| &results.combinations[c].representations);
        return Err(unknown(Argument("representation"), among.representation, &names.collect::<Vec<_>>()));
    }
    Ok(found)
}
