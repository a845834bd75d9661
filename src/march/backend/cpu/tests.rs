//! What is kept ready from one job to the next.

use std::sync::Arc;

use super::{Cpu, test_camera};
use crate::backend::self_test::{placement, scene};
use crate::backend::{Backend, Fusion, OverTime, Rays, Reading, Shot, VoxelScene};
use crate::march::Gates;
use crate::metrics::Confusion;
use crate::voxel::{BitGrid, Window};

/// The counts of each table at two poses.
fn counts(cpu: &mut Cpu, tables: &[Rays], scene: &VoxelScene) -> Vec<Vec<Confusion>> {
    cpu.tables(tables).unwrap();
    cpu.load(scene).unwrap();
    let slots = 0..2 * tables.len() as u32;
    for table in 0..tables.len() as u32 {
        let shot = |pose: u32| Shot::once(2 * table + pose, placement(pose));
        cpu.sense(table as usize, &[shot(0), shot(1)]).unwrap();
    }
    let reading = |slot| Reading { slot, volume: None, hit: 847, miss: -405, presence: false };
    let jobs: Vec<Vec<Reading>> = slots.map(|slot| vec![reading(slot)]).collect();
    cpu.score(Fusion::OccupiedWins, &jobs).unwrap()
}

/// Scenes and tables come back in any order, some of them alike but for one thing.
#[test]
fn what_comes_back_counts_as_if_it_were_new() {
    let camera = || test_camera::camera([60.0, 60.0]);
    let rays = camera();
    let near = Rays { gates: Gates { range_max_q16: 40 << 16, ..rays.gates }, ..rays.clone() };
    let few = Rays { dirs_q15: rays.dirs_q15[..2000].to_vec().into(), image: None, ..rays.clone() };
    let first = scene();
    let window = Window::from_corners([30, 30, 0], [99, 89, 44]);
    let cut = |plane: &BitGrid| plane.to_window(window);
    let part = VoxelScene {
        window,
        truth: cut(&first.truth),
        human: cut(&first.human),
        robot: cut(&first.robot),
        regions: first.regions.iter().map(cut).collect(),
        people: first.people.crop(window),
        ..first.clone()
    };
    let one_region = VoxelScene { regions: first.regions[..1].to_vec(), ..first.clone() };
    let strict = VoxelScene {
        people: crate::voxel::People { min_hits: 300, ..first.people.clone() },
        ..first.clone()
    };
    let mut always = BitGrid::clone(&first.blockers);
    always.remove(&BitGrid::full(Window::from_corners([40, 40, 0], [80, 80, 59])));
    let (always, ever) = (Arc::new(always), first.blockers.clone());
    let over_time = || Some(Arc::new(OverTime { always: always.clone(), ever: ever.clone() }));
    let moving = VoxelScene { over_time: over_time(), ..first.clone() };
    let other_numbers = VoxelScene { over_time: over_time(), ..first.clone() };
    let mut gone = BitGrid::clone(&first.blockers);
    gone.remove(&BitGrid::full(Window::from_corners([60, 50, 1], [67, 60, 35])));
    let without = VoxelScene { blockers: gone.into(), over_time: over_time(), ..first.clone() };
    let scenes = [first, part, one_region, strict, moving, other_numbers, without];
    let tables = [
        vec![rays.clone(), near.clone(), few.clone()],
        vec![near.clone(), rays.clone()],
        vec![few.clone()],
        vec![few, camera(), near],
    ];
    let fresh = |tables: &[Rays], scene: &VoxelScene| counts(&mut Cpu::new(Some(2)).unwrap(), tables, scene);
    let expected: Vec<Vec<_>> =
        scenes.iter().map(|scene| tables.iter().map(|tables| fresh(tables, scene)).collect()).collect();
    assert_ne!(expected[0][0], expected[1][0]);
    assert_ne!(expected[0][0], expected[3][0]);
    assert_ne!(expected[0][0], expected[6][0]);
    // Room for all scenes, and for none.
    for memory in [1 << 30, 1 << 20] {
        let mut cpu = Cpu::new(Some(2)).unwrap().memory(memory);
        for step in 0..40usize {
            let (scene, table) = (step * 5 % scenes.len(), step * 7 / 3 % tables.len());
            let found = counts(&mut cpu, &tables[table], &scenes[scene]);
            assert_eq!(found, expected[scene][table], "step {step}: scene {scene}, tables {table}");
        }
        assert_eq!(cpu.earlier.len() > 4, memory == 1 << 30, "{} scenes are kept", cpu.earlier.len());
    }
}
