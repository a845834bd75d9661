//! Casting and carving a batch of placements: which kernels run, over which buffers. `plan.rs` cuts the work.

use super::kernels::Stage;
use super::loaded::FirstHitCache;
use super::plan::CastBatch;
use super::tiles::BOX_EDGE;
use super::types::{ABREAST, HEADS, PlacementWords};
use super::{Gpu, no_scene};
use crate::backend::{Carving, Shot, no_table};
use crate::{Error, Result};

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
        let sizes = &loaded.sizes;
        let near =
            |shot: &&Shot| everything || table.sizes.is_near(shot.placement.origin_q16, &loaded.corners);
        let (near, far): (Vec<&Shot>, Vec<&Shot>) = shots.iter().partition(near);
        // Where the first hits in the still layer are known, the other blockers are enough.
        let known = shots.iter().all(|shot| shot.first_hits.is_some());
        let others = loaded.layers.as_ref().filter(|_| known).map(|[_, moving]| moving);
        let batch = CastBatch {
            placements: shots.len() as u32,
            near: near.len() as u32,
            everything,
            carving: carving.filter(|_| table.sizes.has_tiles()).unwrap_or(sizes.carving(&table.sizes)),
            whole_layer: others.is_none(),
            plain: shots.iter().all(|shot| shot.first_hits.is_none() && shot.placement.truly.is_none()),
        };
        let mut encoder = queue.device.encoder();
        for &Shot { slot, .. } in shots {
            let (offset, bytes) = (loaded.offset(slot)?, sizes.plane_bytes());
            encoder.clear_buffer(&loaded.ended, 2 * offset, Some(2 * bytes));
            encoder.clear_buffer(&loaded.free, offset, Some(bytes));
            loaded.held[slot as usize] = true;
        }
        let dispatches = sizes.sensing(&table.sizes, &batch, &queue.pace);
        let words = near.into_iter().chain(far).map(PlacementWords::from);
        let placements = room.placements.fill(&queue.device, &words.collect::<Vec<_>>());
        let rows = u64::from(batch.placements);
        let ends = room.ends.hold(&queue.device, rows * table.sizes.ends_bytes());
        let first_hits = kept.buffer(&queue.device);
        let parts = queue.parts(&dispatches);
        let uniforms = [&loaded.setup, &parts, &table.words];
        let rays = [&placements, &table.dirs];
        let bind = |stage, storage: &[&[&wgpu::Buffer]]| queue.bind(stage, &uniforms, &storage.concat());
        let layer = others.unwrap_or(&loaded.blockers);
        let cast = [&table.noise, layer, &first_hits, &ends, &loaded.ended];
        let cast = bind(Stage::Cast, &[&rays, &cast]);
        let tiles = room.tiles.hold(&queue.device, rows * table.sizes.tiles_bytes());
        let carve_rays = bind(Stage::CarveRays, &[&rays, &[&ends, &tiles, &loaded.free]]);
        if batch.carving == Carving::ByRay {
            queue.run(
                encoder,
                &dispatches,
                None,
                |d| if d.stage == Stage::Cast { &cast } else { &carve_rays },
            );
            return Ok((ends, batch.carving));
        }
        encoder.clear_buffer(&tiles, 0, Some(rows * table.sizes.tiles_bytes()));
        let see_tiles = bind(Stage::SeeTiles, &[&[&placements, &loaded.boxes, &tiles]]);
        let cast_tiles = bind(Stage::CastTiles, &[&rays, &[layer, &tiles, &ends]]);
        let pyramid = room.pyramid.hold(&queue.device, rows * table.sizes.pyramid_bytes());
        // What no tile of the image writes is a block of pixels that free nothing.
        encoder.clear_buffer(&pyramid, 0, Some(rows * table.sizes.pyramid_bytes()));
        let undecided = room.undecided.hold(&queue.device, sizes.undecided_bytes(batch.placements));
        encoder.clear_buffer(&undecided, 0, Some(4));
        let reduce = bind(Stage::Pyramid, &[&[&ends, &pyramid]]);
        let carve_boxes = [&placements, &pyramid, &loaded.boxes, &undecided, &loaded.free];
        let carve_boxes = bind(Stage::CarveBoxes, &[&carve_boxes]);
        let heads = [[0, ABREAST, 1, 0]; HEADS as usize];
        let by_voxel = dispatches.iter().filter(|d| d.stage == Stage::CarveVoxels);
        let most_boxes = by_voxel.map(|d| d.part.end - d.part.first).max().unwrap_or(0);
        let left = room
            .left
            .hold(&queue.device, (size_of_val(&heads) as u64) + u64::from(most_boxes * BOX_EDGE.pow(3)) * 4);
        queue.device.write(&left, 0, &heads);
        let looked = [&ends, &pyramid, &undecided, &left, &loaded.free];
        let carve_voxels = bind(Stage::CarveVoxels, &[&rays, &looked]);
        let carve_crowded = bind(Stage::CarveCrowded, &[&rays, &looked]);
        queue.run(encoder, &dispatches, Some(&left), |d| match d.stage {
            Stage::SeeTiles => &see_tiles,
            Stage::CastTiles => &cast_tiles,
            Stage::Cast => &cast,
            Stage::Pyramid => &reduce,
            Stage::CarveBoxes => &carve_boxes,
            Stage::CarveVoxels => &carve_voxels,
            Stage::CarveCrowded => &carve_crowded,
            _ => &carve_rays,
        });
        Ok((ends, batch.carving))
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
        let bound = queue.bind(Stage::StaticHits, &uniforms, &[&placements, &table.dirs, still, &first_hits]);
        queue.run(queue.device.encoder(), &dispatches, None, |_| &bound);
        Ok(())
    }
}
