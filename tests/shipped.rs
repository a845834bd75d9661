//! Oracle = CPU = GPU on the studies that ship: every count, every voxel of the whole grid, the end of every ray.

mod common;

use std::path::Path;

use perirobot::backend::{Backend, cpu::Cpu, gpu::Gpu};
use perirobot::study::Study;
use perirobot::sweep::World;
use perirobot::sweep::compare::{Report, Selection, compare};

#[track_caller]
fn check(file: &str, voxel_size_m: Option<f64>, selection: Selection) {
    let study = Study::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file), voxel_size_m).unwrap();
    let mut backends: Vec<Box<dyn Backend>> = vec![Box::new(Cpu::new(None).unwrap())];
    if let Some(adapter) = common::adapter() {
        backends.push(Box::new(Gpu::new(&adapter).unwrap()));
    }
    let mut report = Report::default();
    for spec in &study.scenes {
        let world = World::prepare(&study, spec).unwrap().remove(0);
        for sensor in &study.sensors {
            compare(&study, &world, sensor, &selection, &mut backends, &mut report).unwrap();
        }
    }
    let compared = study.scenes.len() * study.sensors.len() * (1 + backends.len());
    assert_eq!(report.lines.len(), compared, "{file}: every scene and sensor on every backend");
    let again = format!("cargo run -- compare {file}");
    assert_eq!(report.first_difference, None, "{file}; rerun with: {again}");
}

#[test]
fn tiny_whole() {
    check("scenes/tiny.toml", None, Selection::All);
}

#[test]
fn tiny_with_voxels_of_3_cm() {
    check("scenes/tiny.toml", Some(0.03), Selection::Spread(3));
}

#[test]
fn quick() {
    check("scenes/quick.toml", None, Selection::Spread(3));
}

#[test]
fn experiment_1() {
    check("scenes/paper/exp1.toml", None, Selection::Spread(3));
}

#[test]
fn lidars() {
    check("scenes/paper/lidar.toml", None, Selection::Spread(2));
}
