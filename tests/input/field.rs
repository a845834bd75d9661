//! Fields of scanners from tables, and the largest that the environment does not trip: in a room with a pillar, whose
//! contour is computed here again.

use std::fs;

use crate::common::program::{Folder, Outcome, perirobot, text};

const STUDY: &str = r#"[grid]
voxel_size_m = 0.05
[[scene]]
file = "cell.toml"
[[region]]
name = "human"
box = { min_m = [-0.5, 0.6, 0.1], max_m = [0.5, 1.2, 1.1] }
[[sensor]]
name = "scanner"
kind = "lidar"
fov_deg = 270
beams = 271
rings_deg = [0]
range_m = [0.1, 9]
# field
[[sensor.poses]]
name = "floor"
list = [{ name = "post", position_m = [-1.13, -0.38, 0.52], facing = [1, 0, 0] }]
"#;

/// The inner sides of the room lie on voxel boundaries, as do the pillar's.
const SCENE: &str = r#"interior = "free"
[[object]]
name = "walls"
room = { size_m = [4, 3, 2] }
position_m = [0, 0, 1]
[[object]]
name = "pillar"
box = { size_m = [0.4, 0.4, 1.6] }
position_m = [0.9, 0.3, 0.9]
"#;

const PEOPLE: &str = r#"[[object]]
name = "operator"
role = "human"
cylinder = { radius_m = 0.2, height_m = 1.7 }
position_m = [0.1, -0.6, 0.9]
[[object]]
name = "arm"
role = "robot"
cylinder = { radius_m = 0.2, height_m = 1.2 }
position_m = [-1.1, 0.6, 0.7]
"#;

const SCANNER_M: [f64; 2] = [-1.13, -0.38];
const VOXEL_M: f64 = 0.05;

fn cell() -> Folder {
    let folder = Folder::new();
    folder.write("study.toml", STUDY);
    folder.write("cell.toml", format!("{SCENE}{PEOPLE}"));
    folder
}

fn field(folder: &Folder, more: &[&str]) -> Outcome {
    let (study, out) = (folder.path("study.toml"), folder.path("fields/field.csv"));
    let outcome = perirobot(&[&["field", text(&study), "--out", text(&out)], more].concat());
    if outcome.code == Some(0) {
        fs::rename(out, folder.path("field.csv")).unwrap();
    }
    outcome
}

/// The corners that a successful run writes, and what it prints.
#[track_caller]
fn drawn(folder: &Folder, more: &[&str]) -> (Vec<[f64; 2]>, String) {
    let outcome = field(folder, more);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let table = fs::read_to_string(folder.path("field.csv")).unwrap();
    let (header, rows) = table.split_once('\n').unwrap();
    assert_eq!(header, "x_m,y_m");
    let corner = |row: &str| {
        let (x, y) = row.split_once(',').unwrap();
        assert!([x, y].iter().all(|cell| cell.split_once('.').unwrap().1.len() == 3), "{row}");
        [x, y].map(|cell| cell.parse().unwrap())
    };
    (rows.lines().map(corner).collect(), outcome.stdout)
}

/// How far a ray of the scanner goes in the room whose walls and pillar are thicker by so many metres.
fn distance_m(azimuth_deg: f64, thicker_m: f64) -> f64 {
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    // Where the ray is between two planes across an axis.
    let between = |axis: usize, low: f64, high: f64| {
        let (from, way) = (SCANNER_M[axis], [cos, sin][axis]);
        let [a, b] = [low, high].map(|plane| (plane - from) / way);
        [a.min(b), a.max(b)]
    };
    let room = |axis: usize, half: f64| between(axis, thicker_m - half, half - thicker_m)[1];
    let wall = room(0, 2.0).min(room(1, 1.5));
    let half = 0.2 + thicker_m;
    let [x, y] = [between(0, 0.9 - half, 0.9 + half), between(1, 0.3 - half, 0.3 + half)];
    let [enters, leaves] = [x[0].max(y[0]), x[1].min(y[1])];
    if enters < leaves && enters > 0.0 { wall.min(enters) } else { wall }
}

fn azimuths() -> impl Iterator<Item = f64> {
    (0..271).map(|ray| f64::from(ray) - 135.0)
}

/// The number of rays that were shortened.
fn shortened(printed: &str) -> usize {
    let (_, rest) = printed.split_once("the environment tripped the field: ").unwrap();
    rest.lines().next().unwrap().parse().unwrap()
}

/// Whether a check of a study with the field that was drawn warns that the environment trips it.
fn is_tripped(folder: &Folder, study: &str) -> bool {
    assert!(study.contains("# field"));
    folder.write("fed.toml", study.replace("# field", "field = { polygon = \"field.csv\", height_m = 2 }"));
    let outcome = perirobot(&["check", text(&folder.path("fed.toml"))]);
    let said = outcome.stdout + &outcome.stderr;
    assert_eq!(outcome.code, Some(0), "{said}");
    said.contains("the environment alone trips")
}

#[test]
fn a_reference_contour_is_that_of_the_room() {
    let (corners, printed) = drawn(&cell(), &["--reference"]);
    assert_eq!(corners.len(), 272, "a corner for each ray, and the scanner");
    assert_eq!(corners[271], [0.0, 0.0]);
    let mut behind = 0;
    for ([x, y], azimuth) in corners.iter().zip(azimuths()) {
        let [nearest, farthest] = [VOXEL_M, -VOXEL_M].map(|thicker| distance_m(azimuth, thicker));
        // Corners are rounded by a millimetre on each axis.
        let reach = x.hypot(*y);
        assert!(
            nearest - 0.002 < reach && reach <= farthest + 1e-9,
            "{azimuth}: {nearest} {reach} {farthest}"
        );
        behind += usize::from(farthest < distance_m(azimuth, -1.0));
    }
    assert!(behind > 0, "some rays end at the pillar");
    // Shoelace in f64.
    let next = corners.iter().cycle().skip(1);
    let area: f64 = corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0;
    assert!(printed.contains(&format!("reference contour of scanner:floor/post: {area:.2} m²")), "{printed}");
    assert!(
        printed.contains("limited by \"walls\"") && printed.contains("next: perirobot check"),
        "{printed}"
    );
}

#[test]
fn the_largest_field_is_not_tripped() {
    let folder = cell();
    let (corners, printed) = drawn(&folder, &[]);
    let mut shorter = 0;
    for ([x, y], azimuth) in corners.iter().zip(azimuths()) {
        let [nearest, farthest] = [VOXEL_M, -VOXEL_M].map(|thicker| distance_m(azimuth, thicker) - 0.1);
        let reach = x.hypot(*y);
        assert!(reach <= farthest + 1e-9, "{azimuth}: {reach} {farthest}");
        shorter += usize::from(reach <= nearest - 0.002);
    }
    assert!(shorter <= shortened(&printed), "{shorter} are shorter: {printed}");
    assert!(shortened(&printed) < 20, "{printed}");
    assert!(
        printed.contains("in the study: field = { polygon = \"fields/field.csv\", height_m = 2 }"),
        "{printed}"
    );
    assert!(!is_tripped(&folder, STUDY));
    let (near, _) = drawn(&folder, &["--at-most", "0.5", "--pose", "floor/post", "--sensor", "scanner"]);
    assert!(near.iter().all(|[x, y]| x.hypot(*y) <= 0.5 + 1e-9));
}

#[test]
fn rays_whose_field_is_tripped_are_shortened() {
    let mut all = 0;
    for (beams, place) in [(28, "[0.4, -0.5, 0.9]"), (46, "[0.9, 0.1, 0.9]"), (91, "[0.4, 0.1, 0.9]")] {
        let folder = cell();
        folder.edit("study.toml", "beams = 271", &format!("beams = {beams}"));
        folder.edit("cell.toml", "size_m = [0.4, 0.4, 1.6]", "size_m = [0.05, 0.4, 1.6]");
        folder.edit("cell.toml", "position_m = [0.9, 0.3, 0.9]", &format!("position_m = {place}"));
        let study = fs::read_to_string(folder.path("study.toml")).unwrap();
        // What the environment itself measures trips a field of it: a plate is between two rays.
        let (reference, _) = drawn(&folder, &["--reference"]);
        assert!(is_tripped(&folder, &study), "{place}");
        let (corners, printed) = drawn(&folder, &["--margin", "0"]);
        assert!(!is_tripped(&folder, &study), "{place}");
        let length = |corner: &[f64; 2]| corner[0].hypot(corner[1]);
        let shorter = reference.iter().zip(&corners).filter(|(all, own)| length(own) < length(all)).count();
        assert_eq!(shorter, shortened(&printed), "{printed}");
        assert!(reference.iter().zip(&corners).all(|(all, own)| length(own) <= length(all)));
        all += shorter;
    }
    assert!(all >= 3, "{all}");
}

#[test]
fn other_rings_count_up_to_the_height_of_the_field() {
    let folder = cell();
    let (level, _) = drawn(&folder, &[]);
    folder.edit("study.toml", "rings_deg = [0]", "rings_deg = [-20, 0, 45]");
    let study = fs::read_to_string(folder.path("study.toml")).unwrap();
    // The third ring meets the ceiling 1.48 m above the scanner, as far away.
    let (below, _) = drawn(&folder, &[]);
    assert!(below.iter().all(|[x, y]| x.hypot(*y) < 1.48 - 0.1 + VOXEL_M), "{below:?}");
    assert!(!is_tripped(&folder, &study));
    let low = "field = { polygon_m = [[0, -0.2], [0.4, -0.2], [0.4, 0.2], [0, 0.2]], height_m = 1.25 }";
    folder.edit("study.toml", "# field", low);
    assert_eq!(drawn(&folder, &[]).0, level, "the ceiling is above the field");
}

#[test]
fn a_field_that_is_there_keeps_its_height() {
    let folder = cell();
    let square = "field = { polygon_m = [[0, -0.2], [0.4, -0.2], [0.4, 0.2], [0, 0.2]], height_m = 1.25 }";
    folder.edit("study.toml", "# field", square);
    let (_, printed) = drawn(&folder, &[]);
    assert!(printed.contains("height_m = 1.25 }"), "{printed}");
}

#[test]
fn people_and_robots_are_left_out() {
    let (with, _) = drawn(&cell(), &[]);
    let without = cell();
    without.write("cell.toml", SCENE);
    assert_eq!(with, drawn(&without, &[]).0);
    let pillars = cell();
    pillars.edit("cell.toml", "role = \"human\"\n", "");
    assert!(with != drawn(&pillars, &[]).0, "the person would be in the way");
}

#[test]
fn what_moves_takes_the_least_of_all_moments() {
    let at = |places: &str| {
        let folder = cell();
        folder.edit("cell.toml", "position_m = [0.9, 0.3, 0.9]", places);
        let (corners, printed) = drawn(&folder, &["--reference"]);
        drawn(&folder, &["--margin", "0.02"]);
        assert!(!is_tripped(&folder, STUDY), "{places}");
        (corners, printed)
    };
    let (first, second) = (at("position_m = [0.9, 0.3, 0.9]").0, at("position_m = [-0.3, -0.9, 0.9]").0);
    let (both, printed) = at("snapshots = { position_m = [[0.9, 0.3, 0.9], [-0.3, -0.9, 0.9]] }");
    let length = |corner: &[f64; 2]| corner[0].hypot(corner[1]);
    let least: Vec<[f64; 2]> =
        first.iter().zip(&second).map(|(a, b)| if length(a) <= length(b) { *a } else { *b }).collect();
    assert_eq!(both, least);
    assert!(least != first && least != second);
    assert!(printed.contains("over 2 moments"), "{printed}");
}

/// The pillar is elsewhere in each snapshot: of a case only its own counts.
#[test]
fn the_field_of_a_case_is_drawn_at_its_moments() {
    let with = |places: &str, cases: &str| {
        let folder = cell();
        folder.edit("cell.toml", "position_m = [0.9, 0.3, 0.9]", places);
        folder.edit("study.toml", "# field", cases);
        folder
    };
    let [here, there] = ["[0.9, 0.3, 0.9]", "[-0.3, -0.9, 0.9]"];
    let alone = |place: &str| drawn(&with(&format!("position_m = {place}"), "# field"), &[]).0;
    let square = "polygon_m = [[0, -0.2], [0.4, -0.2], [0.4, 0.2], [0, 0.2]]";
    let cases = format!(
        "field = {{ {square}, height_m = 2 }}\n[[sensor.field_cases]]\nname = \"aside\"\nat = [1]\n{square}\n\
         [[sensor.field_cases]]\nname = \"both\"\nat = [1]\n{square}"
    );
    let folder = with(&format!("snapshots = {{ position_m = [{here}, {there}, {here}] }}"), &cases);
    let (usual, printed) = drawn(&folder, &[]);
    assert_eq!(usual, alone(here));
    assert!(printed.contains("field of scanner:floor/post over 2 of 3 moments"), "{printed}");
    let (aside, printed) = drawn(&folder, &["--case", "aside"]);
    assert_eq!(aside, alone(there));
    assert!(usual != aside);
    for line in [
        "field of scanner:floor/post, case \"aside\", over 1 of 3 moments",
        "in the study, in field_cases \"aside\": polygon = \"fields/field.csv\"",
    ] {
        assert!(printed.contains(line), "{printed}");
    }
    refused(&folder, &["field", "--case", "both"], &["its field case \"both\" counts at no moment"]);
    let unknown = "has no field case \"beside\": expected one of [\"aside\", \"both\"]";
    refused(&folder, &["field", "--case", "beside"], &[unknown]);
    refused(&cell(), &["field", "--case", "aside"], &["it has one field: write [[sensor.field_cases]]"]);
}

/// Of a field or a table that is wrong.
#[track_caller]
fn refused(folder: &Folder, command: &[&str], expected: &[&str]) {
    let study = folder.path("study.toml");
    let outcome = perirobot(&[&command[..1], &[text(&study)], &command[1..]].concat());
    let said = outcome.stdout + &outcome.stderr;
    assert_eq!(outcome.code, Some(2), "{said}");
    for fragment in expected {
        assert!(said.contains(fragment), "no {fragment:?} in {said}");
    }
}

#[test]
fn tables_of_corners_are_checked() {
    let square = "0,-0.2\n0.4,-0.2\n0.4,0.2\n0,0.2\n";
    for (table, expected) in [
        (format!("x_m,z_m\n{square}"), &["line 1: has the columns x_m,z_m", "the columns are x_m,y_m"][..]),
        ("x_m,y_m,z_m\n0,0,0\n".into(), &["line 1: has the columns x_m,y_m,z_m"]),
        (square.into(), &["line 1: has the columns 0,-0.2"]),
        ("# by hand\nx_m,y_m\n0,-0.2\n0.4,-0.2,1\n".into(), &["line 4: has 3 fields, the header 2"]),
        ("x_m,y_m\n0,-0.2\n0.4,NaN\n0.4,0.2\n".into(), &["line 3: NaN: must be metres within 1000"]),
        ("x_m,y_m\n0,-0.2\n0.4,five\n".into(), &["line 3: cell 2 is not a number"]),
        ("x_m;y_m\n0;1\n".into(), &["line 1: columns are separated by semicolons"]),
        (format!("x_m,y_m\n{}", "0,1\n".repeat(1001)), &["line 1002: is corner 1001: at most 1000"]),
        (
            "x_m,y_m\n0,-0.2\n0.4,0.2\n0.4,-0.2\n0,0.2\n".into(),
            &["edges that begin at corners 0 and 2", "cross"],
        ),
        ("x_m,y_m\n0,1\n".into(), &["1 corners bound no area"]),
    ] {
        let folder = cell();
        folder.edit("study.toml", "# field", "field = { polygon = \"hall/field.csv\", height_m = 1.5 }");
        fs::create_dir(folder.path("hall")).unwrap();
        folder.write("hall/field.csv", &table);
        let place = ["study.toml: sensor \"scanner\".field: polygon: ", "hall/field.csv: "];
        refused(&folder, &["check"], &[&place[..1], &place[1..], expected].concat());
    }
    for (keys, expected) in [
        ("height_m = 1.5", "sensor \"scanner\".field: no polygon: give one of polygon_m, polygon"),
        (
            "polygon = \"f.csv\", polygon_m = [[0, 0], [1, 0], [1, 1]], height_m = 1",
            "sensor \"scanner\".field: both polygon_m and polygon: give one polygon",
        ),
        ("polygon = \"none.csv\", height_m = 1", "none.csv: cannot be read"),
    ] {
        let folder = cell();
        folder.edit("study.toml", "# field", &format!("field = {{ {keys} }}"));
        refused(&folder, &["check"], &[expected]);
    }
    // Columns in the other order, and a mark of a spreadsheet before them.
    let folder = cell();
    folder.edit("study.toml", "# field", "field = { polygon = \"field.csv\", height_m = 1.5 }");
    folder.write("field.csv", "\u{feff}y_m,x_m\n-0.2,0\n-0.2,0.4\n0.2,0.4\n0.2,0\n");
    let study = folder.path("study.toml");
    let outcome = perirobot(&["check", text(&study)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

#[test]
fn scanners_without_a_level_field_are_refused() {
    for (from, to, command, expected) in [
        (
            "rings_deg = [0]",
            "rings_deg = [1, 2]",
            &["field"][..],
            "pose floor/post: has no ring at elevation 0",
        ),
        ("facing = [1, 0, 0]", "rpy_deg = [0, 3, 0]", &["field"], "is tilted, and a field is level"),
        (
            "",
            "",
            &["field", "--sensor", "scaner"],
            "--sensor \"scaner\": unknown name; expected one of [\"scanner\"]",
        ),
        (
            "",
            "",
            &["field", "--pose", "post"],
            "--pose \"post\": unknown name; expected one of [\"floor/post\"]",
        ),
        ("", "", &["field", "--out", "field.txt"], "--out field.txt: must end in .csv"),
        ("", "", &["field", "--margin=-1"], "--margin -1: must be from 0 to 100 metres"),
        ("", "", &["field", "--at-most", "0"], "--at-most 0: must be from 0.05 to 1000 metres"),
        (
            "",
            "",
            &["field", "--margin", "9"],
            "pose floor/post: the environment leaves no field: move the scanner",
        ),
        ("beams = 271", "beams = 2", &["field"], "a field needs more rays of the level ring"),
        ("kind = \"lidar\"", "kind = \"rgbd\"", &["field"], "study.toml"),
    ] {
        let folder = cell();
        folder.edit("study.toml", from, to);
        refused(&folder, command, &[expected]);
        assert!(!folder.names().iter().any(|name| name.ends_with(".csv")), "{:?}", folder.names());
    }
    let folder = Folder::new();
    folder.edit("study.toml", "", "[[sensor]]\nname = \"second\"\nkind = \"lidar\"\nrings_deg = [0]\nbeams = 90\nrange_m = [0.1, 5]\nsame_poses_as = \"lidar\"\n");
    refused(
        &folder,
        &["field"],
        &["several scanners: choose one by --sensor; expected one of [\"lidar\", \"second\"]"],
    );
    refused(
        &folder,
        &["field", "--sensor", "second"],
        &["sensor \"second\" has 3 poses: choose one by --pose"],
    );
    let pose = ["field", "--sensor", "camera", "--pose", "wall/0/0"];
    refused(&folder, &pose, &["is of kind \"rgbd\", which has no field"]);
}

#[test]
fn a_contour_of_many_rays_has_at_most_1000_corners() {
    for (fov, beams) in [("270", "2161"), ("360", "4000")] {
        let folder = cell();
        folder.edit("study.toml", "fov_deg = 270", &format!("fov_deg = {fov}"));
        folder.edit("study.toml", "beams = 271", &format!("beams = {beams}"));
        let (corners, printed) = drawn(&folder, &[]);
        assert!((600..=1000).contains(&corners.len()), "{}", corners.len());
        assert!(printed.contains("one corner for each "), "{printed}");
        assert_eq!(corners.contains(&[0.0, 0.0]), fov == "270");
        assert!(!is_tripped(&folder, &fs::read_to_string(folder.path("study.toml")).unwrap()));
    }
}
