//! The tables of rays that the sensors of a study cast.

use crate::input::Study;
use crate::sensor::RayScale;
use perirobot_march::backend::Rays;

/// The tables of rays that a study's sensors cast, in study order.
pub fn ray_tables(study: &Study) -> Vec<Option<Rays>> {
    ray_tables_of(study, |_| true)
}

/// Those of some sensors; nothing in the places of the others.
pub fn ray_tables_of(study: &Study, wanted: impl Fn(usize) -> bool) -> Vec<Option<Rays>> {
    (0..study.sensors.len())
        .map(|sensor| wanted(sensor).then(|| ray_table(study, sensor)).flatten())
        .collect()
}

/// The table of one of them, if it casts.
pub fn ray_table(study: &Study, sensor: usize) -> Option<Rays> {
    let scale = RayScale { voxel_size_m: study.voxel_size_m, backdrop: study.backdrop };
    study.sensors[sensor].kind.rays(&scale)
}
