//! The answers as `approach.csv`, made for pandas, and in words.
//!
//! | column | |
//! |---|---|
//! | `combination`, `poses`, `representation` | which sensors, as in results.csv |
//! | `case` | what of them is not as planned, in words; empty where nothing is |
//! | `scene`, `snapshot` | which moment; `*` for all snapshots at once |
//! | `people` | `absent`, or `cover`: the people of the scene stand in the way, and hide what is behind them |
//! | `body`, `entry` | by their names in the study |
//! | `at_entry` | `open`: the body comes in unnoticed; `noticed` wherever it has room there; `no_room`: something solid is there, at all its places |
//! | `deepest_m`, `deepest_squared` | how near the body comes to the hazard, between centres of voxels: in metres, and squared in voxels; empty unless the entry is open |
//! | `noticed_m`, `noticed_squared` | how far the body is from the hazard, alike, at the nearest of those places of the entry at which it is noticed; empty where there is none |
//! | `path_m` | how long its way is |
//! | `needed_m`, `margin_m` | how far people must be at the highest listed speed of the robot, and how much farther the lesser of `deepest_m` and `noticed_m` is, below 0 where it is too near; empty without `[stopping]`, and `margin_m` where the body has no room |
//! | `x_m`, `y_m`, `z_m` | the middle of the body at the deepest place |
//! | `narrowest_x_m`, `narrowest_y_m`, `narrowest_z_m` | the middle of the body where the way is the narrowest |
//! | `narrowest_places` | at how many places the body must be noticed there to close the way; a place is one position of the body |
//! | `shadowed_by` | the object that hides it there from the most sensors and voxels; empty where none does |
//! | `unnoticed_m2`, `joined_m2` | of a body on the floor, the area of the positions of its middle at which it stands unnoticed, and of those it comes to from the entry |

use glam::DVec3;

use super::body::Body;
use super::ground::{Company, Ground};
use super::moments::Answer;
use super::needed::{self, root_m};
use crate::view::Choice;
use perirobot_march::backend::Fusion;
use perirobot_march::voxel::{Grid, rounded_down, rounded_up};
use perirobot_study::study::Study;
use perirobot_sweep::results::columns::{Csv, pose_names, representation_names};

/// The name of the file.
pub const APPROACH: &str = "approach.csv";

const COLUMNS: [&str; 27] = [
    "combination",
    "poses",
    "representation",
    "case",
    "scene",
    "snapshot",
    "people",
    "body",
    "entry",
    "at_entry",
    "deepest_m",
    "deepest_squared",
    "noticed_m",
    "noticed_squared",
    "path_m",
    "needed_m",
    "margin_m",
    "x_m",
    "y_m",
    "z_m",
    "narrowest_x_m",
    "narrowest_y_m",
    "narrowest_z_m",
    "narrowest_places",
    "shadowed_by",
    "unnoticed_m2",
    "joined_m2",
];

/// The middle of a body at a place, in world metres.
pub(super) fn middle_m(body: &Body, place: [i32; 3], grid: &Grid) -> DVec3 {
    let half = DVec3::from_array(body.size.map(|n| f64::from(n) / 2.0 * grid.voxel_size_m));
    grid.corner_m(place) + half
}

/// Digits of metres in the table: hundredths of a millimetre.
const DIGITS: u32 = 5;

/// A coordinate or a length of a way in metres.
fn metres(metres: f64) -> String {
    format!("{metres:.5}")
}

/// A length from thousandths of a voxel.
fn length_m(thousandths: u64, grid: &Grid) -> f64 {
    thousandths as f64 / 1000.0 * grid.voxel_size_m
}

/// Which sensors were asked about, in words.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// Their combination.
    pub combination: String,
    /// Their poses, as in results.csv.
    pub poses: String,
    /// Their representation.
    pub representation: String,
    /// What is not as planned; empty where nothing is.
    pub case: String,
}

impl Asked {
    /// A choice of a study, and what of it is not as planned.
    pub fn new(study: &Study, choice: &Choice, case: String) -> Asked {
        let combination = &study.combinations[choice.combination];
        Asked {
            combination: combination.name.clone(),
            poses: pose_names(study, combination, choice.choice),
            representation: representation_names(study, combination).swap_remove(choice.representation),
            case,
        }
    }
}

/// What is to be known of an answer where log-odds are summed.
pub fn fusion_warning(study: &Study, choice: &Choice) -> Option<String> {
    let combination = &study.combinations[choice.combination];
    (combination.fusion == Fusion::Octomap).then(|| {
        format!(
            "combination {:?}: log-odds may outvote a single sensor's hits; what is watched is taken of each sensor by \
             itself, so somebody may come nearer than is said",
            combination.name
        )
    })
}

/// The table of all scenes that were asked.
pub fn csv(of: &Asked, scenes: &[(Ground, Vec<Answer>)]) -> Vec<u8> {
    let mut csv = Csv::new(&COLUMNS);
    let sensors = [&of.combination, &of.poses, &of.representation, &of.case];
    for (ground, answers) in scenes {
        for answer in answers {
            let mut row: Vec<String> = sensors.into_iter().cloned().collect();
            row.extend(fields(ground, answer));
            csv.row(&row);
        }
    }
    csv.bytes()
}

fn fields(ground: &Ground, answer: &Answer) -> Vec<String> {
    let (grid, body) = (&ground.worlds[0].grid, &ground.bodies[answer.body]);
    let deepest = answer.found.deepest.as_ref();
    let empty = String::new;
    let point = |place: Option<[i32; 3]>| match place {
        Some(place) => middle_m(body, place, grid).to_array().map(metres),
        None => [empty(), empty(), empty()],
    };
    let area = |places: u64| match body.on_floor {
        true => metres(places as f64 * grid.voxel_size_m * grid.voxel_size_m),
        false => empty(),
    };
    let narrowest = deepest.and_then(|deepest| deepest.narrowest);
    let text = |value: Option<String>| value.unwrap_or_default();
    let mut fields = vec![
        ground.worlds[0].name.clone(),
        answer.snapshot.map_or("*".into(), |snapshot| snapshot.to_string()),
        answer.company.name().into(),
        body.name.clone(),
        ground.study.approach.entries[answer.entry].name.clone(),
        answer.at_entry.name().into(),
    ];
    for squared in [deepest.map(|deepest| deepest.squared), answer.found.noticed] {
        fields.push(text(squared.map(|squared| rounded_down(root_m(squared, grid), DIGITS))));
        fields.push(text(squared.map(|squared| squared.to_string())));
    }
    fields.push(text(deepest.map(|deepest| metres(length_m(deepest.length, grid)))));
    let needed = ground.study.stopping.as_ref().map(|stopping| stopping.fastest().needed_m);
    let margin = answer.found.nearest().zip(needed).map(|(nearest, needed)| root_m(nearest, grid) - needed);
    fields.extend([needed.map(|m| rounded_up(m, DIGITS)), margin.map(|m| rounded_down(m, DIGITS))].map(text));
    fields.extend(point(deepest.and_then(|deepest| deepest.path.last().copied())));
    fields.extend(point(narrowest.map(|narrowest| narrowest.place)));
    fields.push(text(narrowest.map(|narrowest| narrowest.front.to_string())));
    fields.push(answer.shadow.clone().unwrap_or_default());
    fields.extend([area(answer.unnoticed), area(answer.found.reached.count())]);
    fields
}

/// The answers of a scene in words: of each body from each entry that of all snapshots at once.
pub fn describe(ground: &Ground, answers: &[Answer]) -> String {
    let (grid, study) = (&ground.worlds[0].grid, ground.study);
    let at_once = if ground.worlds.len() > 1 { ", all snapshots at once" } else { "" };
    let mut text = format!("scene {}{at_once}\n", ground.worlds[0].name);
    if let (Some(stopping), Some(answer)) = (&study.stopping, answers.first()) {
        text += &needed::beyond_the_grid(stopping, answer.farthest, grid);
    }
    for answer in answers.iter().filter(|answer| answer.snapshot.is_none() || ground.worlds.len() == 1) {
        let body = &ground.bodies[answer.body];
        let with = match answer.company {
            Company::Absent => "",
            Company::Cover => ", people as cover",
        };
        let entry = &study.approach.entries[answer.entry].name;
        text += &format!("  {} from {entry}{with}: ", body.name);
        let Some(nearest) = answer.found.nearest() else {
            text += "has no room at the entry\n";
            continue;
        };
        let away = |squared| rounded_down(root_m(squared, grid), 2);
        match &answer.found.deepest {
            Some(deepest) => {
                text += &format!(
                    "comes to {} m unnoticed, by a way of {:.2} m\n",
                    away(deepest.squared),
                    length_m(deepest.length, grid)
                );
                if nearest < deepest.squared {
                    text += &format!(
                        "    this decides: at other places of the entry it is first noticed {} m from the hazard\n",
                        away(nearest)
                    );
                }
            }
            None => text += &format!("is first noticed at its entry, {} m from the hazard\n", away(nearest)),
        }
        if let Some(stopping) = &study.stopping {
            text += &format!("    {}\n", needed::describe(stopping, nearest, grid));
            let entry = answer.found.entry.and_then(|entry| needed::begins_too_near(stopping, entry, grid));
            text += &entry.map_or(String::new(), |entry| format!("    {entry}\n"));
        }
        let Some(deepest) = &answer.found.deepest else { continue };
        if let Some(narrowest) = deepest.narrowest {
            let at = middle_m(body, narrowest.place, grid);
            let shadow = match &answer.shadow {
                Some(object) => format!("behind {object:?}"),
                None => format!("where fewer than {} of its voxels are watched", body.min_voxels),
            };
            text += &format!(
                "    narrowest at x {:.2}, y {:.2}, z {:.2} m, {shadow}: to be noticed at {} places\n",
                at.x, at.y, at.z, narrowest.front
            );
        }
        if body.on_floor {
            let area = |places: u64| places as f64 * grid.voxel_size_m * grid.voxel_size_m;
            text += &format!(
                "    unnoticed with its middle on {:.2} m² of floor, {:.2} m² of it on ways from here\n",
                area(answer.unnoticed),
                area(answer.found.reached.count())
            );
        }
    }
    text
}
