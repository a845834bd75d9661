//! The recommended choice of poses, the rule that selects it, and the drawn moment.

use super::judged::JudgedChoice;
use super::ranking::Ranking;
use super::{ReportedSweep, measure};
use crate::report::best_choice::AskedScore;
use crate::report::purchased;
use crate::report::series::{Series, worst_snapshot};
use crate::report::terminal::reasons::leader;
use perirobot_decide::cheapest::{AimReport, PurchaseReport, PurchasedSet};
use perirobot_decide::judge::{LeaderScope, cheapest, leaders};
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_study::input::{Counted, Requirement};
use perirobot_sweep::results::{Results, RowKey};

/// A choice of poses, and the region in which it is the best.
#[derive(Clone, Debug)]
pub(super) struct Recommended {
    /// The index of its ranking.
    pub(super) series: usize,
    pub(super) choice: usize,
    pub(super) region: usize,
    /// The score of its view.
    pub(super) score: Score,
    /// Its distinction and the rule, in words.
    pub(super) why: String,
    /// For each scene the moment with the worst score.
    pub(super) moments: Vec<usize>,
    /// The scene with the worst score.
    pub(super) scene: usize,
}

impl Recommended {
    /// Its poses, for a view.
    pub(super) fn choice(&self, rankings: &[Ranking]) -> Choice {
        let Series { combination, representation } = rankings[self.series].series;
        Choice { combination, choice: self.choice, representation, repeat: 0 }
    }

    /// Its combination, poses and representation, as in the columns of tables.
    pub(super) fn names(&self, results: &Results, rankings: &[Ranking]) -> [String; 3] {
        let series = rankings[self.series].series;
        let combination = &results.combinations[series.combination];
        [
            combination.name.clone(),
            combination.name_of(self.choice),
            combination.representations[series.representation].clone(),
        ]
    }
}

/// The recommended choice: the chosen cheapest set that passes, or comes nearest; else the cheapest judged choice that
/// meets all requirements; else the best of chosen sets; else the choice that meets the most requirements of the study
/// as planned; else the best by the score that the study asks for: body parts detected, without people F1. Of equal
/// ones it is that with the higher F1, then the first in the study. `None` if no choice has a score.
pub(super) fn recommend(
    sweep: &ReportedSweep,
    rankings: &[Ranking],
    judged: &[JudgedChoice],
) -> Result<Option<Recommended>> {
    let found = match recommend_purchased(sweep, rankings)
        .or_else(|| recommend_judged(sweep, rankings, judged))
        .or_else(|| recommend_chosen(sweep, rankings, judged))
    {
        Some(found) => Some(found),
        None if !sweep.study.requirements.is_empty() => recommend_required(sweep, rankings)?,
        None => None,
    };
    let found = match found {
        Some(found) => Some(found),
        None => recommend_scored(sweep, rankings)?,
    };
    let Some((series, choice, region, score, mut why)) = found else { return Ok(None) };
    if let Some(JudgedChoice { names: [_, poses, _], .. }) =
        judged.iter().find(|one| one.passes() && one.choice.is_none())
    {
        why += &format!(
            "; {poses}, which was judged, meets all requirements, but was not swept: make it a [[combination]] and sweep again to \
             see it here"
        );
    }
    let (moments, scene) = worst_moments(sweep, rankings[series].series.key(choice, region), score)?;
    Ok(Some(Recommended { series, choice, region, score, why, moments, scene }))
}

/// For each scene the moment with the worst score, and the scene with the worst of all.
///
/// # Errors
/// Those of a journal that cannot be read.
pub(super) fn worst_moments(sweep: &ReportedSweep, key: RowKey, score: Score) -> Result<(Vec<usize>, usize)> {
    let (mut moments, mut worst) = (Vec::new(), None);
    for (scene, of_scene) in sweep.results.scenes.iter().enumerate() {
        let snapshot = worst_snapshot(sweep.results, of_scene, key, score)?.unwrap_or(0);
        let moment = of_scene.moments.start + snapshot;
        moments.push(moment);
        let Some(over) = sweep.results.summarize(moment..moment + 1, key, score)? else { continue };
        let merit = score.merit(over.worst);
        if worst.is_none_or(|(_, least)| merit < least) {
            worst = Some((scene, merit));
        }
    }
    Ok((moments, worst.map_or(0, |(scene, _)| scene)))
}

/// Ranking, choice, region, score, and the reason.
type Found = (usize, usize, usize, Score, String);

/// The number of choices of poses.
fn count(results: &Results) -> usize {
    results.combinations.iter().map(|combination| combination.choices()).fold(0, usize::saturating_add)
}

/// The index of the ranking of a combination in a representation.
pub(super) fn series_of(rankings: &[Ranking], combination: usize, representation: usize) -> Option<usize> {
    rankings
        .iter()
        .position(|one| (one.series.combination, one.series.representation) == (combination, representation))
}

fn recommend_judged(sweep: &ReportedSweep, rankings: &[Ranking], judged: &[JudgedChoice]) -> Option<Found> {
    let passing: Vec<Choice> =
        judged.iter().filter(|one| one.passes()).filter_map(|one| one.choice).collect();
    let combinations: Vec<usize> = passing.iter().map(|choice| choice.combination).collect();
    let choice = passing[cheapest(sweep.study, &combinations)?];
    let series = series_of(rankings, choice.combination, choice.representation)?;
    let (region, score) = match sweep.chosen {
        Some(chosen) => (region_of(sweep, &chosen.asked.region)?, chosen.asked.objective),
        None => required_score(sweep),
    };
    let why = match (judged.len(), passing.len()) {
        (1, _) => "the choice that was judged, and meets all requirements".into(),
        (all, 1) => format!("the only one of {all} judged choices that meets all requirements"),
        (all, some) => format!("the cheapest of {some} of {all} judged choices that meet all requirements"),
    };
    Some((series, choice.choice, region, score, why))
}

pub(super) fn region_of(sweep: &ReportedSweep, region: &str) -> Option<usize> {
    sweep.results.regions.iter().position(|name| name == region)
}

/// The first required score, and its region; else F1.
fn required_score(sweep: &ReportedSweep) -> (usize, Score) {
    let counted = sweep.study.requirements.iter().find_map(Requirement::counted_score);
    counted.map_or((0, Score::F1), |counted| (counted.region, counted.score))
}

fn recommend_purchased(sweep: &ReportedSweep, rankings: &[Ranking]) -> Option<Found> {
    let report = sweep.purchase?;
    let combination = purchased_set(sweep, report.recommended()?)?;
    let series = series_of(rankings, combination, 0)?;
    let then = report.asked.then.as_ref();
    let decided = then.and_then(|then| {
        let (score, region) = then.counted()?;
        Some((region_of(sweep, region)?, score))
    });
    let (region, score) = decided.unwrap_or_else(|| required_score(sweep));
    Some((series, 0, region, score, describe_recommended(report)))
}

/// The distinction of the recommended set, in words.
fn describe_recommended(report: &PurchaseReport) -> String {
    let main = report.main();
    match (&main.set, &main.no_set_below) {
        (Some(_), _) if main.proven => "the cheapest set that passes all requirements".into(),
        (Some(_), Some(bound)) => {
            let bound = report.amount(*bound);
            format!("the cheapest set that was found to pass all requirements; none below {bound} passes")
        }
        (Some(_), None) => "the cheapest set that was found to pass all requirements".into(),
        (None, _) => match report.points.iter().find(|point| matches!(point.aim, AimReport::Nearest(_))) {
            Some(point) => {
                format!(
                    "the set that comes nearest: the cheapest for {}",
                    purchased::describe_aim(&point.aim)
                )
            }
            None => "the set that comes nearest".into(),
        },
    }
}

/// The combination of a set in the sweep.
pub(super) fn purchased_set(sweep: &ReportedSweep, set: &PurchasedSet) -> Option<usize> {
    sweep.results.combinations.iter().position(|one| one.name_of(0) == set.poses())
}

fn recommend_chosen(sweep: &ReportedSweep, rankings: &[Ranking], judged: &[JudgedChoice]) -> Option<Found> {
    let chosen = sweep.chosen?;
    let (best, combination) = (chosen.report.best()?, chosen.report.best_set()?);
    let series = rankings.iter().position(|one| one.series.combination == combination)?;
    let region = region_of(sweep, &chosen.asked.region)?;
    let proof = match best.proven {
        true => "no other set of the listed poses is better",
        false => "the best that was found; it is not proven",
    };
    let judged = match judged.len() {
        0 => String::new(),
        1 => "; the one choice that was judged misses a requirement".into(),
        all => format!("; none of the {all} judged choices meets all requirements"),
    };
    let why = format!("the best set of at most {} sensors: {proof}{judged}", best.at_most);
    Some((series, 0, region, chosen.asked.objective, why))
}

fn recommend_required(sweep: &ReportedSweep, rankings: &[Ranking]) -> Result<Option<Found>> {
    let required = &sweep.study.requirements;
    // A sweep has no approach distances.
    let Some(&Counted { region, score, .. }) = required.iter().find_map(Requirement::counted_score) else {
        return Ok(None);
    };
    let Some(Choice { combination, choice, representation, .. }) =
        leaders(required, sweep.results, 1, LeaderScope::default())?.pop()
    else {
        return Ok(None);
    };
    let series = series_of(rankings, combination, representation);
    let why = format!("the best of {} choices of poses by requirements met as planned", count(sweep.results));
    Ok(series.map(|series| (series, choice, region, score, why)))
}

fn recommend_scored(sweep: &ReportedSweep, rankings: &[Ranking]) -> Result<Option<Found>> {
    let results = sweep.results;
    let AskedScore { region, score, .. } = AskedScore::new(sweep.study, results);
    // A score that no choice has tells nothing.
    let mut tries = [(region, score)].into_iter().chain((0..results.regions.len()).map(|at| (at, Score::F1)));
    let found = tries.find_map(|(region, score)| match leader(results, region, score) {
        Ok(found) => found.map(|found| Ok((found, region, score))),
        Err(error) => Some(Err(error)),
    });
    let Some(([combination, choice, representation], region, score)) = found.transpose()? else {
        return Ok(None);
    };
    let words = match score {
        Score::F1 => "F1".to_string(),
        Score::PartsDetected => "body parts detected, then F1".into(),
        _ => format!("{}, then F1", measure::title(score)),
    };
    let (all, name) = (count(results), &results.regions[region]);
    let why = format!("the best of {all} choices of poses by {words}, in region {name}");
    let series = series_of(rankings, combination, representation);
    Ok(series.map(|series| (series, choice, region, score, why)))
}
