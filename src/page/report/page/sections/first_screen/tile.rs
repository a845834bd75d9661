//! The large numbers, with their bounds.

use maud::{Markup, html};

use crate::report::page::measure::percent;
use crate::report::page::ranking::Ranking;
use crate::report::page::recommended::Recommended;
use crate::report::page::{ReportedSweep, measure};
use crate::report::table::number;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_study::input::Study;
use perirobot_study::sensor::Cost;
use perirobot_sweep::results::Over;

/// A large number.
#[derive(Debug)]
pub(super) struct BigNumber {
    name: String,
    value: String,
    /// The meaning of the number.
    meaning: String,
    /// The worst of all moments, and the upper bound.
    notes: Vec<String>,
}

impl BigNumber {
    /// The tile as an entry of a list.
    pub(super) fn view(&self) -> Markup {
        html! {
            div {
                dt { (self.name) }
                dd {
                    strong { (self.value) }
                    span { (self.meaning) }
                    @for note in &self.notes { span { (note) } }
                }
            }
        }
    }
}

/// The large numbers: what the study requires; with people in the region their detection, else agreement unless something
/// is required; and the unwatched floor of the first plan.
pub(super) fn tiles(
    sweep: &ReportedSweep,
    rankings: &[Ranking],
    recommended: &Recommended,
    floor_m2: [f64; 3],
) -> Result<Vec<BigNumber>> {
    let results = sweep.results;
    let key = rankings[recommended.series].series.key(recommended.choice, recommended.region);
    let own = measure::choice_measures(results, results.moments(), key)?;
    let place = |score: Score| Score::ALL.iter().position(|known| *known == score).unwrap_or_default();
    let mean = |score: Score| own[place(score)];
    let required = &sweep.study.requirements;
    let in_region = required.iter().filter_map(|one| one.counted_score());
    let in_region = in_region.filter(|counted| counted.region == recommended.region);
    let mut shown: Vec<Score> = in_region.map(|counted| counted.score).collect();
    shown.extend(match mean(Score::PeopleDetected) {
        Some(_) => vec![Score::PeopleDetected, Score::PartsDetected],
        None if required.is_empty() => vec![Score::F1, Score::Kappa],
        None => Vec::new(),
    });
    shown.extend([Score::Unknown, Score::FalseAlarm]);
    let mut each: Vec<Score> = Vec::new();
    for score in shown {
        if !each.contains(&score) {
            each.push(score);
        }
    }
    let mut shown = each;
    if sweep.chosen.is_some() && !shown.contains(&recommended.score) {
        shown.insert(0, recommended.score);
    }
    let bounds = measure::baseline_measures(results, results.moments(), recommended.region);
    let bound = |score: Score| bounds.last().and_then(|(_, values)| values[place(score)]);
    let mut tiles: Vec<BigNumber> =
        shown.into_iter().filter_map(|score| Some(tile(score, mean(score)?, bound(score)))).collect();
    tiles.push(blind_floor(floor_m2));
    tiles.push(cost(sweep, rankings, recommended));
    Ok(tiles)
}

fn tile(score: Score, over: Over, bound: Option<f64>) -> BigNumber {
    let shown = |value: f64| if measure::is_share(score) { percent(value, 0) } else { number(Some(value)) };
    let mut notes = Vec::new();
    if over.of > 1 {
        notes.push(format!("worst {}", shown(over.worst)));
    }
    // An ideal sensor has no false alarms, and bounds of 0 % or 100 % are obvious.
    let worth_telling = |bound: &f64| score != Score::FalseAlarm && *bound > 0.0 && *bound < 1.0;
    let together = if score.less_is_better() { "leaves" } else { "would reach" };
    let bound = bound.filter(worth_telling);
    notes
        .extend(bound.map(|bound| format!("a sensor at every position at once {together} {}", shown(bound))));
    if over.values < over.of {
        notes.push(format!("has a value at {} of {} moments", over.values, over.of));
    }
    BigNumber {
        name: measure::title(score),
        value: shown(over.mean),
        meaning: meaning(score, over.of),
        notes,
    }
}

/// The meaning of a score, so that 100 % does not promise too much.
fn meaning(score: Score, moments: usize) -> String {
    let studied = match moments {
        1 => "at the one moment studied".to_string(),
        many => format!("at the {many} moments studied"),
    };
    match score {
        Score::F1 => "agreement with the truth; 1 is perfect".into(),
        Score::Kappa => "agreement beyond chance; 1 is perfect".into(),
        Score::HumanSeen => format!("of people’s voxels are hit {studied}"),
        Score::HumanClaimed => format!("of people’s voxels are called occupied {studied}"),
        Score::PeopleDetected => format!("by a body part or more, {studied}"),
        Score::PartsDetected => "of people’s body parts".into(),
        Score::Unknown => "of the region’s space".into(),
        Score::FalseAlarm => "free, but called occupied".into(),
        Score::SeenTwice => "of the region’s space, by at least two sensors".into(),
    }
}

/// The unwatched share of a plan's floor.
pub(super) fn blind_share([floor, blind, _]: [f64; 3]) -> String {
    percent(blind / floor.max(f64::MIN_POSITIVE), 0)
}

/// The same as a large number.
fn blind_floor(floor_m2: [f64; 3]) -> BigNumber {
    let [floor, blind, _] = floor_m2;
    BigNumber {
        name: "blind floor".into(),
        value: blind_share(floor_m2),
        meaning: "of the whole plan: people there go unnoticed".into(),
        notes: vec![format!("{blind:.1} of {floor:.1} m²")],
    }
}

/// The cost of a combination's sensors, if all have a cost.
pub(super) fn cost_of(study: &Study, combination: usize) -> Option<Cost> {
    let members = study.combinations[combination].members.iter();
    let costs = members.map(|member| study.sensors[member.sensor].terms.cost);
    costs.reduce(|sum, cost| Some(sum?.plus(cost?))).flatten()
}

/// The cost of the recommended choice, or a note if not all its sensors have a cost.
fn cost(sweep: &ReportedSweep, rankings: &[Ranking], recommended: &Recommended) -> BigNumber {
    let name = "cost".into();
    let Some(sum) = cost_of(sweep.study, rankings[recommended.series].series.combination) else {
        let has_costs = sweep.study.sensors.iter().any(|sensor| sensor.terms.cost.is_some());
        let meaning = if has_costs { "not all sensors have a cost" } else { "the study has no costs" };
        let notes = sweep.study.describe_list_prices().into_iter().collect();
        return BigNumber { name, value: "–".into(), meaning: meaning.into(), notes };
    };
    let of_chosen = sweep.chosen.and_then(|chosen| chosen.asked.budget);
    let budget = of_chosen.or_else(|| sweep.purchase?.asked.budget);
    let currency = sweep.study.currency.as_deref();
    let meaning = match (budget, currency) {
        (Some(budget), _) => format!("of a budget of {}", budget.to_text(currency)),
        (None, Some(_)) => "of all sensors".into(),
        (None, None) => "of all sensors, in the study’s currency".into(),
    };
    let notes = sweep.study.describe_list_prices().into_iter().collect();
    BigNumber { name, value: sum.to_text(currency), meaning, notes }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_tells_the_worst_and_what_is_possible() {
        let over = Over { mean: 0.5, std: None, worst: 0.25, pooled: None, values: 3, of: 4 };
        let BigNumber { name, value, notes, .. } = tile(Score::Unknown, over, Some(0.125));
        assert_eq!((name.as_str(), value.as_str()), ("unknown", "50\u{a0}%"));
        assert_eq!(
            notes,
            [
                "worst 25\u{a0}%",
                "a sensor at every position at once leaves 13\u{a0}%",
                "has a value at 3 of 4 moments"
            ]
        );
        let BigNumber { value, notes, .. } = tile(Score::F1, Over { values: 1, of: 1, ..over }, Some(0.75));
        let reach = "a sensor at every position at once would reach 0.750".to_string();
        assert_eq!((value.as_str(), notes), ("0.500", vec![reach]));
        let BigNumber { notes, .. } = tile(Score::Unknown, Over { values: 1, of: 1, ..over }, Some(0.0));
        assert_eq!(notes, [""; 0], "that nothing may stay unknown is nothing to tell");
    }
}
