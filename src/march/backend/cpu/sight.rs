//! What the rays of a table see of a scene from any pose, without noise: for whoever asks what a sensor would notice, not
//! what it says. The voxels are those of the backend's evidence if a ray that ends in nothing certifies what it passed.

use super::first_hit::Layer;
use super::plan::RelevantVoxels;
use super::scratch::Scratch;
use super::simd::SimdLevel;
use super::table::{Blockers, RayTable, TableCaster};
use crate::backend::{GridPose, Noise, Rays};
use crate::march::Gates;
use crate::voxel::BitGrid;

/// A table of rays, made ready.
pub struct SightRays(RayTable);

/// What stops rays, made ready.
pub struct SightScene {
    blockers: Layer,
    all: RelevantVoxels,
}

impl SightRays {
    /// The rays of a table, whatever their noise.
    pub fn new(rays: &Rays) -> SightRays {
        let gates = Gates { no_return_is_free: true, backdrop: false, ..rays.gates };
        SightRays(RayTable::new(&Rays { gates, noise: Noise::default(), ..rays.clone() }))
    }
}

impl SightScene {
    /// A scene with these blockers, over the whole grid.
    pub fn new(blockers: &BitGrid) -> SightScene {
        let all = RelevantVoxels::all(blockers.window());
        SightScene { blockers: Layer::new(blockers.clone()), all }
    }

    /// The voxels that rays pass within their longest range, the first included, and those of the first blockers. A ray whose
    /// first blocker is nearer than its shortest range sees nothing.
    pub fn seen(&self, rays: &SightRays, from: &GridPose) -> BitGrid {
        let SimdLevel { level, wide, .. } = SimdLevel::most();
        let blockers = Blockers { still: None, moving: &self.blockers, sometimes: None };
        let caster = TableCaster {
            level,
            wide,
            table: &rays.0,
            blockers,
            wanted: &self.all,
            carving: None,
            plane_words: 0,
        };
        let planes = caster.sense(&from.caster(), &mut Scratch::new(&caster), None, None);
        let mut seen = planes.free;
        seen.add(&planes.occupied);
        seen
    }
}

impl std::fmt::Debug for SightRays {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SightRays").field("gates", &self.0.gates).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for SightScene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SightScene").field("window", &self.all.voxels.window()).finish_non_exhaustive()
    }
}
