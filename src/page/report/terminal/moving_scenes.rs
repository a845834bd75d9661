//! Moving scenes: the choices with the best mean over the snapshots, and those whose worst snapshot is best.

use crate::report::bound_note;
use crate::report::selection::ReportSelection;
use crate::report::series::{rank, worst_snapshot};
use crate::report::table::{Table, number};
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::swept::SceneResults;
use perirobot_sweep::results::{Over, Results};

/// Choices per list.
const SHOWN: usize = 3;

/// A table for each region and score; empty if no scene moves.
pub fn render(results: &Results, selection: &ReportSelection) -> Result<String> {
    let moving: Vec<&SceneResults> = results.scenes.iter().filter(|scene| scene.moments.len() > 1).collect();
    if moving.is_empty() {
        return Ok(String::new());
    }
    let mut text = String::from(
        "\nSNAPSHOTS of moving scenes (the paper's Experiment 3: an observer walks, the arm moves)\n\
         The best choices of poses by their mean over snapshots and repeats, and by their worst. In: the snapshot of\n\
         the worst, counted from 0. Pooled: the score of all counts together.\n",
    );
    let is_weighted = results.dwell_s.is_some();
    if is_weighted {
        text +=
            "Weighted: the mean in which each snapshot weighs as long as it lasts (dwell_s of the scene).\n";
    }
    for (score, region) in selection.parts() {
        let mut columns =
            vec!["<scene", "<combination · representation", "<best by", "mean", "worst", "in", "pooled"];
        columns.extend(is_weighted.then_some("weighted"));
        columns.extend(["<poses", "<place"]);
        let mut table = Table::new(&columns);
        for scene in &moving {
            rows(results, selection, scene, (score, region), &mut table)?;
            for (name, over) in results.baselines_over(scene.moments.clone(), region, score) {
                let what = [String::new(), format!("baseline {name}"), String::new()];
                let [mean, worst] = [number(over.map(|o| o.mean)), number(over.map(|o| o.worst))];
                let pooled = number(over.and_then(|over| over.pooled));
                table.row(what.into_iter().chain([mean, worst, String::new(), pooled]));
            }
        }
        text += &format!("\n{} in region {}\n{}", score.title(), results.regions[region], table.text());
        text += &bound_note(score);
    }
    Ok(text)
}

/// The rows of one scene: for each combination and representation the best by mean, then the best by worst, and by the
/// weighted mean if snapshots have weights.
fn rows(
    results: &Results,
    selection: &ReportSelection,
    scene: &SceneResults,
    (score, region): (Score, usize),
    table: &mut Table,
) -> Result<()> {
    for series in selection.series(results) {
        let values = series.summarize(results, &scene.moments, region, score)?;
        let weighted = match results.dwell_s {
            Some(_) => Some(series.weighted_mean(results, &scene.moments, region, score)?),
            None => None,
        };
        let f1 = series.f1_means(results, &scene.moments, region)?;
        let by = |of: fn(&Over) -> f64| values.iter().map(|over| over.as_ref().map(of)).collect::<Vec<_>>();
        let orders = [("mean", Some(by(|over| over.mean))), ("worst", Some(by(|over| over.worst)))];
        for (by, values_by) in orders.into_iter().chain([("weighted", weighted.clone())]) {
            let best = rank(score, values_by.into_iter().flatten(), &f1);
            for (rank, &(choice, _)) in best.iter().take(SHOWN).enumerate() {
                let names = [scene.name.clone(), series.title(results), by.into()];
                let over = values[choice];
                let combination = &results.combinations[series.combination];
                let snapshot = worst_snapshot(results, scene, series.key(choice, region), score)?;
                table.row(
                    if rank == 0 { names } else { Default::default() }
                        .into_iter()
                        .chain([
                            number(over.map(|over| over.mean)),
                            number(over.map(|over| over.worst)),
                            snapshot.map_or(String::new(), |snapshot| snapshot.to_string()),
                            number(over.and_then(|over| over.pooled)),
                        ])
                        .chain(weighted.as_ref().map(|weighted| number(weighted[choice])))
                        .chain([combination.label(choice), combination.place_of(choice)]),
                );
            }
        }
    }
    Ok(())
}
