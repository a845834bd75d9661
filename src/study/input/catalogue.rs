//! Real devices by name: `model = "realsense-d435"` stands for the keys of that device in `catalogue.toml`, or in a
//! catalogue of the study's own; keys that the study itself writes take precedence. The keys are checked afterwards, as if the user had
//! written them all.

mod contradiction;
mod own;
mod price;

use std::sync::LazyLock;

use serde::Deserialize;
use toml::{Table, Value};

use crate::diagnostics::{Place, read};
use crate::sensor::SaidOfNoise;
use crate::sensor::kinds::shared::range::noise_in;
pub(super) use own::{read_own, unnamed_warnings};
use perirobot_march::{Error, Result};
use price::take_list_price;
pub use price::{ListPrice, describe_list_prices};

/// A device of the catalogue.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeviceModel {
    /// Its name in studies.
    pub name: String,
    /// The maker's name for it, and the mode of the device.
    pub title: String,
    /// The document that the values are from.
    pub source: String,
    /// The address of that document, or of a copy.
    pub url: String,
    /// What to know before relying on it.
    pub note: String,
    /// Which values could not be compared with a document of the maker.
    pub unconfirmed: Option<String>,
    /// For a stereo camera, the values from which its noise follows.
    pub stereo: Option<Stereo>,
    /// What a public shop asks for one, to be checked.
    pub price: Option<ListPrice>,
    /// To which resolutions its protective field can be set, in millimetres: the smallest object that it detects.
    #[serde(default)]
    pub resolutions_mm: Vec<f64>,
    /// The keys of a `[[sensor]]` that it gives; the noise of a stereo camera is added as the file is read.
    pub keys: Table,
}

/// The values from which the depth noise of a stereo camera follows, besides its focal length.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stereo {
    /// Between its two lenses, in metres.
    pub baseline_m: f64,
    /// Standard deviation with which a point of one image is found in the other, in pixels.
    pub subpixel_px: f64,
}

impl Stereo {
    /// The standard deviation of depth, in metres for a square metre of distance: subpixel / (focal length *
    /// baseline), to four digits. From z = f b / d, an error of the disparity d becomes one of z * z / (f b)
    /// times as much.
    pub(crate) fn per_m2(&self, fov_deg: f64, pixels: f64) -> f64 {
        let focal_px = pixels / 2.0 / libm::tan(fov_deg.to_radians() / 2.0);
        let exact = self.subpixel_px / (focal_px * self.baseline_m);
        let digits = 10f64.powi(3 - exact.log10().floor() as i32);
        (exact * digits).round() / digits
    }
}

impl DeviceModel {
    /// The kind of sensor that it is.
    pub fn kind(&self) -> &str {
        self.keys.get("kind").and_then(Value::as_str).unwrap_or_default()
    }

    /// What one costs by its keys, which a catalogue of a study's own may have.
    pub fn cost(&self) -> Option<f64> {
        let cost = self.keys.get("cost")?;
        cost.as_float().or_else(|| cost.as_integer().map(|whole| whole as f64))
    }

    /// What its sources say of its noise.
    pub fn noise(&self) -> SaidOfNoise {
        noise_in(&self.keys)
    }

    /// The first of the two numbers of a key.
    fn horizontal(&self, key: &str) -> Option<f64> {
        let value = self.keys.get(key)?.as_array()?.first()?;
        value.as_float().or_else(|| value.as_integer().map(|n| n as f64))
    }

    fn add_stereo_noise(&mut self) {
        let optics = self.horizontal("fov_deg").zip(self.horizontal("resolution_px"));
        if let (Some(stereo), Some((fov_deg, pixels))) = (self.stereo, optics) {
            let noise = Table::from_iter([("per_m2".to_string(), stereo.per_m2(fov_deg, pixels).into())]);
            self.keys.insert("noise".into(), noise.into());
        }
    }
}

/// Keys that exclude each other: if a study writes the one on the left, those on the right are not taken from
/// the device.
const INSTEAD: [(&str, &[&str]); 6] = [
    ("rings_deg", &["elevation_deg", "rings"]),
    ("elevation_deg", &["rings_deg"]),
    ("rings", &["rings_deg"]),
    ("beams", &["resolution_deg"]),
    ("resolution_deg", &["beams"]),
    ("camera_info", &["fov_deg", "resolution_px"]),
];

/// Names that are so near to what was written that they may be meant.
const NEAR: f64 = 0.5;

/// All devices, in the order of the file.
pub fn models() -> &'static [DeviceModel] {
    #[derive(Deserialize)]
    struct Catalogue {
        model: Vec<DeviceModel>,
    }
    static MODELS: LazyLock<Vec<DeviceModel>> = LazyLock::new(|| {
        let table: Table = toml::from_str(include_str!("catalogue.toml")).expect("a tested file");
        let mut catalogue: Catalogue = read(table).expect("a tested file");
        catalogue.model.iter_mut().for_each(DeviceModel::add_stereo_noise);
        catalogue.model
    });
    &MODELS
}

/// A study with its models replaced by their keys; for the fingerprint, which must change when the values of
/// a model change.
pub fn written_out(mut study: Table) -> Table {
    let sensors = study.get_mut("sensor").and_then(Value::as_array_mut);
    for sensor in sensors.into_iter().flatten().filter_map(Value::as_table_mut) {
        if let Some(model) = sensor.get("model").and_then(Value::as_str).and_then(|name| find(name, &[])) {
            complete(sensor, model);
        }
    }
    study
}

/// What a sensor has from a device of the catalogue.
#[derive(Default)]
pub(super) struct FromModel {
    /// How its own keys contradict the device's, a sentence each.
    pub(super) contradictions: Vec<String>,
    /// That it casts fewer rays than the device has, if so.
    pub(super) thinned: Option<String>,
    /// Its list price, if that is its cost.
    pub(super) list_price: Option<ListPrice>,
    /// The resolutions of its field.
    pub(super) resolutions_mm: Vec<f64>,
}

/// Replaces `model` in the keys of a sensor by the keys that it stands for, and `cost = "list"` by a list price, which
/// must be in the currency of the study.
pub(super) fn resolve(
    at: &Place,
    keys: &mut Table,
    own: &[DeviceModel],
    currency: Option<&str>,
) -> Result<FromModel> {
    let Some(written) = keys.remove("model") else {
        let list_price = take_list_price(at, keys, None, currency)?;
        return Ok(FromModel { list_price, ..FromModel::default() });
    };
    let Some(name) = written.as_str() else {
        return Err(at.wrong("model", written, "must be a name, as in model = \"realsense-d435\""));
    };
    let model = find(name, own).ok_or_else(|| unknown(at, name, own))?;
    match keys.get("kind") {
        Some(kind) if kind.as_str() != Some(model.kind()) => {
            let rule = format!("the model {name:?} is of kind {:?}: take kind or model away", model.kind());
            Err(at.wrong("kind", kind, &rule))
        }
        _ => {
            refuse_rings(at, keys, model)?;
            let contradictions = contradiction::contradictions(model, keys);
            let thinned = contradiction::describe_thinning(model, keys);
            complete(keys, model);
            let list_price = take_list_price(at, keys, Some(model), currency)?;
            Ok(FromModel {
                contradictions,
                thinned,
                list_price,
                resolutions_mm: model.resolutions_mm.clone(),
            })
        }
    }
}

/// Refuses a number of rings without their range, since it replaces the rings of the device.
fn refuse_rings(at: &Place, keys: &Table, model: &DeviceModel) -> Result<()> {
    let (Some(rings), Some(own)) = (keys.get("rings"), model.keys.get("rings_deg")) else { return Ok(()) };
    let has_range = keys.contains_key("elevation_deg") || keys.get("fov_deg").is_some_and(Value::is_array);
    match has_range || keys.contains_key("rings_deg") {
        true => Ok(()),
        false => {
            let rule = format!(
                "replaces rings_deg = {own} of {}: remove rings, or write elevation_deg = [from, to] beside it",
                model.name
            );
            Err(at.wrong("rings", rings, &rule))
        }
    }
}

fn find<'m>(name: &str, own: &'m [DeviceModel]) -> Option<&'m DeviceModel> {
    own.iter().chain(models()).find(|model| model.name == name)
}

/// Adds the keys of a model that the study does not write.
fn complete(keys: &mut Table, model: &DeviceModel) {
    let written = keys.clone();
    let said_otherwise = |key: &str| {
        // A pair of numbers includes the vertical angle, which a lidar otherwise has from its rings.
        let is_pair = |key: &str| model.kind() == "lidar" && written.get(key).is_some_and(Value::is_array);
        let instead = INSTEAD.iter().any(|(new, old)| written.contains_key(*new) && old.contains(&key));
        instead
            || is_pair("fov_deg") && ["rings_deg", "elevation_deg"].contains(&key)
            || is_pair("resolution_deg") && key == "rings"
    };
    for (key, value) in &model.keys {
        if !written.contains_key(key) && !said_otherwise(key) {
            keys.insert(key.clone(), value.clone());
        }
    }
}

fn unknown(at: &Place, name: &str, own: &[DeviceModel]) -> Error {
    let alike = |model: &&DeviceModel| {
        let (known, name) = (model.name.as_str(), name.to_lowercase());
        known.contains(&name) || strsim::normalized_damerau_levenshtein(known, &name) >= NEAR
    };
    let near: Vec<&str> = own.iter().chain(models()).filter(alike).map(|model| model.name.as_str()).collect();
    let meant = match near.is_empty() || name.is_empty() {
        true => String::new(),
        false => format!(" (did you mean {}?)", near.join(", ")),
    };
    let rule = format!(
        "is not in the catalogue{meant}: `perirobot sensors` lists all that ship; those of your own are in \
         catalogue = \"ours.toml\" of the study"
    );
    at.wrong("model", format!("{name:?}"), &rule)
}

#[cfg(test)]
mod tests;
