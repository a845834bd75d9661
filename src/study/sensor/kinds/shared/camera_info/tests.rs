//! What files of ROS say, by hand: f = 320 across 640 pixels are 90 degrees, 320 down 480 are 73.74.

use super::*;

/// As `camera_calibration` writes it; the centre of 640 × 480 pixels is (319.5, 239.5).
const CALIBRATED: &str = "\
image_width: 640
image_height: 480
camera_name: left
camera_matrix:
  rows: 3
  cols: 3
  data: [320.0, 0, 319.5, 0, 320, 239.5, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.0, 0, 0, 0, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
";

/// As `ros2 topic echo --once` prints it.
const ECHOED: &str = "\
header:
  stamp:
    sec: 12
    nanosec: 500
  frame_id: left
height: 480
width: 640
distortion_model: plumb_bob
d:
- 0.0
- 0.0
- 0.0
- 0.0
- 0.0
k:
- 320.0
- 0.0
- 319.5
- 0.0
- 320.0
- 239.5
- 0.0
- 0.0
- 1.0
binning_x: 0
binning_y: 0
roi:
  x_offset: 0
  y_offset: 0
  height: 0
  width: 0
  do_rectify: false
---
";

fn resolve_file(text: &str, more: &str) -> Result<(Table, Vec<String>), String> {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study.toml");
    std::fs::write(folder.path().join("left.yaml"), text).unwrap();
    let at = Place::new(&study).key("sensor \"camera\"");
    let mut keys: Table = toml::from_str(&format!("camera_info = \"left.yaml\"\n{more}")).unwrap();
    let said = resolve(&at, &mut keys, &Sources::from_main(&study)).map_err(|e| e.to_string())?;
    Ok((keys, said))
}

fn resolve_edited(from: &str, to: &str) -> Result<(Table, Vec<String>), String> {
    assert!(CALIBRATED.contains(from), "{from}");
    resolve_file(&CALIBRATED.replace(from, to), "")
}

#[test]
fn both_ways_of_writing_it_give_the_same_camera() {
    let old = ECHOED.replace("\nd:", "\nD:").replace("\nk:", "\nK:");
    // As Windows' editors and OpenCV begin a file, and keys from elsewhere in it.
    let marked = format!("\u{feff}{CALIBRATED}");
    let of_opencv = CALIBRATED.replace("matrix:\n", "matrix: !!opencv-matrix\n");
    let of_opencv = of_opencv.replace("[320.0, 0, 319.5,", "[ 3.2e+02, 0., 319.5,\n      ");
    assert!(of_opencv.contains("!!opencv") && of_opencv.contains("3.2e+02"));
    let of_opencv = format!("%YAML:1.0\n---\n{of_opencv}");
    let merged = CALIBRATED.replace(
        "image_width: 640\n",
        "size: &size { image_width: 640, image_height: 9 }\n<<: [*size, { image_width: 1 }]\n",
    );
    assert_ne!(merged, CALIBRATED);
    // PyYAML names a list that it meets again.
    let named = ECHOED.replace("\nk:", "\nk: &id001").replace("---\n", "p: *id001\nK: *id001\n---\n");
    let named = named.replace("\nk:", "\nrows:");
    let quoted = CALIBRATED.replace("image_width", "\"image_width\"").replace("plumb_bob", "'plumb_bob'");
    assert!(old.contains("\nK:") && named.contains("K: *id001") && quoted.contains("'plumb_bob'"));
    // Later documents are not read.
    let followed = format!("---\n---\n{ECHOED}width: [");
    // By hand: a list whose next line is not indented, a tab after a colon, a number in another base.
    let flat = CALIBRATED.replace("data: [320.0, 0, 319.5, 0,", "data: [320.0, 0, 319.5,\n0,");
    let tabbed = CALIBRATED.replace("image_width: 640", "image_width:\t640");
    let hexadecimal = CALIBRATED.replace("640", "0x280");
    assert!(flat.contains("\n0,") && tabbed.contains('\t') && hexadecimal.contains("0x280"));
    let by_hand = [&flat, &tabbed, &hexadecimal].map(String::as_str);
    let written = [CALIBRATED, ECHOED, &old, &marked, &of_opencv, &merged, &named, &quoted, &followed];
    for text in written.into_iter().chain(by_hand) {
        let (keys, said) = resolve_file(text, "").unwrap();
        assert_eq!(said, Vec::<String>::new());
        let fov: Vec<f64> = keys["fov_deg"].clone().try_into().unwrap();
        assert!((fov[0] - 90.0).abs() < 1e-12, "{fov:?}");
        assert!((fov[1] - 73.739_795_291_688_04).abs() < 1e-12, "{fov:?}");
        assert_eq!(keys["resolution_px"], Value::try_from([640, 480]).unwrap());
        assert!(!keys.contains_key(KEY));
    }
}

/// A hundredth of 640 px is 6.4: 6 are passed over, 20 are told (atan(20/320) = 3.58°), 70 are refused.
#[test]
fn a_principal_point_off_centre_is_told_or_refused() {
    assert!(resolve_edited("319.5", "325.5").unwrap().1.is_empty());
    let (_, said) = resolve_edited("319.5", "339.5").unwrap();
    assert_eq!(said.len(), 1);
    for part in ["left.yaml", "+20.0 px across and +0.0 px down", "by 3.6 and 0.0 degrees"] {
        assert!(said[0].contains(part), "{said:?}");
    }
    let error = resolve_edited("239.5", "169.5").unwrap_err();
    for part in
        ["sensor \"camera\": camera_info: ", "left.yaml", "-70.0 px down", "more than 10 %", "rectified"]
    {
        assert!(error.contains(part), "{error}");
    }
}

/// At a corner r² = (319.5² + 239.5²) / 320² = 1.5570, so k1 moves it by k1 · r³ · 320 = k1 · 621.7 px.
#[test]
fn a_lens_that_bends_is_told_or_refused() {
    assert!(resolve_edited("[0.0, 0, 0, 0, 0]", "[0.01, 0, 0, 0, 0]").unwrap().1.is_empty());
    let (_, said) = resolve_edited("[0.0, 0, 0, 0, 0]", "[-0.05, 0, 0, 0, 0]").unwrap();
    assert!(said[0].contains("by up to 31.1 px (4.9 % of the width)"), "{said:?}");
    let error = resolve_edited("[0.0, 0, 0, 0, 0]", "[-0.3, 0, 0, 0, 0]").unwrap_err();
    assert!(error.contains("moves pixels by up to 186.5 px (29.1 % of the width)"), "{error}");
    assert!(resolve_edited("[0.0, 0, 0, 0, 0]", "[]").unwrap().1.is_empty());
}

#[test]
fn what_is_no_camera_info_is_refused_by_file_key_and_cure() {
    for (from, to, expected) in [
        ("image_width: 640\n", "", "missing field `image_width`"),
        (
            "image_width: 640",
            "image_width: wide",
            "image_width: found \"wide\", wanted a whole number from 0",
        ),
        ("image_width: 640", "image_width: ~", "missing field `image_width`"),
        ("image_width: 640", "image_width: \"640\"", "image_width: found \"640\", wanted a whole number"),
        (
            "image_width: 640",
            "image_width: 640\nimage_width: 641",
            "duplicate mapping key `image_width` is not allowed here at line 2, column 1",
        ),
        ("image_width: 640", "image_width: -1", "image_width: found -1, wanted a whole number from 0"),
        ("image_width: 640", "image_width: 0", "are 0 and 480: must be above 0"),
        (
            "[320.0, 0, 319.5, 0, 320, 239.5, 0, 0, 1]",
            "[320, 0, 1]",
            "camera_matrix has 3 numbers: must have 9",
        ),
        ("[320.0, 0, 319.5, 0, 320,", "[0, 0, 319.5, 0, 0,", "never calibrated has zeros"),
        (
            "[320.0, 0, 319.5",
            "[.nan, 0, 319.5",
            "camera_matrix: found \".nan\", wanted a number; a camera_info",
        ),
        ("[320.0, 0, 319.5", "[320.0, 2, 319.5", "camera_matrix[1] = 2: must be 0"),
        (
            "plumb_bob",
            "equidistant",
            "distortion_model = \"equidistant\": is no pinhole; name the camera_info",
        ),
        ("[0.0, 0, 0, 0, 0]", "[.inf]", "distortion_coefficients: found \".inf\", wanted a number"),
        ("[0.0, 0, 0, 0, 0]", "[1e999]", "distortion_coefficients: found \".inf\", wanted a number"),
        ("[0.0, 0, 0, 0, 0]", "[0, ~]", "distortion_coefficients: found \"\", wanted a number"),
        ("[0.0, 0, 0, 0, 0]", "[0, 0, 0, 0, 0, 0, 0, 0, 1]", "at most 8 are known"),
        ("camera_name: left", "binning_x: 2", "binning_x = 2, binning_y = 0: must be 0 or 1"),
        (
            "camera_name: left",
            "roi: { width: 320, height: 240 }",
            "roi is 320 x 240: must be the whole image",
        ),
        ("camera_name: left", "camera_name: [", "did not find expected ',' or '}' at line 5, column 7"),
        ("camera_name: left", "[1, 2]: left", "expected string scalar at line 3, column 1"),
        (
            "camera_name: left",
            "<<: 1",
            "merge value must be mapping or sequence of mappings at line 3, column 5",
        ),
        (
            "camera_name: left",
            "all: &all [*all]",
            "Recursive reference not allowed here at line 3, column 12",
        ),
        ("camera_name: left", "camera_name: *left", "reference to unknown value at line 3, column 14"),
    ] {
        let error = resolve_edited(from, to).map(drop).unwrap_err();
        for part in ["study.toml: sensor \"camera\": camera_info: ", "left.yaml: ", expected] {
            assert!(error.contains(part), "no {part:?} in {error}");
        }
        assert!(!error.contains('\n'), "{error}");
    }
    for (text, expected) in [
        ("", "left.yaml: is empty; a camera_info has"),
        ("---\n~\n---\n", "left.yaml: is empty"),
        ("- 640\n- 480\n", "left.yaml: is not a table of keys"),
        ("plain", "left.yaml: is not a table of keys"),
    ] {
        let error = resolve_file(text, "").unwrap_err();
        assert!(error.contains(expected), "no {expected:?} in {error}");
    }
    let refused_soon = |text: String, expected: &str| {
        let error = resolve_file(&text, "").unwrap_err();
        assert!(error.contains(expected) && error.len() < 500, "no {expected:?} in {error}");
    };
    for (deep, expected) in [
        ("[", "recursion limit exceeded at line 18, column 258"),
        ("- ", "Depth { depth: 65 }"),
        ("? ", "Depth { depth: 65 }"),
    ] {
        refused_soon(format!("{CALIBRATED}more:\n  {}", deep.repeat(100_000)), expected);
    }
    let nested = |deep: usize| format!("{CALIBRATED}more: {}1{}\n", "[".repeat(deep), "]".repeat(deep));
    assert!(resolve_file(&nested(63), "").is_ok());
    refused_soon(nested(64), "Depth { depth: 65 }");
    // Each line stands for ten of the line before.
    let line = |n: usize| format!("l{n}: &l{n} [{}]\n", vec![format!("*l{}", n - 1); 10].join(","));
    let laughs = (1..30).map(line).collect::<String>();
    refused_soon(format!("{CALIBRATED}l0: &l0 ha\n{laughs}"), "total_replayed_events=10001 > 10000");
    // A long key and a long text that are copied.
    for (long, times) in [(format!("{{ {}: 1 }}", "k".repeat(900)), 3000), ("ha".repeat(1000), 1100)] {
        let copied = format!("{CALIBRATED}l0: &l0 {long}\nall: [{}*l0]\n", "*l0, ".repeat(times));
        refused_soon(copied, "ScalarBytes { total_scalar_bytes: 20");
    }
    let large = format!("{CALIBRATED}more: {}\n", "ha".repeat(1 << 19));
    refused_soon(large, "left.yaml: has 1048");
    let twice = resolve_file(CALIBRATED, "fov_deg = [90, 60]").unwrap_err();
    assert!(twice.contains("sensor \"camera\": both camera_info and fov_deg: the file gives it"), "{twice}");
}
