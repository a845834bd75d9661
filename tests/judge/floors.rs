//! `floor = "auto"`: stairs, a pit and a fence whose answers are known by hand, in voxels of 10 cm.
//!
//! The floor is at z 0 and in layer 0, so a body of 1.8 m has layers 1 to 17. A body 40 cm wide has four voxels along x. The
//! robot is on a platform and begins with voxel 26 along x, in layers 8 and up, so distances are along x alone.

use std::sync::Arc;

use crate::common::program::{Folder, Outcome, perirobot, text};
use perirobot_decide::approach::{APPROACH, ApproachMoment, Approaches, Company, Ground, NearestApproach};
use perirobot_decide::judge::{Alteration, alter};
use perirobot_decide::view::{ChoiceSelector, find};
use perirobot_march::voxel::BitGrid;
use perirobot_scene::truth::Truth;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// A camera that watches nothing, and a person who comes in on the left.
const STUDY: &str = r#"[grid]
voxel_size_m = 0.1
bounds_m = { min = [-2, -1, -1], max = [3.55, 0.95, 3] }
[[scene]]
file = "cell.toml"
[[region]]
name = "cell"
box = { min_m = [-2, -1, -1], max_m = [3, 1, 3] }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [40, 40]
resolution_px = [8, 8]
range_m = [0.05, 0.1]
[[sensor.poses]]
name = "wall"
list = [{ name = "up", position_m = [3.35, 0.85, 2.85], facing = [1, 0, 0] }]
[approach]
floor = "auto"
step_m = 0.2
[[approach.body]]
name = "standing"
[[approach.entry]]
name = "door"
box = { min_m = [-2, -1, -0.5], max_m = [-1, 1, 2] }
"#;

/// A floor up to x 1, then a stair of the given depth to a platform 80 cm high.
fn scene(more: &str) -> String {
    let box_ = |name: &str, from: f64, to: f64, high: f64| {
        format!(
            "[[object]]\nname = \"{name}\"\nbox = {{ size_m = [{}, 2.4, {high}] }}\nposition_m = [{}, 0, {}]\n",
            to - from,
            (from + to) / 2.0,
            high / 2.0
        )
    };
    let steps = [(1.0, 0.2), (1.3, 0.4), (1.6, 0.6)].map(|(x, high)| box_("stair", x, x + 0.29, high));
    format!(
        "interior = \"occupied\"\n{}{}[[object]]\nname = \"robot\"\nrole = \"robot\"\nbox = {{ size_m = [0.2, 0.2, 1] }}\n\
         position_m = [2.7, 0, 1.3]\n{more}",
        steps.concat(),
        box_("platform", 1.9, 3.4, 0.8)
    )
}

const FLOOR: &str =
    "[[object]]\nname = \"floor\"\nplane = { size_m = [3.2, 2.4] }\nposition_m = [-0.6, 0, 0]\n";
const PIT: &str = "[[object]]\nname = \"left\"\nplane = { size_m = [1.6, 2.4] }\nposition_m = [-1.2, 0, 0]\n\
                   [[object]]\nname = \"right\"\nplane = { size_m = [0.6, 2.4] }\nposition_m = [0.7, 0, 0]\n\
                   [[object]]\nname = \"pit\"\nplane = { size_m = [1.5, 2.4] }\nposition_m = [0, 0, -0.6]\n";
const FENCE: &str =
    "[[object]]\nname = \"fence\"\nbox = { size_m = [0.02, 2.4, 1.2] }\nposition_m = [0.05, 0, 0.6]\n";

fn folder(objects: &[&str], step_m: f64) -> Folder {
    let folder = Folder::new();
    folder.write("study.toml", STUDY.replace("step_m = 0.2", &format!("step_m = {step_m}")));
    // Stairs have names of their own.
    let mut scene = scene(&objects.concat());
    for number in 1..=3 {
        scene = scene.replacen("\"stair\"", &format!("\"stair {number}\""), 1);
    }
    folder.write("cell.toml", scene);
    folder
}

fn answer(folder: &Folder) -> NearestApproach {
    let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let ground = Ground::new(&study, &worlds, &[]).unwrap();
    let truths: Vec<Arc<Truth>> = worlds.iter().map(|world| Company::Absent.truth(world)).collect();
    let moment = ApproachMoment::new(&ground, Company::Absent, &worlds, &truths).unwrap();
    moment.nearest(&BitGrid::new(worlds[0].grid.window())).swap_remove(0)
}

fn run(folder: &Folder, command: &[&str]) -> Outcome {
    let study = folder.path("study.toml");
    perirobot(&[&command[..1], &[text(&study)], &command[1..]].concat())
}

/// The body stands at 17 places along y: the grid has 20 voxels there, and the body four.
const ROWS: u64 = 17;

#[test]
fn a_body_climbs_stairs_of_its_step() {
    // Beside the robot. A step lower than the stairs', and the body ends before the first, voxel 10.
    assert_eq!(answer(&folder(&[FLOOR], 0.2)).squared, Some(1));
    let before = answer(&folder(&[FLOOR], 0.1));
    assert_eq!(before.squared, Some(17 * 17));
    // All columns from the grid's edge, voxel −20, to the stair.
    assert_eq!((before.unnoticed, before.joined), (27 * ROWS, 27 * ROWS));
    // At voxels of 10 cm a step of 15 cm is two layers.
    assert_eq!(answer(&folder(&[FLOOR], 0.15)).squared, Some(1));
}

#[test]
fn a_pit_is_crossed_by_those_who_climb_as_deep() {
    // The left floor ends with voxel −4 and carries a body that ends with voxel −1.
    assert_eq!(answer(&folder(&[PIT], 0.5)).squared, Some(27 * 27));
    assert_eq!(answer(&folder(&[PIT], 0.6)).squared, Some(1));
    let said = run(&folder(&[PIT], 0.2), &["check", "--poses", "0"]).stderr;
    // Four places along x between the edges.
    let area_m2 = 4.0 * ROWS as f64 * 0.01;
    let pit = format!(
        "\"pit\" at z -0.60 m ({area_m2:.2} m²) is a pit that body \"standing\" does not get into or out of: the lowest step is \
         0.60 m and step_m is 0.2"
    );
    assert!(said.contains(&pit), "{said}");
}

#[test]
fn a_fence_is_told() {
    let folder = folder(&[FLOOR, FENCE], 0.2);
    assert_eq!(answer(&folder).squared, Some(27 * 27), "up to voxel -1, before the fence in voxel 0");
    let out = folder.path("out");
    let outcome = run(&folder, &["approach", "--pose", "wall/up", "--out", text(&out)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let said = "gets to 2.70 m unnoticed, on a path of 1.00 m, standing at z 0.00 m\n    fence between: it does not climb \
                \"fence\", which is before the hazard";
    assert!(outcome.stdout.contains(said), "{}", outcome.stdout);
    let rows = Approaches::read(&out).unwrap().unwrap();
    assert_eq!((rows.step_m, rows.rows[0].fence_between.as_deref()), (Some(0.2), Some("fence")));
    let table = std::fs::read_to_string(out.join(APPROACH)).unwrap();
    assert!(table.lines().next().unwrap().ends_with(",fence_between"), "{table}");
    // The stairs are between too, and are climbed.
    let folder = self::folder(&[FLOOR], 0.2);
    folder.edit("cell.toml", "size_m = [0.2, 0.2, 1]", "size_m = [0.2, 0.2, 0.1]");
    let outcome = run(&folder, &["approach", "--pose", "wall/up", "--out", text(&out)]);
    assert!(!outcome.stdout.contains("fence between"), "{}", outcome.stdout);
    assert!(outcome.stdout.contains("standing at z 0.80 m"), "{}", outcome.stdout);
}

/// Over and under a mezzanine: its columns have two places each.
#[test]
fn bodies_walk_over_and_under_each_other() {
    let plate =
        "[[object]]\nname = \"plate\"\nbox = { size_m = [1.7, 2.4, 0.02] }\nposition_m = [0.05, 0, 2.05]\n";
    let joined = |objects: &[&str], step_m: f64| {
        let folder = folder(objects, step_m);
        folder.edit("study.toml", "max = [3.55, 0.95, 3]", "max = [3.55, 0.95, 4.5]");
        answer(&folder).joined
    };
    // It is in layer 20, above the heads, and nobody gets onto it by the stairs.
    assert_eq!(joined(&[FLOOR, plate], 0.2), joined(&[FLOOR], 0.2));
    assert_eq!(joined(&[FLOOR, plate], 1.5), joined(&[FLOOR], 1.5));
    // It carries a body at 21 places along x: from that with voxels −11 to −8 to that with 9 to 12. Beside the last of them
    // a body stands on the second stair, 16 layers lower.
    assert_eq!(joined(&[FLOOR, plate], 1.6), joined(&[FLOOR], 1.6) + 21 * ROWS);
}

#[test]
fn a_level_floor_is_as_by_its_height() {
    let by = |floor: &str| {
        let folder = folder(&[FLOOR], 0.1);
        folder.edit("study.toml", "floor = \"auto\"\nstep_m = 0.1\n", floor);
        // All of the floor, and nothing else that carries.
        folder.write("cell.toml", format!("{FLOOR}[[object]]\nname = \"robot\"\nrole = \"robot\"\nbox = {{ size_m = [0.2, 0.2, 1] }}\nposition_m = [0.5, 0, 0.6]\n").replace("3.2, 2.4", "9, 2.4"));
        answer(&folder)
    };
    assert_eq!(by("floor = \"auto\"\n"), by("floor_m = 0.0\n"));
}

#[test]
fn what_is_not_a_floor_is_refused_or_warned_of() {
    let refused = |from: &str, to: &str, expected: &[&str]| {
        let folder = folder(&[FLOOR], 0.2);
        folder.edit("study.toml", from, to);
        let outcome = run(&folder, &["check", "--poses", "0"]);
        let said = outcome.stdout + &outcome.stderr;
        assert_eq!(outcome.code, Some(2), "{said}");
        expected.iter().for_each(|part| assert!(said.contains(part), "no {part:?} in {said}"));
    };
    refused("step_m = 0.2", "floor_m = 0.0", &["approach: both floor and floor_m", "leave out floor_m"]);
    refused("floor = \"auto\"", "", &["approach: step_m without floor", "add floor = \"auto\""]);
    refused("step_m = 0.2", "step_m = 4", &["approach.step_m = 4: must be a height in metres from 0 to 3"]);
    refused("\"auto\"", "\"level\"", &["unknown variant `level`", "`auto`"]);
    refused(
        "box = { min_m = [-2, -1, -0.5], max_m = [-1, 1, 2] }",
        "box = { min_m = [-2, -1, 0.4], max_m = [-1, 1, 3] }",
        &["entry \"door\": has nothing that carries body \"standing\""],
    );
    let warned = |step_m: f64, expected: &str| {
        let outcome = run(&folder(&[FLOOR], step_m), &["check", "--poses", "0"]);
        assert!(outcome.code == Some(0) && outcome.stderr.contains(expected), "{}", outcome.stderr);
    };
    warned(0.0, "approach.step_m = 0: bodies cross level floors only");
    warned(1.5, "approach.step_m = 1.5: bodies walk up and down what people climb with their hands");
    warned(0.1, "body \"standing\" does not get onto \"stair 1\" at z 0.20 m");
    let outcome = run(&folder(&[FLOOR], 0.2), &["check", "--poses", "0"]);
    assert!(!outcome.stderr.contains("get onto") && !outcome.stderr.contains("step_m"), "{}", outcome.stderr);
}

/// A person of `[postures]` stands on the platform, 8 layers above z 0.
#[test]
fn postures_stand_on_what_carries_them() {
    let lowest = |floor: &str, spot: &str| -> Result<i32, String> {
        let folder = folder(&[FLOOR], 0.2);
        folder.edit("study.toml", "floor = \"auto\"\nstep_m = 0.2\n", floor);
        let postures = format!("[postures]\npeople = [\"standing\"]\nspots = [[{spot}, 0]]\n[approach]");
        folder.edit("study.toml", "[approach]", &postures);
        let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
        let worlds = World::prepare_all(&study).unwrap();
        let names = ChoiceSelector { poses: "wall/up".into(), ..ChoiceSelector::default() };
        let (_, choice) = find(&study, &worlds, &names).unwrap();
        let posture = Alteration::Posture("standing/0".into());
        let (_, worlds, _) = alter(&study, &worlds, &choice, &posture).map_err(|e| e.to_string())?;
        Ok(worlds[0].truth().human.bounds().min[2])
    };
    let auto = "floor = \"auto\"\nstep_m = 0.2\n";
    let level = lowest("floor_m = 0.0\n", "2.2, 0.3").unwrap();
    assert_eq!(lowest(auto, "2.2, 0.3"), Ok(level + 8));
    assert_eq!(lowest(auto, "0.0, 0.3"), Ok(level));
    let said = lowest(auto, "3.55, 0.3").unwrap_err();
    assert!(said.contains("spots[0] = [3.55, 0.3]: must be where a surface carries a person"), "{said}");
}
