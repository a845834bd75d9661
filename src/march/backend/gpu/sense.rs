//! Casts and carves a batch of placements, pass by pass. `plan.rs` cuts the work, `passes` has the buffers of each kernel.

mod passes;

use super::first_hits::FirstHitCache;
use super::kernels::Stage;
use super::plan::CastBatch;
use super::types::PlacementWords;
use super::{Gpu, no_scene};
use crate::backend::{Carving, Shot, no_table};
use crate::{Error, Result};
use passes::{RayBuffers, SensePasses, VoxelBuffers};

impl Gpu {
    /// Casts and carves a batch of placements into their slots: all of their evidence, or what is inside the
    /// regions. The buffer returned begins with the ends of the first, if there is only one, in the order in
    /// which it was carved. Hits are kept of all of them or of none.
    pub(super) fn sense_batch(
        &mut self,
        table: usize,
        shots: &[Shot],
        everything: bool,
    ) -> Result<(wgpu::Buffer, Carving)> {
        self.keep_first_hits(table, shots)?;
        let Gpu { queue, room, tables, loaded, kept, carving, .. } = self;
        let loaded = loaded.as_mut().ok_or_else(no_scene)?;
        let table = tables.get(table).ok_or_else(|| no_table(table))?;
        let mut encoder = queue.device.encoder();
        for &Shot { slot, .. } in shots {
            loaded.clear_slot(&mut encoder, slot)?;
            loaded.held[slot as usize] = true;
        }
        // Where the first hits in the still layer are known, the other blockers are enough.
        let known = shots.iter().all(|shot| shot.first_hits.is_some());
        let others = loaded.layers.as_ref().filter(|_| known).map(|[_, moving]| moving);
        let sizes = &loaded.sizes;
        let is_shaded = table.rays.gates.has_shades() && loaded.blockers.is_shaded();
        let is_plain =
            |shot: &Shot| shot.first_hits.is_none() && shot.placement.truly.is_none() && !is_shaded;
        let batch = CastBatch {
            placements: shots.len() as u32,
            everything,
            carving: carving.filter(|_| table.sizes.has_tiles()).unwrap_or(sizes.carving(&table.sizes)),
            whole_layer: others.is_none(),
            plain: shots.iter().all(is_plain),
            lists: queue.lists(),
        };
        let dispatches = sizes.sensing(&table.sizes, &batch, &queue.pace);
        let words: Vec<_> = shots.iter().map(PlacementWords::from).collect();
        let rays = RayBuffers::new(queue, room, kept.buffer(&queue.device), &words, table);
        let parts = queue.parts(&dispatches);
        let uniforms = [&loaded.setup, &parts, &table.words];
        let layer = others.unwrap_or_else(|| loaded.blockers.buffer(&queue.device));
        let passes = SensePasses { queue, uniforms, loaded, table, layer, rays: &rays };
        let passes = match batch.carving {
            Carving::ByRay => vec![passes.cast(batch.caster()), passes.carve_rays()],
            Carving::ByVoxel => {
                let voxels = VoxelBuffers::new(&passes, room, &mut encoder, &dispatches);
                vec![
                    passes.see_tiles(),
                    passes.cast_tiles(),
                    passes.cast(batch.caster()),
                    passes.build_pyramid(&voxels),
                    passes.carve_boxes(&voxels),
                    passes.carve_voxels(&voxels),
                    passes.carve_crowded(&voxels),
                    passes.carve_near(&voxels),
                ]
            }
        };
        queue.run(encoder, &dispatches, &passes);
        Ok((rays.ends, batch.carving))
    }

    /// Searches the still layer for placements whose first hits are to be kept, but are not.
    fn keep_first_hits(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        let Gpu { queue, room, tables, loaded, kept, .. } = self;
        let loaded = loaded.as_ref().ok_or_else(no_scene)?;
        let table = tables.get(table).ok_or_else(|| no_table(table))?;
        let FirstHitCache { held, .. } = kept;
        let mut new = Vec::new();
        for shot in shots {
            match shot.first_hits.map(|first_hits| held.get_mut(first_hits as usize)) {
                Some(Some(held)) if *held => {}
                Some(Some(held)) => {
                    *held = true;
                    new.push(PlacementWords::from(shot));
                }
                Some(None) => {
                    return Err(Error::device(format!(
                        "no slot {:?} for first hits: there are {}",
                        shot.first_hits,
                        held.len()
                    )));
                }
                None => {}
            }
        }
        let Some([still, _]) = loaded.layers.as_ref().filter(|_| !new.is_empty()) else { return Ok(()) };
        let dispatches = loaded.sizes.keeping(&table.sizes, new.len() as u32, &queue.pace);
        let placements = room.placements.fill(&queue.device, &new);
        let (first_hits, parts) = (kept.buffer(&queue.device), queue.parts(&dispatches));
        let uniforms = [&loaded.setup, &parts, &table.words];
        let storage = [&placements, &table.dirs, still, &first_hits];
        let pass = queue.pass(Stage::StaticHits, &uniforms, &storage);
        queue.run(queue.device.encoder(), &dispatches, &[pass]);
        Ok(())
    }
}
