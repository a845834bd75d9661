//! The kernels, each stated once: its file in `shaders/`, the code it shares with others, what it binds, and
//! how many items a workgroup takes. Its name is also its label in timings and, in capitals, the constant by
//! which it reports. `src/guide/change_it.md` lists what a new kernel takes.

use perirobot_shaders::*;

use super::loop_bounds::{FUSED_WORDS, WORDS_PER_INVOCATION, WORKGROUP};
use super::tiles::TILE;
use Binding::{Part, Read, Uniform, Write};

/// The proof that a kernel ran to its end, which follows the prelude in every kernel and needs the binding
/// `done`.
pub const SHADER_COMPLETION: &str = COMPLETION.text;

/// Words that prove that kernels ran to their ends: of each stage, the workgroups that did, then of each the
/// invocations whose loops did. Then of each the workgroups that the device asked for itself.
pub const DONE_WORDS: u32 = 3 * Stage::ALL.len() as u32;

/// How a kernel sees a buffer; bindings are numbered in the order given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Binding {
    /// A uniform.
    Uniform,
    /// The uniform that tells a dispatch its part; each dispatch has its own offset into it.
    Part,
    /// Storage that is only read.
    Read,
    /// Storage that is written.
    Write,
}

/// What the host knows of a kernel.
pub(super) struct KernelEntry {
    pub(super) shader: Shader,
    /// Code in front of it that other kernels have too.
    pub(super) with: &'static [Shader],
    /// Items of a row of a dispatch that one workgroup takes; so many for each of its tiles, where it takes several.
    items_per_group: u32,
    /// How it sees the buffers that it is bound to, in the order of their numbers.
    bindings: &'static [Binding],
}

/// Makes of each line a variant of [`Stage`] and its [`KernelEntry`]; the entry point of a kernel is always `main`.
macro_rules! kernels {
    ($(#[doc = $doc:literal] $stage:ident = $shader:ident, $with:expr, $items:expr, [$($binding:ident)*];)*) => {
        /// The kernels, one a file of `shaders/`, in the order they run. A kernel's place here is that of its
        /// completion counters.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Stage {
            $(#[doc = $doc] $stage,)*
        }

        impl Stage {
            /// All of them.
            pub const ALL: [Stage; [$($shader),*].len()] = [$(Stage::$stage),*];
        }

        pub(super) const ENTRIES: [KernelEntry; Stage::ALL.len()] = [$(KernelEntry {
            shader: $shader,
            with: $with,
            items_per_group: $items,
            bindings: &[$($binding),*],
        }),*];
    };
}

// The first two bindings are always `setup` and `part`, the last is always `done`.
kernels! {
    /// What each ray hits first in the still layer.
    StaticHits = STATIC_HITS, &[PLACEMENT, LAYER, FIRST_HIT], WORKGROUP, [Uniform Part Uniform Read Read Read Write Write];
    /// Which of a camera's tiles see boxes of voxels that matter.
    SeeTiles = SEE_TILES, &[PLACEMENT, PROJECTION, TILES], 1, [Uniform Part Uniform Read Read Write Write];
    /// How far a tile's rays go through nothing.
    CastTiles = CAST_TILES, &[PLACEMENT, PROJECTION, LAYER, TILES], WORKGROUP, [Uniform Part Uniform Read Read Read Read Write Write Write];
    /// How each ray ends, and the endpoints.
    Cast = CAST, &[PLACEMENT, LAYER, FIRST_HIT, TILES, RAY_END, RUNS], WORKGROUP * TILE, [Uniform Part Uniform Read Read Read Read Read Write Write Write];
    /// The same of plain placements, from lists of the tiles that are open.
    CastListed = CAST_LISTED, &[PLACEMENT, LAYER, FIRST_HIT, TILES, RAY_END], 1, [Uniform Part Uniform Read Read Read Read Read Write Write Write];
    /// What blocks of a camera's pixels free at least and at most.
    Pyramid = PYRAMID, &[BLOCKS, TILES], 1, [Uniform Part Uniform Read Write Write];
    /// Which boxes of voxels are decided by the pyramid alone.
    CarveBoxes = CARVE_BOXES, &[PLACEMENT, PROJECTION, BLOCKS, FREED], WORKGROUP, [Uniform Part Uniform Read Read Read Write Write Write];
    /// The voxels of the boxes that are left.
    CarveVoxels = CARVE_VOXELS, &[PLACEMENT, PROJECTION, BLOCKS, FREED, TILES, LEFT], 1, [Uniform Part Uniform Read Read Read Read Write Write Write];
    /// The voxels among those that many pixels may see.
    CarveCrowded = CARVE_CROWDED, &[PROJECTION, BLOCKS, FREED, TILES, OUTLINE, LEFT], 1, [Uniform Part Uniform Read Read Read Read Read Read Write Write];
    /// The voxels among those that are near, which most pixels may see.
    CarveNear = CARVE_NEAR, &[PLACEMENT, PROJECTION, BLOCKS, FREED, TILES, OUTLINE, LEFT], 1, [Uniform Part Uniform Read Read Read Read Read Read Write Write];
    /// The voxels that each ray frees, one by one.
    CarveRays = CARVE_RAYS, &[PLACEMENT], WORKGROUP * TILE, [Uniform Part Uniform Read Read Read Write Write];
    /// The labels from the evidence of several sensors.
    Fuse = FUSE, &[], WORKGROUP * FUSED_WORDS, [Uniform Part Read Read Read Read Write Write Write];
    /// The labels counted in a region.
    Count = COUNT, &[], WORKGROUP * WORDS_PER_INVOCATION,
        [Uniform Part Read Read Read Read Read Read Write Write];
    /// Which voxels of people are hit.
    Detect = DETECT, &[], WORKGROUP, [Uniform Part Read Read Read Read Write Write];
}

impl Stage {
    /// The name of its file without the ending, by which timings and errors call it.
    pub fn name(self) -> &'static str {
        ENTRIES[self as usize].shader.name
    }

    /// Items of a row of a dispatch that one workgroup takes; so many for each of its tiles, where it takes several.
    pub(super) fn items_per_group(self) -> u32 {
        ENTRIES[self as usize].items_per_group
    }

    /// How it sees the buffers that it is bound to, in the order of their numbers.
    pub(super) fn bindings(self) -> &'static [Binding] {
        ENTRIES[self as usize].bindings
    }
}

/// Storage buffers that the kernel with the most of them sees.
pub(super) fn most_storage_buffers() -> u32 {
    let storage = |stage: Stage| stage.bindings().iter().filter(|b| matches!(b, Read | Write)).count() as u32;
    Stage::ALL.into_iter().map(storage).max().unwrap_or(0)
}
