//! The best score of each combination of sensors, per scene and on average, and relative to the largest combination.

use crate::report::bound_note;
use crate::report::maximum::{Maxima, Maximum, maxima, most_sensors, row};
use crate::report::selection::ReportSelection;
use crate::report::table::{Table, number};
use perirobot_march::Result;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::swept::SceneResults;

/// A table for each region and score; empty for a single combination.
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
            table.row(row(results, &found, of_reference, number));
            for (i, ([label, place], scenes)) in choices_at_maxima(results, &found).into_iter().enumerate() {
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
        text += &bound_note(score);
    }
    Ok(text)
}

/// The choices with the maxima, each with its place and its scenes.
fn choices_at_maxima<'a>(results: &'a Results, found: &Maxima) -> Vec<([String; 2], Vec<&'a str>)> {
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
