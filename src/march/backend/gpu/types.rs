//! What the host and the shaders share: Rust mirrors of the structs in `shaders/types.wgsl`, and the
//! constants, which Rust owns and prints in front of every shader.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};

use super::loop_bounds::last_near_voxels;
use crate::backend::{Fusion, GridFrame, GridPose, Image, Rays, Shot, Slot, VoxelScene};
use crate::metrics::COUNTERS;
use crate::voxel::{Bricks, Window};

/// Most dispatches of `carve_voxels` in a batch; each has a head in the list of boxes, and two in the list of what it leaves.
pub const HEADS: u32 = 2048;

/// Words of a head: the workgroups of a dispatch (x, y, z), and how many voxels are left, or boxes of all dispatches.
pub const HEAD_WORDS: u32 = 4;

/// Most placements of a batch.
pub const MOST_PLACEMENTS: u32 = 512;

/// Most boxes of a dispatch of `carve_voxels`: the list of what it leaves holds all of their voxels.
pub const BOXES_AT_ONCE: u32 = 16_320;

/// Voxels that `carve_crowded` and `carve_near` take for each of their workgroups on x, whose number is limited.
pub const ABREAST: u32 = 128;

/// No ray is read farther away: noise of 64 voxels, times the four or so of the largest of its steps, past
/// the farthest range.
pub const FARTHEST_READ_Q16: u32 = (1 << 28) - 1;

/// In place of a slot: there is no evidence.
pub const NO_SLOT: Slot = u32::MAX;

/// What `shaders/count.wgsl` counts of a region: labels, then what at least two readings label.
pub const REGION_COUNTERS: usize = COUNTERS + 1;

/// The twin of `Setup` in `shaders/types.wgsl`: one scene, as long as it is loaded.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
#[allow(missing_docs)] // the fields' meanings are those of VoxelScene
pub struct Setup {
    pub grid_x: u32,
    pub grid_y: u32,
    pub grid_z: u32,
    pub grid_words_per_row: u32,
    pub window_min_x: i32,
    pub window_min_y: i32,
    pub window_min_z: i32,
    pub window_words_per_row: u32,
    pub window_x: u32,
    pub window_y: u32,
    pub window_z: u32,
    pub window_words: u32,
    pub regions: u32,
    pub bricks_x: u32,
    pub bricks_y: u32,
    pub bricks_word: u32,
    /// The word of a layer where its shades begin; 0 where there are none.
    pub shades_word: u32,
    pub first_hits_stride: u32,
    pub detection_counters: u32,
    /// Two boxes of the blockers that are not in the still layer; of none where there is no such layer.
    pub moving_min_x: i32,
    pub moving_min_y: i32,
    pub moving_min_z: i32,
    pub moving_x: u32,
    pub moving_y: u32,
    pub moving_z: u32,
    pub others_min_x: i32,
    pub others_min_y: i32,
    pub others_min_z: i32,
    pub others_x: u32,
    pub others_y: u32,
    pub others_z: u32,
}

impl Setup {
    /// The numbers of a scene, the boxes of its blockers that are not in the still layer, the words of a slot of first hits in
    /// that layer, and the counters of people's hits of a job.
    pub(crate) fn new(
        scene: &VoxelScene,
        moving: [Window; 2],
        first_hits_stride: u32,
        detection_counters: u32,
    ) -> Self {
        let [
            Window { min: [moving_min_x, moving_min_y, moving_min_z], size: [moving_x, moving_y, moving_z] },
            Window { min: [others_min_x, others_min_y, others_min_z], size: [others_x, others_y, others_z] },
        ] = moving;
        let [bricks_x, bricks_y, _] = Bricks::size_of(scene.blockers.window().size);
        let [grid_x, grid_y, grid_z] = scene.blockers.window().size;
        let [window_min_x, window_min_y, window_min_z] = scene.window.min;
        let [window_x, window_y, window_z] = scene.window.size;
        Setup {
            grid_x,
            grid_y,
            grid_z,
            grid_words_per_row: scene.blockers.words_per_row(),
            window_min_x,
            window_min_y,
            window_min_z,
            window_words_per_row: scene.truth.words_per_row(),
            window_x,
            window_y,
            window_z,
            window_words: scene.truth.words().len() as u32,
            regions: scene.regions.len() as u32,
            bricks_x,
            bricks_y,
            bricks_word: scene.blockers.words().len() as u32,
            shades_word: shades_word(scene),
            first_hits_stride,
            detection_counters,
            moving_min_x,
            moving_min_y,
            moving_min_z,
            moving_x,
            moving_y,
            moving_z,
            others_min_x,
            others_min_y,
            others_min_z,
            others_x,
            others_y,
            others_z,
        }
    }
}

/// The word of a layer of a scene where its shades begin: after its blockers and their bricks, two a word. 0 where there are
/// none.
fn shades_word(scene: &VoxelScene) -> u32 {
    let bricks: u32 = Bricks::size_of(scene.blockers.window().size).into_iter().product();
    match scene.shades {
        Some(_) => scene.blockers.words().len() as u32 + bricks.div_ceil(2),
        None => 0,
    }
}

/// The twin of `Table` in `shaders/types.wgsl`: one table of rays.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
#[allow(missing_docs)] // the fields' meanings are those of Rays
pub struct TableWords {
    /// Words of `ends` from one placement to the next: its rays, or where these may go by tiles those of whole tiles and a word
    /// a tile, in whole fours.
    pub ends_stride: u32,
    pub range_min_q16: u32,
    pub range_max_q16: u32,
    /// Whether these, and the deviations of noise, are depths.
    pub along_axis: u32,
    pub near_ignore_q16: u32,
    pub no_return_is_free: u32,
    pub backdrop: u32,
    /// Whether returns are read elsewhere than they are.
    pub noisy: u32,
    pub lost_below: u32,
    /// Whether dark blockers return less far than others, and how far those of each shade do.
    pub shaded: u32,
    pub shade_range_1_q16: u32,
    pub shade_range_2_q16: u32,
    pub shade_range_3_q16: u32,
    pub shade_range_4_q16: u32,
    pub shade_range_5_q16: u32,
    pub shade_range_6_q16: u32,
    pub shade_range_7_q16: u32,
    pub image_x: u32,
    pub image_y: u32,
    pub focal_x: f32,
    pub focal_y: f32,
    /// Depth in voxels up to which voxels are near.
    pub near: f32,
    /// How much nearer than it is a return may be read, in voxels.
    pub nearer: f32,
}

impl TableWords {
    /// A table of rays, and how far apart the ends of its placements are.
    pub fn new(rays: &Rays, ends_stride: u32) -> Self {
        let gates = rays.gates;
        let image = rays.image.unwrap_or(Image { size_px: [0; 2], focal_px: [1.0; 2] });
        TableWords {
            ends_stride,
            range_min_q16: gates.range_min_q16,
            range_max_q16: gates.range_max_q16,
            along_axis: gates.along_axis as u32,
            near_ignore_q16: gates.near_ignore_q16,
            no_return_is_free: gates.no_return_is_free as u32,
            backdrop: gates.backdrop as u32,
            noisy: !rays.noise.unit_q12.is_empty() as u32,
            lost_below: rays.noise.lost_below,
            shaded: gates.has_shades() as u32,
            shade_range_1_q16: gates.shade_ranges_q16[0],
            shade_range_2_q16: gates.shade_ranges_q16[1],
            shade_range_3_q16: gates.shade_ranges_q16[2],
            shade_range_4_q16: gates.shade_ranges_q16[3],
            shade_range_5_q16: gates.shade_ranges_q16[4],
            shade_range_6_q16: gates.shade_ranges_q16[5],
            shade_range_7_q16: gates.shade_ranges_q16[6],
            image_x: image.size_px[0],
            image_y: image.size_px[1],
            focal_x: image.focal_px[0] as f32,
            focal_y: image.focal_px[1] as f32,
            near: last_near_voxels(&image) as f32,
            nearer: (rays.nearest_q16() >> 16) as f32 + 1.0,
        }
    }
}

/// The twin of `Part` in `shaders/types.wgsl`: what one dispatch covers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Part {
    /// The placement or job, counted from the first of the batch, of the first row of workgroups.
    pub first_row: u32,
    /// First ray, block of pixels, box, or word of the window.
    pub first: u32,
    /// The one after the last.
    pub end: u32,
    /// Which region is counted; 0 for all but `count`.
    pub region: u32,
    /// Whether all rays are cast, those included that do not come near the window or that tiles would do without.
    pub every_ray: u32,
    /// Of how many tiles an invocation takes a column; 0 where rays do not go by tiles. In `see_tiles` how
    /// many boxes a workgroup takes, in `cast_listed` how many tiles there are from one of a workgroup to its next.
    pub tiles: u32,
    /// Whether the layer that is bound holds all blockers.
    pub whole_layer: u32,
    /// Boxes of a dispatch of `carve_voxels`; 0 for all but `carve_boxes`.
    pub boxes_at_once: u32,
    /// Always 0; that it is read from a buffer keeps compilers from assuming so (`shaders/completion.wgsl`).
    pub zero: u32,
}

/// The twin of `GridPose` in `shaders/types.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlacementWords {
    /// Where it is believed to be.
    pub believed: GridFrame,
    /// Where its rays are cast from: the same again, unless the mount is off.
    pub truly: GridFrame,
    /// Whether the mount is off.
    pub is_off: u32,
    /// As [`GridPose::draws`].
    pub draws: u32,
    /// Where the evidence goes.
    pub slot: Slot,
    /// Where its first hits in the still layer are kept, or [`NO_SLOT`].
    pub first_hits: Slot,
}

// `shaders/carve_crowded.wgsl` looks up where a sensor is believed to be, and the slot, by number.
const _: () = assert!(
    offset_of!(PlacementWords, believed) == 0
        && offset_of!(GridFrame, origin_q16) == 0
        && offset_of!(GridFrame, axis_q15) == 4 * 3
        && offset_of!(PlacementWords, slot) == 4 * (6 * 4 + 2)
);

impl From<&Shot> for PlacementWords {
    fn from(shot: &Shot) -> Self {
        let GridPose { origin_q16, axis_q15, truly, draws } = shot.placement;
        let believed = GridFrame { origin_q16, axis_q15 };
        PlacementWords {
            believed,
            truly: truly.unwrap_or(believed),
            is_off: truly.is_some() as u32,
            draws,
            slot: shot.slot,
            first_hits: shot.first_hits.unwrap_or(NO_SLOT),
        }
    }
}

/// A ray's direction as tables have it on the device, where `unpacked_dir` of `shaders/types.wgsl` reads it. Each component needs 17
/// bits, since it reaches 32768.
///
/// Software adapters look words up for one invocation after the other, and two that lie together at once: three words of a
/// direction would take them nearly twice as long.
pub fn dir_words([x, y, z]: [i32; 3]) -> [u32; 2] {
    [(x << 15 | z & 0x7fff) as u32, (y << 15 | z >> 15 & 3) as u32]
}

/// The twin of `Job` in `shaders/types.wgsl`: which readings are fused, and how.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct JobWords {
    /// The first reading.
    pub first: u32,
    /// The reading after the last.
    pub end: u32,
    /// Whether log-odds are summed.
    pub octomap: u32,
}

impl JobWords {
    /// A job of the readings in a range of those of its batch.
    pub(crate) fn new(fusion: Fusion, readings: std::ops::Range<u32>) -> Self {
        JobWords { first: readings.start, end: readings.end, octomap: (fusion == Fusion::Octomap) as u32 }
    }
}

/// The twin of `Reading` in `shaders/types.wgsl`; the meanings are those of [`crate::backend::Reading`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
#[allow(missing_docs)]
pub struct ReadingWords {
    /// A slot, or [`NO_SLOT`].
    pub slot: Slot,
    /// A slot, or [`NO_SLOT`].
    pub volume: Slot,
    pub hit: i32,
    pub miss: i32,
    pub presence: u32,
}
