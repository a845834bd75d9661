//! What the page's script knows of a sensor: where its poses are, what is around them, where its rays look,
//! and what it stands on.

use glam::{DMat3, DQuat, DVec3};
use serde::Serialize;

use super::maps::{Furnished, MapsData, maps_data};
use crate::report::page::surroundings::{Around, Surroundings, key};
use perirobot_scene::pose::Pose;
use perirobot_study::input::Study;
use perirobot_study::sensor::prism::Prism;
use perirobot_study::sensor::turned::Turned;
use perirobot_study::sensor::{Candidate, RayScale, Sensor, Setting, Stance};
use perirobot_study::world::World;
use perirobot_study::world::place::Places;

/// Rays that are drawn of a sensor that is no camera.
const RAYS_SHOWN: usize = 48;

#[derive(Serialize)]
pub(super) struct SensorData<'a> {
    name: &'a str,
    kind: &'static str,
    /// Whether it lies or stands level, with its origin at a corner.
    level: bool,
    /// The ground below what it watches, in its own frame.
    grounds: Vec<Vec<[f64; 3]>>,
    /// What carries it, and where that is in the world at each moment.
    on: Option<Carrier<'a>>,
    poses: Vec<PoseData<'a>>,
    maps: MapsData,
    rays: Option<RaysData>,
}

#[derive(Serialize)]
struct Carrier<'a> {
    object: &'a str,
    link: &'a str,
    frames: Vec<FrameData>,
}

#[derive(Serialize)]
struct FrameData {
    at_m: [f64; 3],
    /// Quaternion x, y, z, w.
    turn: [f64; 4],
}

#[derive(Serialize)]
struct PoseData<'a> {
    name: &'a str,
    group: &'a str,
    /// Where it is, in words.
    place: String,
    #[serde(flatten)]
    frame: Option<FrameData>,
    /// Pan, tilt and roll.
    turned_deg: Option<[f64; 3]>,
    /// How far a cover senses.
    senses_m: Option<f64>,
    /// What is around it; unknown for a sensor on a link.
    around: Option<Around>,
}

/// Some rays of a sensor, in its link frame (x forward, y left, z up).
#[derive(Serialize)]
struct RaysData {
    /// The corners of a camera's picture, in order around it; else some of all rays.
    directions: Vec<[f64; 3]>,
    /// How far each of them measures.
    reach_m: Vec<f64>,
    is_picture: bool,
}

/// Of the sensor of this number.
pub(super) fn sensor_data<'a>(
    study: &'a Study,
    worlds: &[World],
    surroundings: &Surroundings,
    scenes: &[Furnished],
    number: usize,
) -> SensorData<'a> {
    let sensor = &study.sensors[number];
    let on = sensor.on.as_ref().map(|link| Carrier {
        object: &link.object,
        link: &link.link,
        frames: worlds.iter().map(|world| carrier(sensor, &world.settings[number])).collect(),
    });
    let pose_of = |candidate: &Candidate| match candidate.setting {
        Setting::Pose(pose) => Some(pose),
        _ => None,
    };
    let positions = sensor.candidates.iter().filter_map(pose_of).map(|pose| pose.position_m);
    let around = surroundings.measure_all(positions.filter(|_| sensor.on.is_none()));
    let places = Places::new(study, &worlds[0]);
    let poses = sensor.candidates.iter().enumerate().map(|(index, candidate)| {
        let pose = pose_of(candidate);
        let turned = pose.as_ref().map(Turned::new);
        PoseData {
            name: &candidate.name,
            group: &candidate.group,
            place: places.words(number, index),
            frame: pose.as_ref().map(frame_data),
            turned_deg: turned.map(|t| [t.pan_deg, t.tilt_deg, t.roll_deg]),
            senses_m: match candidate.setting {
                Setting::Inflation(metres) => Some(metres),
                _ => None,
            },
            around: pose.and_then(|pose| around.get(&key(pose.position_m)).copied().map(tidy)),
        }
    });
    SensorData {
        name: &sensor.name,
        kind: sensor.kind.name(),
        level: sensor.kind.stance() == Stance::Level,
        grounds: grounds(sensor),
        on,
        poses: poses.collect(),
        maps: maps_data(sensor, scenes),
        rays: rays_data(study, sensor),
    }
}

fn grounds(sensor: &Sensor) -> Vec<Vec<[f64; 3]>> {
    let corners = |prism: &Prism| prism.footprint_m(&Pose::ORIGIN).into_iter().map(DVec3::into).collect();
    sensor.kind.prisms().into_iter().map(corners).collect()
}

/// Metres to a tenth of a millimetre, finer than any tape measure.
fn tidy(around: Around) -> Around {
    around.map(|next| next.map(|(metres, object)| ((metres * 1e4).round() / 1e4, object)))
}

/// Where the link that carries a sensor is, from where its first candidate is on it and in the world.
fn carrier(sensor: &Sensor, in_world: &[Setting]) -> FrameData {
    let (world, own) = (in_world[0].pose(), sensor.candidates[0].setting.pose());
    let rotation = (world.rotation * own.rotation.inverse()).normalize();
    frame_data(&Pose { position_m: world.position_m - rotation * own.position_m, rotation })
}

fn frame_data(pose: &Pose) -> FrameData {
    let DQuat { x, y, z, w } = pose.rotation;
    FrameData { at_m: pose.position_m.to_array(), turn: [x, y, z, w] }
}

fn rays_data(study: &Study, sensor: &Sensor) -> Option<RaysData> {
    let scale = RayScale { voxel_size_m: study.voxel_size_m, backdrop: study.backdrop };
    let rays = sensor.kind.rays(&scale)?;
    let link_from_rays: DMat3 = sensor.kind.frame(&Pose::ORIGIN);
    let metres = |q16: u32| f64::from(q16) / 65536.0 * study.voxel_size_m;
    let last = rays.dirs_q15.len().checked_sub(1)?;
    let shown: Vec<usize> = match &rays.image {
        Some(image) => {
            let width = image.size_px[0] as usize;
            vec![0, width - 1, last, last + 1 - width]
        }
        None => (0..RAYS_SHOWN.min(last + 1)).map(|i| i * (last + 1) / RAYS_SHOWN.min(last + 1)).collect(),
    };
    let direction = |&ray: &usize| {
        let along = glam::DVec3::from_array(rays.dirs_q15[ray].map(f64::from)).normalize();
        (link_from_rays * along).to_array().map(|x| (x * 1e6).round() / 1e6)
    };
    Some(RaysData {
        directions: shown.iter().map(direction).collect(),
        reach_m: shown.iter().map(|&ray| metres(rays.gates_of(ray).range_max_q16)).collect(),
        is_picture: rays.image.is_some(),
    })
}
