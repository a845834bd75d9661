//! Poses that a person dragged: a list of their own among the poses of a sensor. Lattices stay as they are.

use toml_edit::{Item, Value};

use perirobot_march::{Error, Result};
use perirobot_scene::pose::Pose;
use perirobot_study::input::slug;
use perirobot_study::sensor::Stance;

use super::known::Known;
use super::number::{list, number, quote};
use super::path::Path;
use super::plan::PLANNED;
use super::pose::{Orientation, Pose6};
use super::source::Source;
use super::span::{pieces, whole_end};

/// A pose that is listed in a planner's group.
pub(super) struct ListedPose {
    /// The list.
    list: Path,
    /// Its place there.
    index: usize,
    /// Number of the group among the sensor's.
    group: usize,
    sensor: Path,
}

impl ListedPose {
    /// Whether it is the only one of its group.
    pub(super) fn is_last_of_group(&self, source: &Source) -> bool {
        source.count(&self.list) == 1
    }

    /// Whether it is the only pose that is written for its sensor.
    pub(super) fn is_last_of_sensor(&self, source: &Source) -> bool {
        self.is_last_of_group(source) && source.count(&self.sensor.key("poses")) == 1
    }
}

/// The place of a sensor.
pub(super) fn sensor(source: &Source, name: &str) -> Result<Path> {
    let sensors = Path::new("sensor");
    let found = source.position(&sensors, "name", name).map(|index| sensors.entry(index));
    found.ok_or_else(|| {
        let names: Vec<&str> = (0..source.count(&sensors))
            .filter_map(|index| source.str(&Path::new("sensor").entry(index).key("name")))
            .collect();
        Error::input(format!("sensor {name:?}"), "is not in the study")
            .with_advice(format!("its sensors are {names:?}"))
    })
}

/// Where a pose is listed, if that is a group of the planner.
pub(super) fn find(source: &Source, sensor_name: &str, pose: &str) -> Option<ListedPose> {
    let sensor = sensor(source, sensor_name).ok()?;
    let (slug, name) = pose.split_once('/')?;
    let group = planned_groups(source, &sensor).into_iter().find(|(_, own)| own == slug)?.0;
    let list = sensor.key("poses").entry(group).key("list");
    let index = names(source, &list).iter().position(|own| own == name)?;
    Some(ListedPose { list, index, group, sensor })
}

/// The number and the name in poses of each group that is a list of the planner.
fn planned_groups(source: &Source, sensor: &Path) -> Vec<(usize, String)> {
    let poses = sensor.key("poses");
    let group = |index: usize| {
        let name = slug(source.str(&poses.entry(index).key("name"))?);
        let rest = name.strip_prefix(PLANNED)?;
        let is_own = rest.is_empty() || rest.strip_prefix('-').is_some_and(|n| n.parse::<u32>().is_ok());
        let has_list = source.get(&poses.entry(index).key("list")).is_some();
        (is_own && has_list).then_some((index, name))
    };
    (0..source.count(&poses)).filter_map(group).collect()
}

/// The names of all poses of a sensor that the planner lists.
pub(super) fn planned_poses(source: &Source, name: &str) -> Result<Vec<String>> {
    let sensor = sensor(source, name)?;
    let poses = |(group, slug): (usize, String)| {
        let names = names(source, &sensor.key("poses").entry(group).key("list"));
        names.into_iter().map(move |name| format!("{slug}/{name}"))
    };
    Ok(planned_groups(source, &sensor).into_iter().flat_map(poses).collect())
}

/// The last parts of the names of listed poses. One without a name has its number.
fn names(source: &Source, list: &Path) -> Vec<String> {
    let name = |index: usize| source.str(&list.entry(index).key("name")).map(String::from);
    (0..source.count(list)).map(|index| name(index).unwrap_or_else(|| index.to_string())).collect()
}

/// Lists a new pose of a sensor, and returns its name.
pub(super) fn add(
    source: &mut Source,
    known: &Known,
    name: &str,
    stance: Stance,
    at: &Pose6,
) -> Result<String> {
    let sensor = sensor(source, name)?;
    own_poses(source, known, name)?;
    if let Some((group, slug)) = planned_groups(source, &sensor).into_iter().next() {
        let list = sensor.key("poses").entry(group).key("list");
        let numbers = names(source, &list).into_iter().filter_map(|name| name.parse::<u64>().ok());
        let name = numbers.max().map_or(0, |last| last.saturating_add(1)).to_string();
        let keys = entry_keys(&name, at, stance);
        match source.get(&list) {
            Some(Item::ArrayOfTables(_)) => {
                let end = source.get(&list).and_then(whole_end).unwrap_or(source.text().len());
                source.append_block(end, &format!("[[sensor.poses.list]]\n{}", keys.join("\n")))?;
            }
            _ => source.push(&list, &inline(&keys))?,
        }
        return Ok(format!("{slug}/{name}"));
    }
    let group = new_group_name(source, &sensor);
    let entry = inline(&entry_keys("0", at, stance));
    add_group(source, &sensor, &planned_keys(&group, &entry))?;
    Ok(format!("{group}/0"))
}

/// The keys of a new group.
pub(super) fn planned_keys(group: &str, entry: &str) -> [String; 2] {
    [format!("name = {}", quote(group)), format!("list = [\n    {entry},\n]")]
}

/// A name that no group of the sensor has.
fn new_group_name(source: &Source, sensor: &Path) -> String {
    let poses = sensor.key("poses");
    let taken = |name: &str| {
        (0..source.count(&poses))
            .any(|i| source.str(&poses.entry(i).key("name")).is_some_and(|own| slug(own) == name))
    };
    let later = (2..).map(|number| format!("{PLANNED}-{number}"));
    std::iter::once(PLANNED.to_string()).chain(later).find(|name| !taken(name)).unwrap_or_default()
}

/// Adds a group of poses to a sensor, in the manner of its others.
fn add_group(source: &mut Source, sensor: &Path, keys: &[String]) -> Result<()> {
    let poses = sensor.key("poses");
    match (source.get(sensor), source.get(&poses)) {
        (_, Some(Item::Value(Value::Array(_)))) => {
            let keys: Vec<String> = keys.iter().map(|key| on_one_line(key)).collect();
            source.push(&poses, &inline(&keys))
        }
        (Some(Item::Table(_)), before) => {
            let end = before.or(source.get(sensor)).and_then(whole_end).unwrap_or(source.text().len());
            source.append_block(end, &format!("[[sensor.poses]]\n{}", keys.join("\n")))
        }
        _ => {
            let keys: Vec<String> = keys.iter().map(|key| on_one_line(key)).collect();
            source.set(sensor, "poses", &format!("[{}]", inline(&keys)))
        }
    }
}

/// A list that is written over several lines, on one.
fn on_one_line(key: &str) -> String {
    key.replace("[\n    ", "[").replace(",\n]", "]").replace(",\n    ", ", ")
}

fn inline(keys: &[String]) -> String {
    format!("{{ {} }}", keys.join(", "))
}

/// The keys of a listed pose.
pub(super) fn entry_keys(name: &str, at: &Pose6, stance: Stance) -> Vec<String> {
    let at = at.rounded();
    let position = list(at.position_m.iter().map(|metres| number(*metres)));
    let mut keys = vec![format!("name = {}", quote(name)), format!("position_m = {position}")];
    match at.orientation(stance) {
        Orientation::Rpy(rpy_deg) => {
            keys.push(format!("rpy_deg = {}", list(rpy_deg.iter().map(|degrees| number(*degrees)))));
        }
        Orientation::Facing { facing, pan_deg, tilt_deg } => {
            keys.push(format!("facing = {}", list(facing.iter().map(|part| number(*part)))));
            let turns = [("pan_deg", pan_deg), ("tilt_deg", tilt_deg)].into_iter();
            keys.extend(
                turns.filter(|(_, turn)| *turn != 0.0).map(|(key, turn)| format!("{key} = {}", number(turn))),
            );
        }
    }
    keys
}

/// One listed pose as it is written on one line.
pub(super) fn inline_entry(name: &str, at: &Pose6, stance: Stance) -> String {
    inline(&entry_keys(name, at, stance))
}

/// Moves a listed pose. Its name and its comments stay.
pub(super) fn set(source: &mut Source, listed: &ListedPose, at: &Pose6, stance: Stance) -> Result<()> {
    let (at, entry) = (at.rounded(), listed.list.entry(listed.index));
    source.set_numbers(&entry, "position_m", &at.position_m)?;
    let unset =
        |source: &mut Source, keys: &[&str]| keys.iter().try_for_each(|key| source.unset(&entry, key));
    match at.orientation(stance) {
        Orientation::Rpy(rpy_deg) => {
            unset(source, &["facing", "pan_deg", "tilt_deg", "quaternion", "frame"])?;
            source.set_numbers(&entry, "rpy_deg", &rpy_deg)
        }
        Orientation::Facing { facing, pan_deg, tilt_deg } => {
            unset(source, &["rpy_deg", "quaternion", "frame"])?;
            source.set_numbers(&entry, "facing", &facing)?;
            for (key, turn) in [("pan_deg", pan_deg), ("tilt_deg", tilt_deg)] {
                match turn == 0.0 {
                    true => source.unset(&entry, key)?,
                    false => source.set_number(&entry, key, turn)?,
                }
            }
            Ok(())
        }
    }
}

/// Removes a listed pose, and its group with the last.
pub(super) fn remove(source: &mut Source, listed: &ListedPose) -> Result<()> {
    let ListedPose { list, index, group, sensor } = listed;
    if source.count(list) == 1 {
        return source.remove(&sensor.key("poses"), *group);
    }
    // The names of those behind it are their numbers, which would change.
    for later in index + 1..source.count(list) {
        if source.str(&list.entry(later).key("name")).is_none() {
            source.set(&list.entry(later), "name", &quote(&later.to_string()))?;
        }
    }
    source.remove(list, *index)
}

/// Writes out the poses of a sensor that has those of another: a sensor has either its own or those.
fn own_poses(source: &mut Source, known: &Known, name: &str) -> Result<()> {
    let own = sensor(source, name)?;
    let mut owner = own.clone();
    for _ in 0..source.count(&Path::new("sensor")) {
        match source.str(&owner.key("same_poses_as")) {
            Some(like) => owner = sensor(source, like)?,
            None => break,
        }
    }
    if owner == own {
        return Ok(());
    }
    let poses = owner.key("poses");
    let copies: Vec<String> = (0..source.count(&poses))
        .map(|i| copy_group(source, known, name, &poses.entry(i)))
        .collect::<Result<_>>()?;
    let is_list = source.get(&poses).is_some_and(Item::is_value);
    source.unset(&own, "same_poses_as")?;
    match is_list {
        true => source.set(&own, "poses", &list(copies.into_iter())),
        false => {
            let end = source.get(&own).and_then(whole_end).unwrap_or(source.text().len());
            source.append_block(end, copies.join("\n").trim_end())
        }
    }
}

/// The text of a group for another sensor. Poses that depend on whose they are, from tables or at random, are listed.
fn copy_group(source: &Source, known: &Known, name: &str, group: &Path) -> Result<String> {
    let has = |key: &str| source.get(&group.key(key)).is_some();
    let (text, item) = (source.text(), source.get(group));
    if !has("csv") && !has("random") {
        return Ok(match item {
            Some(Item::Table(table)) => {
                pieces(table).into_iter().map(|piece| &text[piece]).collect::<Vec<_>>().join("\n")
            }
            item => item.and_then(Item::span).map_or("", |span| &text[span]).into(),
        });
    }
    let title = source.str(&group.key("name")).unwrap_or_default();
    let prefix = slug(title) + "/";
    let poses = known.sensors.iter().filter(|sensor| sensor.name == name).flat_map(|sensor| &sensor.poses);
    let poses = poses.filter_map(|(pose, at)| Some((pose.strip_prefix(&prefix)?, at.as_ref()?)));
    let entries: Vec<String> = poses.map(|(pose, at)| exact_entry(pose, at)).collect();
    if entries.is_empty() {
        let what = format!(
            "the poses {title:?} are those of another sensor, and are not known until the study loads"
        );
        return Err(Error::input(format!("sensor {name:?}"), what));
    }
    let keys = planned_keys(title, &entries.join(",\n    "));
    Ok(match item {
        Some(Item::Table(_)) => format!("[[sensor.poses]]\n{}", keys.join("\n")),
        _ => inline(&keys.map(|key| on_one_line(&key))),
    })
}

/// A listed pose to the last bit.
fn exact_entry(name: &str, at: &Pose) -> String {
    let position = list(at.position_m.to_array().iter().map(|metres| number(*metres)));
    let [x, y, z, w] = at.rotation.to_array().map(number);
    let quaternion = format!("{{ w = {w}, x = {x}, y = {y}, z = {z} }}");
    format!("{{ name = {}, position_m = {position}, quaternion = {quaternion} }}", quote(name))
}
