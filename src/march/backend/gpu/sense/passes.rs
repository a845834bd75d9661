//! The passes of a batch of placements, a function each: which buffers a kernel reads and writes.

use crate::backend::gpu::kernels::Stage;
use crate::backend::gpu::loaded::{BufferPool, DeviceScene, DeviceTable};
use crate::backend::gpu::loop_bounds::TEAMS;
use crate::backend::gpu::pass::Pass;
use crate::backend::gpu::plan::{Caster, Dispatch};
use crate::backend::gpu::queue::Queue;
use crate::backend::gpu::tiles::BOX_EDGE;
use crate::backend::gpu::types::{ABREAST, HEAD_WORDS, HEADS, MOST_PLACEMENTS, PlacementWords};

/// What all passes of a batch share.
pub(super) struct SensePasses<'a> {
    pub(super) queue: &'a Queue,
    /// The scene, the parts of the dispatches, the table of rays.
    pub(super) uniforms: [&'a wgpu::Buffer; 3],
    pub(super) loaded: &'a DeviceScene,
    pub(super) table: &'a DeviceTable,
    /// The layer of blockers that rays are cast in.
    pub(super) layer: &'a wgpu::Buffer,
    pub(super) rays: &'a RayBuffers,
}

/// What a batch needs to cast rays.
pub(super) struct RayBuffers {
    /// How many placements.
    count: u32,
    placements: wgpu::Buffer,
    /// What is known of first hits in the still layer.
    first_hits: wgpu::Buffer,
    /// The ends of rays.
    pub(super) ends: wgpu::Buffer,
    /// What the tiles of images see.
    tiles: wgpu::Buffer,
    /// The tiles that are left open.
    listed: wgpu::Buffer,
}

/// What a batch needs besides to decide which voxels the pixels of cameras free.
pub(super) struct VoxelBuffers {
    pyramid: wgpu::Buffer,
    /// The boxes that the pyramid does not decide.
    undecided: wgpu::Buffer,
    /// The voxels that `carve_voxels` leaves to `carve_crowded` and `carve_near`, behind a head for each dispatch of either.
    left: wgpu::Buffer,
}

impl RayBuffers {
    /// Room for placements of a table.
    pub(super) fn new(
        queue: &Queue,
        room: &mut BufferPool,
        first_hits: wgpu::Buffer,
        placements: &[PlacementWords],
        table: &DeviceTable,
    ) -> Self {
        let (device, rows) = (&queue.device, placements.len() as u64);
        RayBuffers {
            count: placements.len() as u32,
            placements: room.placements.fill(device, placements),
            first_hits,
            ends: room.ends.hold(device, rows * table.sizes.ends_bytes()),
            tiles: room.tiles.hold(device, rows * table.sizes.tiles_bytes()),
            listed: room
                .listed
                .hold(device, if queue.lists() { table.sizes.listed_bytes(rows as u32) } else { 0 }),
        }
    }
}

impl VoxelBuffers {
    /// Room for a batch, and for what the largest of its dispatches leaves. All that its passes add to is cleared.
    pub(super) fn new(
        passes: &SensePasses,
        room: &mut BufferPool,
        encoder: &mut wgpu::CommandEncoder,
        dispatches: &[Dispatch],
    ) -> Self {
        let SensePasses { queue, loaded, table, rays, .. } = passes;
        let (device, rows) = (&queue.device, u64::from(rays.count));
        encoder.clear_buffer(&rays.tiles, 0, Some(rows * table.sizes.tiles_bytes()));
        encoder.clear_buffer(&rays.listed, 0, queue.lists().then_some(u64::from(2 * MOST_PLACEMENTS) * 4));
        let pyramid = room.pyramid.hold(device, rows * table.sizes.pyramid_bytes());
        // What no tile of the image writes is a block of pixels that free nothing.
        encoder.clear_buffer(&pyramid, 0, Some(rows * table.sizes.pyramid_bytes()));
        let by_voxel = dispatches.iter().filter(|d| d.stage == Stage::CarveVoxels);
        let heads = by_voxel.clone().count();
        let undecided = room.undecided.hold(device, loaded.sizes.undecided_bytes(rays.count));
        device.write(&undecided, 0, &vec![[0, 1, 1, 0]; heads]);
        let most_boxes = by_voxel.map(|d| d.part.end - d.part.first).max().unwrap_or(0);
        let list_words = u64::from(2 * HEADS * HEAD_WORDS + most_boxes * BOX_EDGE.pow(3));
        let left = room.left.hold(device, list_words * 4);
        device.write(&left, 0, &vec![[0, ABREAST / TEAMS, 1, 0]; heads]);
        let near = [0, ABREAST, table.sizes.groups_of_near(), 0];
        device.write(&left, u64::from(HEADS * HEAD_WORDS) * 4, &vec![near; heads]);
        VoxelBuffers { pyramid, undecided, left }
    }
}

impl SensePasses<'_> {
    pub(super) fn see_tiles(&self) -> Pass {
        self.pass(Stage::SeeTiles, &[&self.rays.placements, &self.loaded.boxes, &self.rays.tiles])
    }

    pub(super) fn cast_tiles(&self) -> Pass {
        let RayBuffers { placements, ends, tiles, listed, .. } = self.rays;
        self.pass(Stage::CastTiles, &[placements, &self.table.dirs, self.layer, tiles, ends, listed])
    }

    pub(super) fn cast(&self, caster: Caster) -> Pass {
        let RayBuffers { placements, first_hits, ends, listed, .. } = self.rays;
        let DeviceTable { dirs, noise, .. } = self.table;
        let over = |known| [placements, dirs, noise, self.layer, known, ends, &self.loaded.ended];
        match caster {
            Caster::Any => self.pass(Stage::Cast, &over(first_hits)),
            Caster::Plain => self.queue.plain_cast(&self.uniforms, &over(first_hits)),
            Caster::Listed => self.pass(Stage::CastListed, &over(listed)),
        }
    }

    pub(super) fn carve_rays(&self) -> Pass {
        let RayBuffers { placements, ends, .. } = self.rays;
        self.pass(Stage::CarveRays, &[placements, &self.table.dirs, ends, &self.loaded.free])
    }

    pub(super) fn build_pyramid(&self, voxels: &VoxelBuffers) -> Pass {
        self.pass(Stage::Pyramid, &[&self.rays.ends, &voxels.pyramid])
    }

    pub(super) fn carve_boxes(&self, voxels: &VoxelBuffers) -> Pass {
        let VoxelBuffers { pyramid, undecided, .. } = voxels;
        let DeviceScene { boxes, free, .. } = self.loaded;
        self.pass(Stage::CarveBoxes, &[&self.rays.placements, pyramid, boxes, undecided, free])
    }

    pub(super) fn carve_voxels(&self, voxels: &VoxelBuffers) -> Pass {
        let RayBuffers { placements, ends, .. } = self.rays;
        let VoxelBuffers { pyramid, undecided, left } = voxels;
        let storage = [placements, ends, pyramid, undecided, left, &self.loaded.free];
        self.pass(Stage::CarveVoxels, &storage).with_heads(undecided)
    }

    pub(super) fn carve_crowded(&self, voxels: &VoxelBuffers) -> Pass {
        let RayBuffers { placements, ends, .. } = self.rays;
        let VoxelBuffers { pyramid, undecided, left } = voxels;
        let storage = [placements, &self.table.dirs, ends, pyramid, undecided, left, &self.loaded.free];
        self.pass(Stage::CarveCrowded, &storage).with_heads(left)
    }

    pub(super) fn carve_near(&self, voxels: &VoxelBuffers) -> Pass {
        let RayBuffers { placements, ends, .. } = self.rays;
        let VoxelBuffers { pyramid, undecided, left } = voxels;
        let storage = [placements, &self.table.dirs, ends, pyramid, undecided, left, &self.loaded.free];
        self.pass(Stage::CarveNear, &storage).with_heads(left)
    }

    fn pass(&self, stage: Stage, storage: &[&wgpu::Buffer]) -> Pass {
        self.queue.pass(stage, &self.uniforms, storage)
    }
}
