//! `[postures]` of a study, checked: who stands where, for requirements under "postures". Files of people are read
//! only when they are judged, since they change no count of a sweep.

use std::path::Path;

use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::Deserialize;

use super::value::exactly;
use super::{Place, slug};
use crate::Result;
use crate::pose::{Frame, Pose, from_rpy};
use crate::scene::shipped::{PEOPLE, Shipped};
use crate::scene::spec::SurfaceSpec;

/// Most people at spots.
const MOST: usize = 1000;

/// Who stands where, for requirements under "postures": each of these people at each of these spots, in the place of
/// the people of the scenes, while the robot does what it does.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PosturesFile {
    /// People that ship ("standing", "reaching", "bent", "crouching", "kneeling", "lying", "small", "tall"), or CSV
    /// files with the 17 joints of a mannequin that stands at the origin and faces +x.
    people: Vec<String>,
    /// Where each of them stands: [x, y, yaw], in metres and degrees, at yaw 0 facing +x. The floor is that of
    /// `[approach]`, at height 0 unless floor_m says otherwise.
    spots: Vec<Spot>,
}

/// A place on the floor and a direction.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
struct Spot(#[serde(deserialize_with = "exactly")] [f64; 3]);

/// A person at a spot.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture {
    /// Unique in the study: the person's name and the number of the spot, counted from 0, as in `standing/0`.
    pub name: String,
    /// The person: a file, or one that ships.
    pub(crate) person: SurfaceSpec,
    /// Number of the spot.
    pub(crate) spot: usize,
    /// Where the person's own origin is.
    pub(crate) position_m: DVec3,
    /// How the person is turned.
    pub(crate) rotation: DQuat,
}

impl PosturesFile {
    /// Each person at each spot, on a floor of this height.
    pub(super) fn check(self, at: &Place, floor_m: f64) -> Result<Vec<Posture>> {
        let at = &at.key("postures");
        at.some("people", &self.people, "people = [\"standing\", \"crouching\"]")?;
        at.some("spots", &self.spots, "spots = [[1.0, 0.5, 90]]")?;
        let (people, spots) = (self.people.len(), self.spots.len());
        if people * spots > MOST {
            let what = format!("{people} people at {spots} spots are {} postures", people * spots);
            return Err(at.says(what).wanted(format!("at most {MOST} can be")));
        }
        let people: Vec<(String, SurfaceSpec)> =
            self.people.iter().enumerate().map(|one| person(at, one)).collect::<Result<_>>()?;
        at.unique("person", people.iter().map(|(name, _)| name.as_str()))?;
        let spot = |(number, &Spot([x, y, yaw_deg])): (usize, &Spot)| {
            let position_m = at.vector(&format!("spots[{number}]"), [x, y, floor_m])?;
            at.vector(&format!("spots[{number}]"), [0.0, 0.0, yaw_deg])?;
            let rotation =
                Pose::turned(DVec3::ZERO, from_rpy([0.0, 0.0, yaw_deg.to_radians()]), Frame::Link).rotation;
            Ok((number, position_m, rotation))
        };
        let spots: Vec<(usize, DVec3, DQuat)> =
            self.spots.iter().enumerate().map(spot).collect::<Result<_>>()?;
        let at_each = |(name, person): &(String, SurfaceSpec)| {
            let posture = |&(spot, position_m, rotation): &(usize, DVec3, DQuat)| Posture {
                name: format!("{name}/{spot}"),
                person: person.clone(),
                spot,
                position_m,
                rotation,
            };
            spots.iter().map(posture).collect::<Vec<_>>()
        };
        Ok(people.iter().flat_map(at_each).collect())
    }
}

/// The name and the joints of a person.
fn person(at: &Place, (number, written): (usize, &String)) -> Result<(String, SurfaceSpec)> {
    let path = Path::new(written);
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
        let stem = path.file_stem().map_or_else(String::new, |stem| slug(&stem.to_string_lossy()));
        return Ok((stem, SurfaceSpec::Mannequin(at.folder().join(path))));
    }
    let known = |person: &&Shipped| person.name == written;
    let found = PEOPLE.iter().find(known).map(|&person| (person.name.into(), SurfaceSpec::Shipped(person)));
    found.ok_or_else(|| {
        let names = PEOPLE.map(|person| person.name);
        let rule = format!("must be one of {}, or a file that ends in .csv", names.join(", "));
        at.wrong(&format!("people[{number}]"), format!("{written:?}"), &rule)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(text: &str) -> Result<Vec<Posture>, String> {
        let at = Place { file: Path::new("in/study.toml"), prefix: String::new() };
        let file: PosturesFile = toml::from_str(text).unwrap();
        file.check(&at, 0.5).map_err(|e| e.to_string())
    }

    #[test]
    fn each_person_stands_at_each_spot() {
        let all = checked("people = [\"tall\", \"my/Worker 2.csv\"]\nspots = [[1, 2, 90], [3, 4.5, -180]]")
            .unwrap();
        let names: Vec<&str> = all.iter().map(|posture| posture.name.as_str()).collect();
        assert_eq!(names, ["tall/0", "tall/1", "worker-2/0", "worker-2/1"]);
        assert_eq!(all[2].person, SurfaceSpec::Mannequin("in/my/Worker 2.csv".into()));
        assert_eq!((all[1].spot, all[1].position_m), (1, DVec3::new(3.0, 4.5, 0.5)));
        // At 90° they face +y.
        assert!((all[0].rotation * DVec3::X - DVec3::Y).length() < 1e-12);
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
        ] {
            let what = checked(&format!("people = [{people}]\nspots = [{spots}]")).unwrap_err();
            assert!(what.contains(expected), "{what}");
        }
        let many = "[0, 0, 0], ".repeat(MOST);
        let what = checked(&format!("people = [\"standing\", \"tall\"]\nspots = [{many}]")).unwrap_err();
        assert!(what.contains("2 people at 1000 spots are 2000 postures: at most 1000 can be"), "{what}");
    }
}
