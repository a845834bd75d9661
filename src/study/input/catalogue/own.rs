//! The catalogue of a study's own: read, and its devices checked, whether or not a sensor names them.

use std::path::Path;

use serde::Deserialize;
use toml::Table;

use super::{DeviceModel, ListPrice, Stereo, find};
use crate::diagnostics::{Place, parse};
use crate::input::sensor::{self, SensorContext};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_scene::source::Sources;

/// A device of a study's own catalogue. Only its name and its keys are needed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OwnModel {
    name: String,
    #[serde(default)]
    title: String,
    #[serde(default)]
    source: String,
    #[serde(default)]
    url: String,
    #[serde(default)]
    note: String,
    unconfirmed: Option<String>,
    stereo: Option<Stereo>,
    price: Option<ListPrice>,
    #[serde(default)]
    resolutions_mm: Vec<f64>,
    keys: Table,
}

/// Reads the catalogue of a study's own: `[[model]]` with a name, the keys of a `[[sensor]]`, and what else is known.
///
/// # Errors
/// When the file cannot be read or is not a catalogue, or a device has the name of another one.
pub(in crate::input) fn read_own(at: &Place, path: &Path, sources: &Sources) -> Result<Vec<DeviceModel>> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct OwnCatalogue {
        model: Vec<OwnModel>,
    }
    let text = sources.text(path).map_err(|e| at.wrap(e.with_place("catalogue")))?;
    let own: OwnCatalogue = parse(path, &text).map_err(|(e, _)| e)?;
    let of = |own: OwnModel| {
        let OwnModel { name, title, source, url, note, unconfirmed, stereo, price, resolutions_mm, keys } =
            own;
        let title = if title.is_empty() { name.clone() } else { title };
        let mut model =
            DeviceModel { name, title, source, url, note, unconfirmed, stereo, price, resolutions_mm, keys };
        model.add_stereo_noise();
        model
    };
    let own: Vec<DeviceModel> = own.model.into_iter().map(of).collect();
    let file = Place::new(path);
    file.unique("model", own.iter().map(|model| model.name.as_str()))?;
    for model in &own {
        let at = file.key(&format!("model {:?}", model.name));
        if find(&model.name, &[]).is_some() {
            return Err(at.says("is a device that ships").with_advice("give yours another name"));
        }
        if let Some(odd) = model.resolutions_mm.iter().find(|mm| !(1.0..=1000.0).contains(*mm)) {
            return Err(at.wrong("resolutions_mm", odd, "must be millimetres from 1 to 1000"));
        }
        model.price.as_ref().map_or(Ok(()), |price| price.check(&at.key("price")))?;
        if !model.keys.contains_key("kind") {
            return Err(at
                .key("keys")
                .wrap(Issue::missing("kind"))
                .with_advice("write what it is: kind = \"rgbd\""));
        }
        let placed = ["name", "poses", "on", "same_poses_as", "model"];
        if let Some(key) = placed.iter().find(|key| model.keys.contains_key(**key)) {
            let what = format!("keys.{key} belongs to a sensor of the study, not to a device");
            return Err(at.says(what).with_advice("move it there"));
        }
    }
    Ok(own)
}

/// What is wrong with devices that no sensor of the study at a path names, a line each. Keys that are missing are not: a
/// study may write them.
pub(in crate::input) fn unnamed_warnings(
    (study, catalogue): (&Path, &Path),
    sensors: &[Table],
    context: SensorContext,
) -> Vec<String> {
    let named: Vec<&str> = sensors.iter().filter_map(|keys| keys.get("model")?.as_str()).collect();
    let unnamed = context.models.iter().filter(|model| !named.contains(&model.name.as_str()));
    // Lines are those of the study, and its keys are not.
    let context = SensorContext { line_of: &|_| None, ..context };
    // Files that the keys name are in the study's folder, as those of a sensor.
    let at = Place::new(study).key(&format!("catalogue {:?}", catalogue.file_name().unwrap_or_default()));
    let warning = |model: &DeviceModel| {
        let at = at.key(&format!("model {:?}", model.name));
        let problem = sensor::check_device(&at, model.keys.clone(), &context).err()?.to_string();
        // Each warning of a study begins with its file.
        let problem = problem.trim_start_matches(&format!("{}: ", study.display()));
        Some(format!("{problem} (no sensor names this model)"))
    };
    unnamed.filter_map(warning).collect()
}
