//! Results small enough to work out by hand: two scenes, of which the second moves, and two combinations.

use glam::DVec3;

use super::results::{Choice, ChoicePlace, CombinationResults, Key, Results, SceneResults};
use crate::metrics::{Confusion, RoleCounts};
use crate::sweep::world::Baselines;

/// Counts with an F1 of 2 / (2 + unknown).
pub(super) fn counts(unknown: u64) -> Confusion {
    Confusion { tp: 1, uf: unknown, ..Default::default() }
}

/// Counts without any score.
pub(super) const NO_SCORE: Confusion = Confusion {
    tp: 0,
    fp: 0,
    fn_: 0,
    tn: 0,
    uo: 0,
    uf: 0,
    human: RoleCounts { tp: 0, fn_: 0, uo: 0 },
    robot: RoleCounts { tp: 0, fn_: 0, uo: 0 },
};

/// Scenes `still` (moment 0) and `moving` (moments 1 and 2), one region. The camera has poses at two walls; the pair has
/// two posed sensors and is scored in two representations.
pub(super) fn results(repeats: usize, of: impl Fn(usize, usize, &Key) -> Confusion) -> Results {
    let posed = |name: &str, x: f64| Choice {
        name: format!("camera:{name}"),
        place: Some(ChoicePlace {
            group: name.split('/').next().unwrap_or_default().into(),
            position_m: DVec3::new(x, 2.0, 3.0),
        }),
    };
    let unplaced = |name: &str| Choice { name: name.into(), place: None };
    let texts = |texts: &[&str]| texts.iter().map(|text| text.to_string()).collect();
    let baselines = Baselines {
        all_occupied: counts(8),
        all_free: counts(18),
        nothing_seen: NO_SCORE,
        ceiling: counts(0),
    };
    let mut results = Results {
        scenes: vec![
            SceneResults { name: "still".into(), moments: 0..1 },
            SceneResults { name: "moving".into(), moments: 1..3 },
        ],
        regions: vec!["robot".into()],
        repeats,
        combinations: vec![
            CombinationResults {
                name: "camera".into(),
                sensors: texts(&["camera"]),
                representations: texts(&["points"]),
                choices: vec![posed("left/0", 0.0), posed("left/1", 1.0), posed("right/0", 2.0)],
            },
            CombinationResults {
                name: "pair".into(),
                sensors: texts(&["camera", "pads"]),
                representations: texts(&["points;volume", "box;volume"]),
                choices: vec![unplaced("camera:left/0;pads:floor/0"), unplaced("camera:left/0;pads:floor/1")],
            },
        ],
        baselines: vec![vec![baselines]; 3],
        counts: Vec::new(),
    };
    for moment in 0..3 {
        for repeat in 0..repeats {
            for (combination, (choices, ways)) in [(3, 1), (2, 2)].into_iter().enumerate() {
                for choice in 0..choices {
                    for representation in 0..ways {
                        let key = Key { combination, choice, representation, region: 0 };
                        results.counts.push(of(moment, repeat, &key));
                    }
                }
            }
        }
    }
    results
}

/// One repeat. F1 of the camera's choices at the three moments: 1, 1/4, 1/2; 1/2, 1/2, 1/2; none, none, 2/3. Of the pair,
/// 1/2 everywhere but 1 in the still scene for the second choice's second representation.
pub(super) fn worked() -> Results {
    results(1, |moment, _, key| match (key.combination, key.choice, key.representation) {
        (0, 0, _) => counts([0, 6, 2][moment]),
        (0, 1, _) => counts(2),
        (0, _, _) => [NO_SCORE, NO_SCORE, counts(1)][moment],
        (_, 1, 1) if moment == 0 => counts(0),
        _ => counts(2),
    })
}
