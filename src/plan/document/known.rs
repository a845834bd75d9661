//! What edits must know of a study beyond its text: the names and places of its poses, and the catalogue.

use perirobot_scene::pose::Pose;
use perirobot_study::input::Study;
use perirobot_study::input::catalogue::{DeviceModel, models};
use perirobot_study::sensor::{Sensor, Setting, Stance};

/// What is known of a study, and of devices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// Its sensors.
    pub sensors: Vec<KnownSensor>,
    /// The devices of the catalogue.
    pub models: Vec<KnownModel>,
}

/// What is known of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownSensor {
    /// Its name.
    pub name: String,
    /// How it is turned by what it faces.
    pub stance: Stance,
    /// Whether it has poses that a person can choose. A light curtain that is where its box is has none.
    pub is_posed: bool,
    /// All candidates by name, with the pose of those that have one.
    pub poses: Vec<(String, Option<Pose>)>,
}

/// What is known of a device of the catalogue.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownModel {
    /// Its name there.
    pub name: String,
    /// How it is turned by what it faces.
    pub stance: Stance,
    /// What one costs by the catalogue of the study's own, which its sensor gets.
    pub cost: Option<f64>,
    /// Further keys of a sensor that is made of it, each with its value as TOML.
    pub keys: Vec<(String, String)>,
}

impl Known {
    /// What a study says, beside its own catalogue and the whole one.
    pub fn new(study: &Study) -> Known {
        Known {
            sensors: study.sensors.iter().map(KnownSensor::new).collect(),
            models: study.models.iter().chain(models()).map(KnownModel::new).collect(),
        }
    }

    /// The catalogue alone, for a study that does not load.
    pub fn catalogue() -> Known {
        Known { sensors: Vec::new(), models: models().iter().map(KnownModel::new).collect() }
    }
}

impl KnownModel {
    fn new(model: &DeviceModel) -> KnownModel {
        let mount = model.keys.get("mount").and_then(|mount| mount.as_str());
        let stance = match (model.kind(), mount) {
            ("lidar", None | Some("upright")) => Stance::Upright,
            ("pad" | "gate", _) => Stance::Level,
            _ => Stance::Facing,
        };
        KnownModel { name: model.name.clone(), stance, cost: model.cost(), keys: own_keys(model) }
    }
}

/// What a device of the catalogue does not say and a study must: the zone of a curtain. It begins one metre deep behind
/// the curtain, as wide and as high as that.
fn own_keys(model: &DeviceModel) -> Vec<(String, String)> {
    let corner = |key: &str| -> Option<[f64; 3]> {
        let numbers = model.keys.get("box")?.get(key)?.as_array()?;
        let number = |value: &toml::Value| value.as_float().or(value.as_integer().map(|whole| whole as f64));
        numbers.iter().map(number).collect::<Option<Vec<f64>>>()?.try_into().ok()
    };
    let zone = (model.kind() == "gate" && !model.keys.contains_key("zone"))
        .then(|| corner("min_m").zip(corner("max_m")))
        .flatten();
    let text = |([_, left, _], [back, right, top]): ([f64; 3], [f64; 3])| {
        format!("{{ min_m = [{back}, {left}, 0], max_m = [{}, {right}, {top}] }}", back + 1.0)
    };
    zone.map(text).map(|zone| ("zone".to_string(), zone)).into_iter().collect()
}

impl KnownSensor {
    fn new(sensor: &Sensor) -> KnownSensor {
        let pose = |setting: &Setting| match setting {
            Setting::Pose(pose) => Some(*pose),
            _ => None,
        };
        let poses: Vec<_> =
            sensor.candidates.iter().map(|known| (known.name.clone(), pose(&known.setting))).collect();
        let is_posed = poses.iter().any(|(_, pose)| pose.is_some());
        KnownSensor { name: sensor.name.clone(), stance: sensor.kind.stance(), is_posed, poses }
    }
}
