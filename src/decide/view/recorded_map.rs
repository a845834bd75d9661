//! A recorded map as a sensor of its own: its evidence at one moment of a scene, and its scores.

mod overlooked;

use glam::DVec3;

use super::{Choice, View, Viewer};
pub use overlooked::{Overlooked, Oversight};
use perirobot_march::Result;
use perirobot_march::backend::cpu::Cpu;
use perirobot_scene::recording::{Anchor, Recording};
use perirobot_study::input::Study;
use perirobot_study::sensor::kinds::recorded::{Recorded, RecordedMoment};
use perirobot_study::world::World;
use perirobot_sweep::scoring::Row;

/// A recording in the voxels of one moment of a scene.
pub struct RecordedMap {
    /// The study with the recording as its only sensor.
    pub study: Study,
    world: World,
    /// The known positions of the sensors that recorded it.
    places_m: Vec<DVec3>,
}

impl RecordedMap {
    /// A recording with its frame at some pose in a world of a study.
    ///
    /// # Errors
    /// If it has no label inside the grid, or is too fine for it.
    pub fn new(study: &Study, world: &World, recording: Recording, anchor: Anchor) -> Result<RecordedMap> {
        let places_m = recording.places_m(&anchor);
        let moment = RecordedMoment::new([world.scene, world.snapshot], recording, anchor);
        let study = study.with_recording(Recorded { moments: vec![moment] });
        world.examine_sensors(&study).map_err(|e| e.with_place(&study.path))?;
        Ok(RecordedMap { world: world.with_sensors(&study.sensors), study, places_m })
    }

    /// Whether a sensor's position is known.
    pub fn knows_places(&self) -> bool {
        !self.places_m.is_empty()
    }

    /// Its labels in the whole grid. Nothing is cast.
    pub fn view(&self) -> Result<View<'_>> {
        let choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
        let mut backend = Cpu::new(None)?;
        Ok(Viewer::new(&self.study, &mut backend)?.view_grid(&self.world, &[choice])?.swap_remove(0))
    }

    /// The counts of its view, region by region, as in a sweep.
    pub fn rows(&self, view: &View) -> Vec<Row> {
        let World { scene, snapshot, .. } = &self.world;
        let row = |region| Row {
            scene: *scene,
            snapshot: *snapshot,
            repeat: 0,
            combination: 0,
            choice: 0,
            representation: 0,
            region,
            counts: view.counts(region),
        };
        (0..self.study.regions.len()).map(row).collect()
    }
}
