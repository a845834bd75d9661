//! The shaders as naga sees them: every joined kernel is valid, and every struct that Rust mirrors has the
//! same members at the same offsets. Needs no device.

use std::mem::offset_of;

use naga::{Module, TypeInner};
use perirobot_march::backend::gpu::types::{JobWords, Part, PlacementWords, ReadingWords, Setup, TableWords};
use perirobot_march::backend::gpu::{Stage, shader_source};
use perirobot_march::backend::{GridFrame, body_words::BodyWord};

fn parsed(stage: Stage) -> Module {
    let source = shader_source(stage);
    naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|e| panic!("shaders/{}.wgsl: {}", stage.name(), e.emit_to_string(&source)))
}

#[test]
fn every_kernel_is_valid() {
    for stage in Stage::ALL {
        let module = parsed(stage);
        let flags = naga::valid::ValidationFlags::all();
        let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::default());
        if let Err(error) = validator.validate(&module) {
            panic!("shaders/{}.wgsl: {}", stage.name(), error.emit_to_string(&shader_source(stage)));
        }
        assert_eq!(module.entry_points.len(), 1, "{}", stage.name());
        assert_eq!(module.entry_points[0].name, "main", "{}", stage.name());
    }
}

/// Compares a WGSL struct with what Rust says of its mirror: (name, offset) of each member, and the size.
#[track_caller]
fn check_mirror(name: &str, mirror: &[(&str, usize)], size: usize) {
    let module = parsed(Stage::Cast);
    let (handle, found) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("no struct {name} in shaders/types.wgsl"));
    let TypeInner::Struct { members, .. } = &found.inner else { panic!("{name} is no struct") };
    let in_shader: Vec<_> =
        members.iter().map(|m| (m.name.as_deref().unwrap_or("?"), m.offset as usize)).collect();
    assert_eq!(in_shader, mirror, "members and offsets of {name}: shader, then Rust");
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).expect("a valid module has a layout");
    assert_eq!(layouter[handle].to_stride() as usize, size, "stride of {name} in the shader, then in Rust");
}

macro_rules! mirrored {
    ($name:literal, $mirror:ty, $($member:ident)*) => {
        check_mirror(
            $name,
            &[$((stringify!($member), offset_of!($mirror, $member))),*],
            size_of::<$mirror>(),
        )
    };
}

#[test]
fn structs_match_their_mirrors() {
    mirrored!("Setup", Setup, grid_x grid_y grid_z grid_words_per_row
        window_min_x window_min_y window_min_z window_words_per_row window_x window_y window_z window_words
        regions bricks_x bricks_y bricks_word shades_word first_hits_stride detection_counters
        moving_min_x moving_min_y moving_min_z moving_x moving_y moving_z
        others_min_x others_min_y others_min_z others_x others_y others_z);
    mirrored!("Table", TableWords, ends_stride range_min_q16 range_max_q16 along_axis near_ignore_q16 no_return_is_free backdrop noisy lost_below
        shaded shade_range_1_q16 shade_range_2_q16 shade_range_3_q16 shade_range_4_q16 shade_range_5_q16 shade_range_6_q16 shade_range_7_q16 image_x image_y focal_x focal_y near nearer);
    mirrored!("Part", Part, first_row first end region every_ray tiles whole_layer boxes_at_once zero);
    mirrored!("GridFrame", GridFrame, origin_q16 axis_q15);
    mirrored!("GridPose", PlacementWords, believed truly is_off draws slot first_hits);
    mirrored!("Job", JobWords, first end octomap);
    mirrored!("BodyWord", BodyWord, word voxels hits sensed twice);
    mirrored!("Reading", ReadingWords, slot volume hit miss presence);
}

#[test]
fn arrays_in_storage_have_no_gaps() {
    for stage in Stage::ALL {
        let module = parsed(stage);
        let is_shared = |global: &naga::GlobalVariable| global.space != naga::AddressSpace::WorkGroup;
        for (_, global) in module.global_variables.iter().filter(|(_, global)| is_shared(global)) {
            let TypeInner::Array { base, stride, .. } = module.types[global.ty].inner else { continue };
            let (name, place) = (global.name.as_deref().unwrap_or("?"), stage.name());
            let item = &module.types[base];
            let expected = match &item.inner {
                TypeInner::Scalar(_) | TypeInner::Atomic(_) => size_of::<u32>(),
                TypeInner::Array { .. } if name == "placements" => size_of::<PlacementWords>(),
                // Of three, which would have a gap, there are none.
                TypeInner::Vector { size, .. } => *size as usize * size_of::<u32>(),
                TypeInner::Struct { .. } => match item.name.as_deref() {
                    Some("Job") => size_of::<JobWords>(),
                    Some("Reading") => size_of::<ReadingWords>(),
                    Some("BodyWord") => size_of::<BodyWord>(),
                    other => panic!("{place}: {name} is an array of {other:?}, for which there is no mirror"),
                },
                other => panic!("{place}: {name} is an array of {other:?}, for which there is no mirror"),
            };
            assert_eq!(stride as usize, expected, "{place}: stride of {name}");
        }
    }
}

/// A driver that ends loops early is found by what is asked after each of them (`shaders/completion.wgsl`).
#[test]
fn after_each_loop_a_kernel_asks_whether_it_ended() {
    let mut loops = 0;
    for stage in Stage::ALL {
        let module = parsed(stage);
        let asks = module.functions.iter().find(|(_, f)| f.name.as_deref() == Some("loop_ended"));
        let (asks, _) = asks.expect("every kernel has the proof");
        let bodies = module.functions.iter().map(|(_, f)| f);
        for function in bodies.chain(module.entry_points.iter().map(|entry| &entry.function)) {
            let name = function.name.as_deref().unwrap_or("main");
            loops += asked(&function.body, asks, &format!("{}, fn {name}", stage.name()));
        }
    }
    assert!(loops >= 20, "{loops} loops");
}

/// How many loops a block has, each of them followed by the question before anything else could lead away.
#[track_caller]
fn asked(block: &naga::Block, asks: naga::Handle<naga::Function>, place: &str) -> usize {
    use naga::Statement as S;
    let mut loops = 0;
    for (i, statement) in block.iter().enumerate() {
        loops += match statement {
            S::Block(inner) => asked(inner, asks, place),
            S::If { accept, reject, .. } => asked(accept, asks, place) + asked(reject, asks, place),
            S::Switch { cases, .. } => cases.iter().map(|case| asked(&case.body, asks, place)).sum(),
            S::Loop { body, .. } => {
                let led_away =
                    |s: &&S| matches!(s, S::Loop { .. } | S::Return { .. } | S::Break | S::Continue);
                let next = block[i + 1..].iter().take_while(|s| !led_away(s));
                let calls = |s: &S| matches!(s, S::Call { function, .. } if *function == asks);
                assert!(next.clone().any(calls), "{place}: a loop is not followed by `loop_ended`");
                1 + asked(body, asks, place)
            }
            _ => 0,
        };
    }
    loops
}

/// As many as every WebGPU-class adapter has.
#[test]
fn no_kernel_sees_more_than_eight_storage_buffers() {
    for stage in Stage::ALL {
        let module = parsed(stage);
        let storage =
            |global: &naga::GlobalVariable| matches!(global.space, naga::AddressSpace::Storage { .. });
        let seen = module.global_variables.iter().filter(|(_, global)| storage(global)).count();
        assert!((2..=8).contains(&seen), "shaders/{}.wgsl sees {seen} storage buffers", stage.name());
    }
}

#[test]
fn each_file_is_in_a_kernel() {
    let sources = Stage::ALL.map(shader_source);
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders")).unwrap();
    let files = files.map(|file| file.unwrap().path());
    let files: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "wgsl")).collect();
    assert!(files.len() > Stage::ALL.len(), "{files:?}");
    for path in files {
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(sources.iter().any(|source| source.contains(&text)), "no kernel has {}", path.display());
    }
}
