//! Sweeps of studies that ship.

use super::run;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// No choice of any kind of sensor knows more of what is there than the ceiling says could be known; without
/// noise, which may put a reading where none could be taken.
#[test]
fn no_pose_beats_the_ceiling() {
    for name in ["tiny.toml", "sensors.toml"] {
        let path =
            std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes").join(name);
        let study = Study::load(&path, &Overrides { noiseless: true, ..Default::default() }).unwrap();
        let worlds = World::prepare_all(&study).unwrap();
        let mut cpu = perirobot_march::backend::cpu::Cpu::new(Some(1)).unwrap();
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
