//! Sweeps of shipped studies.

use super::order::run_some;
use super::run;
use crate::results::layout_of;
use perirobot_march::backend::Backend;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::oracle::Oracle;
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// No choice of any kind of sensor has more correct labels than the upper bound allows; without noise, which may
/// displace a return to an impossible place.
#[test]
fn no_pose_beats_the_ceiling() {
    for name in ["tiny.toml", "sensors.toml"] {
        let path =
            std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes").join(name);
        let study = Study::load(&path, &Overrides { noiseless: true, ..Default::default() }).unwrap();
        let worlds = World::prepare_all(&study).unwrap();
        let mut cpu = Cpu::new(Some(1)).unwrap();
        for row in run(&study, &worlds, &mut cpu).unwrap() {
            let world = worlds.iter().find(|w| (w.scene, w.snapshot) == (row.scene, row.snapshot)).unwrap();
            let ceiling = world.baselines[row.region].ceiling;
            assert!(
                row.counts.tp <= ceiling.tp && row.counts.human.tp <= ceiling.human.tp,
                "{name}: {row:?}"
            );
            assert_eq!(row.counts.total(), ceiling.total());
        }
    }
}

/// The oracle prepares each scene when it loads it.
#[test]
fn scenes_that_are_made_ahead_count_as_those_that_are_not() {
    let path =
        std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/paper/exp3.toml");
    let study = Study::load(&path, &Overrides { voxel_size_m: Some(0.15), ..Default::default() }).unwrap();
    let worlds: Vec<World> = World::prepare_all(&study).unwrap().into_iter().step_by(6).collect();
    let (mut cpu, mut oracle) = (Cpu::new(Some(2)).unwrap(), Oracle::default());
    let [first, second, ..] = &worlds[..] else { panic!("a walk has more snapshots") };
    let scene = |world: &World| world.scene(window_of(&world.regions));
    cpu.load(&scene(first)).unwrap();
    let make = |cpu: &Cpu, world: &World| cpu.scene_maker().and_then(|make| make(&scene(world)));
    assert!(make(&cpu, first).is_none(), "it is loaded");
    let made = make(&cpu, second);
    assert!(made.is_some());
    cpu.load_made(&scene(second), made).unwrap();
    assert!(make(&cpu, second).is_none() && make(&cpu, first).is_none(), "both are known");

    let all: Vec<_> = layout_of(&study).all_choices().collect();
    let some = [all[0], all[all.len() - 1]];
    let counted = run_some(&study, &worlds, &some, &mut Cpu::new(Some(2)).unwrap()).unwrap();
    assert_eq!(counted, run_some(&study, &worlds, &some, &mut oracle).unwrap());
    assert_eq!(counted.len(), worlds.len() * some.len() * study.regions.len());
}
