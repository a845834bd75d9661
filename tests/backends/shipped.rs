//! Oracle = CPU = GPU on the quick studies that ship: every count, every voxel of the whole grid, the end of
//! every ray. The gate compares the experiments by the program itself.

use std::path::Path;

use crate::common;
use perirobot_march::backend::{Backend, cpu::Cpu, gpu::Gpu};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::{World, ray_tables};
use perirobot_sweep::scoring::compare::{Comparison, PoseSelection, compare, compare_combination};

#[track_caller]
fn check(file: &str, voxel_size_m: Option<f64>, selection: PoseSelection) {
    let overrides = Overrides { voxel_size_m, ..Default::default() };
    let study = Study::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file), &overrides).unwrap();
    let mut backends: Vec<Box<dyn Backend>> = vec![Box::new(Cpu::new(None).unwrap())];
    if let Some(adapter) = common::adapter() {
        backends.push(Box::new(Gpu::new(&adapter).unwrap()));
    }
    let mut report = Comparison::default();
    let worlds = World::prepare_all(&study).unwrap();
    for world in &worlds {
        for sensor in 0..study.sensors.len() {
            compare(&study, world, sensor, &selection, &mut backends, &mut report).unwrap();
        }
    }
    for of_scene in worlds.chunk_by(|a, b| a.scene == b.scene) {
        for combination in 0..study.combinations.len() {
            compare_combination(&study, of_scene, combination, &selection, &mut backends, &mut report)
                .unwrap();
        }
    }
    let casting = ray_tables(&study).iter().flatten().count();
    let each = worlds.len() * casting + study.scenes.len() * study.combinations.len();
    let compared = each * (1 + backends.len());
    assert_eq!(report.lines.len(), compared, "{file}: every sensor and combination on every backend");
    let again = format!("cargo run -- verify-backends {file}");
    assert_eq!(report.first_difference, None, "{file}; rerun with: {again}");
}

#[test]
fn tiny_whole() {
    check("scenes/tiny.toml", None, PoseSelection::All);
}

#[test]
fn tiny_with_voxels_of_3_cm() {
    check("scenes/tiny.toml", Some(0.03), PoseSelection::Spread { number: 3, turn: 0 });
}

#[test]
fn quick() {
    check("scenes/quick.toml", None, PoseSelection::Spread { number: 3, turn: 0 });
}

#[test]
fn lidars() {
    check("scenes/paper/lidar.toml", None, PoseSelection::Spread { number: 2, turn: 0 });
}

#[test]
fn every_sensor() {
    check("scenes/sensors.toml", None, PoseSelection::All);
}
