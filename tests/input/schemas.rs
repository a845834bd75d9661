//! The schemas of study and scene files: every file that ships keeps to them, and they find what they are there to find.

use std::fs;
use std::path::{Path, PathBuf};

use jsonschema::Validator;
use perirobot_study::input::{Overrides, Study, catalogue, schema};
use serde_json::Value;

fn root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn validator(schema: &str) -> Validator {
    jsonschema::validator_for(&serde_json::from_str(schema).unwrap()).unwrap()
}

/// What is wrong with a text of TOML.
fn errors(validator: &Validator, text: &str) -> Vec<String> {
    let json: Value = toml::from_str(text).unwrap();
    validator.iter_errors(&json).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

/// All TOML files that ship, and the templates of `init`.
fn files() -> Vec<PathBuf> {
    let (mut folders, mut files) = (vec![root("scenes"), root("src/cli/init")], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "toml") && !path.ends_with("Cargo.toml") {
                files.push(path);
            }
        }
    }
    files
}

#[test]
fn every_file_that_ships_keeps_to_its_schema() {
    let (study, scene) = (validator(schema::study()), validator(schema::scene()));
    let (mut studies, mut scenes) = (0, 0);
    for path in files() {
        let text = fs::read_to_string(&path).unwrap();
        let is_scene = text.contains("[[object]]");
        let found = errors(if is_scene { &scene } else { &study }, &text);
        assert!(found.is_empty(), "{}: {found:#?}", path.display());
        // Editors find the schema by the first line; `init` puts schemas beside what it writes.
        let kind = if is_scene { "scene" } else { "study" };
        let named = text.lines().next().and_then(|line| line.strip_prefix("#:schema "));
        let named = named.unwrap_or_else(|| panic!("{} names no schema in its first line", path.display()));
        assert!(named.ends_with(&format!("schemas/{kind}.schema.json")), "{}: {named}", path.display());
        let template = path.starts_with(root("src"));
        assert!(template || path.with_file_name(named).exists(), "{}: no {named}", path.display());
        *(if is_scene { &mut scenes } else { &mut studies }) += 1;
    }
    assert!(studies >= 8 && scenes >= 6, "{studies} studies, {scenes} scenes");
}

const STUDY: &str = r#"[[scene]]
file = "cell.toml"
[[region]]
name = "r"
sphere = { center_m = [0, 0, 1], radius_m = 1 }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [87, 58]
resolution_px = [16, 9]
range_m = [0.2, 3]
[[sensor.poses]]
name = "p"
x_m = { start = -1, stop = 1, step = 0.5 }
y_m = [0, 1]
z_m = 2
facing = [0, 1, 0]
"#;

#[test]
fn studies_are_found_good_or_wrong() {
    let study = validator(schema::study());
    assert_eq!(errors(&study, STUDY), Vec::<String>::new());
    let three = "kind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [16, 9]\nrange_m = [0.2, 3]";
    for good in [
        "model = \"realsense-d435\"",
        "model = \"realsense-d435\"\nkind = \"rgbd\"\nrange_m = [0.2, 9]",
        "kind = \"rgbd\"\ncamera_info = \"left.yaml\"\nrange_m = [0.2, 3]",
        "model = \"zed-2\"\ncamera_info = \"left.yaml\"",
        "kind = \"lidar\"\nresolution_deg = [0.2, 2]\nfov_deg = 270\nrings_deg = [0]\nrange_m = [0.1, 5]",
        "kind = \"cover\"\ninflation_m = [0.1]",
        "kind = \"known_robot\"",
    ] {
        let found = errors(&study, &STUDY.replace(three, good));
        assert!(found.is_empty(), "{good}: {found:#?}");
    }
    for wrong in [
        "model = \"realsense-d999\"",
        "kind = \"rgbd\"\nresolution_px = [16, 9]\nrange_m = [0.2, 3]",
        "kind = \"rgbd\"\nfov_deg = [87, 58, 1]\nresolution_px = [16, 9]\nrange_m = [0.2, 3]",
        "kind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [16, 9.5]\nrange_m = [0.2, 3]",
        "kind = \"rgbd\"\nfov_deg = \"wide\"\nresolution_px = [16, 9]\nrange_m = [0.2, 3]",
        "kind = \"camera\"\nfov_deg = [87, 58]\nresolution_px = [16, 9]\nrange_m = [0.2, 3]",
        "kind = \"lidar\"\nmodel = \"zed-2\"",
        "kind = \"known_robot\"\nrange_m = [0.2, 3]",
        "kind = \"pad\"",
    ] {
        assert!(!errors(&study, &STUDY.replace(three, wrong)).is_empty(), "{wrong}");
    }
    for (from, to) in [
        ("radius_m", "radius"),
        ("file = \"cell.toml\"", "path = \"cell.toml\""),
        ("name = \"r\"", "name = 3"),
        ("step = 0.5", "steps = 4"),
        ("facing = [0, 1, 0]", "facing = [0, 1]"),
        ("[[scene]]", "repeats = -1\n[[scene]]"),
        ("[[scene]]", "fusion = \"max\"\n[[scene]]"),
    ] {
        assert!(STUDY.contains(from));
        assert!(!errors(&study, &STUDY.replace(from, to)).is_empty(), "{to}");
    }
}

/// What the schema takes as spelled right is what the program reads: each device of the catalogue by its
/// name.
#[test]
fn every_device_is_known_to_both() {
    let study = validator(schema::study());
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cell.toml"), "[[object]]\nname = \"a\"\nbox = { size_m = [1, 1, 1] }\n")
        .unwrap();
    for model in catalogue::models() {
        let zone =
            if model.kind() == "gate" { "\nzone = { min_m = [0, 0, 0], max_m = [1, 1, 1] }" } else { "" };
        let three = "kind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [16, 9]\nrange_m = [0.2, 3]";
        let text = STUDY.replace(three, &format!("model = {:?}{zone}", model.name));
        assert_eq!(errors(&study, &text), Vec::<String>::new(), "{}", model.name);
        let path = folder.path().join("study.toml");
        fs::write(&path, text).unwrap();
        Study::load(&path, &Overrides::default()).unwrap_or_else(|e| panic!("{}: {e}", model.name));
    }
}

#[test]
fn scenes_are_found_wrong() {
    let scene = validator(schema::scene());
    let good = "[[object]]\nname = \"a\"\nbox = { size_m = [1, 1, 1] }\n";
    assert!(errors(&scene, good).is_empty());
    for more in
        ["colour = \"red\"", "role = \"person\"", "position_m = [1, 2]", "rpy_deg = 3", "optical = true"]
    {
        assert!(!errors(&scene, &format!("{good}{more}")).is_empty(), "{more}");
    }
}
