//! The best score of any choice of poses of a combination, per scene and on average.

use super::series::{Series, first_best};
use super::table::number;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::swept::SceneResults;

/// The best of one combination in one region.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Maxima {
    /// Index of the combination.
    pub(super) combination: usize,
    /// For each scene, the best mean over snapshots and repeats of a choice in any representation.
    pub(super) scenes: Vec<Option<Maximum>>,
    /// Mean of the scenes' maxima, over those with a value.
    pub(super) mean: Option<f64>,
}

/// A maximum and its first choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Maximum {
    /// The score.
    pub(super) value: f64,
    /// Index of the choice of poses.
    pub(super) choice: usize,
    /// Index of the choice of representations.
    pub(super) representation: usize,
}

/// The maxima of a combination by one score in one region.
pub(super) fn maxima(results: &Results, combination: usize, region: usize, score: Score) -> Result<Maxima> {
    let representations = results.combinations[combination].representations.len();
    let of_scene = |scene: &SceneResults| {
        let mut best: Option<Maximum> = None;
        for representation in 0..representations {
            let series = Series { combination, representation };
            let values = series.summarize(results, &scene.moments, region, score)?;
            let f1 = series.f1_means(results, &scene.moments, region)?;
            let first = first_best(score, values.iter().map(|over| Some(over.as_ref()?.mean)), &f1);
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
    /// Adds the mean over its scenes.
    pub(super) fn new(combination: usize, scenes: Vec<Option<Maximum>>) -> Maxima {
        let values: Vec<f64> = scenes.iter().flatten().map(|maximum| maximum.value).collect();
        let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
        Maxima { combination, scenes, mean }
    }
}

/// The combination with the most sensors, if it is unique.
pub(super) fn most_sensors(results: &Results) -> Option<usize> {
    let sizes: Vec<usize> = results.combinations.iter().map(|c| c.members.len()).collect();
    let most = sizes.iter().max()?;
    let mut those = (0..sizes.len()).filter(|&combination| sizes[combination] == *most);
    those.next().filter(|_| those.next().is_none())
}

/// The row of a combination: its name, its maximum in each scene, their mean, and the ratio to the reference's mean;
/// `write` formats scores.
pub(super) fn row<'a>(
    results: &'a Results,
    found: &'a Maxima,
    reference: Option<f64>,
    write: impl Fn(Option<f64>) -> String + 'a,
) -> impl Iterator<Item = String> + 'a {
    let name = results.combinations[found.combination].name.clone();
    let last = [write(found.mean), number(relative(found.mean, reference))];
    let scenes = found.scenes.iter().map(move |maximum| write(maximum.map(|m| m.value)));
    [name].into_iter().chain(scenes).chain(last)
}

/// The ratio of two means.
pub(super) fn relative(mean: Option<f64>, reference: Option<f64>) -> Option<f64> {
    let reference = reference.filter(|r| *r != 0.0)?;
    Some(mean? / reference)
}
