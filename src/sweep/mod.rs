//! Candidates × scenes → counts: the main job, and the comparison of backends. Files are written by `table` and
//! `manifest`; nothing here draws or searches.

pub mod compare;
pub mod files;
pub mod manifest;
pub mod shapes;
pub mod summary;
pub mod table;
pub mod world;

use crate::backend::Backend;
use crate::metrics::Confusion;
use crate::study::Study;
use crate::voxel::region::window_of;
use crate::{Error, Result};
pub use world::World;

/// The counts of one pose in one region of one scene; indices are those of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Index of the scene.
    pub scene: usize,
    /// Index of the sensor.
    pub sensor: usize,
    /// Index of the pose among the sensor's candidates.
    pub pose: usize,
    /// Index of the region.
    pub region: usize,
    /// What the pose got right and wrong.
    pub counts: Confusion,
}

/// How many scene-poses a study has.
pub fn jobs(study: &Study) -> u64 {
    let poses: usize = study.sensors.iter().map(|sensor| sensor.candidates.len()).sum();
    (study.scenes.len() * poses) as u64
}

/// Scores every pose of every sensor in every scene, rows in study order: scene, sensor, pose, region. `done` hears
/// how many scene-poses each batch finished.
pub fn run(
    study: &Study,
    worlds: &[World],
    backend: &mut dyn Backend,
    mut done: impl FnMut(u64),
) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (scene, world) in worlds.iter().enumerate() {
        let cell = world.cell(window_of(&world.regions));
        for (sensor, spec) in study.sensors.iter().enumerate() {
            backend.load(&cell, &spec.rays(study.voxel_size_m, study.backdrop))?;
            let placements: Vec<_> =
                spec.candidates.iter().map(|c| spec.placement(&c.pose, &world.truth.grid)).collect();
            let mut pose = 0;
            for batch in placements.chunks(backend.batch().max(1)) {
                let scored = backend.score(batch)?;
                if scored.len() != batch.len() || scored.iter().any(|r| r.len() != world.regions.len()) {
                    let what = format!("answered for {} of {} poses", scored.len(), batch.len());
                    return Err(Error::Device(format!("backend {}: {what}", backend.name())));
                }
                for regions in scored {
                    let counts = regions.into_iter().enumerate();
                    rows.extend(counts.map(|(region, counts)| Row { scene, sensor, pose, region, counts }));
                    pose += 1;
                }
                done(batch.len() as u64);
            }
        }
    }
    Ok(rows)
}
