//! The tables of rays that the sensors of a study cast. They are made once: a study keeps those that were requested last,
//! and so do its copies with other poses or combinations. Clones of a table share its rays, so backends recognise it.

use std::sync::{Arc, Mutex, PoisonError};

use crate::input::Study;
use crate::sensor::{Kind, RayScale};
use perirobot_march::backend::Rays;

/// Most rays that are kept: 64 MiB of directions.
const MOST_KEPT: usize = (64 << 20) / size_of::<[i32; 3]>();

/// The tables of rays that were requested last, the latest last.
#[derive(Clone, Debug, Default)]
pub struct KeptRays(Arc<Mutex<Vec<KeptTable>>>);

/// A table, and what it was made of.
#[derive(Debug)]
struct KeptTable {
    kind: Arc<dyn Kind>,
    scale: RayScale,
    rays: Rays,
}

impl KeptRays {
    /// The table of a kind of sensor, if it casts.
    fn table(&self, kind: &Arc<dyn Kind>, scale: RayScale) -> Option<Rays> {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_its_own = |known: &KeptTable| {
            std::ptr::addr_eq(Arc::as_ptr(&known.kind), Arc::as_ptr(kind)) && known.scale == scale
        };
        let mut kept = lock();
        if let Some(known) = kept.iter().rposition(is_its_own) {
            let table = kept.remove(known);
            let rays = table.rays.clone();
            kept.push(table);
            return Some(rays);
        }
        // Others need not wait while it is made.
        drop(kept);
        let rays = kind.rays(&scale)?;
        let mut kept = lock();
        kept.push(KeptTable { kind: kind.clone(), scale, rays: rays.clone() });
        let mut room = MOST_KEPT;
        let fitting = kept.iter().rev().take_while(|table| {
            let left = room.checked_sub(table.rays.dirs_q15.len());
            room = left.unwrap_or(0);
            left.is_some()
        });
        let forgotten = kept.len() - fitting.count();
        kept.drain(..forgotten);
        Some(rays)
    }
}

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
    let scale = study.ray_scale();
    study.kept_rays.table(&study.sensors[sensor].kind, scale)
}
