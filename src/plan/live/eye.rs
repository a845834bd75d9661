//! What a sensor sees from where it stands, as a picture: the nearer the brighter, people in colour by the parts of their
//! bodies, the robot in blue, and darker what is too near or too far to be measured. Single rays are followed on the host.

use std::collections::HashMap;

use glam::{DMat3, DVec3};
use perirobot_march::backend::cpu::BlockerSearch;
use perirobot_march::backend::{GridPose, Image};
use perirobot_march::error::Issue;
use perirobot_march::march::{FULL_RANGE, Gates, MAX_RANGE_VOXELS, direction_q16};
use perirobot_march::metrics::BodyPart;
use perirobot_march::{Error, Result};
use perirobot_page::render::Canvas;
use perirobot_study::input::Planned;
use perirobot_study::sensor::{Setting, quantise_q15};
use perirobot_study::world::{World, ray_table};
use rayon::prelude::*;

use super::Live;

/// Width of the picture in pixels, and its height for sensors that have none of their own.
const WIDTH: u32 = 320;
const HEIGHT: u32 = 200;

/// What is not a camera is drawn as one that looks where it faces, with this full angle across.
const WIDE_RAD: f64 = 1.75;

/// Colours of body parts in their order, of the robot, of the rest and of nothing.
const PARTS: [[u8; 3]; 11] = [
    [240, 228, 66],
    [230, 159, 0],
    [213, 94, 0],
    [204, 121, 167],
    [240, 150, 60],
    [220, 120, 120],
    [200, 90, 30],
    [170, 70, 110],
    [250, 190, 90],
    [235, 170, 150],
    [230, 159, 0],
];
const ROBOT: [u8; 3] = [60, 150, 220];
const REST: [u8; 3] = [210, 210, 214];
const NOTHING: [u8; 3] = [18, 20, 26];

/// How much of a colour is left, of 256, of what a sensor cannot measure.
const UNMEASURED: u32 = 96;

impl Live {
    /// The picture of what a sensor of a plan sees at a moment, as the bytes of a PNG file.
    ///
    /// # Errors
    /// A plan, a place in it or a moment that the study does not have; a sensor that has no pose.
    pub fn eye(&mut self, plan: &[Planned], index: usize, moment: usize) -> Result<Vec<u8>> {
        let Some(planned) = plan.get(index) else {
            return Err(Issue::says(format!("the plan has no sensor {index}: it has {}", plan.len())).into());
        };
        let cell = self.cell(super::Resolution::Fine)?;
        let ready = cell.ready(moment)?;
        let (study, candidates) = cell.study.with_plan(&[*planned])?;
        let world = cell.world(moment)?.with_sensors(&study.sensors);
        let (sensor, candidate) = (planned.sensor, candidates[0]);
        let wrong = |what: &str| Error::from(Issue::says(format!("{:?} {what}", study.sensors[sensor].name)));
        if !matches!(world.settings[sensor][candidate], Setting::Pose(_)) {
            return Err(wrong("has no pose from which it could see"));
        }
        if let Some(words) = world.impossible_placement(&study, [sensor, candidate]) {
            return Err(wrong(&words));
        }
        let pose = world.settings[sensor][candidate].pose();
        let placement = world.placement(&study, sensor, candidate, 0).caster();
        let table = ray_table(&study, sensor);
        let image = table.as_ref().and_then(|rays| rays.image);
        let open = Gates {
            range_min_q16: 0,
            range_max_q16: MAX_RANGE_VOXELS << 16,
            shade_ranges_q16: FULL_RANGE,
            along_axis: false,
            near_ignore_q16: table.as_ref().map_or(0, |rays| rays.gates.near_ignore_q16),
            no_return_is_free: false,
            backdrop: false,
        };
        let seen = Picture {
            camera: PictureRays::new(image, pose.optical(), &placement),
            measured: table.map_or(open, |rays| rays.gates),
            open,
            from: placement,
        };
        seen.draw(&world, &ready.search).png()
    }
}

/// The rays of a picture: right, down and ahead in the sensor's frame.
struct PictureRays {
    size: [u32; 2],
    /// What a pixel is across and down, ahead being 1.
    step: [f64; 2],
    /// Rows of the world from the frame of the picture, Q15.
    axis_q15: [[i32; 3]; 3],
}

impl PictureRays {
    fn new(image: Option<Image>, optical: DMat3, placement: &GridPose) -> PictureRays {
        match image {
            Some(image) => {
                let [width, height] = image.size_px.map(f64::from);
                let across = WIDTH.min(image.size_px[0]).max(1);
                let down =
                    (f64::from(across) * height / width).round().clamp(1.0, 4.0 * f64::from(WIDTH)) as u32;
                let step = [
                    width / image.focal_px[0] / f64::from(across),
                    height / image.focal_px[1] / f64::from(down),
                ];
                PictureRays { size: [across, down], step, axis_q15: placement.axis_q15 }
            }
            None => {
                let step = 2.0 * (WIDE_RAD / 2.0).tan() / f64::from(WIDTH);
                let row = |r: usize| std::array::from_fn(|a| quantise_q15(optical.col(a)[r]));
                PictureRays { size: [WIDTH, HEIGHT], step: [step; 2], axis_q15: std::array::from_fn(row) }
            }
        }
    }

    fn dir_q15(&self, [u, v]: [u32; 2]) -> [i32; 3] {
        let middle = self.size.map(|n| f64::from(n) / 2.0);
        let aside = (f64::from(u) + 0.5 - middle[0]) * self.step[0];
        let down = (f64::from(v) + 0.5 - middle[1]) * self.step[1];
        DVec3::new(aside, down, 1.0).normalize().to_array().map(quantise_q15)
    }
}

struct Picture {
    camera: PictureRays,
    /// What the sensor measures, and all that is drawn.
    measured: Gates,
    open: Gates,
    from: GridPose,
}

impl Picture {
    fn draw(&self, world: &World, search: &BlockerSearch) -> Canvas {
        let truth = world.truth();
        let parts: HashMap<[i32; 3], BodyPart> =
            world.people.voxels.iter().map(|of| (of.voxel, of.part)).collect();
        let begin = search.rays_from(self.from.origin_q16);
        let [width, height] = self.camera.size;
        let far = f64::from(self.measured.range_max_q16.min(24 << 16)).max(1.0);
        let pixel = |number: u32| {
            let dir_q15 = self.camera.dir_q15([number % width, number / width]);
            let way = self.camera.axis_q15.map(|axis| direction_q16(axis, dir_q15));
            let Some(hit) = search.first(&begin, way, &self.open) else { return NOTHING };
            let colour = match parts.get(&hit.voxel) {
                Some(part) => PARTS[*part as usize],
                None if truth.robot.get(hit.voxel) => ROBOT,
                None => REST,
            };
            // Faces across an axis are lit alike, so that edges show.
            let face = [256, 232, 208][hit.axis];
            let near = 256 - (150.0 * (f64::from(hit.t_q16) / far).min(1.0)) as u32;
            let gates = self.measured.ray_gates(dir_q15[2]);
            let is_measured = (gates.range_min_q16..=gates.range_max_q16).contains(&hit.t_q16);
            let light = face * near / 256 * if is_measured { 256 } else { UNMEASURED } / 256;
            colour.map(|c| (u32::from(c) * light / 256) as u8)
        };
        let rgb: Vec<u8> = (0..width * height).into_par_iter().flat_map_iter(pixel).collect();
        Canvas::from_rgb([width, height], rgb)
    }
}
