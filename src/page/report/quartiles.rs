//! Minimum, quartiles and maximum of many scores.

use super::series::Series;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::swept::SceneResults;

/// Five numbers of a distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Distribution {
    /// The smallest.
    pub(super) min: f64,
    /// A quarter is below it.
    pub(super) lower_quartile: f64,
    /// Half is below it.
    pub(super) median: f64,
    /// Three quarters are below it.
    pub(super) upper_quartile: f64,
    /// The largest.
    pub(super) max: f64,
    /// The number of values.
    pub(super) values: usize,
}

/// The distribution of some values; `None` if there are none. A quantile p of n sorted values is at place p·(n − 1),
/// counted from 0, linearly interpolated.
pub(super) fn distribution(mut values: Vec<f64>) -> Option<Distribution> {
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

/// The distribution of a series' score in a scene: scene, series, the number of choices with a value, and the five
/// numbers, formatted by `write`.
pub(super) fn row(
    results: &Results,
    scene: &SceneResults,
    series: Series,
    found: Option<Distribution>,
    write: impl Fn(Option<f64>) -> String,
) -> [String; 8] {
    let five = found.map(|d| [d.min, d.lower_quartile, d.median, d.upper_quartile, d.max].map(Some));
    let [min, lower, median, upper, max] = five.unwrap_or([None; 5]).map(write);
    let n = found.map_or(0, |d| d.values).to_string();
    [scene.name.clone(), series.title(results), n, min, lower, median, upper, max]
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
