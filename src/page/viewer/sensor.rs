//! The data of a sensor for the viewer: its pose, its rays, and the ground that it watches.

use glam::{DMat3, DQuat, DVec3};
use serde::Serialize;

use perirobot_scene::pose::Pose;
use perirobot_study::input::Study;
use perirobot_study::sensor::prism::Prism;
use perirobot_study::sensor::{FieldOfView, Sensor, Setting};

/// Drawn rays of a sensor other than a camera.
const RAYS_SHOWN: usize = 48;

/// A frame in the world, or in its parent.
#[derive(Clone, Debug, Serialize)]
pub struct FrameData {
    /// Its origin in metres.
    pub at_m: [f64; 3],
    /// Its rotation: a quaternion x, y, z, w.
    pub turn: [f64; 4],
}

impl FrameData {
    /// The frame of a pose.
    pub fn new(pose: &Pose) -> FrameData {
        let DQuat { x, y, z, w } = pose.rotation;
        FrameData { at_m: pose.position_m.to_array(), turn: [x, y, z, w] }
    }

    /// The frame of the link that carries a sensor, from the poses of its first candidate on it and in the world.
    pub fn of_carrier(sensor: &Sensor, in_world: &[Setting]) -> FrameData {
        let (world, own) = (in_world[0].pose(), sensor.candidates[0].setting.pose());
        let rotation = (world.rotation * own.rotation.inverse()).normalize();
        FrameData::new(&Pose { position_m: world.position_m - rotation * own.position_m, rotation })
    }
}

/// Some rays of a sensor, in its link frame (x forward, y left, z up).
#[derive(Clone, Debug, Serialize)]
pub struct RaysData {
    /// The corners of a camera's image, in order around it; else a sample of all rays.
    pub directions: Vec<[f64; 3]>,
    /// Their ranges.
    pub reach_m: Vec<f64>,
    /// Whether they are the corners of an image.
    pub is_picture: bool,
}

impl RaysData {
    /// The rays of a sensor; `None` if it has neither a table of rays nor a field like that of a radar.
    pub fn new(study: &Study, sensor: &Sensor) -> Option<RaysData> {
        let scale = study.ray_scale();
        let link_from_rays: DMat3 = sensor.kind.frame(&Pose::ORIGIN);
        let Some(rays) = sensor.kind.rays(&scale) else { return RaysData::of_field(sensor, link_from_rays) };
        let metres = |q16: u32| f64::from(q16) / 65536.0 * study.voxel_size_m;
        let last = rays.dirs_q15.len().checked_sub(1)?;
        let shown: Vec<usize> = match &rays.image {
            Some(image) => {
                let width = image.size_px[0] as usize;
                vec![0, width - 1, last, last + 1 - width]
            }
            None => {
                (0..RAYS_SHOWN.min(last + 1)).map(|i| i * (last + 1) / RAYS_SHOWN.min(last + 1)).collect()
            }
        };
        let direction = |&ray: &usize| {
            let along = DVec3::from_array(rays.dirs_q15[ray].map(f64::from)).normalize();
            rounded(link_from_rays * along)
        };
        Some(RaysData {
            directions: shown.iter().map(direction).collect(),
            reach_m: shown.iter().map(|&ray| metres(rays.gates_of(ray).range_max_q16)).collect(),
            is_picture: rays.image.is_some(),
        })
    }

    /// Of a sensor that keeps its rays to itself, evenly over its field of view.
    fn of_field(sensor: &Sensor, link_from_rays: DMat3) -> Option<RaysData> {
        let field =
            Some(sensor.kind.field_of_view()).filter(|field| matches!(field, FieldOfView::Turn { .. }))?;
        let [_, farthest_m] = sensor.kind.range()?.range_m;
        let directions: Vec<_> =
            field.some(RAYS_SHOWN).into_iter().map(|along| rounded(link_from_rays * along)).collect();
        Some(RaysData { reach_m: vec![farthest_m; directions.len()], directions, is_picture: false })
    }
}

/// A direction as pages have it.
fn rounded(direction: DVec3) -> [f64; 3] {
    direction.to_array().map(|x| (x * 1e6).round() / 1e6)
}

/// The corners of the ground below each zone that a sensor watches, in its own frame.
pub fn grounds(sensor: &Sensor) -> Vec<Vec<[f64; 3]>> {
    let corners = |prism: &Prism| prism.footprint_m(&Pose::ORIGIN).into_iter().map(DVec3::into).collect();
    sensor.kind.prisms().into_iter().map(corners).collect()
}
