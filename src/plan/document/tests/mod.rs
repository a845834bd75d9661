//! Edits of texts, small ones and the shipped studies. What is expected is written out, or found in another way.

mod forms;
mod objects;
mod random;
mod rounding;
mod shapes;
mod shipped;
mod written;

use std::path::{Path, PathBuf};

use perirobot_scene::source::Sources;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::sensor::Stance;

use super::*;

/// The folder of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A text as the study of a file that need not be there.
fn load(path: &Path, text: &str) -> Study {
    let sources = Sources::from_main(path).with_file(path, text.into());
    Study::read(path, &Overrides::default(), sources).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn at(position_m: [f64; 3], pan_deg: f64, tilt_deg: f64) -> Pose6 {
    Pose6 { position_m, pan_deg, tilt_deg, roll_deg: 0.0 }
}

/// What is known of sensors with some poses.
fn known(sensors: &[(&str, &[&str])]) -> Known {
    let sensors = sensors.iter().map(|(name, poses)| KnownSensor {
        name: name.to_string(),
        stance: Stance::Facing,
        is_posed: true,
        poses: poses.iter().map(|pose| (pose.to_string(), None)).collect(),
    });
    let model = KnownModel { name: "d455".into(), stance: Stance::Facing, cost: None, keys: Vec::new() };
    Known { sensors: sensors.collect(), models: vec![model] }
}

fn place(sensor: &str, pose: &str) -> Edit {
    Edit::Place { sensor: sensor.into(), pose: pose.into() }
}

fn add(sensor: &str, at: Pose6) -> Edit {
    Edit::Add { device: Device::Sensor(sensor.into()), at, cost: None }
}

/// The text after some edits.
#[track_caller]
fn edited(text: &str, known: &Known, edits: &[Edit]) -> String {
    let mut document = Document::new(text.into());
    for edit in edits {
        if let Err(e) = document.apply(edit, None, known) {
            panic!("{edit:?}: {e}\n{}", document.text());
        }
    }
    document.text().into()
}

/// The lines of a text that are comments.
fn comments(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.trim_start().starts_with('#')).collect()
}

/// Whether all comments of a text are in another, in their order.
fn keeps_comments(before: &str, after: &str) -> bool {
    let mut left = comments(after).into_iter();
    comments(before).into_iter().all(|comment| left.any(|other| other == comment))
}
