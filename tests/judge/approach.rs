//! `perirobot approach`: a cell whose answer is known, a body put where it says, its way in pictures, and what cannot be
//! asked.

use std::fs;

use crate::common;
use crate::common::program::{Folder, Outcome, names, perirobot, shelf, text};
use perirobot_decide::approach::{APPROACH, APPROACH_JSON, Ground, PATHS, Way, nearest_ways};
use perirobot_decide::view::watched::Watchers;
use perirobot_decide::view::{ChoiceSelector, find};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

fn approach(folder: &Folder, pose: &str) -> Outcome {
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    perirobot(&["approach", text(&study), "--pose", pose, "--out", text(&out)])
}

/// The entry of the study.
const DOOR: &str = "box = { min_m = [1.4, -1.0, 0], max_m = [2.0, 1.0, 2.0] }";
const FRONT: &str = "wall/front";
const BOTH: &str = "camera:wall/front;camera:wall/back";

/// Values of some columns of a row.
fn row<const N: usize>(folder: &Folder, key: [&str; 3], columns: [&str; N]) -> [String; N] {
    let mut reader = csv::Reader::from_path(folder.path("out").join(APPROACH)).unwrap();
    let header = reader.headers().unwrap().clone();
    let at = |name: &str| header.iter().position(|column| column == name).unwrap();
    let is_asked = |row: &csv::StringRecord| {
        let columns = ["snapshot", "people", "body"];
        (0..3).all(|i| &row[at(columns[i])] == key[i])
    };
    let found = reader.records().map(Result::unwrap).find(is_asked).expect("a row");
    columns.map(|name| found[at(name)].to_string())
}

/// The shelf is 60 cm wide and ends at x = 0.2 m, with the voxel of index 4; a person who stands behind it has
/// voxels from index 5 on. The robot's last is at −0.8 m, index −16: 21 voxels, 1.05 m. The person who begins
/// farthest in stands at x = 1.6 m with the middle, and at 0.45 m in the end: 1.15 m straight on.
#[test]
fn a_shelf_60_cm_wide_lets_a_person_in_unless_a_second_camera_looks_behind_it() {
    let folder = shelf();
    let outcome = approach(&folder, FRONT);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let asked = ["deepest_squared", "deepest_m", "path_m", "x_m", "shadowed_by"];
    let known = ["441", "1.05000", "1.15000", "0.45000", "shelf"];
    assert_eq!(row(&folder, ["0", "absent", "standing"], asked), known);
    for said in ["standing from door: gets to 1.05 m unnoticed, on a path of 1.15 m", "behind \"shelf\""] {
        assert!(outcome.stdout.contains(said), "{}", outcome.stdout);
    }
    // 1.95 m are needed at 1 m/s, and 1.0025 at 0.25.
    let needed = row(&folder, ["0", "absent", "standing"], ["needed_m", "margin_m"]);
    assert_eq!(needed, ["1.95000", "-0.90000"]);
    let said =
        "too near at 1 m/s: 1.95 m are needed, 0.90 m more; far enough up to 0.25 m/s, where 1.01 m are";
    assert!(outcome.stdout.contains(said), "{}", outcome.stdout);
    assert_eq!(
        outcome.stdout.matches("To be checked: human_speed_m_s = 1.6").count(),
        1,
        "{}",
        outcome.stdout
    );
    // The colleague hides more of the floor, and what is nearest is the same.
    let area = |people| row(&folder, ["0", people, "crawling"], ["joined_m2"])[0].parse::<f64>().unwrap();
    assert!(area("cover") > 1.5 * area("absent"));
    let plans = ["standing", "crawling", "trolley"].map(|body| format!("floor-cell-{body}"));
    let plans =
        plans.iter().flat_map(|plan| ["", "-people-as-cover"].map(|with| format!("{plan}{with}.svg")));
    let files = [APPROACH, APPROACH_JSON, PATHS].map(String::from);
    let mut expected: Vec<String> = files.into_iter().chain(plans).collect();
    expected.sort();
    assert_eq!(names(&folder.path("out")), expected);
    // The path of the first row: from 1.6 to 0.45 m in 23 steps of 5 cm.
    let ply = fs::read_to_string(folder.path("out").join(PATHS)).unwrap();
    let first: Vec<Vec<f64>> = ply
        .lines()
        .skip_while(|line| *line != "end_header")
        .skip(1)
        .map(|line| line.split(' ').map(|n| n.parse().unwrap()).collect())
        .take_while(|vertex: &Vec<f64>| vertex.len() == 4 && vertex[3] == 0.0)
        .collect();
    assert_eq!((first.len(), first[0][0], first[23][0]), (24, 1.6, 0.45));

    let outcome = approach(&folder, BOTH);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    // At its nearest, from index 28 on: 44 voxels.
    let said =
        "standing from door: is first noticed at its entry, 2.20 m from the hazard\n    far enough: 1.95 m";
    assert!(outcome.stdout.contains(said), "{}", outcome.stdout);
    let noticed = ["at_entry", "noticed_squared", "noticed_m", "margin_m"];
    let known = ["noticed", "1936", "2.20000", "0.25000"];
    assert_eq!(row(&folder, ["0", "absent", "standing"], noticed), known);
    assert_eq!(row(&folder, ["0", "absent", "standing"], asked), ["", "", "", "", ""]);
    let unnoticed = row(&folder, ["0", "absent", "standing"], ["unnoticed_m2", "joined_m2"]);
    assert_eq!(unnoticed, ["0.00000", "0.00000"]);
    // A shelf that is 10 cm wide hides nobody who is 40 cm wide: its shadow is less than twice as wide.
    folder.edit("cell.toml", "size_m = [0.2, 0.6, 2.3]", "size_m = [0.2, 0.1, 2.3]");
    approach(&folder, FRONT);
    assert_eq!(row(&folder, ["0", "absent", "standing"], asked), ["", "", "", "", ""]);
}

/// An entry is no safer for being watched: somebody who is first noticed there has come as near as that. The nearest
/// voxel of the entry has index −10, and the robot ends with −16: 6 voxels.
#[test]
fn who_is_first_noticed_near_the_robot_is_too_near() {
    let folder = shelf();
    folder.edit("study.toml", DOOR, "box = { min_m = [-0.5, -0.25, 0], max_m = [-0.05, 0.25, 2.0] }");
    let columns = ["at_entry", "deepest_squared", "noticed_squared", "noticed_m", "margin_m"];
    let asked = |pose| (approach(&folder, pose), row(&folder, ["0", "absent", "standing"], columns));
    let (outcome, found) = asked(BOTH);
    assert_eq!(found, ["noticed", "", "36", "0.30000", "-1.65000"], "{}", outcome.stdout);
    for said in [
        "is first noticed at its entry, 0.30 m from the hazard\n    too near at 1 m/s: 1.95 m are needed, 1.65 m more",
        "at no listed speed is it far enough",
        "no sensor can help at 1 m/s: the entry begins 0.30 m from the hazard, and has to begin 1.95 m from it or farther, \
         1.65 m farther out",
    ] {
        assert!(outcome.stdout.contains(said), "{}", outcome.stdout);
    }
    assert!(!outcome.stderr.contains("log-odds"), "{}", outcome.stderr);
    // Also where other places of the same entry let somebody in unnoticed, less near.
    let near = "min_m = [-0.5, -0.25, 0], max_m = [-0.05, 0.25, 2.0]";
    folder.edit("study.toml", near, "min_m = [-0.5, -1.0, 0], max_m = [2.0, 1.0, 2.0]");
    folder.edit("study.toml", "[grid]", "fusion = \"octomap\"\n[grid]");
    let (outcome, found) = asked(FRONT);
    assert_eq!(found, ["open", "441", "36", "0.30000", "-1.65000"], "{}", outcome.stdout);
    let said = "gets to 1.05 m unnoticed, on a path of 0.00 m\n    decisive: 0.30 m, where it is first noticed at another \
                place of the entry\n    too near at 1 m/s: 1.95 m are needed, 1.65 m more;";
    assert!(outcome.stdout.contains(said), "{}", outcome.stdout);
    assert!(outcome.stderr.contains("log-odds may outvote a single sensor's hits"), "{}", outcome.stderr);
}

/// Where the answer says, a person who is put into the scene has no voxel hit, on any backend; half a metre
/// aside the same person is detected.
#[test]
fn a_person_put_at_the_deepest_place_is_not_hit_by_any_backend() {
    let folder = shelf();
    folder.edit("cell.toml", "name = \"colleague\"", "name = \"intruder\"");
    folder.edit(
        "cell.toml",
        "cylinder = { radius_m = 0.2, height_m = 1.7 }",
        "cylinder = { radius_m = 0.19, height_m = 1.7 }",
    );
    folder.edit(
        "study.toml",
        "[[sensor]]",
        "[[region]]\nname = \"human\"\nhuman_box = { margin_m = 0.1 }\n[[sensor]]",
    );
    approach(&folder, FRONT);
    let [x, y] = row(&folder, ["0", "absent", "standing"], ["x_m", "y_m"]);
    let seen = |position: String| {
        let spot = folder.path("cell.toml");
        let before = fs::read_to_string(&spot).unwrap();
        folder.edit("cell.toml", "position_m = [0.1, 0.55, 0.9]", &format!("position_m = {position}"));
        let mut backends = vec![vec!["--backend", "oracle"], vec!["--backend", "cpu"]];
        backends.extend(common::on_adapter().map(Vec::from));
        let seen = backends.into_iter().map(|on| {
            let (study, out) = (folder.path("study.toml"), folder.path("swept"));
            let fixed = ["sweep", text(&study), "--out", text(&out), "--restart"];
            let outcome = perirobot(&[&fixed, &on[..]].concat());
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
            let mut reader = csv::Reader::from_path(out.join("results.csv")).unwrap();
            let header = reader.headers().unwrap().clone();
            let at = |name: &str| header.iter().position(|column| column == name).unwrap();
            let is_asked = |row: &csv::StringRecord| {
                &row[at("poses")] == "camera:wall/front" && &row[at("region")] == "human"
            };
            let found = reader.records().map(Result::unwrap).find(is_asked).unwrap();
            found[at("hit_human")].parse::<u64>().unwrap()
        });
        let seen: Vec<u64> = seen.collect();
        fs::write(&spot, before).unwrap();
        assert!(seen.iter().all(|hits| *hits == seen[0]), "{seen:?}");
        seen[0]
    };
    assert_eq!(seen(format!("[{x}, {y}, 0.92]")), 0);
    assert!(seen(format!("[{x}, {}, 0.92]", y.parse::<f64>().unwrap() - 0.5)) > 100);
}

#[test]
fn what_cannot_be_asked_is_refused_before_anything_is_cast() {
    let refused = |edits: &[(&str, &str, &str)], expected: &[&str]| {
        let folder = shelf();
        edits.iter().for_each(|(file, from, to)| folder.edit(file, from, to));
        let outcome = approach(&folder, FRONT);
        let what = format!("{edits:?}: {:?}\n{}", outcome.code, outcome.stderr);
        assert_eq!(outcome.code, Some(2), "{what}");
        expected.iter().for_each(|part| assert!(outcome.stderr.contains(part), "no {part:?} in {what}"));
        assert!(!outcome.stderr.contains("panicked") && outcome.stdout.is_empty(), "{what}");
        assert!(!folder.path("out").exists(), "{what}");
    };
    let study = |from: &'static str, to: &'static str| ("study.toml", from, to);
    refused(
        &[
            study(DOOR, "box = { min_m = [-1.2, -0.3, 0], max_m = [-0.79, 0.3, 2.0] }"),
            ("cell.toml", "radius_m = 0.2, height_m = 1.2", "radius_m = 0.3, height_m = 2.1"),
        ],
        &[
            "approach: entry \"door\": lies inside something solid: body \"standing\" is free at no place of it",
        ],
    );
    refused(
        &[study(DOOR, "box = { min_m = [1.4, -1.0, 0], max_m = [2.0, -0.7, 2.0] }")],
        &[
            "entry \"door\": is too small for body \"standing\"",
            "0.40 × 0.40 × 1.75 m",
            "0.60 × 0.30 × 2.00 m",
        ],
    );
    refused(
        &[study(DOOR, "box = { min_m = [5, 5, 0], max_m = [6, 6, 2.0] }")],
        &["entry \"door\": lies outside the grid, which goes from [-2.0", "bounds_m"],
    );
    refused(
        &[
            ("cell.toml", "role = \"robot\"", "role = \"environment\""),
            study("separation = {}", "swept = \"human\""),
        ],
        &["no hazard: no object of the scene is a robot", "role = \"robot\""],
    );
    refused(
        &[study("name = \"standing\"", "name = \"flying\"")],
        &["approach.body \"flying\": no shape", "name one of standing, crawling, arm, leg, finger"],
    );
    refused(
        &[study("name = \"standing\"", "name = \"finger\"")],
        &["body \"finger\": has 1 voxels of 0.05 m", "min_voxels = 1 or less"],
    );
    refused(
        &[study("hazard = \"robot\"", "region = \"tool\"")],
        &["approach.region = \"tool\": must be a region of the study: [\"robot\", \"near@0.25\""],
    );
    refused(
        &[study("hazard = \"robot\"", "hazard = \"robot\"\nregion = \"robot\"")],
        &["both hazard and region"],
    );
    refused(&[study("min_voxels = 3", "min_voxels = 0")], &["approach.min_voxels = 0: must be 1 or more"]);
    refused(
        &[study("min_voxels = 3", "floor_m = 3")],
        &["body \"standing\": is nowhere inside the grid, on a floor at 3 m"],
    );
    refused(
        &[study("size_m = [0.4, 0.4, 0.9]", "size_m = [0.4, -1, 0.9]")],
        &["approach.body \"trolley\".size_m = -1: must be a size in metres"],
    );
    // So many voxels that listing them would take hours.
    refused(
        &[
            study("name = \"standing\"", "name = \"huge\"\nball = { diameter_m = 40 }"),
            study("voxel_size_m = 0.05", "voxel_size_m = 0.01"),
            study("separation = {}", "swept = \"robot\""),
            study("min = [-2, -1.5, 0], max = [2, 1.5, 2.2]", "min = [-2, -0.1, 0], max = [2, 0.1, 2.2]"),
        ],
        &["body \"huge\": is nowhere inside the grid"],
    );
    refused(&[study("name = \"crawling\"", "name = \"standing\"")], &["two bodies are named \"standing\""]);
    refused(
        &[study(DOOR, "gate = \"camera\"")],
        &["entry \"door\".gate = \"camera\": must be a sensor of the study with kind = \"gate\""],
    );
    refused(&[study(DOOR, "edges = false")], &["entry \"door\".edges = false: must be true"]);
    refused(&[study(DOOR, "")], &["entry \"door\": no place: give one of box, gate, edges"]);
    refused(
        &[
            study(DOOR, "edges = true"),
            (
                "cell.toml",
                "plane = { size_m = [4, 3] }",
                "room = { size_m = [3.9, 2.9, 2.1] }\nposition_m = [0, 0, 1.05]",
            ),
        ],
        &["entry \"door\": lies inside something solid", "no opening of the grid's edge is free"],
    );
}

/// Without distances nothing is said of them; at a distance that is exactly enough a body is far enough away, and
/// where the grid ends before, that is said.
#[test]
fn what_is_needed_is_compared_in_whole_numbers() {
    let of = |edits: &[(&str, &str)]| {
        let folder = shelf();
        edits.iter().for_each(|(from, to)| folder.edit("study.toml", from, to));
        let outcome = approach(&folder, FRONT);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        (row(&folder, ["0", "absent", "standing"], ["needed_m", "margin_m"]), outcome.stdout)
    };
    let text = fs::read_to_string(shelf().path("study.toml")).unwrap();
    let table = text.split_once("[stopping]").unwrap().1.split_once("[approach]").unwrap().0;
    let (columns, said) = of(&[
        ("[stopping]", ""),
        (table, ""),
        ("name = \"near\"\nseparation = {}", "name = \"near\"\nswept = \"robot\""),
    ]);
    assert_eq!(columns, ["", ""]);
    assert!(!said.contains("needed") && !said.contains("To be checked"), "{said}");
    // 0.8 · 0.65 + 0.15 + 0.25 + 0.13 = 1.05: in floating point a little more, in whole voxels 441 as it is.
    let exact = |uncertainty| {
        of(&[
            ("intrusion_m = 0.4", "intrusion_m = 0.0\nhuman_speed_m_s = 0.8"),
            ("person_uncertainty_m = 0.1", uncertainty),
            ("robot_uncertainty_m = 0.01", "robot_uncertainty_m = 0.0"),
        ])
    };
    let (columns, said) = exact("person_uncertainty_m = 0.13");
    assert_eq!(columns[0], "1.05000");
    assert!(
        said.contains("far enough: 1.05 m are needed at 1 m/s, the highest listed speed, 0.00 m less (by 0.00 m: not certain, since the gap may be 0.12 m less)"),
        "{said}"
    );
    let (columns, said) = exact("person_uncertainty_m = 0.13001");
    assert_eq!(columns, ["1.05001", "-0.00001"]);
    assert!(
        said.contains("too near at 1 m/s: 1.06 m are needed, 0.01 m more; far enough up to 0.5 m/s"),
        "{said}"
    );
    let (_, said) = exact("person_uncertainty_m = 1.0");
    assert!(said.contains("at no listed speed is it far enough"), "{said}");
    assert!(!said.contains("are bounds"), "{said}");
    let (_, said) = exact("person_uncertainty_m = 5.0");
    assert!(
        said.contains("5.92 m are needed at 1 m/s, and nothing in the grid is farther away than"),
        "{said}"
    );
}

/// Somebody who stands outside of a light curtain is not noticed by it, and in it is.
#[test]
fn a_light_curtain_is_an_entry_from_its_outside() {
    let folder = shelf();
    let gate = "[[sensor]]\nname = \"curtain\"\nkind = \"gate\"\n\
                box = { min_m = [1.2, -1.4, 0.1], max_m = [1.3, 1.4, 2] }\n\
                zone = { min_m = [-2, -1.4, 0], max_m = [1.2, 1.4, 2] }\n[[combination]]\nname = \"gated\"\nsensors = [\"curtain\", \"camera\"]\n";
    folder.edit("study.toml", "# Each camera alone", &format!("{gate}# Each camera alone"));
    folder.edit("study.toml", DOOR, "gate = \"curtain\"");
    // Without the curtain's signal the camera alone is passed in the shelf's shadow.
    let outcome = approach(&folder, FRONT);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let [deepest, _] = row(&folder, ["0", "absent", "standing"], ["deepest_squared", "path_m"]);
    assert_eq!(deepest, "441");
    // With it, the person comes as near as the side of the curtain that is outside: from index 26 on.
    let outcome = approach(&folder, "curtain:here;camera:wall/front");
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let [deepest, x] = row(&folder, ["0", "absent", "standing"], ["deepest_squared", "x_m"]);
    assert_eq!((deepest.as_str(), x.as_str()), ("1764", "1.50000"), "42 voxels from −16 to 26");
    assert!(!outcome.stderr.contains("always on"), "{}", outcome.stderr);
    // One that begins in the floor is always on: nobody changes what it says, and the camera is alone again.
    folder.edit("study.toml", "min_m = [1.2, -1.4, 0.1]", "min_m = [1.2, -1.4, 0]");
    let outcome = approach(&folder, "curtain:here;camera:wall/front");
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(row(&folder, ["0", "absent", "standing"], ["deepest_squared"]), ["441"]);
    assert!(outcome.stderr.contains("the environment alone trips 1 of 1"), "{}", outcome.stderr);
}

/// A light curtain is an entry where it is planned, also where it is dead or its mount is off: in the picture as in the
/// table.
#[test]
fn a_picture_of_what_is_altered_has_the_entries_as_planned() {
    let folder = shelf();
    let gate = "[[sensor]]\nname = \"curtain\"\nkind = \"gate\"\n\
                box = { min_m = [-0.05, -1.4, -0.95], max_m = [0.05, 1.4, 0.95] }\n\
                zone = { min_m = [-3.2, -1.4, -1.05], max_m = [-0.05, 1.4, 0.95] }\n\
                [[sensor.poses]]\nname = \"at\"\nlist = [{ name = \"near\", position_m = [1.25, 0, 1.05] }, \
                { name = \"far\", position_m = [1.35, 0, 1.05] }]\n\
                [[combination]]\nname = \"gated\"\nsensors = [\"curtain\", \"camera\"]\n";
    folder.edit("study.toml", "# Each camera alone", &format!("{gate}# Each camera alone"));
    folder.edit("study.toml", DOOR, "gate = \"curtain\"");
    folder.edit("study.toml", "", "\n[mounting_error]\ndraws = 1\nposition_m = 0.1\n");
    let (study, out, plan) = (folder.path("study.toml"), folder.path("out"), folder.path("way.svg"));
    let chosen = [text(&study), "--pose", "curtain:at/near;camera:wall/front"];
    for altered in [["--dead", "curtain:at/near"], ["--draw", "0"]] {
        let told = |command: &[&str], out: &str| {
            let outcome = perirobot(&[command, &chosen, &altered, &["--out", out]].concat());
            assert_eq!(outcome.code, Some(0), "{altered:?}: {}", outcome.stderr);
            outcome.stdout
        };
        told(&["approach"], text(&out));
        let drawn = told(&["render", "--approach"], text(&plan));
        for body in ["standing", "crawling", "trolley"] {
            let near =
                ["absent", "cover"].map(|people| row(&folder, ["0", people, body], ["deepest_m"]).concat());
            // Nothing where it is noticed.
            let nearest = near.iter().filter(|deepest_m| !deepest_m.is_empty()).min();
            let said = nearest.map(|deepest_m| format!("gets to {deepest_m:.4} m unnoticed"));
            let line = drawn.lines().find(|line| line.starts_with(&format!("{body} from")));
            let told = line.map(|line| line[line.find("gets to").unwrap()..].to_string());
            assert_eq!(told, said, "{altered:?}: {drawn}");
        }
    }
}

/// A body whose entry somebody fills is not said to be noticed.
#[test]
fn an_entry_without_room_is_told_from_one_where_a_body_is_noticed() {
    let folder = shelf();
    folder.edit("study.toml", DOOR, "box = { min_m = [1.2, -0.25, 0], max_m = [1.7, 0.25, 2.0] }");
    folder.edit("cell.toml", "position_m = [0.1, 0.55, 0.9]", "position_m = [1.45, 0, 0.9]");
    let at_entry = |people| row(&folder, ["0", people, "standing"], ["at_entry", "deepest_m"]);
    let outcome = approach(&folder, FRONT);
    assert_eq!(at_entry("absent"), ["open", "1.05000"]);
    assert_eq!(at_entry("cover"), ["no_room", ""]);
    let said = "standing from door, people as cover: has no room at the entry";
    assert!(outcome.stdout.contains(said), "{}", outcome.stdout);
    approach(&folder, BOTH);
    assert_eq!(at_entry("absent"), ["noticed", ""]);
    assert_eq!(row(&folder, ["0", "cover", "standing"], ["noticed_m", "margin_m"]), ["", ""]);
}

/// Where no object hides a body, no more is said than what is known.
#[test]
fn beyond_the_range_of_a_camera_nothing_is_named_as_shadow() {
    let folder = shelf();
    folder.edit("study.toml", "range_m = [0.1, 6.0]", "range_m = [0.1, 0.3]");
    let outcome = approach(&folder, FRONT);
    assert_eq!(row(&folder, ["0", "absent", "standing"], ["shadowed_by"]), [""]);
    let said = "where fewer than 3 of its voxels are watched: ";
    assert!(outcome.stdout.contains(said), "{}", outcome.stdout);
}

/// Names that differ in spelling only have plans of their own, and plans of another run are told.
#[test]
fn each_floor_plan_has_a_file_of_its_own() {
    let folder = shelf();
    approach(&folder, FRONT);
    folder.edit("study.toml", "name = \"trolley\"", "name = \"Standing!\"");
    let outcome = approach(&folder, FRONT);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for (plan, body) in [("floor-cell-standing.svg", "standing"), ("floor-cell-standing-2.svg", "Standing!")]
    {
        let svg = fs::read_to_string(folder.path("out").join(plan)).unwrap();
        assert!(svg.contains(&format!("cell: {body}, nobody else there")), "{plan}");
    }
    let told = |plan: &str| outcome.stderr.contains(&format!("{plan}: is no floor plan of this run"));
    assert!(told("floor-cell-trolley.svg") && told("floor-cell-trolley-people-as-cover.svg"));
    assert!(!told("floor-cell-crawling.svg") && !told("floor-cell-standing-2.svg"));
}

/// The report reads the JSON: one of an earlier run must not stand beside the tables and paths of the next.
#[test]
fn a_run_that_cannot_write_leaves_no_answers_of_an_earlier_one() {
    let folder = shelf();
    approach(&folder, FRONT);
    let out = folder.path("out");
    fs::remove_file(out.join(PATHS)).unwrap();
    fs::create_dir(out.join(PATHS)).unwrap();
    let outcome = approach(&folder, BOTH);
    assert_ne!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stderr.contains(PATHS), "{}", outcome.stderr);
    assert!(![APPROACH, APPROACH_JSON].iter().any(|name| out.join(name).exists()));
}

/// By which ways bodies come in by the sensors of a choice of poses.
fn ways(folder: &Folder, pose: &str) -> Vec<Way> {
    let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let (_, choice) =
        find(&study, &worlds, &ChoiceSelector { poses: pose.into(), ..ChoiceSelector::default() }).unwrap();
    let watchers = Watchers::new(&study, choice);
    nearest_ways(&Ground::new(&study, &worlds, watchers.each()).unwrap(), &worlds, &watchers).unwrap()
}

#[test]
fn pictures_show_the_way_of_who_comes_nearest() {
    let folder = shelf();
    let way = ways(&folder, FRONT).swap_remove(0);
    assert_eq!((way.body.as_str(), way.entry.as_str(), way.points_m.len()), ("standing", "door", 24));
    assert!((way.nearest_m - 1.05).abs() < 1e-12, "{}", way.nearest_m);
    let (first, last) = (way.points_m[0], way.points_m[23]);
    assert!((first.x - 1.6).abs() < 1e-9 && (last.x - 0.45).abs() < 1e-9, "{first} to {last}");
    // Around the person at the end, 0.4 m across, whose voxels begin with the layer above the floor's and end at 1.8 m.
    let corners = || way.outline_m.iter().flatten();
    let far = corners().map(|corner| (corner - last).truncate().length()).fold(0.0, f64::max);
    let [low, high] = [f64::min, f64::max].map(|of| corners().map(|corner| corner.z).reduce(of).unwrap());
    assert!(
        (far - 0.2).abs() < 1e-9 && (low - 0.05).abs() < 1e-9 && (high - 1.8).abs() < 1e-9,
        "{far}, {low}, {high}"
    );
    let draw = |file: &str, more: &[&str]| {
        let (study, out) = (folder.path("study.toml"), folder.path(file));
        let outcome =
            perirobot(&[&["render", text(&study), "--pose", FRONT, "--out", text(&out)], more].concat());
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        (outcome.stdout, fs::read(out).unwrap())
    };
    let (said, drawn) = draw("way.svg", &["--approach"]);
    let known = "standing from door gets to 1.05 m unnoticed";
    assert!(said.contains(known), "{said}");
    let drawn = String::from_utf8(drawn).unwrap();
    assert!(
        drawn.contains(known) && drawn.matches("class=\"way\"").count() == 6,
        "three ways and their signs"
    );
    let (said, plain) = draw("plain.svg", &[]);
    assert!(!said.contains("unnoticed") && !String::from_utf8(plain).unwrap().contains("class=\"way\""));
    let of_way = |bytes: &[u8]| {
        let mut png = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; png.output_buffer_size().unwrap()];
        png.next_frame(&mut pixels).unwrap();
        pixels.chunks(3).filter(|pixel| *pixel == [163, 0, 92]).count()
    };
    let (with, without) = (of_way(&draw("way.png", &["--approach"]).1), of_way(&draw("plain.png", &[]).1));
    assert!(with > 500 && without == 0, "{with} pixels, {without}");
}

#[test]
fn who_is_noticed_at_the_entry_has_no_way() {
    let folder = shelf();
    folder.edit("study.toml", "[[approach.body]]\nname = \"crawling\"", "");
    folder.edit(
        "study.toml",
        "[[approach.body]]\nname = \"trolley\"\nbox = { size_m = [0.4, 0.4, 0.9] }",
        "",
    );
    let (study, out) = (folder.path("study.toml"), folder.path("both.svg"));
    let outcome = perirobot(&["render", text(&study), "--pose", BOTH, "--approach", "--out", text(&out)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(
        outcome.stdout.contains("every body of [approach] is noticed at every entry"),
        "{}",
        outcome.stdout
    );
}
