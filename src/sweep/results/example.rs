//! Results small enough to work out by hand: two scenes, of which the second moves, and two combinations.

use std::sync::Arc;

use crate::results::RowKey;
use crate::results::journal::{JournalHeader, Locked, Pages, Shard};
use crate::results::swept::{CombinationResults, MemberResults, PoseResults, Results, SceneResults, Subject};
use perirobot_march::metrics::{BODY_PARTS, Confusion, Detection, Overlap, RoleCounts};
use perirobot_study::world::Baselines;

/// Counts with an F1 of 2 / (2 + unknown).
pub fn counts(unknown: u64) -> Confusion {
    Confusion { tp: 1, uf: unknown, ..Default::default() }
}

/// Counts without any score.
pub const NO_SCORE: Confusion = Confusion {
    tp: 0,
    fp: 0,
    fn_: 0,
    tn: 0,
    uo: 0,
    uf: 0,
    human: RoleCounts { tp: 0, fn_: 0, uo: 0 },
    robot: RoleCounts { tp: 0, fn_: 0, uo: 0 },
    detection: Detection {
        hit_human: 0,
        people: 0,
        people_detected: 0,
        parts: 0,
        parts_detected: 0,
        missed: [0; BODY_PARTS],
    },
    overlap: Overlap { twice: 0, hit_human_twice: 0 },
};

/// Scenes `still` (moment 0) and `moving` (moments 1 and 2), one region. The camera has poses at two walls;
/// the pair has two posed sensors and is scored in two representations.
pub fn results(repeats: usize, of: impl Fn(usize, usize, &RowKey) -> Confusion) -> Results {
    results_in(&["robot"], repeats, of)
}

/// The same in some regions.
pub fn results_in(
    regions: &[&str],
    repeats: usize,
    of: impl Fn(usize, usize, &RowKey) -> Confusion,
) -> Results {
    let posed = |name: &str, x: f64| PoseResults {
        name: name.into(),
        group: name.split('/').next().map(String::from),
        place: format!("wall, x {x:.1} m, 3.0 m high"),
    };
    let camera = Arc::new(vec![posed("left/0", 0.0), posed("left/1", 1.0), posed("right/0", 2.0)]);
    let pads = Arc::new(vec![posed("floor/0", 0.0), posed("floor/1", 1.0)]);
    let member = |sensor: &str, poses: &Arc<Vec<PoseResults>>, candidates: &[usize]| MemberResults {
        sensor: sensor.into(),
        poses: poses.clone(),
        candidates: candidates.into(),
    };
    let texts = |texts: &[&str]| texts.iter().map(|text| text.to_string()).collect();
    let baselines = Baselines {
        all_occupied: counts(8),
        all_free: counts(18),
        nothing_seen: NO_SCORE,
        ceiling: counts(0),
    };
    let subject = Subject {
        scenes: vec![
            SceneResults { name: "still".into(), moments: 0..1, variant: None },
            SceneResults { name: "moving".into(), moments: 1..3, variant: None },
        ],
        regions: texts(regions),
        repeats,
        combinations: vec![
            CombinationResults {
                name: "camera".into(),
                members: vec![member("camera", &camera, &[0, 1, 2])],
                representations: texts(&["points"]),
            },
            CombinationResults {
                name: "pair".into(),
                members: vec![member("camera", &camera, &[0]), member("pads", &pads, &[0, 1])],
                representations: texts(&["points;volume", "box;volume"]),
            },
        ],
        baselines: vec![vec![baselines; regions.len()]; 3],
        dwell_s: None,
    };
    let layout = subject.layout();
    let header = JournalHeader {
        fingerprint: [7; 32],
        shard: Shard::WHOLE,
        blocks: layout.blocks() as u64,
        block_rows: layout.block_rows(),
        kept: 0..layout.block_rows(),
    };
    let folder = tempfile::tempdir().unwrap();
    let mut journal = Locked::open(folder.path()).unwrap().begin(header).unwrap();
    for moment in 0..3 {
        for repeat in 0..repeats {
            let put = |_: [&str; 4], key: RowKey| {
                journal.put(layout.row(moment, repeat, &key), &[of(moment, repeat, &key)])
            };
            subject.each_key(put).unwrap();
        }
    }
    Results::new(subject, Pages::new(vec![journal]))
}

/// The results of [`example`] on a failing disk.
#[cfg(target_os = "linux")]
pub fn unreadable() -> Results {
    let mut results = example();
    results.pages.break_disk();
    results
}

/// One repeat. F1 of the camera's choices at the three moments: 1, 1/4, 1/2; 1/2, 1/2, 1/2; none, none, 2/3.
/// Of the pair, 1/2 everywhere but 1 in the still scene for the second choice's second representation.
pub fn example() -> Results {
    results(1, |moment, _, key| worked_counts(moment, key))
}

/// The counts of [`example`].
pub fn worked_counts(moment: usize, key: &RowKey) -> Confusion {
    match (key.combination, key.choice, key.representation) {
        (0, 0, _) => counts([0, 6, 2][moment]),
        (0, 1, _) => counts(2),
        (0, _, _) => [NO_SCORE, NO_SCORE, counts(1)][moment],
        (_, 1, 1) if moment == 0 => counts(0),
        _ => counts(2),
    }
}
