//! `approach.json`: the answers with the values of `approach.csv` and with their types. The report reads it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::ground::{Company, Ground};
use super::moments::{ApproachAnswer, AtEntry};
use super::needed::root_m;
use crate::json_file::JsonFile;
use crate::view::Choice;
use perirobot_march::Result;
use perirobot_march::voxel::{rounded_down, rounded_up};
use perirobot_study::input::Study;
use perirobot_sweep::results::columns::{pose_names, representation_names};

/// The name of the table.
pub const APPROACH: &str = "approach.csv";

/// The name of the file with the same answers and their types.
pub const APPROACH_JSON: &str = "approach.json";

const FILE: JsonFile = JsonFile {
    name: APPROACH_JSON,
    format: 1,
    table: APPROACH,
    again: "run `perirobot approach` again into this folder, or remove approach.json and approach.csv",
};

/// Digits of metres and square metres: hundredths of a millimetre.
pub(super) const DIGITS: usize = 5;

/// How near bodies come to the hazard unnoticed by some sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Approaches {
    /// Number of the format: 1.
    pub format: u32,
    /// The version of the program.
    pub perirobot: String,
    /// The combination of the sensors, by its name.
    pub combination: String,
    /// Their poses, as in results.csv.
    pub poses: String,
    /// Their representation.
    pub representation: String,
    /// What of them is not as planned, in words; empty if all is.
    pub case: String,
    /// The highest step that bodies walk, with `floor = "auto"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_m: Option<f64>,
    /// The answers: the rows of `approach.csv`.
    pub rows: Vec<ApproachRow>,
}

/// The answer for a body from an entry. Distances are between centres of voxels. Metres and square metres have the digits
/// of the table: five behind the point, distances rounded down and what is needed rounded up. Squared distances, in whole
/// voxels, are exact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ApproachRow {
    /// The scene, by its name.
    pub scene: String,
    /// The snapshot, counted from 0; `None` for all snapshots at once.
    pub snapshot: Option<usize>,
    /// Who else is there.
    pub people: Company,
    /// The body, by its name.
    pub body: String,
    /// The entry, by its name.
    pub entry: String,
    /// What becomes of the body at the entry.
    pub at_entry: AtEntry,
    /// How near the body comes to the hazard unnoticed; `None` unless the entry is open.
    pub deepest_m: Option<f64>,
    /// The same, squared, in voxels.
    pub deepest_squared: Option<u32>,
    /// How far the body is from the hazard at the nearest place of the entry at which it is noticed; `None` if there is
    /// none.
    pub noticed_m: Option<f64>,
    /// The same, squared, in voxels.
    pub noticed_squared: Option<u32>,
    /// Length of the path to the nearest place.
    pub path_m: Option<f64>,
    /// How far people must be at the highest listed speed of the robot; `None` without `[stopping]`.
    pub needed_m: Option<f64>,
    /// How much farther the lesser of `deepest_m` and `noticed_m` is; `None` also if the body has no room.
    pub margin_m: Option<f64>,
    /// The middle of the body at the deepest place, in the world.
    pub middle_m: Option<[f64; 3]>,
    /// The middle of the body where the way is the narrowest, in the world.
    pub narrowest_m: Option<[f64; 3]>,
    /// At how many places the body must be noticed there to close the way.
    pub narrowest_places: Option<u64>,
    /// The object that hides the body there from most sensors and voxels; `None` if none does.
    pub shadowed_by: Option<String>,
    /// With `floor = "auto"`, the object between the body at the deepest place and the hazard that it does not climb; `None`
    /// if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fence_between: Option<String>,
    /// The sensors that latch into whose zone the body gets without having been noticed on the way.
    #[serde(default)]
    pub latches_passed: Vec<String>,
    /// The area of the positions of its middle at which a body on the floor is unnoticed; `None` of other bodies.
    pub unnoticed_m2: Option<f64>,
    /// The part of that area to which it comes from the entry; `None` of other bodies.
    pub joined_m2: Option<f64>,
}

impl Approaches {
    /// The answers of all scenes for a choice of a study; `case` says what of it is not as planned.
    pub fn new(
        study: &Study,
        choice: &Choice,
        case: String,
        scenes: &[(Ground, Vec<ApproachAnswer>)],
    ) -> Approaches {
        let combination = &study.combinations[choice.combination];
        let rows =
            scenes.iter().flat_map(|(ground, answers)| answers.iter().map(|answer| row(ground, answer)));
        Approaches {
            format: FILE.format,
            perirobot: env!("CARGO_PKG_VERSION").into(),
            combination: combination.name.clone(),
            poses: pose_names(study, combination, choice.choice),
            representation: representation_names(study, combination).swap_remove(choice.representation),
            case,
            step_m: study.approach.step_m,
            rows: rows.collect(),
        }
    }

    /// Combination, poses and representation, as in the columns of tables.
    pub fn names(&self) -> [&str; 3] {
        [&self.combination, &self.poses, &self.representation]
    }

    /// Reads them from a folder; `None` if nothing was asked there.
    ///
    /// # Errors
    /// `Error::Input` that names the file and what to do: if the file is damaged or in another format, or if an older
    /// program wrote the table without it.
    pub fn read(folder: &Path) -> Result<Option<Approaches>> {
        FILE.read(folder)
    }

    /// Writes them into a folder.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        FILE.write(folder, self)
    }
}

fn row(ground: &Ground, answer: &ApproachAnswer) -> ApproachRow {
    let (grid, body) = (&ground.worlds[0].grid, &ground.bodies[answer.body]);
    let deepest = answer.found.deepest.as_ref();
    let narrowest = deepest.and_then(|deepest| deepest.narrowest);
    let distance_m = |squared: u32| down(root_m(squared, grid));
    let point = |place: [i32; 3]| body.middle_m(place, grid).to_array().map(nearest);
    let area = |places: u64| nearest(places as f64 * grid.voxel_size_m * grid.voxel_size_m);
    let [deepest_squared, noticed_squared] = [deepest.map(|deepest| deepest.squared), answer.found.noticed];
    let needed = ground.study.stopping.as_ref().map(|stopping| stopping.fastest().needed_m);
    let margin = answer.found.nearest().zip(needed).map(|(nearest, needed)| root_m(nearest, grid) - needed);
    let passed = answer.latches.iter().filter(|(_, is_passed)| *is_passed);
    ApproachRow {
        scene: ground.worlds[0].name.clone(),
        snapshot: answer.snapshot,
        people: answer.company,
        body: body.name.clone(),
        entry: ground.study.approach.entries[answer.entry].name.clone(),
        at_entry: answer.at_entry,
        deepest_m: deepest_squared.map(distance_m),
        deepest_squared,
        noticed_m: noticed_squared.map(distance_m),
        noticed_squared,
        path_m: deepest.map(|deepest| nearest(deepest.length_m(grid))),
        needed_m: needed.map(|needed| number(&rounded_up(needed, DIGITS as u32))),
        margin_m: margin.map(down),
        middle_m: deepest.and_then(|deepest| deepest.path.last().copied()).map(point),
        narrowest_m: narrowest.map(|narrowest| point(narrowest.place)),
        narrowest_places: narrowest.map(|narrowest| narrowest.front),
        shadowed_by: answer.shadow.clone(),
        fence_between: answer.fence.clone(),
        latches_passed: passed.map(|(name, _)| name.clone()).collect(),
        unnoticed_m2: body.on_floor.then(|| area(answer.unnoticed)),
        joined_m2: body.on_floor.then(|| area(answer.found.reached.count())),
    }
}

/// A distance that there is.
fn down(metres: f64) -> f64 {
    number(&rounded_down(metres, DIGITS as u32))
}

/// A coordinate, the length of a way, or an area.
fn nearest(value: f64) -> f64 {
    number(&format!("{value:.DIGITS$}"))
}

fn number(decimal: &str) -> f64 {
    decimal.parse().expect("digits of a number")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_is_what_was_written() {
        let row = ApproachRow {
            scene: "cell".into(),
            snapshot: None,
            people: Company::Absent,
            body: "standing".into(),
            entry: "door".into(),
            at_entry: AtEntry::NoRoom,
            deepest_m: Some(down(441f64.sqrt() * 0.05)),
            deepest_squared: Some(u32::MAX),
            noticed_m: None,
            noticed_squared: None,
            path_m: Some(nearest(1.234_567)),
            needed_m: Some(1.95),
            margin_m: Some(down(-0.000_001)),
            middle_m: Some([0.1, -0.0, 1e3]),
            narrowest_m: None,
            narrowest_places: Some(u64::MAX),
            shadowed_by: Some("a \"shelf\"".into()),
            fence_between: Some("fence".into()),
            latches_passed: vec!["curtain".into()],
            unnoticed_m2: None,
            joined_m2: Some(0.0),
        };
        assert_eq!((row.deepest_m, row.path_m, row.margin_m), (Some(1.05), Some(1.23457), Some(-0.00001)));
        let [combination, poses, representation] =
            ["both", "camera:a;camera:b", "points;points"].map(String::from);
        let rows = vec![row.clone(), ApproachRow { snapshot: Some(0), at_entry: AtEntry::Open, ..row }];
        let (format, perirobot, case) = (FILE.format, "0.1.0".into(), "draw 1".into());
        let step_m = Some(0.25);
        let written =
            Approaches { format, perirobot, combination, poses, representation, case, step_m, rows };
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(Approaches::read(folder.path()).unwrap(), None);
        written.write(folder.path()).unwrap();
        assert_eq!(Approaches::read(folder.path()).unwrap().unwrap(), written);
    }
}
