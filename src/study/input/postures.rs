//! `[postures]` of a study, checked: who stands where, for requirements under "postures". Files of people are read
//! only when they are judged, since they change no count of a sweep.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, Visitor};

use super::scene_file::person::PersonKeys;
use super::slug;
use crate::diagnostics::Place;
use crate::keys::{AxisValues, Unit, UpFile, exactly, numbers};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_scene::objects::bvh::MotionFile;
use perirobot_scene::objects::keypoints::{JointLayout, KeypointFile};
use perirobot_scene::objects::spec::{PersonFile, SurfaceSpec};
use perirobot_scene::pose::{Pose, RotationFrame, from_rpy};
use perirobot_shipped::{PEOPLE, Person};

/// Most people at spots.
const MOST: usize = 1000;

/// Who stands where, for requirements under "postures": each of these people at each of these spots, in the place of
/// the people of the scenes, while the robot does what it does.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct PosturesFile {
    /// People that ship ("standing", "reaching", "bent", "crouching", "kneeling", "lying", "small", "tall", "sitting",
    /// "carrying"), CSV files with the joints of a mannequin that stands at the origin and faces +x, or tables that say more
    /// of a file.
    people: Vec<PersonEntry>,
    /// Where each of them stands: [x, y, yaw], in metres and degrees, at yaw 0 facing +x. The floor is that of
    /// `[approach]`: at height 0 unless floor_m is given, and the lowest surface with room for a person if floor = "auto".
    spots: Vec<PersonSpot>,
    /// How fast they move, in metres a second, for radars. Default 0: they stand still.
    speed_m_s: Option<f64>,
}

/// A name or a file, or what a file needs besides.
#[derive(Clone)]
enum PersonEntry {
    Named(String),
    File(PersonTable),
}

/// A file of a person's joints, or moments of a recorded motion, of which the person is moved to where its hips are above
/// the spot, and turned as the spot says.
#[derive(Clone, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct PersonTable {
    /// A CSV file of joints, or motion capture (.bvh).
    mannequin: PathBuf,
    /// Which joints the CSV file has, in which order. Default "coco-17".
    layout: Option<JointLayout>,
    /// The unit of a .bvh file: "m", "cm", "mm", "in", or how many metres it is.
    unit: Option<Unit>,
    /// The axis that points up in a .bvh file. Default "y".
    up: Option<UpFile>,
    /// Which bone of a .bvh file begins at which joint, where its name is not a usual one.
    bones: Option<BTreeMap<String, String>>,
    /// Moments of a .bvh file, each a posture: a list of seconds, or { start, stop, step }.
    times_s: Option<AxisValues>,
}

impl<'de> Deserialize<'de> for PersonEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PersonVisitor;
        impl<'de> Visitor<'de> for PersonVisitor {
            type Value = PersonEntry;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a name, a file of joints, or { mannequin = file, ... }")
            }
            fn visit_str<E>(self, name: &str) -> Result<PersonEntry, E> {
                Ok(PersonEntry::Named(name.into()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<PersonEntry, A::Error> {
                PersonTable::deserialize(MapAccessDeserializer::new(map)).map(PersonEntry::File)
            }
        }
        deserializer.deserialize_any(PersonVisitor)
    }
}

#[cfg(test)]
impl schemars::JsonSchema for PersonEntry {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "PersonEntry".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "anyOf": [{ "type": "string" }, generator.subschema_for::<PersonTable>()] })
    }
}

/// A place on the floor and a direction.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct PersonSpot(#[serde(deserialize_with = "exactly")] [f64; 3]);

/// A person at a spot.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture {
    /// Unique in the study: the person's name and the number of the spot, counted from 0, as in `standing/0`.
    pub name: String,
    /// The person: a file, or one that ships.
    pub person: SurfaceSpec,
    /// Number of the spot.
    pub spot: usize,
    /// Where the person's own origin is.
    pub position_m: DVec3,
    /// How the person is turned.
    pub rotation: DQuat,
    /// How fast the person moves, in metres a second.
    pub speed_m_s: f64,
}

impl PosturesFile {
    /// Each person at each spot, on a floor of this height.
    pub(super) fn check(self, at: &Place, floor_m: f64) -> Result<Vec<Posture>> {
        let at = &at.key("postures");
        at.some("people", &self.people, "people = [\"standing\", \"crouching\"]")?;
        at.some("spots", &self.spots, "spots = [[1.0, 0.5, 90]]")?;
        let people: Vec<Vec<(String, SurfaceSpec)>> =
            self.people.iter().enumerate().map(|one| persons(at, one)).collect::<Result<_>>()?;
        let people = people.concat();
        let all = people.len().saturating_mul(self.spots.len());
        if all > MOST {
            let what = format!("{} people at {} spots are {all} postures", people.len(), self.spots.len());
            return Err(at.says(what).with_advice(format!("at most {MOST} can be")));
        }
        at.unique("person", people.iter().map(|(name, _)| name.as_str()))?;
        let spot = |(number, &PersonSpot([x, y, yaw_deg])): (usize, &PersonSpot)| {
            let position_m = at.vector(&format!("spots[{number}]"), [x, y, floor_m])?;
            at.vector(&format!("spots[{number}]"), [0.0, 0.0, yaw_deg])?;
            let rotation = Pose::from_rotation(
                DVec3::ZERO,
                from_rpy([0.0, 0.0, yaw_deg.to_radians()]),
                RotationFrame::Link,
            )
            .rotation;
            Ok((number, position_m, rotation))
        };
        let spots: Vec<(usize, DVec3, DQuat)> =
            self.spots.iter().enumerate().map(spot).collect::<Result<_>>()?;
        let speed_m_s = self.speed_m_s.unwrap_or(0.0);
        at.number("speed_m_s", speed_m_s, 0.0..=100.0, "a speed in metres a second from 0 to 100")?;
        let at_each = |(name, person): &(String, SurfaceSpec)| {
            let posture = |&(spot, position_m, rotation): &(usize, DVec3, DQuat)| Posture {
                name: format!("{name}/{spot}"),
                person: person.clone(),
                spot,
                position_m,
                rotation,
                speed_m_s,
            };
            spots.iter().map(posture).collect::<Vec<_>>()
        };
        Ok(people.iter().flat_map(at_each).collect())
    }
}

/// The names and the joints of an entry: one person, or one for each moment of a motion, as `walk@0.5`.
fn persons(at: &Place, (number, entry): (usize, &PersonEntry)) -> Result<Vec<(String, SurfaceSpec)>> {
    let key = format!("people[{number}]");
    let table = match entry {
        PersonEntry::Named(written) => return person(at, &key, written).map(|person| vec![person]),
        PersonEntry::File(table) => table,
    };
    let at = &at.key(&key);
    let keys =
        PersonKeys { layout: table.layout, unit: table.unit, up: table.up, bones: table.bones.as_ref() };
    let name = name_of(&table.mannequin);
    match (keys.check(at, "mannequin", &table.mannequin)?, &table.times_s) {
        (PersonFile::Motion(file), Some(times_s)) => {
            let moment = |time_s: f64| {
                let file = MotionFile { time_s, centred: true, ..file.clone() };
                (format!("{name}@{time_s}"), SurfaceSpec::Mannequin(PersonFile::Motion(file)))
            };
            Ok(numbers(at, "times_s", times_s)?.into_iter().map(moment).collect())
        }
        (PersonFile::Motion(_), None) => Err(at
            .wrap(Issue::missing("times_s"))
            .with_advice("name moments of the motion, as in times_s = [0.5, 2]")),
        (PersonFile::Joints(_), Some(_)) => {
            Err(at.says("times_s belong to motion capture").with_advice("a .bvh file"))
        }
        (person, None) => {
            if table.unit.is_some() || table.up.is_some() {
                let rule = "a table of joints is in metres, z up";
                return Err(at.says("unit and up belong to motion capture").with_advice(rule));
            }
            Ok(vec![(name, SurfaceSpec::Mannequin(person))])
        }
    }
}

fn name_of(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| slug(&stem.to_string_lossy()))
}

/// A person by its name or file.
fn person(at: &Place, key: &str, written: &str) -> Result<(String, SurfaceSpec)> {
    let path = Path::new(written);
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
        let file = KeypointFile { path: at.folder().join(path), layout: JointLayout::Coco17 };
        return Ok((name_of(path), SurfaceSpec::Mannequin(PersonFile::Joints(file))));
    }
    let known = |person: &&Person| person.name == written;
    let found = PEOPLE.iter().find(known).map(|&person| (person.name.into(), SurfaceSpec::Shipped(person)));
    found.ok_or_else(|| {
        let names = PEOPLE.map(|person| person.name);
        let rule = format!(
            "must be one of {}, a file that ends in .csv, or {{ mannequin = \"walk.bvh\", ... }}",
            names.join(", ")
        );
        at.wrong(key, format!("{written:?}"), &rule)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str) -> Result<Vec<Posture>, String> {
        let at = Place::new(Path::new("in/study.toml"));
        let file: PosturesFile = toml::from_str(text).unwrap();
        file.check(&at, 0.5).map_err(|e| e.to_string())
    }

    #[test]
    fn each_person_stands_at_each_spot() {
        let all =
            check("people = [\"tall\", \"my/Worker 2.csv\"]\nspots = [[1, 2, 90], [3, 4.5, -180]]").unwrap();
        let names: Vec<&str> = all.iter().map(|posture| posture.name.as_str()).collect();
        assert_eq!(names, ["tall/0", "tall/1", "worker-2/0", "worker-2/1"]);
        let file = KeypointFile { path: "in/my/Worker 2.csv".into(), layout: JointLayout::Coco17 };
        assert_eq!(all[2].person, SurfaceSpec::Mannequin(PersonFile::Joints(file)));
        assert_eq!((all[1].spot, all[1].position_m), (1, DVec3::new(3.0, 4.5, 0.5)));
        // At 90° they face +y.
        assert!((all[0].rotation * DVec3::X - DVec3::Y).length() < 1e-12);
    }

    #[test]
    fn files_say_their_layout_and_motions_their_moments() {
        let all = check(
            "people = [{ mannequin = \"p.csv\", layout = \"halpe-26\" }, { mannequin = \"My Walk.bvh\", unit = \"cm\", \
             bones = { head = \"Kopf\" }, times_s = [0.5, 2] }]\nspots = [[0, 0, 0], [1, 0, 0]]",
        )
        .unwrap();
        let names: Vec<&str> = all.iter().map(|posture| posture.name.as_str()).collect();
        assert_eq!(names, ["p/0", "p/1", "my-walk@0.5/0", "my-walk@0.5/1", "my-walk@2/0", "my-walk@2/1"]);
        let table = KeypointFile { path: "in/p.csv".into(), layout: JointLayout::Halpe26 };
        assert_eq!(all[0].person, SurfaceSpec::Mannequin(PersonFile::Joints(table)));
        let SurfaceSpec::Mannequin(PersonFile::Motion(motion)) = &all[5].person else { panic!("a motion") };
        assert_eq!((motion.path.to_str(), motion.scale, motion.time_s), (Some("in/My Walk.bvh"), 0.01, 2.0));
        assert!(motion.centred && motion.bones["head"] == "Kopf");
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (people, spots, expected) in [
            ("", "[0, 0, 0]", "in/study.toml: postures: "),
            ("\"standing\"", "", "in/study.toml: postures: "),
            (
                "\"stading\"",
                "[0, 0, 0]",
                "postures.people[0] = \"stading\": must be one of standing, reaching, bent",
            ),
            ("\"lying\", \"lying\"", "[0, 0, 0]", "two persons are named \"lying\""),
            ("\"a/lying.csv\", \"lying\"", "[0, 0, 0]", "two persons are named \"lying\""),
            (
                "\"standing\"",
                "[0, 0, 0], [1, nan, 0]",
                "postures.spots[1] = [1.0, NaN, 0.5]: must be three numbers",
            ),
            ("\"standing\"", "[1, 2, inf]", "postures.spots[0]"),
            (
                "{ mannequin = \"w.bvh\" }",
                "[0, 0, 0]",
                "postures.people[0]: a .bvh file does not say its unit",
            ),
            (
                "\"tall\", { mannequin = \"w.bvh\", unit = \"m\" }",
                "[0, 0, 0]",
                "postures.people[1]: no times_s: name moments of the motion",
            ),
            (
                "{ mannequin = \"w.csv\", times_s = 1 }",
                "[0, 0, 0]",
                "people[0]: times_s belong to motion capture",
            ),
            (
                "{ mannequin = \"w.csv\", up = \"y\" }",
                "[0, 0, 0]",
                "people[0]: unit and up belong to motion capture",
            ),
            (
                "{ mannequin = \"w.bvh\", unit = \"m\", times_s = [1, 1] }",
                "[0, 0, 0]",
                "two persons are named \"w@1\"",
            ),
        ] {
            let what = check(&format!("people = [{people}]\nspots = [{spots}]")).unwrap_err();
            assert!(what.contains(expected), "{what}");
        }
        let many = "[0, 0, 0], ".repeat(MOST);
        let what = check(&format!("people = [\"standing\", \"tall\"]\nspots = [{many}]")).unwrap_err();
        assert!(what.contains("2 people at 1000 spots are 2000 postures: at most 1000 can be"), "{what}");
    }
}
