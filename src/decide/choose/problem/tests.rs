//! The worth of a set equals the scores in the tables of a sweep.

use perirobot_cover::{MOST_VOXELS, Ratio, Worth};
use perirobot_march::metrics::{Across, Confusion, Detection, Overlap, Score};
use perirobot_sweep::results::over::summarize;

/// Random counts, some of them zero, some as large as a region can be.
fn random(state: &mut u64) -> Confusion {
    let mut next = |below: u64| {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 20) % below
    };
    let size = [2, 20, 1000, MOST_VOXELS / 6][next(4) as usize];
    let mut counts: [u64; 12] = std::array::from_fn(|_| if next(4) == 0 { 0 } else { next(size) });
    counts[9..].fill(0);
    let people: u64 = counts[6..9].iter().sum();
    let [people_count, parts] = [next(4), next(12)];
    let found = Detection {
        hit_human: next(people + 1),
        people: people_count,
        people_detected: next(people_count + 1),
        parts,
        parts_detected: next(parts + 1),
        missed: [0; 11],
    };
    let overlap = Overlap { twice: next(counts[..6].iter().sum::<u64>() + 1), hit_human_twice: 0 };
    Confusion::from_counts(counts).with_detection(found).with_overlap(overlap)
}

const SCORES: [Score; 5] =
    [Score::F1, Score::Kappa, Score::HumanSeen, Score::PeopleDetected, Score::PartsDetected];

#[test]
fn fractions_are_the_scores_of_the_tables() {
    let mut state = 5;
    let (mut some, mut none) = (0, 0);
    for case in 0..20_000 {
        let counts = random(&mut state);
        for score in Score::ALL {
            let (found, expected) = (Ratio::from_score(score, &counts), score.evaluate(&counts));
            assert_eq!(found.map(Ratio::value), expected, "case {case}: {score:?} of {counts:?}");
            *if found.is_some() { &mut some } else { &mut none } += 1;
        }
    }
    assert!(some > 10_000 && none > 100, "{some} with a value, {none} without");
}

#[test]
fn worths_over_moments_are_those_of_the_tables() {
    let mut state = 9;
    for case in 0..5000 {
        let moments: Vec<Confusion> = (0..1 + case % 5).map(|_| random(&mut state)).collect();
        for score in SCORES {
            let expected = summarize(std::slice::from_ref(&moments), score);
            let found = |over| Worth::from_counts(score, over, &moments).map(Worth::value);
            assert_eq!(found(Across::Worst), expected.map(|over| over.worst), "case {case}: {score:?}");
            assert_eq!(found(Across::Mean), expected.map(|over| over.mean), "case {case}: {score:?}");
            let all = moments.iter().fold(Confusion::default(), |sum, counts| sum.plus(counts));
            if all.total() <= MOST_VOXELS {
                assert_eq!(found(Across::Pooled), score.evaluate(&all), "case {case}: {score:?}");
            }
        }
    }
}
