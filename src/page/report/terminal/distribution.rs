//! Distributions of the scores of all choices of poses: minimum, quartiles and maximum of each scene, region,
//! combination and representation, with the baselines of that scene and region.

use crate::report::bound_note;
use crate::report::quartiles::{distribution, row};
use crate::report::selection::ReportSelection;
use crate::report::table::{Table, number};
use perirobot_march::Result;
use perirobot_sweep::results::Results;

/// A table for each region and score.
pub fn render(results: &Results, selection: &ReportSelection) -> Result<String> {
    let mut text = String::from(
        "\nDISTRIBUTION over all choices of poses (the paper's Experiment 1: representations of one camera)\n\
         A choice counts with its mean over snapshots and repeats. Quartiles: the value at place p·(n − 1) of the n\n\
         sorted ones, interpolated. Behind the bar: what trivial answers score in that scene, and at most could be.\n",
    );
    for (score, region) in selection.parts() {
        let mut table = Table::new(&[
            "<scene",
            "<combination · representation",
            "n",
            "min",
            "lower q",
            "median",
            "upper q",
            "max",
            "<",
            "upper",
            "all occ",
            "all free",
            "nothing",
        ]);
        for scene in &results.scenes {
            let baselines = results
                .baselines_over(scene.moments.clone(), region, score)
                .map(|(_, over)| number(over.map(|over| over.mean)));
            for series in selection.series(results) {
                let values = series.summarize(results, &scene.moments, region, score)?;
                let found = distribution(values.into_iter().flatten().map(|over| over.mean).collect());
                table.row(
                    row(results, scene, series, found, number)
                        .into_iter()
                        .chain(["|".into()])
                        .chain(baselines.clone()),
                );
            }
        }
        text += &format!("\n{} in region {}\n{}", score.title(), results.regions[region], table.text());
        text += &bound_note(score);
    }
    Ok(text)
}
