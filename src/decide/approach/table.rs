//! The answers as `approach.csv`, made for pandas, and as text.
//!
//! | column | |
//! |---|---|
//! | `combination`, `poses`, `representation` | which sensors, as in results.csv |
//! | `case` | what of them is not as planned; empty if nothing is |
//! | `scene`, `snapshot` | which moment; `*` for all snapshots at once |
//! | `people` | `absent`, or `cover`: the people of the scene block paths, and hide the space behind them |
//! | `body`, `entry` | by their names in the study |
//! | `at_entry` | `open`: the body enters unnoticed; `noticed`: wherever it has room; `no_room`: all its places are solid |
//! | `deepest_m`, `deepest_squared` | how close the body gets to the hazard, between centres of voxels: in metres, and squared in voxels; empty unless the entry is open |
//! | `noticed_m`, `noticed_squared` | its distance at the nearest place of the entry at which it is noticed; empty if there is none |
//! | `path_m` | length of its path |
//! | `needed_m`, `margin_m` | how far people must be at the highest listed speed of the robot, and how much farther the lesser of `deepest_m` and `noticed_m` is, below 0 where it is too near; empty without `[stopping]`, and `margin_m` where the body has no room |
//! | `x_m`, `y_m`, `z_m` | the middle of the body at the deepest place |
//! | `narrowest_x_m`, `narrowest_y_m`, `narrowest_z_m` | the middle of the body where the way is the narrowest |
//! | `narrowest_places` | at how many places the body must be noticed there to close the way; a place is one position of the body |
//! | `shadowed_by` | the object that hides it there from the most sensors and voxels; empty if none does |
//! | `latches_passed` | the curtains that latch into whose zone the body gets without having been noticed on the way, joined by `;`: their latch does not hold |
//! | `unnoticed_m2`, `joined_m2` | of a body on the floor: the area of the positions of its middle at which it is unnoticed, and of those joined to the entry |
//! | `fence_between` | only with `floor = "auto"`: the object between body and hazard at the deepest place that the body does not climb; empty if there is none |

use super::approach_json::{ApproachRow, Approaches, DIGITS};
use super::ground::{Company, Ground};
use super::moments::ApproachAnswer;
use super::needed::{self, root_m};
use crate::view::Choice;
use perirobot_march::backend::Fusion;
use perirobot_march::voxel::rounded_down;
use perirobot_study::input::Study;
use perirobot_sweep::results::columns::Csv;

const COLUMNS: [&str; 28] = [
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
    "latches_passed",
    "unnoticed_m2",
    "joined_m2",
];

/// The column that a table has if bodies walk on surfaces.
const FENCE: &str = "fence_between";

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

impl Approaches {
    /// The table.
    pub fn csv(&self) -> Vec<u8> {
        let fence = self.step_m.map(|_| FENCE);
        let mut csv = Csv::new(&COLUMNS.into_iter().chain(fence).collect::<Vec<_>>());
        let sensors = [&self.combination, &self.poses, &self.representation, &self.case];
        for row in &self.rows {
            let between = fence.map(|_| row.fence_between.clone().unwrap_or_default());
            csv.row(&sensors.into_iter().cloned().chain(fields(row)).chain(between).collect::<Vec<String>>());
        }
        csv.bytes()
    }
}

fn fields(row: &ApproachRow) -> Vec<String> {
    let ApproachRow { scene, snapshot, people, body, entry, at_entry, .. } = row;
    let snapshot = snapshot.map_or("*".into(), |snapshot| snapshot.to_string());
    let [people, at_entry] = [people.name(), at_entry.name()].map(String::from);
    let metres = |number: Option<f64>| number.map_or(String::new(), |number| format!("{number:.DIGITS$}"));
    let count = |count: Option<u64>| count.map_or(String::new(), |count| count.to_string());
    let point = |point: Option<[f64; 3]>| point.map_or([None; 3], |point| point.map(Some)).map(metres);
    let mut fields = vec![scene.clone(), snapshot, people, body.clone(), entry.clone(), at_entry];
    fields.extend([metres(row.deepest_m), count(row.deepest_squared.map(u64::from))]);
    fields.extend([metres(row.noticed_m), count(row.noticed_squared.map(u64::from))]);
    fields.extend([row.path_m, row.needed_m, row.margin_m].map(metres));
    fields.extend(point(row.middle_m));
    fields.extend(point(row.narrowest_m));
    fields.push(count(row.narrowest_places));
    fields.push(row.shadowed_by.clone().unwrap_or_default());
    fields.push(row.latches_passed.join(";"));
    fields.extend([row.unnoticed_m2, row.joined_m2].map(metres));
    fields
}

/// The answers of a scene in words: of each body from each entry that of all snapshots at once.
pub fn describe(ground: &Ground, answers: &[ApproachAnswer]) -> String {
    let (grid, study) = (&ground.worlds[0].grid, ground.study);
    let at_once = if ground.worlds.len() > 1 { ", all snapshots at once" } else { "" };
    let mut text = format!("scene {}{at_once}\n", ground.worlds[0].name);
    if let (Some(stopping), Some(answer)) = (&study.stopping, answers.first()) {
        text += &needed::describe_grid_end(stopping, answer.farthest, grid);
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
                let height = match (body.climbs, deepest.path.last()) {
                    (Some(_), Some(&place)) => {
                        format!(", standing at z {:.2} m", grid.corner_m(place).z - grid.voxel_size_m)
                    }
                    _ => String::new(),
                };
                text += &format!(
                    "gets to {} m unnoticed, on a path of {:.2} m{height}\n",
                    away(deepest.squared),
                    deepest.length_m(grid)
                );
                if let Some(fence) = &answer.fence {
                    text += &format!(
                        "    fence between: it does not climb {fence:?}, which is before the hazard\n"
                    );
                }
                if nearest < deepest.squared {
                    text += &format!(
                        "    decisive: {} m, where it is first noticed at another place of the entry\n",
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
        for (sensor, is_passed) in &answer.latches {
            text += &match is_passed {
                true => format!(
                    "    gets into the zone of {sensor:?} without tripping it: its latch does not hold, and people \
                     there may be undetected\n"
                ),
                false => format!(
                    "    gets into the zone of {sensor:?} only by tripping it: its latch holds from here\n"
                ),
            };
        }
        let Some(deepest) = &answer.found.deepest else { continue };
        if let Some(narrowest) = deepest.narrowest {
            let at = body.middle_m(narrowest.place, grid);
            let shadow = match &answer.shadow {
                Some(object) => format!("behind {object:?}"),
                None => format!("where fewer than {} of its voxels are watched", body.min_voxels),
            };
            text += &format!(
                "    narrowest at x {:.2}, y {:.2}, z {:.2} m, {shadow}: {} positions to watch there\n",
                at.x, at.y, at.z, narrowest.front
            );
        }
        if body.on_floor {
            let area = |places: u64| places as f64 * grid.voxel_size_m * grid.voxel_size_m;
            text += &format!(
                "    unnoticed on {:.2} m² of floor (its centre), {:.2} m² of it on paths from here\n",
                area(answer.unnoticed),
                area(answer.found.reached.count())
            );
        }
    }
    text
}
