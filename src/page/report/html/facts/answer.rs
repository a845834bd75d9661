//! The first screen: what was asked, what is recommended, a few large numbers with what is possible at most, and the
//! floor plan.

use crate::render::plan::{FloorPlan, floor_plan, swatch};
use crate::report::apart::Writing;
use crate::report::best::extent;
use crate::report::choose::{self, Spelling};
use crate::report::html::ranking::Ranking;
use crate::report::html::recommended::Recommended;
use crate::report::html::{ReportedSweep, measure};
use crate::report::judge::of_which;
use crate::report::table::number;
use perirobot_decide::approach::Way;
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Over;

/// Most sensors, combinations or scenes that are called by their names.
const MOST_NAMED: usize = 4;

/// The first screen.
#[derive(Debug)]
pub(crate) struct Answer {
    /// What was asked, as a sentence.
    pub(crate) asked: String,
    /// The names of the recommended choice, of which all numbers are.
    pub(crate) set: String,
    /// Of what the recommended choice is the best.
    pub(crate) why: String,
    pub(crate) sensors: Vec<AnswerSensor>,
    /// Which of them cast fewer rays than their devices.
    pub(crate) thinned: Vec<String>,
    /// In which region, and over what.
    pub(crate) counted: String,
    pub(crate) tiles: Vec<Tile>,
    /// That of the scene where the choice is the worst first.
    pub(crate) plans: Vec<ShownPlan>,
}

/// A sensor of the recommended choice.
#[derive(Debug)]
pub(crate) struct AnswerSensor {
    /// As in the plan.
    pub(crate) letter: String,
    pub(crate) name: String,
    pub(crate) place: String,
    pub(crate) cost: String,
}

/// A large number.
#[derive(Debug)]
pub(crate) struct Tile {
    pub(crate) name: String,
    pub(crate) value: String,
    /// Of what it is the number.
    pub(crate) meaning: String,
    /// The worst of all moments, and what is possible at best.
    pub(crate) notes: Vec<String>,
}

/// A plan with what stands below it.
#[derive(Debug)]
pub(crate) struct ShownPlan {
    pub(crate) svg: String,
    pub(crate) title: String,
    /// The sign and its meaning.
    pub(crate) legend: Vec<(String, String)>,
    pub(crate) floor: String,
}

/// The first screen of what is recommended.
pub(super) fn answer(
    sweep: &ReportedSweep,
    rankings: &[Ranking],
    recommended: &Recommended,
    near: &[Vec<Way>],
) -> Result<Answer> {
    let ReportedSweep { results, study, .. } = *sweep;
    let series = rankings[recommended.series].series;
    let combination = &results.combinations[series.combination];
    let (choice, region) = (recommended.choice, recommended.region);
    let looked = recommended.looked(rankings);
    let plan = |scene: usize| plan(sweep, looked, (scene, recommended.moments[scene]), near.get(scene));
    let others = (0..results.scenes.len()).filter(|scene| *scene != recommended.scene);
    let plans: Vec<(FloorPlan, ShownPlan)> =
        [recommended.scene].into_iter().chain(others).map(plan).collect();
    let asked = &study.combinations[series.combination];
    let named = asked.members.iter().zip(combination.poses(choice)).zip(&plans[0].0.sensors);
    let sensors = named.map(|((member, (of, pose)), (letter, _))| AnswerSensor {
        letter: letter.map_or(String::new(), String::from),
        name: of.sensor.clone(),
        place: if pose.place.is_empty() { pose.name.clone() } else { pose.place.clone() },
        cost: study.sensors[member.sensor].terms.cost.map_or(String::new(), |cost| cost.to_string()),
    });
    let members = asked.members.iter().map(|member| &study.sensors[member.sensor]);
    let mut thinned: Vec<String> = members
        .filter_map(|sensor| Some(format!("“{}” {}.", sensor.name, sensor.thinned.as_ref()?)))
        .collect();
    // A sensor may be in a set more than once.
    thinned.dedup();
    Ok(Answer {
        thinned,
        asked: question(sweep),
        set: format!("{} ({})", combination.name, combination.name_of(choice)),
        why: recommended.why.clone(),
        sensors: sensors.collect(),
        counted: format!(
            "The numbers are those of {}; all but floor and cost: {} in region {}, over {}",
            combination.name,
            if results.moments().len() > 1 { "means" } else { "counted" },
            results.regions[region],
            extent(results)
        ),
        tiles: tiles(sweep, rankings, recommended, plans[0].0.floor_m2)?,
        plans: plans.into_iter().map(|(_, shown)| shown).collect(),
    })
}

/// What a study asks for, in a sentence or two.
fn question(sweep: &ReportedSweep) -> String {
    let results = sweep.results;
    if let Some(chosen) = sweep.chosen {
        return format!("Asked: {}.", choose::question(chosen, &IN_WORDS));
    }
    let all: Vec<(&str, usize)> =
        results.combinations.iter().map(|one| (one.name.as_str(), one.choices())).collect();
    let sum = all.iter().map(|(_, choices)| *choices).fold(0, usize::saturating_add);
    let (of, parts) = match all.as_slice() {
        [(name, _)] => (format!("of “{name}”"), String::new()),
        some if some.len() <= MOST_NAMED => {
            let parts: Vec<String> =
                some.iter().map(|(name, choices)| format!("{choices} of “{name}”")).collect();
            ("of sensors".into(), format!(" They are {}.", listed(&parts)))
        }
        many => (format!("of {} combinations of sensors", many.len()), String::new()),
    };
    let regions = if results.regions.len() == 1 { "region" } else { "regions" };
    format!(
        "Asked: which of {sum} choices of poses {of} is the best in {regions} {}?{parts}",
        listed(&results.regions)
    )
}

/// Scores as the page calls them.
const IN_WORDS: Spelling = Spelling {
    score: measure::title,
    over: of_which,
    least: |score, least| match measure::is_share(score) {
        true => Writing::Percent.exactly(least),
        false => least.to_string(),
    },
};

/// `a, b and c`.
fn listed<S: AsRef<str>>(names: &[S]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    match names.as_slice() {
        [] => String::new(),
        [one] => one.to_string(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// The title of the page, as a sentence.
pub(super) fn title(sweep: &ReportedSweep) -> String {
    let names: Vec<&str> = sweep.study.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
    let sensors = if names.len() > MOST_NAMED {
        format!("{} sensors", names.len())
    } else {
        format!("the {}", listed(&names))
    };
    let scenes: Vec<&str> = sweep.results.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let scenes = if scenes.len() > MOST_NAMED { format!("{} scenes", scenes.len()) } else { listed(&scenes) };
    match sweep.chosen {
        Some(_) => format!("Which sensors, and where, in {scenes}"),
        None => format!("Where to put {sensors} in {scenes}"),
    }
}

fn plan(
    sweep: &ReportedSweep,
    looked: Choice,
    (scene, moment): (usize, usize),
    near: Option<&Vec<Way>>,
) -> (FloorPlan, ShownPlan) {
    let of_scene = sweep.results.scenes[scene].moments.clone();
    let plan =
        floor_plan(sweep.study, &sweep.worlds[of_scene.clone()], moment - of_scene.start, Some(looked));
    let plan = plan.with_ways(near.map_or(&[], Vec::as_slice));
    let [floor, blind, hardly] = plan.floor_m2;
    let name = &sweep.results.scenes[scene].name;
    let when = match of_scene.len() {
        1 => String::new(),
        _ => format!(", snapshot {} (its worst)", moment - of_scene.start),
    };
    let shown = ShownPlan {
        svg: plan.inline(),
        title: format!("Floor plan of {name}{when}"),
        legend: plan.legend.iter().map(|(class, meaning)| (swatch(class), meaning.clone())).collect(),
        floor: format!(
            "Of {floor:.1} m² of floor, {blind:.1} m² are blind, and above another {hardly:.1} m² less than half is watched, \
             as if nobody stood there."
        ),
    };
    (plan, shown)
}

/// The numbers that are shown large: with people in the region what is known of them, else agreement; and the floor
/// of the first plan that nothing watches.
fn tiles(
    sweep: &ReportedSweep,
    rankings: &[Ranking],
    recommended: &Recommended,
    floor_m2: [f64; 3],
) -> Result<Vec<Tile>> {
    let results = sweep.results;
    let key = rankings[recommended.series].series.key(recommended.choice, recommended.region);
    let own = measure::of_choice(results, results.moments(), key)?;
    let place = |score: Score| Score::ALL.iter().position(|known| *known == score).unwrap_or_default();
    let of = |score: Score| own[place(score)];
    let mut shown = match of(Score::PeopleDetected) {
        Some(_) => vec![Score::PeopleDetected, Score::PartsDetected],
        None => vec![Score::F1, Score::Kappa],
    };
    shown.extend([Score::Unknown, Score::FalseAlarm]);
    if sweep.chosen.is_some() && !shown.contains(&recommended.score) {
        shown.insert(0, recommended.score);
    }
    let bounds = measure::of_baselines(results, results.moments(), recommended.region);
    let bound = |score: Score| bounds.last().and_then(|(_, values)| values[place(score)]);
    let mut tiles: Vec<Tile> =
        shown.into_iter().filter_map(|score| Some(tile(score, of(score)?, bound(score)))).collect();
    tiles.push(blind_floor(floor_m2));
    tiles.push(cost(sweep, rankings, recommended));
    Ok(tiles)
}

fn tile(score: Score, over: Over, bound: Option<f64>) -> Tile {
    let shown = |value: f64| if measure::is_share(score) { percent(value) } else { number(Some(value)) };
    let mut notes = Vec::new();
    if over.of > 1 {
        notes.push(format!("worst {}", shown(over.worst)));
    }
    // Of false alarms an ideal sensor has none, and nobody expects more than all or less than nothing.
    let worth_telling = |bound: &f64| score != Score::FalseAlarm && *bound > 0.0 && *bound < 1.0;
    let together = if score.less_is_better() { "leaves" } else { "would reach" };
    let bound = bound.filter(worth_telling);
    notes
        .extend(bound.map(|bound| format!("a sensor at every position at once {together} {}", shown(bound))));
    if over.values < over.of {
        notes.push(format!("has a value at {} of {} moments", over.values, over.of));
    }
    Tile { name: measure::title(score), value: shown(over.mean), meaning: meaning(score, over.of), notes }
}

/// Of what a score is a number, so that a share of 100 % promises no more than it says.
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
    }
}

/// The share of a floor that nothing watches.
fn blind_floor([floor, blind, _]: [f64; 3]) -> Tile {
    Tile {
        name: "blind floor".into(),
        value: percent(blind / floor.max(f64::MIN_POSITIVE)),
        meaning: "of the whole plan: nobody is noticed there".into(),
        notes: vec![format!("{blind:.1} of {floor:.1} m²")],
    }
}

/// What the recommended choice costs, or that not all its sensors have a cost.
fn cost(sweep: &ReportedSweep, rankings: &[Ranking], recommended: &Recommended) -> Tile {
    let asked = &sweep.study.combinations[rankings[recommended.series].series.combination];
    let costs = asked.members.iter().map(|member| sweep.study.sensors[member.sensor].terms.cost);
    let name = "cost".into();
    let Some(sum) = costs.reduce(|sum, cost| Some(sum?.plus(cost?))).flatten() else {
        return Tile {
            name, value: "–".into(), meaning: "the study has no costs".into(), notes: Vec::new()
        };
    };
    let budget = sweep.chosen.and_then(|chosen| chosen.asked.budget);
    let meaning = budget.map_or("of all sensors, in the study’s currency".into(), |budget| {
        format!("of a budget of {budget}")
    });
    Tile { name, value: sum.to_string(), meaning, notes: Vec::new() }
}

/// A share, rounded, but not to nothing or all unless it is.
fn percent(share: f64) -> String {
    match (share * 100.0).round() {
        0.0 if share > 0.0 => "<1\u{a0}%".into(),
        100.0 if share < 1.0 => ">99\u{a0}%".into(),
        rounded => format!("{rounded:.0}\u{a0}%"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_not_rounded_to_nothing_or_all() {
        let shares = [0.0, 0.001, 0.004, 0.333, 0.996, 0.9999, 1.0];
        assert_eq!(
            shares.map(percent),
            ["0 %", "<1 %", "<1 %", "33 %", ">99 %", ">99 %", "100 %"]
                .map(|text| text.replace(' ', "\u{a0}"))
        );
    }

    #[test]
    fn a_tile_tells_the_worst_and_what_is_possible() {
        let over = Over { mean: 0.5, std: None, worst: 0.25, pooled: None, values: 3, of: 4 };
        let Tile { name, value, notes, .. } = tile(Score::Unknown, over, Some(0.125));
        assert_eq!((name.as_str(), value.as_str()), ("unknown", "50\u{a0}%"));
        assert_eq!(
            notes,
            [
                "worst 25\u{a0}%",
                "a sensor at every position at once leaves 13\u{a0}%",
                "has a value at 3 of 4 moments"
            ]
        );
        let Tile { value, notes, .. } = tile(Score::F1, Over { values: 1, of: 1, ..over }, Some(0.75));
        let reach = "a sensor at every position at once would reach 0.750".to_string();
        assert_eq!((value.as_str(), notes), ("0.500", vec![reach]));
        let Tile { notes, .. } = tile(Score::Unknown, Over { values: 1, of: 1, ..over }, Some(0.0));
        assert_eq!(notes, [""; 0], "that nothing may stay unknown is nothing to tell");
    }
}
