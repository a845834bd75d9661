//! How the scores of all choices of poses are distributed: smallest, quartiles and largest of each scene,
//! region, combination and representation, beside the baselines of that scene and region.

use super::table::{Table, number};
use super::{ReportSelection, Series, near_side};
use perirobot_march::Result;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::swept::SceneResults;

/// Five numbers about many.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distribution {
    /// The smallest.
    pub min: f64,
    /// A quarter lies below it.
    pub lower_quartile: f64,
    /// Half lies below it.
    pub median: f64,
    /// Three quarters lie below it.
    pub upper_quartile: f64,
    /// The largest.
    pub max: f64,
    /// How many there are.
    pub values: usize,
}

/// The distribution of some values; `None` if there are none. A quantile p of n sorted values lies at place
/// p·(n − 1), counted from 0, and between two values on the straight line from one to the other.
pub(crate) fn distribution(mut values: Vec<f64>) -> Option<Distribution> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let quantile = |quarters: usize| {
        let (below, part) = (quarters * last / 4, (quarters * last % 4) as f64 / 4.0);
        let above = (below + 1).min(last);
        values[below] + part * (values[above] - values[below])
    };
    let [min, lower_quartile, median, upper_quartile, max] = [0, 1, 2, 3, 4].map(quantile);
    Some(Distribution { min, lower_quartile, median, upper_quartile, max, values: values.len() })
}

/// How a score of a series is distributed in a scene: scene, series, how many choices have a value, and the five
/// numbers.
pub(super) fn row(
    results: &Results,
    scene: &SceneResults,
    series: Series,
    found: Option<Distribution>,
) -> [String; 8] {
    let five = found.map(|d| [d.min, d.lower_quartile, d.median, d.upper_quartile, d.max].map(Some));
    let [min, lower, median, upper, max] = five.unwrap_or([None; 5]).map(number);
    let n = found.map_or(0, |d| d.values).to_string();
    [scene.name.clone(), series.title(results), n, min, lower, median, upper, max]
}

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
                let values = series.over(results, &scene.moments, region, score)?;
                let found = distribution(values.into_iter().flatten().map(|over| over.mean).collect());
                table.row(
                    row(results, scene, series, found)
                        .into_iter()
                        .chain(["|".into()])
                        .chain(baselines.clone()),
                );
            }
        }
        text += &format!("\n{} in region {}\n{}", score.title(), results.regions[region], table.text());
        text += &near_side(score);
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_worked_by_hand() {
        let five = |values: &[f64]| {
            let d = distribution(values.to_vec()).unwrap();
            [d.min, d.lower_quartile, d.median, d.upper_quartile, d.max]
        };
        assert_eq!(five(&[5.0, 1.0, 4.0, 2.0, 3.0]), [1.0, 2.0, 3.0, 4.0, 5.0]);
        // Places 3/4, 3/2 and 9/4 of four values.
        assert_eq!(five(&[8.0, 0.0, 4.0, 2.0]), [0.0, 1.5, 3.0, 5.0, 8.0]);
        assert_eq!(five(&[7.0]), [7.0; 5]);
        assert_eq!(distribution(Vec::new()), None);
    }
}
