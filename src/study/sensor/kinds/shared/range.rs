//! The keys that all sensors which measure distances share.

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, Deserializer, MapAccess, Unexpected, Visitor};
use toml::Table;

use super::Silence;
use crate::diagnostics::Place;
use crate::sensor::noise::Deviation;
use crate::sensor::range::{Along, Range, ReflectanceRanges};
use crate::sensor::{Calibration, SaidOfNoise};
use perirobot_march::Result;

/// Their values, as each kind reads them.
pub(crate) struct RangeKeys {
    pub(crate) range_m: [f64; 2],
    pub(crate) along: Option<Along>,
    pub(crate) near_ignore_m: Option<f64>,
    pub(crate) no_return: Option<Silence>,
    pub(crate) noise: Option<NoiseFile>,
    pub(crate) dropout: Option<f64>,
    pub(crate) calibration: Option<CalibrationFile>,
    pub(crate) reflectance_ranges_m: Option<Vec<[f64; 2]>>,
}

impl RangeKeys {
    pub(crate) fn check(self, at: &Place, noiseless: bool) -> Result<Range> {
        let [near, far] = self.range_m;
        if !(near >= 0.0 && near < far && far < 1e6) {
            let rule = "must be [nearest, farthest] in metres, 0 <= nearest < farthest < 1000000";
            return Err(at.wrong("range_m", format!("{:?}", self.range_m), rule));
        }
        let near_ignore_m = self.near_ignore_m.unwrap_or(0.0);
        at.number("near_ignore_m", near_ignore_m, 0.0..far, "a distance from 0 to the sensor's range")?;
        let range = Range {
            range_m: self.range_m,
            along: self.along.unwrap_or_default(),
            near_ignore_m,
            no_return_is_free: self.no_return == Some(Silence::Free),
            noise: deviation(at, self.noise, far)?,
            dropout: at.number("dropout", self.dropout.unwrap_or(0.0), 0.0..1.0, SHARE)?,
            calibration: self.calibration.map(|file| file.check(at)).transpose()?,
            reflectance: reflectance(at, self.reflectance_ranges_m.as_deref(), far)?,
        };
        Ok(if noiseless { range.to_noiseless() } else { range })
    }
}

/// Ranges by reflectance, ascending.
fn reflectance(at: &Place, pairs: Option<&[[f64; 2]]>, far: f64) -> Result<ReflectanceRanges> {
    let Some(pairs) = pairs else { return Ok(ReflectanceRanges::default()) };
    let wrong = |rule: &str| Err(at.wrong("reflectance_ranges_m", format!("{pairs:?}"), rule));
    let is_range = |metres: f64| metres > 0.0 && metres < 1e6;
    if let Some([share, _]) = pairs.iter().find(|[share, _]| !(*share > 0.0 && *share <= 1.0)) {
        let percent = share / 100.0;
        return wrong(&match (1.0..=100.0).contains(share) {
            true => format!("begins each pair with a share of the light from 0 to 1: {share} % is {percent}"),
            false => "begins each pair with a share of the light, above 0 and up to 1".into(),
        });
    }
    if pairs.is_empty() || pairs.len() > 3 {
        return wrong("must have one to three pairs, as in [[0.1, 8], [0.9, 25]]");
    }
    if !pairs.iter().all(|[_, metres]| is_range(*metres)) {
        return wrong("ends each pair with a range in metres, above 0 and below 1000000");
    }
    if !pairs.is_sorted_by(|one, next| one[0] < next[0] && one[1] <= next[1]) {
        return wrong("must ascend: a brighter object is detected at least as far");
    }
    let found = ReflectanceRanges::new(pairs);
    match found.range_m(1.0) {
        brightest if brightest < far => wrong(&format!(
            "makes {brightest:.2} m for what reflects all light, below the sensor's range of {far} m: lower range_m to it"
        )),
        _ => Ok(found),
    }
}

const SHARE: &str = "the share of returns that is lost, from 0 to below 1";

/// The noise of distances: a standard deviation that may grow with distance, or "unknown".
pub(crate) enum NoiseFile {
    Model(ModelFile),
    Unknown,
}

/// Standard deviation of a distance of t metres: std_m + per_m t + per_m2 t^2, in metres.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct ModelFile {
    /// At any distance, in metres. Default 0.
    std_m: Option<f64>,
    /// For each metre of distance. Default 0.
    per_m: Option<f64>,
    /// For each square metre, as of a stereo camera: subpixel error / (focal length in pixels * baseline). Default 0.
    per_m2: Option<f64>,
}

impl<'de> Deserialize<'de> for NoiseFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NoiseVisitor;
        impl<'de> Visitor<'de> for NoiseVisitor {
            type Value = NoiseFile;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("{ std_m, per_m, per_m2 }, as in noise = { std_m = 0.02 }, or \"unknown\"")
            }
            fn visit_str<E: de::Error>(self, word: &str) -> Result<NoiseFile, E> {
                match word {
                    UNKNOWN => Ok(NoiseFile::Unknown),
                    _ => Err(E::invalid_value(Unexpected::Str(word), &self)),
                }
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<NoiseFile, A::Error> {
                ModelFile::deserialize(MapAccessDeserializer::new(map)).map(NoiseFile::Model)
            }
        }
        deserializer.deserialize_any(NoiseVisitor)
    }
}

#[cfg(test)]
impl schemars::JsonSchema for NoiseFile {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Noise".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let model = ModelFile::json_schema(generator);
        schemars::json_schema!({ "anyOf": [model, { "const": UNKNOWN }] })
    }
}

/// The word for unknown noise.
const UNKNOWN: &str = "unknown";

/// How far a mount may be from where the study says it is: standard deviations along and about each of the sensor's own axes.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct CalibrationFile {
    /// Of its position, in metres. Default 0.
    position_m: Option<f64>,
    /// Of its rotation, in degrees. Default 0.
    angle_deg: Option<f64>,
}

impl CalibrationFile {
    fn check(self, at: &Place) -> Result<Calibration> {
        let at = at.key("calibration");
        if self.position_m.is_none() && self.angle_deg.is_none() {
            let example = "as in calibration = { position_m = 0.01, angle_deg = 0.3 }";
            return Err(at.says(format!("give position_m, angle_deg or both, {example}")));
        }
        let (position_m, angle_deg) = (self.position_m.unwrap_or(0.0), self.angle_deg.unwrap_or(0.0));
        at.number("position_m", position_m, 0.0..=1.0, "a standard deviation in metres, from 0 to 1")?;
        at.number("angle_deg", angle_deg, 0.0..=30.0, "a standard deviation in degrees, from 0 to 30")?;
        Ok(Calibration { position_m, angle_rad: angle_deg.to_radians() })
    }
}

/// Refuses the former key of noise, from before it could grow with distance, and says how to write the same
/// now.
pub(crate) fn refuse_former(at: &Place, keys: &Table) -> Result<()> {
    match keys.get("noise_std_m") {
        None => Ok(()),
        Some(value) => {
            let rule = format!("is written noise = {{ std_m = {value} }} now");
            Err(at.wrong("noise_std_m", value, &rule))
        }
    }
}

/// The noise that the keys of a sensor, including its model's, describe.
pub(crate) fn noise_in(keys: &Table) -> SaidOfNoise {
    match keys.get("noise") {
        None => SaidOfNoise::Nothing,
        Some(noise) if noise.as_str() == Some(UNKNOWN) => SaidOfNoise::Unknown,
        Some(_) => SaidOfNoise::Model,
    }
}

/// A deviation, no larger than the distance itself.
fn deviation(at: &Place, noise: Option<NoiseFile>, far: f64) -> Result<Deviation> {
    let Some(NoiseFile::Model(file)) = noise else { return Ok(Deviation::NONE) };
    let ModelFile { std_m, per_m, per_m2 } = file;
    let at = at.key("noise");
    if [std_m, per_m, per_m2].iter().all(Option::is_none) {
        return Err(at.says("give at least one of std_m, per_m and per_m2, as in noise = { std_m = 0.02 }"));
    }
    let rule = format!("a length in metres from 0 to {far}, how far the sensor measures");
    let number = |key: &str, value: Option<f64>, most: f64, rule: &str| {
        at.number(key, value.unwrap_or(0.0), 0.0..=most, rule)
    };
    let deviation = Deviation {
        std_m: number("std_m", std_m, far, &rule)?,
        per_m: number("per_m", per_m, 1.0, "metres of deviation for a metre of distance, from 0 to 1")?,
        per_m2: number("per_m2", per_m2, 1.0, "metres of deviation for a square metre, from 0 to 1")?,
    };
    match deviation.at_m(far) {
        largest if largest > far => {
            Err(at.says(format!("is {largest} m at {far} m, which must be at most the distance itself")))
        }
        _ => Ok(deviation),
    }
}

/// The standard deviation of a sensor whose noise cannot grow with distance. Checked even where noise is
/// switched off.
pub(crate) fn constant(at: &Place, noise: Option<NoiseFile>, most_m: f64, noiseless: bool) -> Result<f64> {
    if let Some(NoiseFile::Model(ModelFile { per_m, per_m2, .. })) = noise
        && (per_m.is_some() || per_m2.is_some())
    {
        let what =
            "a cover has the same noise at all distances: give std_m only, as in noise = { std_m = 0.02 }";
        return Err(at.key("noise").says(what));
    }
    let deviation = deviation(at, noise, most_m)?;
    Ok(if noiseless { 0.0 } else { deviation.std_m })
}
