//! The placed sensors in the study: the combination named "planned", of one choice. Without one they are what `[choose]`
//! says hangs there already.

use toml_edit::{Item, Value};

use perirobot_march::{Error, Result};
use perirobot_scene::pose::Pose;
use perirobot_study::input::slug;
use serde::{Deserialize, Serialize};

use super::group;
use super::known::Known;
use super::number::{list, quote, quote_key};
use super::path::Path;
use super::pose::Pose6;
use super::source::Source;
use super::span::whole_end;

/// The name of the combination, and of the groups of poses that are the planner's.
pub const PLANNED: &str = "planned";

/// A placed sensor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlacedName {
    /// The sensor's name.
    pub sensor: String,
    /// The name of its pose: `wall/1/0`.
    pub pose: String,
}

impl PlacedName {
    /// The same from two names.
    pub fn new(sensor: &str, pose: &str) -> PlacedName {
        PlacedName { sensor: sensor.into(), pose: pose.into() }
    }
}

/// The place of the combination, if the study has it.
pub(super) fn combination(source: &Source) -> Option<usize> {
    source.position(&Path::new("combination"), "name", PLANNED)
}

/// The placed sensors, in the order of the file.
pub(super) fn read(source: &Source, known: &Known) -> Result<Vec<PlacedName>> {
    let Some(index) = combination(source) else { return read_always(source) };
    let at = Path::new("combination").entry(index);
    let mut plan = Vec::new();
    for sensor in source.strings(&at.key("sensors"))? {
        let poses = source.strings(&at.key("poses").key(&sensor))?;
        let wrong = |what: String| {
            let cure = format!("name each pose, as in poses = {{ {} = [\"wall/1/0\"] }}", quote_key(&sensor));
            Err(Error::input(format!("combination {PLANNED:?}"), what).with_advice(cure))
        };
        if let Some(pattern) = poses.iter().find(|pose| pose.contains(['*', '?'])) {
            return wrong(format!("{pattern:?} may be several poses, and a plan has one for each sensor"));
        }
        let candidates = known.sensors.iter().find(|one| one.name == sensor).map(|one| &one.poses);
        let poses: Vec<String> = match (poses.is_empty(), candidates.map(Vec::as_slice)) {
            (false, _) => poses.into_iter().map(|pose| spelled(&pose, candidates)).collect(),
            (true, Some([(only, _)])) => vec![only.clone()],
            (true, _) => return wrong(format!("no pose is named for {sensor:?}")),
        };
        let count = source.get(&at.key("count").key(&sensor)).and_then(Item::as_integer).unwrap_or(1);
        if count != poses.len() as i64 {
            return wrong(format!("there are {count} of {sensor:?} and {} poses", poses.len()));
        }
        plan.extend(poses.iter().map(|pose| PlacedName::new(&sensor, pose)));
    }
    Ok(plan)
}

/// A pose's name whose group may be spelled as in the study, in the spelling of names.
fn spelled(pose: &str, candidates: Option<&Vec<(String, Option<Pose>)>>) -> String {
    let is_known = candidates.is_some_and(|all| all.iter().any(|(name, _)| name == pose));
    match pose.split_once('/') {
        Some((group, rest)) if !is_known => format!("{}/{rest}", slug(group)),
        _ => pose.into(),
    }
}

fn read_always(source: &Source) -> Result<Vec<PlacedName>> {
    let always = source.strings(&Path::new("choose").key("always"))?;
    let name = |text: &String| {
        let what = || Error::input("choose.always", format!("{text:?} is not a sensor and one of its poses"));
        text.split_once(':').map(|(sensor, pose)| PlacedName::new(sensor, pose)).ok_or_else(what)
    };
    always.iter().map(name).collect()
}

/// The poses of one sensor in a plan.
fn poses_of<'a>(plan: &'a [PlacedName], sensor: &'a str) -> Vec<String> {
    plan.iter().filter(|placed| placed.sensor == sensor).map(|placed| placed.pose.clone()).collect()
}

/// Writes the placed sensors. `alone` are the sensors of a study without combinations, which go on being scored alone.
pub(super) fn write(source: &mut Source, plan: &[PlacedName], alone: &[String]) -> Result<()> {
    let combinations = Path::new("combination");
    let sensors = sensors_of(plan);
    match (combination(source), plan.is_empty()) {
        (Some(index), false) => update(source, &combinations.entry(index), plan, &sensors),
        (None, false) => append(source, plan, &sensors, alone),
        (found, true) => {
            if let Some(index) = found {
                source.remove(&combinations, index)?;
            }
            // Else what hangs there already would be the plan again.
            source.unset(&Path::new("choose"), "always")
        }
    }
}

fn update(source: &mut Source, at: &Path, plan: &[PlacedName], sensors: &[String]) -> Result<()> {
    source.set_strings(at, "sensors", sensors)?;
    let (poses, count) = (at.key("poses"), at.key("count"));
    let several = |sensor: &String| poses_of(plan, sensor).len() > 1;
    drop_keys(source, &poses, |sensor| sensors.contains(sensor))?;
    match source.get(&poses) {
        None => source.set(at, "poses", &poses_table(plan, sensors))?,
        Some(_) => {
            sensors
                .iter()
                .try_for_each(|sensor| source.set_strings(&poses, sensor, &poses_of(plan, sensor)))?;
        }
    }
    // A count of one can stay.
    let is_one = |sensor: &String| source.get(&count.key(sensor)).and_then(Item::as_integer) == Some(1);
    let stays: Vec<&String> = sensors.iter().filter(|sensor| several(sensor) || is_one(sensor)).collect();
    if stays.is_empty() {
        return source.unset(at, "count");
    }
    drop_keys(source, &count, |sensor| stays.contains(&sensor))?;
    match source.get(&count) {
        None if sensors.iter().any(several) => source.set(at, "count", &count_table(plan, sensors)),
        _ => sensors
            .iter()
            .filter(|sensor| several(sensor))
            .try_for_each(|sensor| source.set(&count, sensor, &poses_of(plan, sensor).len().to_string())),
    }
}

/// Removes keys of a table that are not wanted.
fn drop_keys(source: &mut Source, table: &Path, wanted: impl Fn(&String) -> bool) -> Result<()> {
    let keys = source.get(table).and_then(Item::as_table_like);
    let keys: Vec<String> =
        keys.map_or(Vec::new(), |keys| keys.iter().map(|(key, _)| key.to_string()).collect());
    keys.iter().filter(|key| !wanted(key)).try_for_each(|key| source.unset(table, key))
}

fn poses_table(plan: &[PlacedName], sensors: &[String]) -> String {
    let pair = |sensor: &String| {
        let poses = poses_of(plan, sensor);
        format!("{} = {}", quote_key(sensor), list(poses.iter().map(|pose| quote(pose))))
    };
    format!("{{ {} }}", sensors.iter().map(pair).collect::<Vec<_>>().join(", "))
}

fn count_table(plan: &[PlacedName], sensors: &[String]) -> String {
    let counted = sensors.iter().map(|sensor| (sensor, poses_of(plan, sensor).len()));
    let pairs = counted.filter(|(_, count)| *count > 1);
    let pairs: Vec<String> =
        pairs.map(|(sensor, count)| format!("{} = {count}", quote_key(sensor))).collect();
    format!("{{ {} }}", pairs.join(", "))
}

/// The keys of the combination.
fn keys(plan: &[PlacedName], sensors: &[String]) -> Vec<String> {
    let names = list(sensors.iter().map(|name| quote(name)));
    let mut keys = vec![format!("name = {}", quote(PLANNED)), format!("sensors = {names}")];
    if sensors.len() < plan.len() {
        keys.push(format!("count = {}", count_table(plan, sensors)));
    }
    keys.push(format!("poses = {}", poses_table(plan, sensors)));
    keys
}

/// The sensors of a plan, each once.
fn sensors_of(plan: &[PlacedName]) -> Vec<String> {
    let mut sensors: Vec<String> = Vec::new();
    for placed in plan {
        if !sensors.contains(&placed.sensor) {
            sensors.push(placed.sensor.clone());
        }
    }
    sensors
}

/// The tables that another study needs for this plan: the poses that were dragged, and the combination.
pub(super) fn text(plan: &[PlacedName], known: &Known) -> String {
    let mut text = String::new();
    let sensors = sensors_of(plan);
    for sensor in known.sensors.iter().filter(|sensor| sensors.contains(&sensor.name)) {
        let own = |(name, pose): &(String, Option<Pose>)| {
            let own = name.strip_prefix(PLANNED)?.strip_prefix('/')?;
            let is_placed = plan.iter().any(|one| one.sensor == sensor.name && one.pose == *name);
            let entry = |pose: Pose| group::inline_entry(own, &Pose6::new(&pose), sensor.stance);
            pose.filter(|_| is_placed).map(entry)
        };
        let entries: Vec<String> = sensor.poses.iter().filter_map(own).collect();
        if !entries.is_empty() {
            let keys = group::planned_keys(PLANNED, &entries.join(",\n    ")).join("\n");
            text += &format!("# below [[sensor]] {}\n[[sensor.poses]]\n{keys}\n\n", quote(&sensor.name));
        }
    }
    match plan.is_empty() {
        true => text,
        false => text + "[[combination]]\n" + &keys(plan, &sensors).join("\n") + "\n",
    }
}

fn append(source: &mut Source, plan: &[PlacedName], sensors: &[String], alone: &[String]) -> Result<()> {
    let names = |names: &[String]| list(names.iter().map(|name| quote(name)));
    let keys = keys(plan, sensors);
    let path = Path::new("combination");
    if let Some(Item::Value(Value::Array(_))) = source.get(&path) {
        return source.push(&path, &format!("{{ {} }}", keys.join(", ")));
    }
    let block = |keys: &[String]| format!("\n[[combination]]\n{}", keys.join("\n"));
    let mut blocks = String::new();
    let after = source.get(&path).and_then(whole_end);
    if after.is_none() {
        let one = |name: &String| block(&[format!("sensors = {}", names(std::slice::from_ref(name)))]);
        blocks += &alone.iter().map(|name| one(name) + "\n").collect::<String>();
    }
    blocks += &block(&keys);
    let sensors = source.get(&Path::new("sensor")).filter(|item| item.is_array_of_tables());
    // The last tables of the file may follow; keys of the whole file cannot.
    let after = after.or(sensors.and_then(whole_end)).unwrap_or(source.text().trim_end().len());
    source.append_block(after, &blocks)
}
