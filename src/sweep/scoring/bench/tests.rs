//! The contents of a race, except times.

use super::super::compare::tests::{Liar, Lie, tiny};
use super::*;
use perirobot_march::backend::cpu::Cpu;

/// Three of the tiny study's camera poses on the oracle and the liar, in two equal snapshots.
fn run_race(lie: Lie) -> Result<Race> {
    let ((study, first), (_, again)) = (tiny(), tiny());
    let backend = Box::new(Liar(Cpu::new(Some(1))?, lie));
    let mut contenders = [Contender { name: "a liar".into(), backend, threads: 1 }];
    race(&study, &[first, again], 0, 3, Duration::ZERO, &mut contenders)
}

#[test]
fn a_race_counts_what_it_did() {
    let race = run_race(Lie::None).unwrap();
    assert_eq!((race.combination.as_str(), race.poses, race.rays), ("camera", 6, 6 * 64 * 36));
    let lines: Vec<_> = race.lines.iter().map(|line| (line.name.as_str(), line.rounds)).collect();
    assert_eq!(lines, [("oracle, 1 thread", 1), ("a liar", 1)]);
    assert!(race.lines.iter().all(|line| !line.work.is_zero()));
    assert_eq!(race.first_difference, None);
}

#[test]
fn a_wrong_count_is_named() {
    let first = run_race(Lie::Count).unwrap().first_difference.unwrap_or_default();
    let place = "scene tiny, repeat 0, poses camera:wall/0/0, points in region human, a liar against the oracle: counts [";
    assert!(first.contains(place), "{first}");
    let error = run_race(Lie::FewerPoses).map(drop).unwrap_err().to_string();
    assert!(error.contains("backend liar: answered for 1 of "), "{error}");
}

#[test]
fn evidence_that_choices_share_is_cast_once() {
    let (mut study, world) = tiny();
    // Every pose of the camera with every pose of the lidar: 2 · 3 choices, but only 2 and 3 casts.
    let [mut both, lidar] = [0, 1].map(|sensor| study.combinations[sensor].clone());
    both.members[0].candidates.truncate(2);
    both.members.push(lidar.members[0].clone());
    both.members[1].candidates.truncate(3);
    study.combinations = vec![both];
    let [camera_rays, lidar_rays] = [0, 1].map(|sensor| super::rays(&study, 0)[sensor]);
    let race = race(&study, &[world], 0, 100, Duration::ZERO, &mut []).unwrap();
    assert_eq!((race.poses, race.rays), (6, (2 * camera_rays + 3 * lidar_rays) as u64));
}
