//! The question of a study as a problem for the solver, and why it may have no answer.

use super::layout::layout_of;
use super::pairs::{PairTerms, forbidden_pairs};
use perirobot_cover::layout::{MomentBits, WantedCounts};
use perirobot_cover::{
    CandidateEvidence, FrontAnswer, MOST_VOXELS, NoAnswer, Odds, Problem, Ratio, SetLimits, SetRules,
};
use perirobot_march::backend::Fusion;
use perirobot_march::error::Issue;
use perirobot_march::metrics::Score;
use perirobot_march::progress::{Progress, SearchState};
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choose, Study};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;

/// The region of a question, and the counts of its scores.
pub fn wanted_counts(choose: &Choose) -> (usize, WantedCounts) {
    let required = choose.require.iter().map(|require| require.score);
    (choose.region, WantedCounts::from_scores(std::iter::once(choose.objective).chain(required)))
}

/// The problem of a study that passed [`examine`].
pub fn problem_of<'a>(
    study: &Study,
    choose: &Choose,
    worlds: &[World],
    evidence: &'a CandidateEvidence,
) -> Problem<'a> {
    let items = &evidence.items;
    let terms = PairTerms { apart_m: choose.apart_m, disturb: choose.disturb };
    Problem {
        evidence,
        goal: (choose.objective, choose.over),
        require: choose.require.iter().map(|r| (r.score, r.over, Ratio::from_f64(r.at_least))).collect(),
        limits: SetLimits { at_most: choose.at_most, budget: choose.budget.map(Cost::thousandths) },
        rules: rules_of(study, items, worlds, &choose.always, terms),
        odds: odds_of(study, choose.fusion, &choose.representations, evidence),
    }
    .drop_idle_odds()
}

/// The log-odds of labels, from the representation of each sensor; `None` if unions decide.
pub(crate) fn odds_of(
    study: &Study,
    fusion: Fusion,
    representations: &[usize],
    evidence: &CandidateEvidence,
) -> Option<Odds> {
    let reading = |&[sensor, _]: &[usize; 2]| {
        let kind = &study.sensors[sensor].kind;
        (kind.speaks_last(), kind.log_odds(representations[sensor]))
    };
    match fusion {
        Fusion::Octomap => Odds::new(evidence.items.iter().map(reading).collect(), evidence),
        _ => None,
    }
}

/// Sensor and candidate of each candidate of a study, in study order.
pub(crate) fn candidates_of(study: &Study) -> Vec<[usize; 2]> {
    let sensors = study.sensors.iter().enumerate();
    sensors.flat_map(|(sensor, spec)| (0..spec.candidates.len()).map(move |c| [sensor, c])).collect()
}

/// The allowed pairs of candidates, by sensor and candidate, and their costs.
pub(crate) fn rules_of(
    study: &Study,
    items: &[[usize; 2]],
    worlds: &[World],
    always: &[[usize; 2]],
    terms: PairTerms,
) -> SetRules {
    let cost = |&[sensor, _]: &[usize; 2]| study.sensors[sensor].terms.cost.map_or(0, Cost::thousandths);
    let number = |wanted: &[usize; 2]| {
        items.iter().position(|item| item == wanted).expect("every candidate is among them")
    };
    let most = study.sensors.iter().map(|sensor| sensor.terms.at_most);
    SetRules {
        sensor: items.iter().map(|item| item[0]).collect(),
        cost: items.iter().map(cost).collect(),
        always: always.iter().map(number).collect(),
        near: forbidden_pairs(study, items, worlds, terms),
        most: most.map(|most| most.map_or(usize::MAX, |most| most as usize)).collect(),
    }
}

/// Checks before any cast that the scores of a study can have a value in its region, and an exact one.
///
/// # Errors
/// If one cannot, or if the region has too many voxels.
pub(super) fn examine(study: &Study, choose: &Choose, worlds: &[World]) -> Result<()> {
    let layout = layout_of(study, worlds, choose.region);
    let sum = |of: fn(&MomentBits) -> u64| layout.moments.iter().map(of).sum::<u64>();
    let name = &study.regions[choose.region].0;
    let voxels: u64 = layout.moments.iter().flat_map(|moment| moment.voxels).sum();
    if voxels > MOST_VOXELS {
        let what = format!("has {voxels} voxels in all scenes, snapshots and repeats together");
        let cure = "at most 2147483648 are exact: use larger voxels";
        return Err(Error::input(format!("region {name:?}"), what).cure(cure));
    }
    let lacking = |score: Score| match score {
        Score::F1 | Score::Kappa if sum(|moment| moment.voxels[0]) == 0 => Some("occupied voxel"),
        Score::Kappa if sum(|moment| moment.voxels[1]) == 0 => Some("free voxel"),
        Score::HumanSeen if layout.parts().next().is_none() => Some("voxel of a person"),
        Score::PeopleDetected | Score::PartsDetected
            if !layout.parts().any(|part| part.voxels >= layout.min_hits()) =>
        {
            Some("part of a person with min_hits voxels")
        }
        _ => None,
    };
    let scores = std::iter::once(("objective".to_string(), choose.objective));
    let required = choose.require.iter().enumerate();
    let scores = scores.chain(required.map(|(i, require)| (format!("require[{i}].score"), require.score)));
    for (key, score) in scores {
        let place = format!("choose.{key} = {:?}", score.name());
        if score == Score::SeenTwice {
            let why = "a search counts the union of a set's sensors, not the overlap of two";
            return Err(Error::input(place, why).cure("use another score, or require it with `[[require]]`"));
        }
        if let Some(what) = lacking(score) {
            let why = format!("region {name:?} has no {what} in any scene, so the score is undefined");
            return Err(Error::input(place, why)
                .with_advice("use another region or score")
                .with_place(&study.path));
        }
    }
    Ok(())
}

/// The best set of each size, and of each step of cost below the budget if there are costs.
///
/// # Errors
/// If no set meets the requirements; if evidence in a file cannot be read.
pub fn answer(problem: &Problem, progress: &dyn Progress) -> Result<FrontAnswer> {
    perirobot_cover::answer(problem, progress).map_err(|why| no_set(problem, why))
}

/// The remedy if no set is good enough.
const CURE: &str = "ask for less, or allow more: sensors, budget, or mounts nearer to each other";

fn no_set(problem: &Problem, why: NoAnswer) -> Error {
    match why {
        NoAnswer::Unread(error) => error,
        NoAnswer::Stopped => {
            Error::Stopped(Issue::says("no set that meets the requirements was found before the stop"))
        }
        NoAnswer::Required { number, best, is_proven } => {
            let (score, over, least) = problem.require[number];
            let (name, over, least) = (score.name(), over.name(), least.value());
            let most = best.map_or("has no value".into(), |best| {
                let known = if is_proven { "at most" } else { "in the best set found" };
                format!("is {:.4} {known}", best.value())
            });
            let none = if is_proven { "no allowed set reaches" } else { "no set was found that reaches" };
            Error::input(
                format!("choose.require[{number}]"),
                format!("{none} {name} {least} ({over}): it {most}"),
            )
            .cure(CURE)
        }
        NoAnswer::Together => {
            let what = match (problem.require.is_empty(), problem.is_searchable()) {
                (true, _) => "no allowed set has a value of the objective",
                (false, false) => "adding and swapping single sensors found no set that meets all of them",
                (false, true) => "each of them can be met, but no allowed set meets all of them",
            };
            let key = if problem.require.is_empty() { "choose.objective" } else { "choose.require" };
            Error::input(key, what).cure(CURE)
        }
    }
}

/// The progress of a search within some limits, in words: the best score, and its upper bound.
pub fn progress_of(state: &SearchState) -> String {
    let &SearchState { at_most, budget, best, bound, .. } = state;
    let cost = budget.map(Cost::from_thousandths).map(|budget| format!(" for {budget}"));
    let best = best.map_or("none found yet".into(), |best| format!("the best is {best:.4}"));
    let bound = bound.map(|bound| format!(", none is above {bound:.4}"));
    format!("sets of at most {at_most}{}: {best}{}", cost.unwrap_or_default(), bound.unwrap_or_default())
}

#[cfg(test)]
mod tests;
