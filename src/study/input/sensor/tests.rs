//! What each kind of sensor is when a study says as little as it may.

use std::path::Path;

use super::*;
use crate::sensor::RayScale;
use perirobot_march::backend::Rays;

fn read(keys: &str, noiseless: bool) -> Sensor {
    let at = Place::new(Path::new("study.toml"));
    let sources = Sources::from_main(at.file);
    let context = SensorContext {
        seed: 1,
        noiseless,
        index: 0,
        earlier: &[],
        poses: 0,
        sources: &sources,
        models: &[],
        currency: None,
        scenes: &[],
        has_all_scenes: true,
        surfaces: &Surfaces::default(),
        line_of: &|_| None,
    };
    check(&at, toml::from_str(keys).unwrap(), &context).unwrap()
}

/// How a kind prints itself, with the keys that all kinds need.
fn kind(keys: &str) -> String {
    let pose = "poses = [{ name = \"p\", list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }] }]";
    format!("{:?}", read(&format!("name = \"s\"\n{pose}\n{keys}"), false).kind)
}

#[track_caller]
fn has(kind: &str, parts: &[&str]) {
    parts.iter().for_each(|part| assert!(kind.contains(part), "no {part:?} in {kind}"));
}

const RGBD: &str = "kind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [4, 3]\nrange_m = [0.3, 6]";
const LIDAR: &str = "kind = \"lidar\"\nfov_deg = [360, 30]\nresolution_deg = 30\nrange_m = [0.3, 6]";
const FIELD: &str = "field = { polygon_m = [[0, 0], [1, 0], [1, 1]], height_m = 1 }";

#[test]
fn cameras() {
    has(
        &kind(RGBD),
        &["shapes: [Points]", "keypoint_tolerance_m: 0.15", "no_return_is_free: false", "near_ignore_m: 0.0"],
    );
    let all = "representations = [\"box\", \"cylinders\", \"points\", \"spheres\"]";
    let shapes = "shapes: [Box, Cylinders { radius_m: 0.25 }, Points, Spheres { radius_m: 0.2 }]";
    has(&kind(&format!("{RGBD}\n{all}")), &[shapes]);
    let sized =
        format!("{RGBD}\n{all}\nspheres_radius_m = 0.1\ncylinders_radius_m = 0.3\nno_return = \"free\"");
    has(
        &kind(&sized),
        &["Cylinders { radius_m: 0.3 }", "Spheres { radius_m: 0.1 }", "no_return_is_free: true"],
    );
    let rgb = RGBD.replace("rgbd", "rgb") + "\nzone = { min_m = [0, 0, 0], max_m = [1, 1, 1] }";
    has(&kind(&rgb), &["min_keypoints: 1,", "keypoint_tolerance_m: 0.15", "otherwise_free: false"]);
    has(&kind(&format!("{rgb}\notherwise = \"free\"")), &["otherwise_free: true"]);
}

#[test]
fn scanners() {
    has(&kind(LIDAR), &["mount: Upright", "points: true", "field: None"]);
    has(
        &kind(&format!("{LIDAR}\n{FIELD}")),
        &["points: false", "field: Some(FieldSet { usual: ProtectiveField", "otherwise_free: true"],
    );
    let both = format!("{LIDAR}\n{FIELD}\nrepresentations = [\"field\", \"points\"]");
    has(&kind(&both), &["points: true", "field: Some(FieldSet"]);
    let unsure = FIELD.replace("height_m = 1", "height_m = 1, otherwise = \"unknown\"");
    has(&kind(&format!("{LIDAR}\n{unsure}")), &["otherwise_free: false"]);
}

#[test]
fn switches() {
    has(
        &kind("kind = \"pad\"\nsize_m = [1, 0.75]"),
        &["z_m: [0.0, 2.2]", "tare: true", "otherwise_free: true"],
    );
    let pad = "kind = \"pad\"\nsize_m = [1, 0.75]\nheight_m = 3\ntare = false\notherwise = \"unknown\"";
    has(&kind(pad), &["z_m: [0.0, 3.0]", "tare: false", "otherwise_free: false"]);
    let corners = "{ min_m = [0, 0, 0], max_m = [1, 1, 1] }";
    let gate = format!("kind = \"gate\"\nbox = {corners}\nzone = {corners}");
    has(&kind(&gate), &["otherwise_free: false"]);
    has(&kind(&format!("{gate}\notherwise = \"free\"")), &["otherwise_free: true"]);
}

/// Devices of the catalogue say what they emit, and a study says otherwise.
#[test]
fn light_is_that_of_the_device_unless_a_study_says_otherwise() {
    let pose = "poses = [{ name = \"p\", list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }] }]";
    let emits = |keys: &str| read(&format!("name = \"s\"\n{pose}\n{keys}"), false).emits;
    let light = |keys: &str, light: &str| emits(&format!("{keys}\nemits = {light:?}"));
    assert_eq!(emits(RGBD), None);
    assert_eq!(light(RGBD, "structured_light").as_deref(), Some("structured_light"));
    let helios = "model = \"lucid-helios-2\"";
    assert_eq!(emits(helios).as_deref(), Some("tof"));
    assert_eq!(light(helios, "tof_850nm").as_deref(), Some("tof_850nm"));
    assert_eq!(light(helios, "none"), None);
    assert_eq!(emits("model = \"sick-nanoscan3\"").as_deref(), Some("lidar"));
    assert_eq!(emits("model = \"realsense-d435\""), None);
    let at = Place::new(Path::new("study.toml"));
    let kind = read(&format!("name = \"s\"\n{pose}\nmodel = \"safety-mat\""), false).kind;
    assert_eq!(super::emits(&at, Some("none".into()), &*kind).unwrap(), None);
    let error = super::emits(&at, Some("tof".into()), &*kind).unwrap_err().to_string();
    assert!(error.contains("emits = \"tof\": belongs to a sensor whose field of view is known"), "{error}");
    assert!(error.contains("not to kind = \"pad\": remove it"), "{error}");
    for wrong in ["", "ToF", "lidar 905"] {
        let error = super::emits(&at, Some(wrong.into()), &*kind).unwrap_err().to_string();
        assert!(error.contains("must name a kind of light by small letters, digits and _"), "{error}");
    }
}

#[test]
fn what_has_no_poses_has_candidates_all_the_same() {
    let names = |keys: &str| -> Vec<(String, Setting)> {
        let sensor = read(&format!("name = \"s\"\n{keys}"), false);
        sensor.candidates.into_iter().map(|c| (c.name, c.setting)).collect()
    };
    let cover = names("kind = \"cover\"\ninflation_m = [0.30, 0.1]");
    assert_eq!(
        cover,
        [("0.3".to_string(), Setting::Inflation(0.3)), ("0.1".to_string(), Setting::Inflation(0.1))]
    );
    assert_eq!(names("kind = \"known_robot\""), [("known".to_string(), Setting::Fixed)]);
    let corners = "{ min_m = [0, 0, 0], max_m = [1, 1, 1] }";
    assert_eq!(
        names(&format!("kind = \"gate\"\nbox = {corners}\nzone = {corners}")),
        [("here".to_string(), Setting::Fixed)]
    );
}

#[test]
fn noise_is_switched_off_for_all() {
    let pose = "poses = [{ name = \"p\", list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }] }]";
    let cover = "kind = \"cover\"\ninflation_m = [0.1]".to_string();
    for keys in [format!("{RGBD}\n{pose}"), format!("{LIDAR}\n{pose}"), cover] {
        let noisy = |noiseless| {
            let sensor = read(&format!("name = \"s\"\nnoise = {{ std_m = 0.02 }}\n{keys}"), noiseless);
            let rays = sensor.kind.rays(&RayScale::new(0.1, false));
            let drawn = rays.map_or(sensor.kind.is_noisy(), |rays: Rays| !rays.noise.unit_q12.is_empty());
            assert_eq!(sensor.kind.is_noisy(), drawn);
            drawn
        };
        assert_eq!([noisy(false), noisy(true)], [true, false], "{keys}");
    }
}

#[test]
fn a_table_of_rays_gives_directions_of_any_length() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("study.toml");
    let table = "# a ring\nx, y, z\n2, 0, 0\n0,-0.5,0\n\n3,0,4\n";
    std::fs::write(folder.path().join("ring.csv"), table).unwrap();
    let at = Place::new(&file);
    let keys = "name = \"s\"\nkind = \"rays\"\ndirections = \"ring.csv\"\nrange_m = [0, 1]\n\
                poses = [{ name = \"p\", list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }] }]";
    let sources = Sources::from_main(&file);
    let context = SensorContext {
        seed: 1,
        noiseless: false,
        index: 0,
        earlier: &[],
        poses: 0,
        sources: &sources,
        models: &[],
        currency: None,
        scenes: &[],
        has_all_scenes: true,
        surfaces: &Surfaces::default(),
        line_of: &|_| None,
    };
    let sensor = check(&at, toml::from_str(keys).unwrap(), &context).unwrap();
    let rays = sensor.kind.rays(&RayScale::new(0.1, false)).unwrap();
    // 0.6 · 2¹⁵ = 19660.8 and 0.8 · 2¹⁵ = 26214.4.
    assert_eq!(*rays.dirs_q15, [[32_768, 0, 0], [0, -32_768, 0], [19_661, 0, 26_214]]);
    assert_eq!(rays.gates.range_max_q16, 10 << 16);
}

#[test]
fn poses_of_another_sensor_are_the_same_poses() {
    let at = Place::new(Path::new("study.toml"));
    let pose =
        "poses = [{ name = \"p\", list = [{ position_m = [0, 0, 1], facing = [1, 0, 0], tilt_deg = -30 }] }]";
    let first = read(&format!("name = \"first\"\n{RGBD}\n{pose}"), false);
    let like = format!("name = \"second\"\n{RGBD}\nsame_poses_as = \"first\"");
    let (earlier, sources) = (std::slice::from_ref(&first), Sources::from_main(at.file));
    let context = SensorContext {
        seed: 1,
        noiseless: false,
        index: 1,
        earlier,
        poses: 1,
        sources: &sources,
        models: &[],
        currency: None,
        scenes: &[],
        has_all_scenes: true,
        surfaces: &Surfaces::default(),
        line_of: &|_| None,
    };
    let second = check(&at, toml::from_str(&like).unwrap(), &context).unwrap();
    assert_eq!(first.candidates, second.candidates);
    assert_eq!(first.candidates[0].name, "p/0");
}

#[test]
fn lengths_beyond_all_reason_are_told() {
    let keys = |text: &str| toml::from_str::<Table>(text).unwrap();
    let told = odd_lengths(&keys("spheres_radius_m = 1000\nsize_m = [1, 750.5]\nheight_m = 2"));
    let expected = [
        "spheres_radius_m = 1000: is more than 2 m meant? Lengths are metres",
        "size_m = [1, 750.5]: is more than 50 m meant? Lengths are metres",
    ];
    assert_eq!(told, expected);
    assert_eq!(odd_lengths(&keys("spheres_radius_m = 0.2\nsize_m = 1\nheight_m = \"x\"")), [""; 0]);
}

/// The azimuths and elevations of a LIDAR in degrees: first, last and number of each.
fn angles(keys: &str) -> [(f64, f64, usize); 2] {
    let kind = kind(&format!("kind = \"lidar\"\nrange_m = [0.1, 6]\n{keys}"));
    ["azimuths_rad: [", "elevations_rad: ["].map(|list| {
        let (_, after) = kind.split_once(list).unwrap();
        let (inside, _) = after.split_once(']').unwrap();
        let all: Vec<f64> = inside.split(", ").map(|x| x.parse::<f64>().unwrap().to_degrees()).collect();
        let round = |x: f64| (x * 1e6).round() / 1e6;
        (round(all[0]), round(all[all.len() - 1]), all.len())
    })
}

#[test]
fn rings_and_beams_by_number_have_both_ends() {
    let vlp = "elevation_deg = [-15, 15]\nrings = 16\nresolution_deg = 10";
    assert_eq!(angles(vlp), [(-180.0, 170.0, 36), (-15.0, 15.0, 16)]);
    assert_eq!(angles("fov_deg = [360, 30]\nrings = 16\nbeams = 36"), angles(vlp));
    assert_eq!(angles("fov_deg = 270\nrings_deg = [0]\nbeams = 1081")[0], (-135.0, 135.0, 1081));
    assert_eq!(
        angles("elevation_deg = [-5, 0]\nrings = 2\nbeams = 1"),
        [(-180.0, -180.0, 1), (-5.0, 0.0, 2)]
    );
    // By step the end is left out, which is told where it lies on a step.
    let by_step = "elevation_deg = [-15, 15]\nresolution_deg = [10, 2]";
    assert_eq!(angles(by_step)[1], (-15.0, 13.0, 15));
    let told = |keys: &str| {
        let pose = "poses = [{ name = \"p\", list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }] }]";
        read(&format!("name = \"s\"\nkind = \"lidar\"\nrange_m = [0.1, 6]\n{pose}\n{keys}"), false).warnings
    };
    assert_eq!(
        told(by_step),
        [
            "elevation_deg by steps of 2 leaves its end out: 15 angles from -15 to 13. If the device has both ends, write rings = 16 \
          instead of the step"
        ]
    );
    assert!(told("fov_deg = 270\nrings_deg = [0]\nresolution_deg = 0.25")[0].contains("write beams = 1081"));
    let vertical = &told("fov_deg = [360, 30]\nresolution_deg = [1, 2]")[0];
    assert!(
        vertical.contains("15 angles from -15 to 13") && vertical.contains("write rings = 16"),
        "{vertical}"
    );
    let rounded = &told("elevation_deg = [-60, 60]\nresolution_deg = 0.2")[0];
    assert!(rounded.contains("600 angles from -60 to 59.8. If"), "{rounded}");
    for silent in [
        vlp,
        "fov_deg = [360, 90]\nresolution_deg = [4, 6]",
        "elevation_deg = [45, 90]\nresolution_deg = 0.7",
        "rings_deg = [0]\nresolution_deg = 1",
    ] {
        assert_eq!(told(silent), [""; 0], "{silent}");
    }
}

#[test]
fn a_device_that_a_study_contradicts_is_named() {
    let pose = "poses = [{ name = \"p\", list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }] }]";
    let sensor = read(
        &format!(
            "name = \"s\"\nmodel = \"realsense-d435\"\nfov_deg = [58, 87]\nresolution_px = [424, 240]\n{pose}"
        ),
        false,
    );
    assert_eq!(sensor.warnings, ["fov_deg = [58, 87]: swapped; realsense-d435 has [87, 58]"]);
    assert_eq!(sensor.thinned.unwrap(), "casts about one in 4.0 of the rays of realsense-d435");
    has(&format!("{:?}", sensor.kind), &["along: Axis"]);
    has(&kind(&format!("{RGBD}\nrange_along = \"axis\"")), &["along: Axis"]);
    has(&kind(RGBD), &["along: Ray"]);
}
