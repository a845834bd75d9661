//! What a sensor guards, in its own keys: the box and the zone of a light curtain, the size of a mat, the field of a scanner.

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use serde::{Deserialize, Serialize};

use super::apply::Editor;
use super::group;
use super::number::{list, number};
use super::path::Path;
use super::pose::round_metres;
use super::source::Source;

/// The longest length that a study can say.
const FARTHEST_M: f64 = 1e6;

/// What a sensor guards, in its own frame, or in the world if it has no poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case")]
pub enum SensorShape {
    /// A light curtain. What is left out stays.
    Gate {
        /// Where it senses.
        #[serde(default)]
        r#box: Option<Corners>,
        /// What it guards.
        #[serde(default)]
        zone: Option<Corners>,
    },
    /// A mat.
    Pad {
        /// Along and across where it faces, in metres.
        size_m: [f64; 2],
    },
    /// The field of a scanner.
    Field {
        /// Its corners, in metres.
        polygon_m: Vec<[f64; 2]>,
    },
}

/// A box by its corners, in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Corners {
    /// Lowest corner.
    pub min_m: [f64; 3],
    /// Highest corner.
    pub max_m: [f64; 3],
}

impl Editor<'_> {
    pub(super) fn set_sensor_shape(&mut self, sensor: &str, shape: &SensorShape) -> Result<()> {
        let at = group::sensor(self.source, sensor)?;
        let in_sensor = |e: Error| e.with_place(format!("sensor {sensor:?}"));
        let source = &mut *self.source;
        match shape {
            SensorShape::Gate { r#box, zone } => {
                let boxes = [("box", r#box), ("zone", zone)].into_iter();
                boxes
                    .filter_map(|(key, corners)| Some((key, corners.as_ref()?)))
                    .try_for_each(|(key, corners)| set_corners(source, &at, key, corners).map_err(in_sensor))
            }
            SensorShape::Pad { size_m } => {
                check_lengths("size_m", size_m).map_err(in_sensor)?;
                let old = source.numbers(&at.key("size_m"));
                let size_m = rounded(size_m, old.as_deref());
                if let Some(wrong) = size_m.iter().find(|metres| **metres <= 0.0) {
                    return Err(in_sensor(Issue::value("size_m", wrong, "must be above 0").into()));
                }
                source.set_numbers(&at, "size_m", &size_m)
            }
            SensorShape::Field { polygon_m } => set_field(source, &at, polygon_m).map_err(in_sensor),
        }
    }
}

/// Numbers as they are written. Those that stay are not rounded.
fn rounded(numbers: &[f64], old: Option<&[f64]>) -> Vec<f64> {
    let old = old.unwrap_or_default();
    let round =
        |(index, new): (usize, &f64)| if old.get(index) == Some(new) { *new } else { round_metres(*new) };
    numbers.iter().enumerate().map(round).collect()
}

fn check_lengths(key: &str, numbers: &[f64]) -> Result<()> {
    match numbers.iter().all(|metres| metres.abs() <= FARTHEST_M) {
        true => Ok(()),
        false => {
            let rule = format!("must be lengths in metres from -{FARTHEST_M} to {FARTHEST_M}");
            Err(Issue::value(key, format!("{numbers:?}"), rule).into())
        }
    }
}

fn set_corners(source: &mut Source, sensor: &Path, key: &str, corners: &Corners) -> Result<()> {
    let at = sensor.key(key);
    let sides = [("min_m", corners.min_m), ("max_m", corners.max_m)];
    for (side, numbers) in sides {
        check_lengths(&format!("{key}.{side}"), &numbers)?;
    }
    let [low, high] =
        sides.map(|(side, numbers)| rounded(&numbers, source.numbers(&at.key(side)).as_deref()));
    if low.iter().zip(&high).any(|(low, high)| low >= high) {
        let rule = "must be above min_m on every axis";
        return Err(Issue::value(format!("{key}.max_m"), format!("{high:?}"), rule).into());
    }
    let [low_text, high_text] = [&low, &high].map(|side| list(side.iter().map(|metres| number(*metres))));
    match source.get(&at) {
        // A box of the catalogue becomes one of the study.
        None => source.set(sensor, key, &format!("{{ min_m = {low_text}, max_m = {high_text} }}")),
        Some(_) => {
            source.set_numbers(&at, "min_m", &low)?;
            source.set_numbers(&at, "max_m", &high)
        }
    }
}

fn set_field(source: &mut Source, sensor: &Path, polygon_m: &[[f64; 2]]) -> Result<()> {
    check_lengths("field.polygon_m", polygon_m.as_flattened())?;
    let at = sensor.key("field").key("polygon_m");
    if source.get(&sensor.key("field").key("polygon")).is_some() {
        return Err(Error::input("field.polygon", "its corners are in a table")
            .with_advice("change them there, or write them as polygon_m"));
    }
    if source.get(&at).is_none() {
        return Err(
            Error::input("field", "is not written in the study").with_advice("write it into the file")
        );
    }
    let corner = |source: &Source, index: usize| source.numbers(&at.entry(index));
    if source.count(&at) == polygon_m.len() {
        return polygon_m.iter().enumerate().try_for_each(|(index, new)| {
            let new = rounded(new, corner(source, index).as_deref());
            source.replace_numbers(&at.entry(index), &new)
        });
    }
    let corners = polygon_m.iter().map(|new| list(new.iter().map(|metres| number(round_metres(*metres)))));
    let text = list(corners);
    source.set(&sensor.key("field"), "polygon_m", &text)
}
