//! The README's picture, drawn by our own march: Scene 1 as voxels, coloured by what a camera on the wall makes of it.
//! `PERIROBOT_REGENERATE=1 cargo test --test generated_picture` writes it anew.

use std::path::Path;

use glam::DVec3;
use perirobot::backend::{Backend, cpu::Cpu};
use perirobot::march;
use perirobot::sensor::range::Range;
use perirobot::sensor::rgbd::{Rgbd, Shape};
use perirobot::sensor::{Camera, Pose, placement};
use perirobot::study::{Overrides, Study};
use perirobot::sweep::{World, tables};
use perirobot::voxel::BitGrid;

const SIZE: [u32; 2] = [960, 560];
const FILE: &str = "scenes/paper/scene1.png";

/// What the camera says of an occupied voxel, as the picture's colours.
const SEEN: [f64; 3] = [70.0, 170.0, 90.0];
const SEEN_HUMAN: [f64; 3] = [255.0, 190.0, 60.0];
const UNKNOWN: [f64; 3] = [105.0, 110.0, 125.0];
const UNKNOWN_HUMAN: [f64; 3] = [215.0, 70.0, 60.0];

#[test]
fn the_readme_shows_what_this_code_draws() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut study = Study::load(
        &root.join("scenes/paper/exp1.toml"),
        &Overrides { voxel_size_m: Some(0.025), noiseless: true },
    )
    .unwrap();
    study.scenes.truncate(1);
    let world = World::prepare(&study, 0).unwrap().remove(0);
    let candidates = &study.sensors[0].candidates;
    let candidate = candidates.iter().position(|c| c.name == "left-wall/15/1").unwrap();

    let mut cpu = Cpu::new(None).unwrap();
    cpu.tables(&[tables(&study)[0].clone().unwrap()]).unwrap();
    cpu.load(&world.cell(world.truth.grid.window())).unwrap();
    let seen = cpu.read(0, &world.placement(&study, 0, candidate, 0)).unwrap().planes.occupied;

    let pixels = draw(&world, &seen, world.settings[0][candidate].pose().position_m);
    let path = root.join(FILE);
    if std::env::var_os("PERIROBOT_REGENERATE").is_some() {
        write_png(&path, &pixels);
    }
    let shipped = read_png(&path);
    let differing = shipped.iter().zip(&pixels).filter(|(a, b)| a != b).count();
    assert!(
        shipped.len() == pixels.len() && differing == 0,
        "{differing} of {} bytes of {FILE} differ; PERIROBOT_REGENERATE=1 draws it anew",
        pixels.len()
    );
}

/// Marches a ray for each pixel from a corner of the room to the first occupied voxel.
fn draw(world: &World, seen: &BitGrid, sensor_m: DVec3) -> Vec<u8> {
    let eye = DVec3::new(2.85, 1.85, 2.75);
    let range =
        Range { range_m: [0.0, 20.0], near_ignore_m: 0.0, no_return_is_free: false, noise_std_m: 0.0 };
    let camera = Camera { fov_rad: [1.35, 0.87], resolution_px: SIZE };
    let viewer = Rgbd { camera, range, shapes: vec![Shape::Points], keypoint_tolerance_m: 0.0 };
    let grid = &world.truth.grid;
    let facing = Pose::facing(eye, DVec3::new(-0.1, -0.1, 0.75) - eye, 0.0, 0.0);
    let placement = placement(&viewer, &facing, grid, 0);
    let sensor = perirobot::voxel::Grid::cell_of(grid.position_q16(sensor_m));
    let mut pixels = Vec::new();
    for dir in viewer.camera.dirs_q15() {
        let mut ray =
            march::start(placement.origin_q16, placement.axis_q15.map(|a| march::direction_q16(a, dir)));
        let color = loop {
            let axis = march::next_axis(ray.next_q16);
            march::cross(&mut ray, axis);
            let near = (0..3).map(|r| (ray.cell[r] - sensor[r]).pow(2)).sum::<i32>() <= 9;
            if near {
                break [40.0, 120.0, 255.0];
            }
            if world.truth.occupied.get(ray.cell) {
                break shade(world, seen, ray.cell, axis);
            }
        };
        pixels.extend(color.map(|c| c as u8));
    }
    pixels
}

/// A voxel's colour, darker on faces that look sideways so that edges show.
fn shade(world: &World, seen: &BitGrid, cell: [i32; 3], axis: usize) -> [f64; 3] {
    let light = [0.72, 0.86, 1.0][axis];
    let base = match (seen.get(cell), world.truth.human.get(cell)) {
        (true, true) => SEEN_HUMAN,
        (true, false) => SEEN,
        (false, true) => UNKNOWN_HUMAN,
        (false, false) => UNKNOWN,
    };
    base.map(|c| c * light)
}

fn write_png(path: &Path, pixels: &[u8]) {
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder.write_header().unwrap().write_image_data(pixels).unwrap();
}

fn read_png(path: &Path) -> Vec<u8> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels
}
