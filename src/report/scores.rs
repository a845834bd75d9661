//! `scores.csv`, made for pandas: the scores of every choice over snapshots and repeats, for each scene and for all
//! scenes together. Which choice is best is left to the tables for people.

use std::ops::Range;

use super::{Over, Results, Score, Series};

/// What stands in the column `scene` for all scenes together.
pub const ALL_SCENES: &str = "*";

/// One row a scene, combination, choice of poses, representation and region, in the order of results.csv; then the same
/// for all scenes. What has no value is empty: a score that is nowhere defined, and the spread of a single repeat.
pub fn render(results: &Results) -> Vec<u8> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    let mut row = |fields: &[String]| {
        csv.write_record(fields).expect("all rows are as long as the header, and memory takes them");
    };
    let mut header = ["scene", "combination", "poses", "representation", "region"].map(String::from).to_vec();
    for score in Score::ALL {
        header.extend(["mean", "std", "worst", "pooled", "n"].map(|what| format!("{}_{what}", score.name())));
    }
    row(&header);
    let all = (ALL_SCENES, results.moments());
    let scenes = results.scenes.iter().map(|scene| (scene.name.as_str(), scene.moments.clone()));
    for (scene, moments) in scenes.chain([all]) {
        rows_of(results, scene, &moments, &mut row);
    }
    csv.into_inner().expect("memory takes all bytes")
}

fn rows_of(results: &Results, scene: &str, moments: &Range<usize>, row: &mut impl FnMut(&[String])) {
    for (c, combination) in results.combinations.iter().enumerate() {
        for (choice, poses) in combination.choices.iter().enumerate() {
            for (representation, name) in combination.representations.iter().enumerate() {
                for (r, region) in results.regions.iter().enumerate() {
                    let key = Series { combination: c, representation }.key(choice, r);
                    let mut fields =
                        [scene, &combination.name, &poses.name, name, region].map(String::from).to_vec();
                    for score in Score::ALL {
                        fields.extend(columns(results.over(moments.clone(), key, score)));
                    }
                    row(&fields);
                }
            }
        }
    }
}

/// mean, std, worst, pooled, n.
fn columns(over: Option<Over>) -> [String; 5] {
    let text = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
    let Some(Over { mean, std, worst, pooled, values, .. }) = over else {
        return [text(None), text(None), text(None), text(None), "0".into()];
    };
    [text(Some(mean)), text(std), text(Some(worst)), text(pooled), values.to_string()]
}
