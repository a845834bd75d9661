//! First hits in a still layer, kept on the device from snapshot to snapshot.

use std::sync::Arc;

use super::buffers::GrowingBuffer;
use super::device::GpuDevice;
use super::layers::layer_words;
use super::loaded::DeviceTable;
use crate::backend::OverTime;
use crate::voxel::BitGrid;

/// A still layer, and what rays hit first in it: these are kept as long as the layer and the tables are.
pub(super) struct FirstHitCache {
    over_time: Option<Arc<OverTime>>,
    /// The still layer that was uploaded last, which is mostly that of the next snapshot.
    still: Option<(Arc<BitGrid>, wgpu::Buffer)>,
    /// Words of a slot.
    pub(super) stride: u32,
    /// Which slots hold first hits in this layer.
    pub(super) held: Vec<bool>,
    room: GrowingBuffer,
}

impl FirstHitCache {
    /// Nothing is kept.
    pub(super) fn new() -> Self {
        FirstHitCache {
            over_time: None,
            still: None,
            stride: 0,
            held: Vec::new(),
            room: GrowingBuffer::storage("first_hits"),
        }
    }

    /// Forgets what is kept: other tables are to be cast.
    pub(super) fn forget(&mut self) {
        self.over_time = None;
    }

    /// Another scene, perhaps of the same still layer.
    pub(super) fn load(
        &mut self,
        device: &GpuDevice,
        over_time: Option<&Arc<OverTime>>,
        tables: &[DeviceTable],
        memory_bytes: Option<u64>,
    ) {
        // Another layer's buffer goes before the new one is made, so that both need not fit side by side.
        let is_next = |still: &Arc<BitGrid>| {
            over_time.is_some_and(|all| Arc::ptr_eq(still, &all.always) || *still == all.always)
        };
        self.still.take_if(|(still, _)| !is_next(still));
        let same = self.over_time.as_ref().zip(over_time).is_some_and(|(a, b)| Arc::ptr_eq(a, b));
        if !same {
            let largest = tables.iter().map(|table| &table.sizes).max_by_key(|sizes| sizes.rays_bytes());
            let slots = largest.map_or(0, |sizes| sizes.first_hits_at_once(&device.report, memory_bytes));
            self.stride = largest.map_or(0, |sizes| (sizes.rays_bytes() / 4) as u32);
            self.held = vec![false; if over_time.is_some() { slots.min(MOST_FIRST_HITS) } else { 0 }];
            self.over_time = over_time.cloned();
        }
    }

    /// The still layer of the loaded scene on the device.
    pub(super) fn still_layer(&mut self, device: &GpuDevice, still: &Arc<BitGrid>) -> wgpu::Buffer {
        let upload = || (still.clone(), device.upload("still", &layer_words(still, None)));
        self.still.get_or_insert_with(upload).1.clone()
    }

    /// The buffer of all slots.
    pub(super) fn buffer(&mut self, device: &GpuDevice) -> wgpu::Buffer {
        self.room.hold(device, self.held.len() as u64 * u64::from(self.stride) * 4)
    }
}

/// Most placements whose first hits are kept, however few their rays.
const MOST_FIRST_HITS: usize = 4096;
