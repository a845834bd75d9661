//! What the page's script knows of a sensor: where its poses are, what is around them, where its rays look,
//! and what it stands on.

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
