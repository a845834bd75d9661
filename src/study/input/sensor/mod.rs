//! Sensors of a study, checked. The keys that all kinds share are read here, those of a kind in its own file.

#[cfg(test)]
mod schema;

use std::cell::Cell;

use serde::Deserialize;
use toml::{Table, Value};

use super::catalogue::{self, DeviceModel, FromModel};
use super::poses::{self, PosesFile, Surfaces};
use crate::diagnostics::{LineOf, Place, Problems, Step, Unread, Unreadable, describe, read};
use crate::sensor::kinds::shared::range::noise_in;
use crate::sensor::kinds::{self, Checked, EXAMPLES, KindEntry, LARGEST_M};
use crate::sensor::lens::has_lens;
use crate::sensor::{Candidate, Cost, CostTerms, GroupSurface, Kind, MountLink, PoseSpread, Sensor, Setting};
use perirobot_march::{Error, Result};
use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::source::Sources;
#[cfg(test)]
pub(super) use schema::AnySensor;

/// The keys of every sensor.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct CommonFile {
    /// Its name in results.
    name: String,
    /// What it is.
    #[cfg_attr(test, schemars(with = "String"))]
    kind: &'static KindEntry,
    /// The link of a robot that carries it; poses are then in the link's frame.
    on: Option<MountLink>,
    /// An earlier sensor whose poses it has, too.
    same_poses_as: Option<String>,
    /// What one of them costs, in any currency, for `perirobot choose`. "list" takes the list price of its model, to be
    /// checked, if the catalogue has one in the `currency` of the study.
    #[cfg_attr(test, schemars(schema_with = "schema::cost"))]
    cost: Option<f64>,
    /// How many of them a set of `perirobot choose` may have. Default as many as the set may have sensors.
    at_most: Option<u32>,
    /// The kind of light that it emits, as in "tof" or "lidar_905nm": sensors of one kind may disturb each other. "none" if
    /// it emits none, whatever its device does.
    emits: Option<String>,
    /// Where it may stand.
    #[serde(default)]
    poses: Vec<PosesFile>,
}

const COMMON_KEYS: [&str; 8] = ["name", "kind", "on", "same_poses_as", "cost", "at_most", "emits", "poses"];

/// The context in which a sensor is checked.
#[derive(Clone, Copy)]
pub(super) struct SensorContext<'a> {
    /// The study's seed.
    pub(super) seed: u64,
    /// Whether noise is switched off.
    pub(super) noiseless: bool,
    /// Its place in the study.
    pub(super) index: usize,
    /// The sensors before it that are right.
    pub(super) earlier: &'a [Sensor],
    /// How many poses those have together.
    pub(super) poses: usize,
    /// The sources through which its files are read.
    pub(super) sources: &'a Sources,
    /// The devices of the study's own catalogue.
    pub(super) models: &'a [DeviceModel],
    /// The unit of the study's costs.
    pub(super) currency: Option<&'a str>,
    /// The study's scenes that could be read, and whether those are all.
    pub(super) scenes: &'a [SceneSpec],
    pub(super) has_all_scenes: bool,
    /// Surfaces of their objects that were read before.
    pub(super) surfaces: &'a Surfaces,
    /// On which line of the study a key stands.
    pub(super) line_of: LineOf<'a>,
}

impl SensorContext<'_> {
    /// Why the keys of this sensor cannot be read, with an example of the key that is wrong or missing.
    fn unreadable(&self, at: &Place, error: &Unreadable, more: &str) -> Error {
        let key = match (&error.keys()[..], &error.kind) {
            ([key], _) => *key,
            ([], Unread::Missing(key)) => *key,
            _ => "",
        };
        let example = EXAMPLES.iter().find(|example| example.split(' ').next() == Some(key));
        let example = example.map_or(String::new(), |example| format!(", as in {example}"));
        let place = [Step::Key("sensor".into()), Step::Entry(self.index)];
        at.says(format!("{}{example}{more}", describe(error, self.line_of, &place)))
    }
}

/// Checks one `[[sensor]]`. All that is wrong with its poses is told at once.
pub(super) fn check(at: &Place, mut keys: Table, context: &SensorContext) -> Result<Sensor, Vec<Error>> {
    let name = keys.get("name").and_then(|name| name.as_str());
    let at = &at.key(&name.map_or(format!("sensor[{}]", context.index), |name| format!("sensor {name:?}")));
    let FromModel { contradictions, thinned, list_price, resolutions_mm } =
        catalogue::resolve(at, &mut keys, context.models, context.currency).map_err(|e| vec![e])?;
    let mut common = Table::new();
    for key in COMMON_KEYS {
        common.extend(keys.remove(key).map(|value| (key.to_string(), value)));
    }
    let common: CommonFile = read(common).map_err(|e| vec![context.unreadable(at, &e, "")])?;
    let noise = noise_in(&keys);
    let Checked { kind, mut warnings } = checked_kind(at, &common, keys, context).map_err(|e| vec![e])?;
    warnings.splice(0..0, contradictions);
    let terms = terms(at, &common).map_err(|e| vec![e])?;
    let emits = emits(at, common.emits, &*kind).map_err(|e| vec![e])?;
    if common.on.is_some() && !kind.takes_poses() {
        return Err(vec![
            at.says(format!("on does not belong to a {}", kind.name()))
                .with_advice("it is where the robot is"),
        ]);
    }
    let like = common.same_poses_as.as_deref();
    let source = CandidateSource { like, on: common.on.as_ref(), context };
    let CandidateSets { candidates, spreads, surfaces } =
        candidates(at, &common.name, &*kind, &common.poses, &source)?;
    Ok(Sensor {
        name: common.name,
        kind,
        on: common.on,
        candidates,
        draw_words: Vec::new(),
        spreads,
        surfaces,
        noise,
        thinned,
        terms,
        list_price,
        resolutions_mm,
        emits,
        warnings,
    })
}

/// Checks the keys of a device without a name and poses. Keys that are missing are no error: a study may write them.
pub(super) fn check_device(at: &Place, mut keys: Table, context: &SensorContext) -> Result<()> {
    let mut common = Table::from_iter([("name".to_string(), Value::from("device"))]);
    for key in COMMON_KEYS {
        common.extend(keys.remove(key).map(|value| (key.to_string(), value)));
    }
    // A curtain may leave its zone to the study.
    if common.get("kind").and_then(Value::as_str) == Some("gate") {
        let corners = [("min_m", 0.0), ("max_m", 1.0)].map(|(key, m)| (key.to_string(), vec![m; 3].into()));
        keys.entry("zone").or_insert_with(|| Table::from_iter(corners).into());
    }
    let common: CommonFile = read(common).map_err(|e| context.unreadable(at, &e, ""))?;
    let is_incomplete = Cell::new(false);
    let unreadable = |e: Unreadable| {
        is_incomplete.set(matches!(e.kind, Unread::Missing(_)));
        context.unreadable(at, &e, "")
    };
    match read_kind(at, &common, keys, context, &unreadable) {
        Err(_) if is_incomplete.get() => Ok(()),
        Err(problem) => Err(problem),
        Ok(Checked { kind, .. }) => {
            terms(at, &common)?;
            emits(at, common.emits, &*kind).map(|_| ())
        }
    }
}

/// What one of them costs, and how many a set may have.
fn terms(at: &Place, common: &CommonFile) -> Result<CostTerms> {
    if common.at_most == Some(0) {
        return Err(at.wrong("at_most", 0, "must be 1 or more; take the sensor away if there is to be none"));
    }
    let cost = common.cost.map(|cost| Cost::check(at, "cost", cost)).transpose()?;
    Ok(CostTerms { cost, at_most: common.at_most })
}

/// The kind of light that it emits, if any.
fn emits(at: &Place, said: Option<String>, kind: &dyn Kind) -> Result<Option<String>> {
    let Some(light) = said.filter(|light| light != "none") else { return Ok(None) };
    let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    if light.is_empty() || !light.chars().all(is_plain) {
        let rule = "must name a kind of light by small letters, digits and _, as in \"tof\" or \"lidar_905nm\"; \"none\" if \
                    it emits none";
        return Err(at.wrong("emits", format!("{light:?}"), rule));
    }
    match has_lens(kind) {
        true => Ok(Some(light)),
        false => {
            let rule = format!(
                "belongs to a sensor whose field of view is known, as of a camera or a lidar, and not to kind = {:?}: remove it",
                kind.name()
            );
            Err(at.wrong("emits", format!("{light:?}"), &rule))
        }
    }
}

/// The sensor that the keys of its kind describe, with warnings.
fn checked_kind(at: &Place, common: &CommonFile, keys: Table, context: &SensorContext) -> Result<Checked> {
    let mut warnings = odd_lengths(&keys);
    let unreadable = |e: Unreadable| {
        let more = match e.kind {
            Unread::UnknownKey(..) => format!(" (and {} with every sensor)", COMMON_KEYS.join(", ")),
            _ => String::new(),
        };
        context.unreadable(at, &e, &more)
    };
    let checked = read_kind(at, common, keys, context, &unreadable)?;
    warnings.extend(checked.warnings);
    Ok(Checked { warnings, ..checked })
}

fn read_kind(
    at: &Place,
    common: &CommonFile,
    keys: Table,
    context: &SensorContext,
    unreadable: &dyn Fn(Unreadable) -> Error,
) -> Result<Checked> {
    let &SensorContext { noiseless, sources, scenes, has_all_scenes, .. } = context;
    let carrier = common.on.as_ref().map(|on| on.object.as_str());
    let context = kinds::Context { noiseless, sources, scenes, has_all_scenes, carrier };
    (common.kind.read)(at, keys, &context, unreadable)
}

/// Where candidates may come from besides the sensor's own poses.
struct CandidateSource<'a> {
    like: Option<&'a str>,
    on: Option<&'a MountLink>,
    context: &'a SensorContext<'a>,
}

/// The candidates of a sensor, and what is known of groups of them.
struct CandidateSets {
    candidates: Vec<Candidate>,
    spreads: Vec<PoseSpread>,
    surfaces: Vec<GroupSurface>,
}

fn candidates(
    at: &Place,
    name: &str,
    kind: &dyn Kind,
    groups: &[PosesFile],
    source: &CandidateSource,
) -> Result<CandidateSets, Vec<Error>> {
    let one = |e: Error| vec![e];
    if !kind.takes_poses() && (!groups.is_empty() || source.like.is_some()) {
        return Err(one(at
            .says(format!("poses do not belong to a {}", kind.name()))
            .with_advice("take them away")));
    }
    let most = poses::MAX_POSES.saturating_sub(source.context.poses);
    if let Some(like) = source.like {
        return same_poses(at, kind, groups, like, source.context.earlier, most).map_err(one);
    }
    let settings = kind.settings();
    if groups.is_empty() && !settings.is_empty() {
        let candidate = |(name, setting)| Candidate { name, group: kind.name().into(), setting };
        let candidates = settings.into_iter().map(candidate).collect();
        return Ok(CandidateSets { candidates, spreads: Vec::new(), surfaces: Vec::new() });
    }
    at.some("poses", groups, "[[sensor.poses]] name = \"wall\"").map_err(one)?;
    let mut problems = Problems::default();
    let (mut candidates, mut spreads, mut surfaces) = (Vec::new(), Vec::new(), Vec::new());
    for (i, group) in groups.iter().enumerate() {
        let stream = (source.context.index as u64) << 32 | i as u64;
        let &SensorContext { seed, sources: files, scenes, has_all_scenes, surfaces: known, .. } =
            source.context;
        let source = poses::PoseSource {
            sensor: name,
            stance: kind.stance(),
            seed,
            stream,
            most,
            files,
            on: source.on,
            scenes,
            has_all_scenes,
            surfaces: known,
        };
        let extras = problems.keep(poses::expand(at, group, &source, &mut candidates)).unwrap_or_default();
        spreads.extend(extras.spreads);
        surfaces.extend(extras.surface);
    }
    problems.none()?;
    at.unique("pose", candidates.iter().map(|c| c.name.as_str())).map_err(one)?;
    Ok(CandidateSets { candidates, spreads, surfaces })
}

/// The candidates of an earlier sensor with the same stance.
fn same_poses(
    at: &Place,
    kind: &dyn Kind,
    groups: &[PosesFile],
    like: &str,
    earlier: &[Sensor],
    most: usize,
) -> Result<CandidateSets> {
    if !groups.is_empty() {
        return Err(at.says("both poses and same_poses_as").with_advice("give one"));
    }
    let posed = || earlier.iter().filter(|sensor| has_poses(sensor));
    let found = posed().find(|sensor| sensor.name == like).ok_or_else(|| {
        let known: Vec<_> = posed().map(|sensor| &sensor.name).collect();
        let rule = format!("must be a sensor above it that has poses: {known:?}");
        at.wrong("same_poses_as", format!("{like:?}"), &rule)
    })?;
    // The same pose turns sensors of different stances differently.
    if found.kind.stance() != kind.stance() {
        let what = format!("{:?} is not mounted as a {} is", like, kind.name());
        return Err(at.wrap(Error::input("same_poses_as", what).with_advice("write out its poses")));
    }
    if found.candidates.len() > most {
        return Err(at.wrap(poses::too_many().with_place("same_poses_as")));
    }
    let Sensor { candidates, spreads, surfaces, .. } = found.clone();
    Ok(CandidateSets { candidates, spreads, surfaces })
}

fn has_poses(sensor: &Sensor) -> bool {
    sensor.candidates.iter().any(|candidate| matches!(candidate.setting, Setting::Pose(_)))
}

/// Warnings about lengths that are implausibly large.
fn odd_lengths(keys: &Table) -> Vec<String> {
    let metres = |value: &Value| match value {
        Value::Array(all) => all.iter().filter_map(number).fold(0.0, f64::max),
        value => number(value).unwrap_or(0.0),
    };
    let odd = LARGEST_M.iter().filter_map(|(key, most_m)| {
        let given = keys.get(*key).filter(|value| metres(value) > *most_m)?;
        Some(format!("{key} = {given}: is more than {most_m} m meant? Lengths are metres"))
    });
    odd.collect()
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

#[cfg(test)]
mod tests;
