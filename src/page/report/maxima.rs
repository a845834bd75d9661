//! The best score of each combination of sensors, per scene and on average, and as a part of what the largest
//! combination reaches.

use super::table::{Table, number};
use super::{ReportSelection, Series, first_best, near_side};
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::swept::SceneResults;

/// The best of one combination in one region.
#[derive(Clone, Debug, PartialEq)]
pub struct Maxima {
    /// Index of the combination.
    pub combination: usize,
    /// For each scene, the best mean over snapshots and repeats that a choice in some representation has.
    pub scenes: Vec<Option<Maximum>>,
    /// Mean of the scenes' maxima, of those that there are.
    pub mean: Option<f64>,
}

/// A maximum and where it is reached first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maximum {
    /// The score.
    pub value: f64,
    /// Number of the choice of poses.
    pub choice: usize,
    /// Number of the choice of representations.
    pub representation: usize,
}

/// The maxima of a combination by one score in one region.
pub(crate) fn maxima(results: &Results, combination: usize, region: usize, score: Score) -> Result<Maxima> {
    let representations = results.combinations[combination].representations.len();
    let of_scene = |scene: &SceneResults| {
        let mut best: Option<Maximum> = None;
        for representation in 0..representations {
            let series = Series { combination, representation };
            let values = series.over(results, &scene.moments, region, score)?;
            let first = first_best(score, values.iter().map(|over| Some(over.as_ref()?.mean)));
            let Some((choice, value)) = first else { continue };
            if best.is_none_or(|best| score.merit(value) > score.merit(best.value)) {
                best = Some(Maximum { value, choice, representation });
            }
        }
        Ok(best)
    };
    Ok(Maxima::new(combination, results.scenes.iter().map(of_scene).collect::<Result<_>>()?))
}

impl Maxima {
    /// With the mean of those of its scenes.
    pub(super) fn new(combination: usize, scenes: Vec<Option<Maximum>>) -> Maxima {
        let values: Vec<f64> = scenes.iter().flatten().map(|maximum| maximum.value).collect();
        let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
        Maxima { combination, scenes, mean }
    }
}

/// The combination with the most sensors, if no other has as many.
pub(crate) fn most_sensors(results: &Results) -> Option<usize> {
    let sizes: Vec<usize> = results.combinations.iter().map(|c| c.members.len()).collect();
    let most = sizes.iter().max()?;
    let mut those = (0..sizes.len()).filter(|&combination| sizes[combination] == *most);
    those.next().filter(|_| those.next().is_none())
}

/// A table for each region and score; nothing where there is one combination only.
pub fn render(results: &Results, selection: &ReportSelection) -> Result<String> {
    if results.combinations.len() < 2 {
        return Ok(String::new());
    }
    let reference = most_sensors(results);
    let mut text = String::from(
        "\nMAXIMA of each combination (the paper's Experiment 2: sensors fused)\n\
         The best score of any choice of poses, each with its mean over snapshots and repeats, and the mean of the\n\
         scenes' maxima.",
    );
    text += &reference.map_or("\n".into(), |reference| {
        format!(" Relative: as a part of that mean of {}.\n", results.combinations[reference].name)
    });
    for (score, region) in selection.parts() {
        let scenes: Vec<String> = results.scenes.iter().map(|scene| format!(">{}", scene.name)).collect();
        let scenes = scenes.iter().map(String::as_str);
        let columns: Vec<&str> =
            ["<combination"].into_iter().chain(scenes).chain(["mean", "relative"]).collect();
        let mut table = Table::new(&columns);
        let mut choices = Table::new(&["<combination", "<scenes", "<maximum reached first by", "<place"]);
        let of_reference =
            reference.map(|reference| maxima(results, reference, region, score)).transpose()?;
        let of_reference = of_reference.and_then(|maxima| maxima.mean);
        for &combination in &selection.combinations {
            let found = maxima(results, combination, region, score)?;
            table.row(row(results, &found, of_reference));
            for (i, ([label, place], scenes)) in reached(results, &found).into_iter().enumerate() {
                let name =
                    if i == 0 { results.combinations[combination].name.clone() } else { String::new() };
                choices.row([name, scenes.join(", "), label, place]);
            }
        }
        for (name, overall) in results.baselines_over(0..results.baselines.len(), region, score) {
            let of_scene = |scene: &SceneResults| {
                let all = results.baselines_over(scene.moments.clone(), region, score);
                let own = all.into_iter().find(|(other, _)| *other == name).and_then(|(_, over)| over);
                number(own.map(|over| over.mean))
            };
            let scenes = results.scenes.iter().map(of_scene);
            let begin = [format!("baseline {name}")].into_iter().chain(scenes);
            table.row(begin.chain([number(overall.map(|over| over.mean)), String::new()]));
        }
        let title = format!("{} in region {}", score.title(), results.regions[region]);
        text += &format!("\n{title}\n{}{}", table.text(), choices.text());
        text += &near_side(score);
    }
    Ok(text)
}

/// What a combination reaches: its name, its maximum in each scene, their mean, and that as a part of the
/// reference's.
pub(super) fn row<'a>(
    results: &'a Results,
    found: &'a Maxima,
    reference: Option<f64>,
) -> impl Iterator<Item = String> + 'a {
    let scenes = found.scenes.iter().map(|maximum| number(maximum.map(|m| m.value)));
    let name = results.combinations[found.combination].name.clone();
    let last = [number(found.mean), number(relative(found.mean, reference))];
    [name].into_iter().chain(scenes).chain(last)
}

/// A mean as a part of another.
pub(super) fn relative(mean: Option<f64>, reference: Option<f64>) -> Option<f64> {
    let reference = reference.filter(|r| *r != 0.0)?;
    Some(mean? / reference)
}

/// The choices that reach the maxima, each with its place and the scenes where it does.
fn reached<'a>(results: &'a Results, found: &Maxima) -> Vec<([String; 2], Vec<&'a str>)> {
    let combination = &results.combinations[found.combination];
    let label = |maximum: &Maximum| {
        let representation = &combination.representations[maximum.representation];
        let several = combination.representations.len() > 1;
        let as_what = if several { format!(" as {representation}") } else { String::new() };
        let label = format!("{}{as_what}", combination.label(maximum.choice));
        [label, combination.place_of(maximum.choice)]
    };
    let mut choices: Vec<([String; 2], Vec<&str>)> = Vec::new();
    for (scene, maximum) in results.scenes.iter().zip(&found.scenes) {
        let Some(maximum) = maximum else { continue };
        let label = label(maximum);
        match choices.iter_mut().find(|(known, _)| *known == label) {
            Some((_, scenes)) => scenes.push(&scene.name),
            None => choices.push((label, vec![&scene.name])),
        }
    }
    choices
}
