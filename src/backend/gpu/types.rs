//! What the host and the shaders share: Rust mirrors of the structs in `shaders/types.wgsl`, and the constants, which
//! Rust owns and prints in front of every shader. Buffers and dispatches are left to the other files.

use std::fmt::Write;

use bytemuck::{Pod, Zeroable};

use crate::backend::{Cell, Fusion, LOG_ODDS, Placement, Rays, Slot};
use crate::march;
use crate::metrics::COUNTERS;

/// Invocations of a workgroup: one wave or two on any GPU, and a whole number of vectors on a software adapter.
pub const WORKGROUP: u32 = 64;

/// Words of a region that one invocation of `count` takes, so that a group's sums are worth their atomics.
pub const WORDS_PER_INVOCATION: u32 = 16;

/// The kernels, one a file of `shaders/`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// How each ray ends.
    Cast,
    /// What each ray's end proves.
    Carve,
    /// What the evidence of several sensors says together.
    Fuse,
    /// What that is worth in a region.
    Count,
}

impl Stage {
    /// All of them, in the order they run; a stage's place here is its completion counter.
    pub const ALL: [Stage; 4] = [Stage::Cast, Stage::Carve, Stage::Fuse, Stage::Count];

    /// The name of its file, without the ending.
    pub fn name(self) -> &'static str {
        ["cast", "carve", "fuse", "count"][self as usize]
    }
}

/// In place of a slot: evidence that there is not.
pub const NO_SLOT: Slot = u32::MAX;

/// The twin of `Setup` in `shaders/types.wgsl`: one scene, as long as it is loaded.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
#[allow(missing_docs)] // the fields' meanings are those of Cell
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
}

impl Setup {
    /// The numbers of a scene.
    pub fn new(cell: &Cell) -> Self {
        let [grid_x, grid_y, grid_z] = cell.blockers.window().size;
        let [window_min_x, window_min_y, window_min_z] = cell.window.min;
        let [window_x, window_y, window_z] = cell.window.size;
        Setup {
            grid_x,
            grid_y,
            grid_z,
            grid_words_per_row: cell.blockers.words_per_row(),
            window_min_x,
            window_min_y,
            window_min_z,
            window_words_per_row: cell.truth.words_per_row(),
            window_x,
            window_y,
            window_z,
            window_words: cell.truth.words().len() as u32,
            regions: cell.regions.len() as u32,
        }
    }
}

/// The twin of `Table` in `shaders/types.wgsl`: one table of rays.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
#[allow(missing_docs)] // the fields' meanings are those of Rays
pub struct TableWords {
    pub rays: u32,
    pub range_min_q16: u32,
    pub range_max_q16: u32,
    pub near_ignore_q16: u32,
    pub no_return_is_free: u32,
    pub backdrop: u32,
    /// Whether there are steps of noise.
    pub noisy: u32,
}

impl From<&Rays> for TableWords {
    fn from(rays: &Rays) -> Self {
        let gates = rays.gates;
        TableWords {
            rays: rays.dirs_q15.len() as u32,
            range_min_q16: gates.range_min_q16,
            range_max_q16: gates.range_max_q16,
            near_ignore_q16: gates.near_ignore_q16,
            no_return_is_free: gates.no_return_is_free as u32,
            backdrop: gates.backdrop as u32,
            noisy: !rays.noise_q16.is_empty() as u32,
        }
    }
}

/// The twin of `Part` in `shaders/types.wgsl`: what one dispatch covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Part {
    /// The placement or job, counted from the first of the batch, of the first row of workgroups.
    pub first_row: u32,
    /// First ray, or first word of the window.
    pub first: u32,
    /// The ray or word after the last.
    pub end: u32,
    /// Which region is counted; 0 for all but `count`.
    pub region: u32,
}

/// The twin of `Placement` in `shaders/types.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlacementWords {
    /// As [`Placement::origin_q16`].
    pub origin_q16: [i32; 3],
    /// Row 0 of [`Placement::axis_q15`].
    pub axis_x_q15: [i32; 3],
    /// Row 1.
    pub axis_y_q15: [i32; 3],
    /// Row 2.
    pub axis_z_q15: [i32; 3],
    /// As [`Placement::draws`].
    pub draws: u32,
    /// Where the evidence goes.
    pub slot: Slot,
}

impl PlacementWords {
    /// A placement, and the slot that its evidence goes to.
    pub fn new(slot: Slot, placement: &Placement) -> Self {
        let [axis_x_q15, axis_y_q15, axis_z_q15] = placement.axis_q15;
        let Placement { origin_q16, draws, .. } = *placement;
        PlacementWords { origin_q16, axis_x_q15, axis_y_q15, axis_z_q15, draws, slot }
    }
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
    pub fn new(fusion: Fusion, readings: std::ops::Range<u32>) -> Self {
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
}

/// What stands in front of every kernel: the constants, the structs and the march. A kernel of a test's own can
/// follow it.
pub fn shader_prelude() -> String {
    let mut source = String::from("// Constants, printed by src/backend/gpu/types.rs.\n");
    let constants = [
        ("NEVER", march::NEVER),
        ("MAX_RANGE_VOXELS", march::MAX_RANGE_VOXELS),
        ("DRAW_SHIFT", 32 - march::NOISE_STEPS.ilog2()),
        ("NOTHING", march::NOTHING),
        ("RETURN", march::RETURN),
        ("BLIND", march::BLIND),
        ("LEFT", march::LEFT),
        ("WORKGROUP", WORKGROUP),
        ("WORDS_PER_INVOCATION", WORDS_PER_INVOCATION),
        ("COUNTERS", COUNTERS as u32),
        ("KERNELS", Stage::ALL.len() as u32),
        ("CAST", Stage::Cast as u32),
        ("CARVE", Stage::Carve as u32),
        ("FUSE", Stage::Fuse as u32),
        ("COUNT", Stage::Count as u32),
        ("NO_SLOT", NO_SLOT),
    ];
    for (name, value) in constants {
        writeln!(source, "const {name} = {value}u;").expect("writing to a string");
    }
    for (name, value) in [("LEAST_LOG_ODDS", LOG_ODDS.start()), ("MOST_LOG_ODDS", LOG_ODDS.end())] {
        writeln!(source, "const {name} = {value}i;").expect("writing to a string");
    }
    source + include_str!("../../../shaders/types.wgsl") + include_str!("../../../shaders/march.wgsl")
}

/// The whole source of a kernel, as the device gets it: prelude and kernel, joined.
pub fn shader_source(stage: Stage) -> String {
    shader_prelude()
        + match stage {
            Stage::Cast => include_str!("../../../shaders/cast.wgsl"),
            Stage::Carve => include_str!("../../../shaders/carve.wgsl"),
            Stage::Fuse => include_str!("../../../shaders/fuse.wgsl"),
            Stage::Count => include_str!("../../../shaders/count.wgsl"),
        }
}
