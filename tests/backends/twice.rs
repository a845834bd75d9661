//! What several sensors see, by going through all voxels and all that each sensor says of them, on every backend.

use std::collections::BTreeMap;

use super::random_cells::{gpu, keep};
use crate::common::cases::{Case, case};
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{Backend, Fusion, Planes, Reading, Slot};
use perirobot_march::metrics::Overlap;
use perirobot_march::voxel::BitGrid;

/// Counts what at least two readings label and hit.
fn count(case: &Case, evidence: &BTreeMap<Slot, Planes>, job: &[Reading], region: &BitGrid) -> Overlap {
    let how_many = |says: &dyn Fn(&Planes) -> bool| {
        let parts = |reading: &Reading| [Some(reading.slot), reading.volume].into_iter().flatten();
        job.iter().filter(|reading| parts(reading).filter_map(|slot| evidence.get(&slot)).any(says)).count()
    };
    let is_labelled =
        |voxel: &[i32; 3]| how_many(&|planes| planes.occupied.get(*voxel) || planes.free.get(*voxel)) >= 2;
    let is_hit = |voxel: &[i32; 3]| how_many(&|planes| planes.hits.get(*voxel)) >= 2;
    let people = case.scene.people.voxels.iter().map(|of| of.voxel).filter(|voxel| region.get(*voxel));
    Overlap {
        twice: region.voxels().filter(is_labelled).count() as u64,
        hit_human_twice: people.filter(is_hit).count() as u64,
    }
}

/// Compares the counts of a backend with those of its evidence, and adds them up.
fn check(backend: &mut dyn Backend, case: &Case, sum: &mut Overlap) {
    backend.tables(&case.tables).unwrap();
    backend.load(&case.scene).unwrap();
    keep(backend, case).unwrap();
    let held = case.shots.iter().map(|shot| shot.slot).chain(case.uploads.iter().map(|(slot, _)| *slot));
    let evidence = held.map(|slot| (slot, backend.planes(&[slot]).unwrap().remove(0))).collect();
    let alone = case.jobs.iter().flatten().map(|reading| vec![*reading]);
    let jobs: Vec<Vec<Reading>> = case.jobs.iter().cloned().chain(alone).collect();
    for fusion in [Fusion::OccupiedWins, Fusion::Octomap] {
        for (job, found) in jobs.iter().zip(backend.score(fusion, &jobs).unwrap()) {
            for (number, (found, region)) in found.iter().zip(&case.scene.regions).enumerate() {
                let expected = count(case, &evidence, job, region);
                let (name, seed) = (backend.name(), case.seed);
                let place = format!("{name}, case {seed}, region {number}, {fusion:?} of {job:?}");
                assert_eq!(found.overlap, expected, "{place}");
                assert!(job.len() > 1 || expected == Overlap::default(), "{place}");
                sum.twice += expected.twice;
                sum.hit_human_twice += expected.hit_human_twice;
            }
        }
    }
}

#[test]
fn what_two_sensors_see_is_counted_on_every_backend() {
    let mut sums = Vec::new();
    let mut run = |backend: &mut dyn Backend| {
        let mut sum = Overlap::default();
        (0..120).for_each(|seed| check(backend, &case(seed), &mut sum));
        assert!(sum.twice > 1000 && sum.hit_human_twice > 10, "{}: {sum:?}", backend.name());
        sums.push(sum);
    };
    run(&mut Oracle::default());
    run(&mut Cpu::new(Some(2)).unwrap());
    if let Some(mut gpu) = gpu() {
        run(&mut gpu);
    }
    assert!(sums.iter().all(|sum| *sum == sums[0]), "{sums:?}");
}
