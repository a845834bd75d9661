//! What sensors guard, as it is written.

use super::*;

const STUDY: &str = r#"[[sensor]]
name = "curtain"
model = "light-curtain"
box = { min_m = [-1.2, -0.25, 0.95], max_m = [1.2, -0.15, 1.9] }   # before the table
zone = { min_m = [-1.2, -0.15, 0], max_m = [1.2, 0.9, 2.0] }

[[sensor]]
name = "mat"
model = "safety-mat"                     # a metre wide

[[sensor]]
name = "scanner"
kind = "lidar"
[sensor.field]
height_m = 2
polygon_m = [
    [0, -0.4],                           # right
    [1.25, -0.4], [1.25, 0.4],
    [0, 0.4],
]

[[sensor]]
name = "table curtain"
kind = "gate"
[sensor.box]                             # its own table
min_m = [0, 0, 0]
max_m = [0.1, 1, 1]
[sensor.zone]
min_m = [0.1, 0, 0]
max_m = [1, 1, 1]
"#;

fn set(sensor: &str, shape: SensorShape) -> Edit {
    Edit::SetSensorShape { sensor: sensor.into(), shape }
}

fn corners(min_m: [f64; 3], max_m: [f64; 3]) -> Option<Corners> {
    Some(Corners { min_m, max_m })
}

#[track_caller]
fn assert_written(edit: Edit, replaced: &[[&str; 2]]) {
    let mut expected = STUDY.to_string();
    for [from, to] in replaced {
        assert!(expected.contains(from), "{from}");
        expected = expected.replacen(from, to, 1);
    }
    assert_eq!(edited(STUDY, &Known::default(), &[edit]), expected);
}

#[test]
fn the_keys_of_a_shape_are_written_in_place() {
    let moved = SensorShape::Gate {
        r#box: corners([-1.0, -0.25, 0.95], [1.4, -0.15, 1.9]),
        zone: corners([-1.0, -0.15, 0.0], [1.4004, 0.9, 2.0]),
    };
    assert_written(
        set("curtain", moved),
        &[
            [
                "box = { min_m = [-1.2, -0.25, 0.95], max_m = [1.2,",
                "box = { min_m = [-1, -0.25, 0.95], max_m = [1.4,",
            ],
            [
                "zone = { min_m = [-1.2, -0.15, 0], max_m = [1.2,",
                "zone = { min_m = [-1, -0.15, 0], max_m = [1.4,",
            ],
        ],
    );
    let zone = SensorShape::Gate { r#box: None, zone: corners([0.1, 0.0, 0.0], [2.0, 1.0, 1.0]) };
    assert_written(set("table curtain", zone), &[["max_m = [1, 1, 1]", "max_m = [2, 1, 1]"]]);
    // What the catalogue says becomes a key of the study.
    assert_written(
        set("mat", SensorShape::Pad { size_m: [1.2, 0.75] }),
        &[["# a metre wide\n", "# a metre wide\nsize_m = [1.2, 0.75]\n"]],
    );
    let field = [[0.0, -0.4], [1.25, -0.4], [1.5004, 0.35], [0.0, 0.4]];
    assert_written(
        set("scanner", SensorShape::Field { polygon_m: field.to_vec() }),
        &[["[1.25, 0.4],", "[1.5, 0.35],"]],
    );
    let box_of_mat = SensorShape::Gate { r#box: corners([0.0; 3], [1.0, 2.0, 3.0]), zone: None };
    let new = "box = { min_m = [0, 0, 0], max_m = [1, 2, 3] }\n";
    assert_written(set("mat", box_of_mat), &[["# a metre wide\n", &format!("# a metre wide\n{new}")]]);
}

#[test]
fn a_shape_that_is_none_is_refused() {
    let flat = SensorShape::Gate { r#box: corners([0.0, 0.0, 1.0], [1.0, 0.0, 2.0]), zone: None };
    let far = SensorShape::Field { polygon_m: vec![[f64::NAN, 0.0]] };
    for (sensor, shape, expected) in [
        (
            "curtain",
            flat,
            "sensor \"curtain\": box.max_m = [1.0, 0.0, 2.0]: must be above min_m on every axis",
        ),
        ("mat", SensorShape::Pad { size_m: [1.0, 0.0004] }, "sensor \"mat\": size_m = 0: must be above 0"),
        ("scanner", far, "sensor \"scanner\": field.polygon_m = [NaN, 0.0]"),
        ("mat", SensorShape::Field { polygon_m: vec![[0.0; 2]] }, "sensor \"mat\": field: is not written"),
        ("nobody", SensorShape::Pad { size_m: [1.0; 2] }, "sensor \"nobody\": is not in the study"),
    ] {
        let mut document = Document::new(STUDY.into());
        let error = document.apply(&set(sensor, shape), None, &Known::default()).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
        assert!(!document.is_changed());
    }
}

#[test]
fn a_curtain_of_the_catalogue_gets_a_zone() {
    let known = Known::catalogue();
    let model = known.models.iter().find(|model| model.name == "light-curtain").unwrap();
    let [(key, zone)] = &model.keys[..] else { panic!("{:?}", model.keys) };
    assert_eq!((key.as_str(), zone.as_str()), ("zone", "{ min_m = [0.05, -1, 0], max_m = [1.05, 1, 1.5] }"));
    assert!(known.models.iter().all(|one| one.keys.is_empty() || one.name == model.name));
}

#[test]
fn a_field_of_a_table_stays_there() {
    let study = STUDY.replacen("polygon_m = [", "polygon = \"field.csv\"\nother = [", 1);
    let mut document = Document::new(study);
    let moved = set("scanner", SensorShape::Field { polygon_m: vec![[0.0; 2]; 3] });
    let error = document.apply(&moved, None, &Known::default()).unwrap_err().to_string();
    assert!(error.starts_with("sensor \"scanner\": field.polygon: its corners are in a table"), "{error}");
}
