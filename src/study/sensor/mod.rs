//! Sensors of a study, checked. The keys that all kinds share are read here, those of a kind in its own file.

mod cover;
mod gate;
mod lidar;
mod pad;
mod range;
mod rays;
mod rgb;
mod rgbd;

use std::sync::Arc;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Table;

use super::file::PosesFile;
use super::value::exactly;
use super::{Place, poses};
use crate::sensor::known_robot::KnownRobot;
use crate::sensor::prism::Prism;
use crate::sensor::{Candidate, Kind, Link, Sensor, Setting};
use crate::source::Sources;
use crate::{Error, Result};

/// Most rays a sensor may cast at one pose: their directions, 12 bytes each, must fit one buffer of 128 MiB.
const MAX_RAYS: usize = (128 << 20) / 12;

/// The keys of every sensor.
#[derive(Deserialize)]
struct CommonFile {
    name: String,
    kind: KindName,
    on: Option<LinkFile>,
    same_poses_as: Option<String>,
    #[serde(default)]
    poses: Vec<PosesFile>,
}

const COMMON_KEYS: [&str; 5] = ["name", "kind", "on", "same_poses_as", "poses"];

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum KindName {
    Rgbd,
    Rgb,
    Lidar,
    Rays,
    Pad,
    Gate,
    Cover,
    KnownRobot,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LinkFile {
    object: String,
    link: String,
}

/// What a silent sensor says of what it watches.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Silence {
    Unknown,
    Free,
}

/// A box in a file.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxFile {
    #[serde(deserialize_with = "exactly")]
    min_m: [f64; 3],
    #[serde(deserialize_with = "exactly")]
    max_m: [f64; 3],
}

impl BoxFile {
    fn check(&self, at: &Place, key: &str) -> Result<Prism> {
        let at = at.key(key);
        let (min, max) = (at.vector("min_m", self.min_m)?, at.vector("max_m", self.max_m)?);
        if !min.cmplt(max).all() {
            return Err(at.wrong("max_m", format!("{:?}", self.max_m), "must be above min_m on every axis"));
        }
        Ok(Prism::between(min, max))
    }
}

/// A kind without keys of its own.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoKeys {}

/// Checks one `[[sensor]]`, its place in the study being `earlier.len()`.
pub(super) fn check(
    at: &Place,
    mut keys: Table,
    seed: u64,
    noiseless: bool,
    earlier: &[Sensor],
    sources: &Sources,
) -> Result<Sensor> {
    let index = earlier.len();
    let mut common = Table::new();
    for key in COMMON_KEYS {
        common.extend(keys.remove(key).map(|value| (key.to_string(), value)));
    }
    let name = common.get("name").and_then(|name| name.as_str());
    let at = at.key(&name.map_or(format!("sensor[{index}]"), |name| format!("sensor {name:?}")));
    let common: CommonFile = common.try_into().map_err(|e| unreadable(&at, &e))?;
    let kind: Arc<dyn Kind> = match common.kind {
        KindName::Rgbd => Arc::new(rgbd::check(&at, own(&at, keys)?, noiseless)?),
        KindName::Rgb => Arc::new(rgb::check(&at, own(&at, keys)?)?),
        KindName::Lidar => Arc::new(lidar::check(&at, own(&at, keys)?, noiseless)?),
        KindName::Rays => Arc::new(rays::check(&at, own(&at, keys)?, noiseless, sources)?),
        KindName::Pad => Arc::new(pad::check(&at, own(&at, keys)?)?),
        KindName::Gate => Arc::new(gate::check(&at, own(&at, keys)?)?),
        KindName::Cover => Arc::new(cover::check(&at, own(&at, keys)?, noiseless)?),
        KindName::KnownRobot => {
            let NoKeys {} = own(&at, keys)?;
            Arc::new(KnownRobot)
        }
    };
    let on = common.on.map(|LinkFile { object, link }| Link { object, link });
    if on.is_some() && !kind.takes_poses() {
        return Err(at.says(format!("on does not belong to a {}: it is where the robot is", kind.name())));
    }
    let like = common.same_poses_as.as_deref();
    let source = Source { seed, index, earlier, like, files: sources };
    let candidates = candidates(&at, &common.name, &*kind, &common.poses, &source)?;
    Ok(Sensor { name: common.name, kind, on, candidates })
}

/// Where candidates may come from besides the sensor's own poses.
struct Source<'a> {
    seed: u64,
    index: usize,
    earlier: &'a [Sensor],
    like: Option<&'a str>,
    files: &'a Sources,
}

fn candidates(
    at: &Place,
    name: &str,
    kind: &dyn Kind,
    groups: &[PosesFile],
    source: &Source,
) -> Result<Vec<Candidate>> {
    if !kind.takes_poses() && (!groups.is_empty() || source.like.is_some()) {
        return Err(at.says(format!("poses do not belong to a {}: take them away", kind.name())));
    }
    let before: usize = source.earlier.iter().map(|sensor| sensor.candidates.len()).sum();
    let most = poses::MAX_POSES.saturating_sub(before);
    if let Some(like) = source.like {
        if !groups.is_empty() {
            return Err(at.says("both poses and same_poses_as: give one"));
        }
        let posed = || source.earlier.iter().filter(|sensor| has_poses(sensor));
        let found = posed().find(|sensor| sensor.name == like).ok_or_else(|| {
            let known: Vec<_> = posed().map(|sensor| &sensor.name).collect();
            at.wrong(
                "same_poses_as",
                format!("{like:?}"),
                &format!("must be a sensor above it that has poses: {known:?}"),
            )
        })?;
        // A pose means another way of standing to a sensor that stands otherwise.
        if found.kind.stance() != kind.stance() {
            let what = format!("{:?} stands otherwise than a {}: write out its poses", like, kind.name());
            return Err(at.says(format!("same_poses_as: {what}")));
        }
        if found.candidates.len() > most {
            return Err(at.says(format!("same_poses_as: {}", poses::too_many())));
        }
        return Ok(found.candidates.clone());
    }
    let settings = kind.settings();
    if groups.is_empty() && !settings.is_empty() {
        let candidate = |(name, setting)| Candidate { name, group: kind.name().into(), setting };
        return Ok(settings.into_iter().map(candidate).collect());
    }
    at.some("poses", groups, "[[sensor.poses]] name = \"wall\"")?;
    let mut candidates = Vec::new();
    for (i, group) in groups.iter().enumerate() {
        let stream = (source.index as u64) << 32 | i as u64;
        let (stance, seed, files) = (kind.stance(), source.seed, source.files);
        let source = poses::Source { sensor: name, stance, seed, stream, most, files };
        poses::expand(at, group, &source, &mut candidates)?;
    }
    at.unique("pose", candidates.iter().map(|c| c.name.as_str()))?;
    Ok(candidates)
}

fn has_poses(sensor: &Sensor) -> bool {
    sensor.candidates.iter().any(|candidate| matches!(candidate.setting, Setting::Pose(_)))
}

/// The keys of one kind.
fn own<T: DeserializeOwned>(at: &Place, keys: Table) -> Result<T> {
    keys.try_into().map_err(|e| {
        let error = unreadable(at, &e);
        match e.message().starts_with("unknown field") {
            true => Error::Input(format!("{error} (and {} with every sensor)", COMMON_KEYS.join(", "))),
            false => error,
        }
    })
}

/// How keys are written that a reader may miss or take for something else.
const EXAMPLES: [&str; 11] = [
    "name = \"camera\"",
    "kind = \"rgbd\"",
    "fov_deg = [87, 58], horizontal and vertical",
    "resolution_px = [1280, 720]",
    "resolution_deg = [0.5, 2], horizontal and vertical, or one for both",
    "range_m = [0.3, 6]",
    "size_m = [1, 0.75]",
    "inflation_m = [0.1, 0.2]",
    "directions = \"rays.csv\", a table with the columns x,y,z",
    "box = { min_m = [0, 0, 0.3], max_m = [0.1, 1, 2] }",
    "zone = { min_m = [0, -1, 0], max_m = [2, 1, 2] }",
];

/// The reader's words, with an example of the key that they are about. They end with it.
fn unreadable(at: &Place, error: &toml::de::Error) -> Error {
    let said = error.to_string().trim_end().replace('\n', " ");
    let about = |example: &&&str| {
        let key = example.split(' ').next().unwrap_or_default();
        said.ends_with(&format!("`{key}`"))
    };
    let example = EXAMPLES.iter().find(about).map_or(String::new(), |example| format!(", as in {example}"));
    at.says(format!("{said}{example}"))
}

/// Representations are there, and none twice.
fn each_once<T: PartialEq>(at: &Place, names: &[T], example: &str) -> Result<()> {
    at.some("representations", names, example)?;
    match (0..names.len()).find(|&i| names[..i].contains(&names[i])) {
        Some(i) => Err(at.says(format!("representations[{i}] stands there before: name each once"))),
        None => Ok(()),
    }
}

/// A length that must be above zero.
fn length(at: &Place, key: &str, metres: f64) -> Result<f64> {
    at.number(key, metres, f64::MIN_POSITIVE..1e6, "a length in metres above 0 and below 1000000")
}

#[cfg(test)]
mod tests;
