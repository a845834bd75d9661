//! One score over several scenes, snapshots and repeats: mean, worst, spread and pooled. A score without a
//! value (a zero denominator) is left out, never counted as zero.

use perirobot_march::metrics::{Confusion, Score};

/// A score over several moments and repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Over {
    /// Mean of the values: each scene, snapshot and repeat has the same weight.
    pub mean: f64,
    /// Sample standard deviation (n − 1) of the repeats' means; `None` unless two repeats have one.
    pub std: Option<f64>,
    /// The smallest value; the largest if less is better.
    pub worst: f64,
    /// The score of all counts together.
    pub pooled: Option<f64>,
    /// The number of values.
    pub values: usize,
    /// The number if none was left out.
    pub of: usize,
}

/// One choice's score over repeats, each with the counts of its moments; `None` if there is no value.
pub fn summarize(repeats: &[Vec<Confusion>], score: Score) -> Option<Over> {
    let (mut all, mut means, mut counts, mut of) = (Sum::default(), Vec::new(), Confusion::default(), 0);
    let mut worst: Option<f64> = None;
    for repeat in repeats {
        let mut one = Sum::default();
        for reading in repeat {
            counts = counts.plus(reading);
            of += 1;
            if let Some(value) = score.evaluate(reading) {
                worst = Some(worst.map_or(value, |worst| score.worse(worst, value)));
                one.add(value);
                all.add(value);
            }
        }
        means.extend(one.mean());
    }
    let (mean, worst) = (all.mean()?, worst?);
    Some(Over { mean, std: deviation(&means), worst, pooled: score.evaluate(&counts), values: all.count, of })
}

/// The mean of one choice's score over repeats, each with the counts of its moments, weighted by the moments'
/// durations; `None` if no value has a duration.
pub(crate) fn weighted_mean(repeats: &[Vec<Confusion>], dwell_s: &[f64], score: Score) -> Option<f64> {
    let moments = repeats.iter().flat_map(|repeat| repeat.iter().zip(dwell_s));
    let values = moments.filter_map(|(reading, &seconds)| Some((score.evaluate(reading)?, seconds)));
    let (sum, all) =
        values.fold((0.0, 0.0), |(sum, all), (value, seconds)| (sum + value * seconds, all + seconds));
    (all > 0.0).then(|| sum / all)
}

/// A sum of values in their order, so that the same counts give the same bytes.
#[derive(Default)]
struct Sum {
    sum: f64,
    count: usize,
}

impl Sum {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

/// Sample standard deviation.
fn deviation(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    Some((squares / (values.len() - 1) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn confusion(tp: u64, uf: u64) -> Confusion {
        Confusion { tp, uf, ..Default::default() }
    }

    fn f1(repeats: &[Vec<Confusion>]) -> Option<Over> {
        summarize(repeats, Score::F1)
    }

    #[test]
    fn what_has_no_value_is_left_out_of_mean_and_worst() {
        // F1 1/2 and 2/3; an empty table has none.
        let value = f1(&[vec![confusion(1, 2), confusion(1, 1), Confusion::default()]]).unwrap();
        assert_eq!((value.mean, value.worst), ((0.5 + 2.0 / 3.0) / 2.0, 0.5));
        assert_eq!((value.values, value.of), (2, 3));
        // 2·2 / (2·2 + 3)
        assert_eq!((value.pooled, value.std), (Some(4.0 / 7.0), None));
        assert_eq!(f1(&[vec![Confusion::default()]]), None);
        assert_eq!(f1(&[]), None);
    }

    #[test]
    fn a_moment_weighs_as_long_as_it_lasts() {
        // F1 1/2 for 3 s and 2/3 for 1 s; the moment without a value is left out, regardless of its duration.
        let moments = [vec![confusion(1, 2), confusion(1, 1), Confusion::default()]];
        let mean = |dwell_s: &[f64]| weighted_mean(&moments, dwell_s, Score::F1);
        assert_eq!(mean(&[3.0, 1.0, 100.0]), Some((1.5 + 2.0 / 3.0) / 4.0));
        assert_eq!(mean(&[0.0, 2.0, 0.0]), Some(2.0 / 3.0));
        assert_eq!(mean(&[0.0, 0.0, 5.0]), None);
    }

    #[test]
    fn repeats_spread_about_their_mean() {
        // Two moments each: the repeats' means are (1 + 1/2)/2, (1/2 + 1/2)/2 and (1 + 1)/2, that is 3/4, 1/2
        // and 1.
        let (one, half) = (confusion(1, 0), confusion(1, 2));
        let value = f1(&[vec![one, half], vec![half, half], vec![one, one]]).unwrap();
        assert_eq!((value.mean, value.worst, value.values), (0.75, 0.5, 6));
        // Squares 0, 1/16, 1/16 over n − 1 = 2: the root of 1/16.
        assert_eq!(value.std, Some(0.25));
        // 6 true positives, 6 unknown: 12 / 18.
        assert_eq!(value.pooled, Some(12.0 / 18.0));
    }

    #[test]
    fn the_worst_of_what_is_better_small_is_the_largest() {
        let moments = [vec![confusion(1, 2), confusion(1, 1)]];
        let value = summarize(&moments, Score::Unknown).unwrap();
        assert_eq!((value.worst, value.pooled), (2.0 / 3.0, Some(3.0 / 5.0)));
    }

    #[test]
    fn a_repeat_without_a_value_does_not_spread() {
        let value = f1(&[vec![confusion(1, 2)], vec![Confusion::default()]]).unwrap();
        assert_eq!((value.mean, value.std, value.values, value.of), (0.5, None, 1, 2));
    }
}
