//! Where the objects of a scene file are, as it is written: `position_m` and the yaw of `rpy_deg`, of the object or of a
//! moment of its snapshots.

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use serde::{Deserialize, Serialize};

use super::path::Path;
use super::pose::{round_degrees, round_metres};
use super::source::Source;

/// The farthest from the origin that a scene can say.
const FARTHEST_M: f64 = 1e6;

/// Where an object goes. What is left out stays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectMove {
    /// Its position, in metres.
    #[serde(default)]
    pub position_m: Option<[f64; 3]>,
    /// How it is turned about the vertical.
    #[serde(default)]
    pub yaw_deg: Option<f64>,
    /// Which entry of `snapshots.position_m`, if the object has that.
    #[serde(default)]
    pub position_entry: usize,
    /// Which entry of `snapshots.rpy_deg`, if the object has that.
    #[serde(default)]
    pub yaw_entry: usize,
}

/// Where an object is, as a scene file says it.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectPlaces {
    /// Its name.
    pub name: String,
    /// Its position, or that of each entry of its snapshots.
    pub positions_m: Vec<[f64; 3]>,
    /// How it is turned about the vertical, the same way; `None` if a quaternion says it.
    pub yaws_deg: Option<Vec<f64>>,
    /// Whether it is at other positions from moment to moment.
    pub has_position_list: bool,
    /// Whether it is turned otherwise from moment to moment.
    pub has_yaw_list: bool,
    /// Whether it walks along a path.
    pub has_walk: bool,
}

/// The objects of a scene file, in its order; nothing of a text that is not TOML.
pub fn object_places(text: &str) -> Vec<ObjectPlaces> {
    let Ok(source) = Source::new(text.into()) else { return Vec::new() };
    let objects = Path::new("object");
    let place = |index: usize| {
        let at = objects.entry(index);
        let lists = at.key("snapshots");
        let name = source.str(&at.key("name"))?.to_string();
        let entries = |key: &str| source.get(&lists.key(key)).map(|_| triples(&source, &lists.key(key)));
        let own = |key: &str| triple(&source, &at.key(key)).unwrap_or_default();
        let (positions, turns) = (entries("position_m"), entries("rpy_deg"));
        let is_turned_else = has_quaternion(&source, &at);
        let (has_position_list, has_yaw_list) = (positions.is_some(), turns.is_some());
        let yaw = |rpy_deg: [f64; 3]| rpy_deg[2];
        Some(ObjectPlaces {
            name,
            positions_m: positions.unwrap_or_else(|| vec![own("position_m")]),
            yaws_deg: (!is_turned_else)
                .then(|| turns.unwrap_or_else(|| vec![own("rpy_deg")]).into_iter().map(yaw).collect()),
            has_position_list,
            has_yaw_list,
            has_walk: source.get(&lists.key("walk")).is_some(),
        })
    };
    (0..source.count(&objects)).filter_map(place).collect()
}

/// The objects whose places are those of `[[candidate]]`, by the text of a study.
pub fn candidate_objects(text: &str) -> Vec<String> {
    let Ok(source) = Source::new(text.into()) else { return Vec::new() };
    let all = Path::new("candidate");
    let named = |index: usize| {
        let at = all.entry(index);
        let object = source.str(&at.key("object")).map(String::from);
        object.into_iter().chain(source.strings(&at.key("with")).unwrap_or_default())
    };
    (0..source.count(&all)).flat_map(named).collect()
}

/// Whether a quaternion says how an object is turned.
fn has_quaternion(source: &Source, object: &Path) -> bool {
    let has = |table: &Path, key: &str| source.get(&table.key(key)).is_some();
    let lists = object.key("snapshots");
    has(&lists, "quaternion") || has(object, "quaternion") && !has(&lists, "rpy_deg")
}

fn triple(source: &Source, path: &Path) -> Option<[f64; 3]> {
    source.numbers(path)?.try_into().ok()
}

/// The entries of a list of places. One that is not three numbers, with which no study loads, is the origin.
fn triples(source: &Source, list: &Path) -> Vec<[f64; 3]> {
    (0..source.count(list)).map(|entry| triple(source, &list.entry(entry)).unwrap_or_default()).collect()
}

/// Moves or turns an object. Numbers are rounded as they are written; those that stay are not.
pub(super) fn set(source: &mut Source, object: &str, to: &ObjectMove) -> Result<()> {
    let objects = Path::new("object");
    let place = || format!("object {object:?}");
    let Some(index) = source.position(&objects, "name", object) else {
        return Err(Error::input(place(), "is not in the scene file").with_advice("name one that it has"));
    };
    let at = objects.entry(index);
    for (key, why) in [
        (at.key("on"), "is carried by a robot, in the frame of its link"),
        (at.key("snapshots").key("walk"), "walks along a path"),
    ] {
        if source.get(&key).is_some() {
            return Err(Error::input(place(), why).with_advice("change its place in the scene file"));
        }
    }
    if let Some(position_m) = to.position_m {
        if !position_m.iter().all(|metres| metres.abs() <= FARTHEST_M) {
            let rule = format!("must be three numbers from -{FARTHEST_M} to {FARTHEST_M}");
            let wrong = Issue::value("position_m", format!("{position_m:?}"), rule);
            return Err(Error::from(wrong).with_place(place()));
        }
        let new = |old: [f64; 3]| {
            std::array::from_fn(|axis| match position_m[axis] == old[axis] {
                true => old[axis],
                false => round_metres(position_m[axis]),
            })
        };
        write(source, &at, "position_m", to.position_entry, new).map_err(|e| e.with_place(place()))?;
    }
    if let Some(yaw_deg) = to.yaw_deg {
        if yaw_deg.is_nan() || yaw_deg.abs() > 1e6 {
            let wrong =
                Issue::value("yaw_deg", yaw_deg, "must be an angle in degrees from -1000000 to 1000000");
            return Err(Error::from(wrong).with_place(place()));
        }
        if has_quaternion(source, &at) {
            return Err(Error::input(place(), "is turned by a quaternion, which cannot be edited here")
                .with_advice("write rpy_deg instead of it into the scene file"));
        }
        let new = |[roll, pitch, yaw]: [f64; 3]| match yaw_deg == yaw {
            true => [roll, pitch, yaw],
            false => [roll, pitch, round_degrees(yaw_deg)],
        };
        write(source, &at, "rpy_deg", to.yaw_entry, new).map_err(|e| e.with_place(place()))?;
    }
    Ok(())
}

/// Changes three numbers of an object, or of an entry of its snapshots.
fn write(
    source: &mut Source,
    object: &Path,
    key: &str,
    entry: usize,
    change: impl Fn([f64; 3]) -> [f64; 3],
) -> Result<()> {
    let list = object.key("snapshots").key(key);
    if source.get(&list).is_some() {
        let (count, at) = (source.count(&list), list.entry(entry));
        let old = triple(source, &at).ok_or_else(|| {
            let rule = format!("must be an entry of snapshots.{key}, which has {count}");
            Error::from(Issue::value("entry", entry, rule))
        })?;
        return source.replace_numbers(&at, &change(old));
    }
    let old = triple(source, &object.key(key)).unwrap_or_default();
    let new = change(old);
    // A key that is not there is left out as long as it would say what its default says.
    if new == old { Ok(()) } else { source.set_numbers(object, key, &new) }
}
