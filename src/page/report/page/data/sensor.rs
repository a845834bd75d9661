//! The data of a sensor for the page's script: its poses and surroundings, its directions of view, and its carrier.

use serde::Serialize;

use super::maps::{Furnished, MapsData, maps_data};
use crate::report::page::surroundings::{Around, Surroundings, key};
use crate::viewer::sensor::{FrameData, RaysData, grounds};
use perirobot_study::input::Study;
use perirobot_study::sensor::turned::Turned;
use perirobot_study::sensor::{Candidate, Setting, Stance};
use perirobot_study::world::World;
use perirobot_study::world::place::Places;

#[derive(Serialize)]
pub(super) struct SensorData<'a> {
    name: &'a str,
    kind: &'static str,
    /// Whether it is level with its origin at a corner.
    level: bool,
    /// The ground below its watched volume, in its own frame.
    grounds: Vec<Vec<[f64; 3]>>,
    /// Its carrier, with its pose in the world at each moment.
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
struct PoseData<'a> {
    name: &'a str,
    group: &'a str,
    /// The place in words.
    place: String,
    #[serde(flatten)]
    frame: Option<FrameData>,
    /// Pan, tilt and roll.
    turned_deg: Option<[f64; 3]>,
    /// The reach of a cover.
    senses_m: Option<f64>,
    /// Its surroundings; unknown for a sensor on a link.
    around: Option<Around>,
}

/// The data of a sensor by its index.
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
        frames: worlds.iter().map(|world| FrameData::of_carrier(sensor, &world.settings[number])).collect(),
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
            frame: pose.as_ref().map(FrameData::new),
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
        rays: RaysData::new(study, sensor),
    }
}

/// Metres to a tenth of a millimetre, finer than any tape measure.
fn tidy(around: Around) -> Around {
    around.map(|next| next.map(|(metres, object)| ((metres * 1e4).round() / 1e4, object)))
}
