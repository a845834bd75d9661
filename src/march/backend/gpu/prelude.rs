//! The sources of the kernels as the device gets them: the constants, which Rust owns and prints in front, what
//! kernels share, and the kernel.

use std::fmt::Write;

use perirobot_shaders::{INTEGERS, MARCH, TYPES};

use super::kernels::{DONE_WORDS, ENTRIES, KernelEntry, SHADER_COMPLETION, Stage};
use super::loop_bounds::{
    DEVIATION_PER_VOXEL, MOST_LAYERS, MOST_LEAPS, MOST_LOOKS, MOST_ROWS, MOST_SECTIONS, MOST_SEEING,
    NEAR_TILES, TEAMS, WORDS_PER_INVOCATION, WORKGROUP,
};
use super::tiles::{BOX_BITS, BOX_EDGE, CUBES, PYRAMID_LEVELS, TILE};
use super::types::{
    ABREAST, FARTHEST_READ_Q16, HEAD_WORDS, HEADS, MOST_PLACEMENTS, NO_SLOT, PlacementWords, REGION_COUNTERS,
};
use crate::backend::LOG_ODDS;
use crate::march::{self, deviation};
use crate::voxel::Bricks;

/// What stands in front of every kernel: the constants, the structs, floats as integers and the march. A kernel of a test's own
/// can follow it.
pub fn shader_prelude() -> String {
    let mut source = String::from("// Constants, printed by src/march/backend/gpu/prelude.rs.\n");
    let constants = [
        ("NEVER", march::NEVER),
        ("MAX_RANGE_VOXELS", march::MAX_RANGE_VOXELS),
        ("MAX_STD_VOXELS", march::MAX_STD_VOXELS),
        ("NOISE_STEPS", march::NOISE_STEPS),
        ("ENTRY_SHIFT", 32 - march::NOISE_STEPS.ilog2()),
        ("NOTHING", march::NOTHING),
        ("RETURN", march::RETURN),
        ("BLIND", march::BLIND),
        ("LEFT", march::LEFT),
        ("WORKGROUP", WORKGROUP),
        ("WORDS_PER_INVOCATION", WORDS_PER_INVOCATION),
        ("REGION_COUNTERS", REGION_COUNTERS as u32),
        ("KERNELS", Stage::ALL.len() as u32),
        ("DONE_WORDS", DONE_WORDS),
        ("NO_SLOT", NO_SLOT),
        ("BRICK_EDGE_LOG2", Bricks::EDGE_LOG2),
        ("BOX_EDGE", BOX_EDGE),
        ("CUBES", CUBES),
        ("BOX_BITS", BOX_BITS),
        ("LEAST_LEVEL", *PYRAMID_LEVELS.start()),
        ("TILE", TILE),
        ("TILE_LEVEL", TILE.ilog2()),
        ("MOST_LEVEL", *PYRAMID_LEVELS.end()),
        ("PLACEMENT_WORDS", size_of::<PlacementWords>() as u32 / 4),
        ("MOST_SEEING", MOST_SEEING),
        ("MOST_LEAPS", MOST_LEAPS),
        ("MOST_SECTIONS", MOST_SECTIONS),
        ("MOST_ROWS", MOST_ROWS),
        ("MOST_LAYERS", MOST_LAYERS),
        ("MOST_LOOKS", MOST_LOOKS),
        ("TEAMS", TEAMS),
        ("NEAR_TILES", NEAR_TILES),
        ("ABREAST", ABREAST),
        ("HEADS", HEADS),
        ("HEAD_WORDS", HEAD_WORDS),
        ("MOST_PLACEMENTS", MOST_PLACEMENTS),
        ("UNDECIDED_FIRST", HEADS * HEAD_WORDS),
        ("FARTHEST_READ_Q16", FARTHEST_READ_Q16),
    ];
    for (name, value) in constants {
        writeln!(source, "const {name} = {value}u;").expect("writing to a string");
    }
    for stage in Stage::ALL {
        writeln!(source, "const {} = {}u;", stage.name().to_uppercase(), stage as u32)
            .expect("writing to a string");
    }
    for (name, value) in [("DEVIATION_PER_VOXEL", DEVIATION_PER_VOXEL), ("DEVIATION_FIXED", deviation::FIXED)]
    {
        writeln!(source, "const {name} = {value:?}f;").expect("writing to a string");
    }
    for (name, value) in [
        ("LEAST_LOG_ODDS", LOG_ODDS.start()),
        ("MOST_LOG_ODDS", LOG_ODDS.end()),
        ("LEAST_AXIAL_Q15", &march::LEAST_AXIAL_Q15),
    ] {
        writeln!(source, "const {name} = {value}i;").expect("writing to a string");
    }
    for shared in [TYPES, INTEGERS, MARCH] {
        source += shared.text;
    }
    source
}

/// The whole source of a kernel, as the device gets it: prelude, proof, what several kernels share, and the
/// kernel, joined.
pub fn shader_source(stage: Stage) -> String {
    let KernelEntry { with, shader, .. } = ENTRIES[stage as usize];
    let own = with.iter().chain([&shader]).map(|shader| shader.text);
    [shader_prelude().as_str(), SHADER_COMPLETION].into_iter().chain(own).collect()
}
