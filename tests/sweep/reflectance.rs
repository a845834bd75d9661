//! Dark objects: how far a scanner detects people and walls by the light that they reflect, and what cannot be said of
//! it. Random cells compare all backends.

use crate::common::program::{Edit, Folder, perirobot, refused, rows, text};

/// A corridor along x. A person stands 3 m before the scanner, then 5 m; a wall closes the corridor at 8 m.
const CELL: &str = "\
[[object]]
name = \"floor\"
plane = { size_m = [9, 2] }
position_m = [4, 0, 0]
[[object]]
name = \"wall\"
box = { size_m = [0.2, 2, 1.8] }
position_m = [8, 0, 0.9]
[[object]]
name = \"person\"
role = \"human\"
box = { size_m = [0.4, 0.4, 1.7] }
position_m = [3, 0, 0.95]
[object.snapshots]
position_m = [[3, 0, 0.95], [5, 0, 0.95]]
";

const STUDY: &str = "\
min_hits = 1
[grid]
voxel_size_m = 0.1
[[scene]]
file = \"cell.toml\"
[[region]]
name = \"corridor\"
box = { min_m = [0.5, -1, 0.1], max_m = [8.5, 1, 1.7] }
[[sensor]]
name = \"scanner\"
kind = \"lidar\"
rings_deg = [0]
resolution_deg = 1
fov_deg = 60
range_m = [0.1, 9]
reflectance_ranges_m = [[0.018, 4.0], [0.9, 10]]
[[sensor.poses]]
name = \"post\"
list = [{ position_m = [0, 0, 1.05], facing = [1, 0, 0] }]
";

fn folder(edits: &[Edit]) -> Folder {
    let folder = Folder::new();
    folder.write("study.toml", STUDY);
    folder.write("cell.toml", CELL);
    edits.iter().for_each(|(file, from, to)| folder.edit(file, from, to));
    folder
}

/// Of both moments, the person's voxels that are hit, the other occupied ones of the corridor that are labelled, and the free
/// ones that are; both backends say the same.
fn counts(edits: &[Edit]) -> [[u32; 3]; 2] {
    let folder = folder(edits);
    let study = folder.path("study.toml");
    let [oracle, cpu] = ["oracle", "cpu"].map(|backend| {
        let out = folder.path(backend);
        let outcome = perirobot(&["sweep", text(&study), "--backend", backend, "--out", text(&out)]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let each = rows(&out.join("results.csv"));
        let count = |moment: usize, column: &str| each[moment][column].parse::<u32>().unwrap();
        [0, 1].map(|moment| {
            let [tp, human, free] = ["tp", "tp_human", "tn"].map(|column| count(moment, column));
            [human, tp - human, free]
        })
    });
    assert_eq!(oracle, cpu);
    cpu
}

#[test]
fn the_dark_are_detected_less_far() {
    // 0.018 without a value: up to 4 m.
    let [near, far] = counts(&[]);
    assert!(near[0] > 0 && far[0] == 0, "{near:?} {far:?}");
    assert!(near[1] > 0 && far[1] > 0, "the wall is bright: {near:?} {far:?}");
    // A tag of a person darkens what it lies on.
    let tagged = (
        "cell.toml",
        "name = \"person\"\nrole = \"human\"",
        "name = \"person\"\nrole = \"human\"\ntag_only = true",
    );
    let dummy = "\n[[object]]\nname = \"dummy\"\nbox = { size_m = [0.4, 0.4, 1.7] }\n[object.snapshots]\n\
                 position_m = [[3, 0, 0.95], [5, 0, 0.95]]\n";
    assert_eq!(counts(&[tagged, ("cell.toml", "", dummy)]), [near, far]);
    // As bright as the wall, the person is detected at both places, and as before at the first.
    let bright = ("cell.toml", "role = \"human\"", "role = \"human\"\nreflectance = 0.9");
    let [bright_near, bright_far] = counts(&[bright]);
    assert_eq!(bright_near, near);
    assert!(bright_far[0] > 0, "{bright_far:?}");
    // The square root of 0.05 / 0.018 is 1.67, so that it is 6.7 m on the square root, and 4.0 · 2.5^0.261 = 5.08 m
    // between the two.
    let cloth = ("cell.toml", "role = \"human\"", "role = \"human\"\nreflectance = 0.05");
    assert_eq!(counts(&[cloth]), [bright_near, bright_far]);
    // The front of the person at 5 m is 4.8 m away.
    let darker = ("cell.toml", "role = \"human\"", "role = \"human\"\nreflectance = 0.035");
    assert_eq!(counts(&[darker]), [near, far]);
    // Of a dark wall nothing comes back, so the space before it stays unknown.
    let dark_wall = ("cell.toml", "name = \"wall\"", "name = \"wall\"\nreflectance = 0.018");
    let [dark_near, dark_far] = counts(&[dark_wall]);
    assert!(
        dark_near[1] == 0 && dark_near[2] < near[2] && dark_far == [0, 0, 0],
        "{dark_near:?} {dark_far:?}"
    );
}

/// Boxes of these reflectances that no ray comes to.
fn behind_the_wall(reflectances: &[&str]) -> String {
    let a_box = |(number, reflectance): (usize, &&str)| {
        format!(
            "\n[[object]]\nname = \"box {number}\"\nbox = {{ size_m = [0.1, 0.1, 0.1] }}\nposition_m = [8.4, 0, 0.3]\n\
             reflectance = {reflectance}\n"
        )
    };
    reflectances.iter().enumerate().map(a_box).collect()
}

/// Whatever the number of the person's shade among others, its range is the same.
#[test]
fn seven_shades_are_told_apart() {
    let of = |reflectance: &str, others: &[&str]| {
        let own = format!("role = \"human\"\nreflectance = {reflectance}");
        counts(&[("cell.toml", "role = \"human\"", &own), ("cell.toml", "", &behind_the_wall(others))])
    };
    let [dark, bright] = ["0.035", "0.9"].map(|reflectance| of(reflectance, &[]));
    assert_ne!(dark, bright);
    let darker = ["0.02", "0.021", "0.022", "0.023", "0.024"];
    let brighter = ["0.91", "0.92", "0.93", "0.94", "0.95"];
    // With the person's own and the 0.018 of people without a value they are seven.
    for count in 0..=5 {
        let others = [&darker[..count], &brighter[count..]].concat();
        assert_eq!(of("0.035", &others), dark, "{others:?}");
        assert_eq!(of("0.9", &others), bright, "{others:?}");
    }
}

#[test]
fn without_ranges_nobody_is_dark() {
    let plain = ("study.toml", "reflectance_ranges_m = [[0.018, 4.0], [0.9, 10]]\n", "");
    let dark = ("cell.toml", "role = \"human\"", "role = \"human\"\nreflectance = 0.001");
    assert_eq!(counts(&[plain]), counts(&[plain, dark]));
    assert!(counts(&[plain])[1][0] > 0);
}

#[test]
fn reflectance_that_cannot_be() {
    let wrong = |edits: &[Edit], expected: &[&str]| refused(&folder(&[]), edits, expected);
    let person = |line: &'static str| ("cell.toml", "role = \"human\"", line);
    wrong(
        &[person("role = \"human\"\nreflectance = 40")],
        &["cell.toml: object \"person\".reflectance = 40", "must be a share from 0 to 1: 40 % is 0.4"],
    );
    wrong(&[person("role = \"human\"\nreflectance = 0")], &["reflectance = 0", "above 0 and up to 1"]);
    let ranges = |line: &'static str| ("study.toml", "[[0.018, 4.0], [0.9, 10]]", line);
    let sensor = "study.toml: sensor \"scanner\".reflectance_ranges_m = ";
    wrong(&[ranges("[[10, 4.0]]")], &[sensor, "10 % is 0.1"]);
    wrong(&[ranges("[]")], &[sensor, "one to three pairs"]);
    wrong(&[ranges("[[0.9, 10], [0.1, 4]]")], &[sensor, "must ascend"]);
    wrong(&[ranges("[[0.1, -4]]")], &[sensor, "a range in metres, above 0"]);
    wrong(
        &[ranges("[[1.0, 5]]")],
        &[sensor, "makes 5.00 m for what reflects all light, below the sensor's range of 9 m"],
    );
    let many = behind_the_wall(&["0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7"]);
    wrong(
        &[("cell.toml", "", &many)],
        &[
            "its objects have 8 different values of reflectance: 0.018, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7",
            "at most 7",
        ],
    );
}
