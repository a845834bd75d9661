//! A recorded map, looked at as a sensor of its own: what it says of one moment of a scene, and what that scores.

use super::{Choice, View, Viewer};
use crate::Result;
use crate::backend::cpu::Cpu;
use crate::recording::{Anchor, Recording};
use crate::sensor::recorded::{Recorded, RecordedMoment};
use crate::study::Study;
use crate::sweep::Row;
use crate::world::World;

/// A recording, laid into the voxels of one moment of a scene.
pub struct RecordedMap {
    /// The study with the recording as its only sensor.
    pub study: Study,
    world: World,
}

impl RecordedMap {
    /// A recording whose frame stands somewhere in a world of a study.
    ///
    /// # Errors
    /// When it says nothing inside the grid, or is too fine for it.
    pub fn new(study: &Study, world: &World, recording: Recording, anchor: Anchor) -> Result<RecordedMap> {
        let moment = RecordedMoment::new([world.scene, world.snapshot], recording, anchor);
        let study = study.of_recording(Recorded { moments: vec![moment] });
        world.examine_sensors(&study).map_err(|e| e.at(&study.path))?;
        Ok(RecordedMap { world: world.with_sensors(&study.sensors), study })
    }

    /// What it says in all regions. Nothing is cast.
    pub fn view(&self) -> Result<View<'_>> {
        let choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
        let mut backend = Cpu::new(None)?;
        Ok(Viewer::new(&self.study, &mut backend)?.in_regions(&self.world, &[choice])?.swap_remove(0))
    }

    /// Its counts, region by region, as a sweep has them.
    pub fn rows(&self) -> Result<Vec<Row>> {
        let (view, World { scene, snapshot, .. }) = (self.view()?, &self.world);
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
        Ok((0..self.study.regions.len()).map(row).collect())
    }
}
