//! Every device is a sensor as it stands, and what a study writes goes before it.

use std::path::Path;

use super::*;
use crate::input::poses::Surfaces;
use crate::input::sensor;
use crate::sensor::{RayScale, SaidOfNoise};
use perirobot_scene::source::Sources;

const STUDY: &str = "study.toml";

fn place() -> Place<'static> {
    Place::new(Path::new(STUDY))
}

fn resolve_keys(keys: &str) -> Result<Table, String> {
    let mut keys: Table = toml::from_str(keys).unwrap();
    resolve(&place(), &mut keys, &[], None).map_err(|e| e.to_string())?;
    Ok(keys)
}

#[test]
fn every_device_is_a_sensor_with_a_source() {
    let mut names = std::collections::HashSet::new();
    for model in models() {
        assert!(names.insert(&model.name), "{} stands twice", model.name);
        for said in [&model.title, &model.source, &model.note] {
            assert!(said.len() > 20, "{}: {said:?}", model.name);
        }
        assert!(model.url.starts_with("https://"), "{}: {}", model.name, model.url);
        let zone =
            if model.kind() == "gate" { "zone = { min_m = [0, 0, 0], max_m = [1, 1, 1] }" } else { "" };
        let keys = format!(
            "name = \"s\"\nmodel = {:?}\n{zone}\nposes = [{{ name = \"p\", list = [{{ position_m = [0, 0, 1], facing = \
             [1, 0, 0] }}] }}]",
            model.name
        );
        let checked = sensor::check(
            &place(),
            toml::from_str(&keys).unwrap(),
            &sensor::SensorContext {
                seed: 0,
                noiseless: false,
                index: 0,
                earlier: &[],
                poses: 0,
                sources: &Sources::from_main(Path::new(STUDY)),
                models: &[],
                currency: None,
                scenes: &[],
                has_all_scenes: true,
                surfaces: &Surfaces::default(),
                line_of: &|_| None,
            },
        );
        let sensor = checked.unwrap_or_else(|e| panic!("{}: {e:?}", model.name));
        assert_eq!(sensor.kind.name(), model.kind());
        let measures = ["rgbd", "lidar"].contains(&model.kind());
        assert_eq!(sensor.noise != SaidOfNoise::Nothing, measures, "{}: noise", model.name);
        assert!(model.stereo.is_none() || sensor.noise == SaidOfNoise::Model, "{}: noise", model.name);
        if let Some(rays) = sensor.kind.rays(&RayScale::new(0.05, false)) {
            assert!(
                (500..1_100_000).contains(&rays.dirs_q15.len()),
                "{}: {}",
                model.name,
                rays.dirs_q15.len()
            );
        }
    }
    assert!(names.len() >= 40);
}

/// By hand: 424 / tan(43.5 deg) = 446.80 pixels; 0.08 / (446.80 * 0.05) = 0.0035810, and 0.08 / (446.80 *
/// 0.095) = 0.0018848.
#[test]
fn the_noise_of_stereo_cameras_follows_from_their_baseline() {
    let per_m2 = |name: &str| find(name, &[]).unwrap().keys["noise"]["per_m2"].as_float().unwrap();
    assert_eq!([per_m2("realsense-d435"), per_m2("realsense-d455")], [0.003581, 0.001885]);
    let stereo = Stereo { baseline_m: 0.1, subpixel_px: 0.1 };
    assert_eq!(stereo.per_m2(90.0, 200.0), 0.01, "100 pixels of focal length");
}

/// Rays by hand: 848 · 480; 16 · 1800; 350 · 58; 1024 · 128; 275 · 6 + 1; 1081 steps.
#[test]
fn known_devices_have_known_rays() {
    for (name, expected) in [
        ("realsense-d435", 407_040),
        ("velodyne-vlp-16", 28_800),
        ("velodyne-vlp-32c", 57_600),
        ("livox-mid-360", 350 * 58),
        ("ouster-os0-128", 131_072),
        ("ouster-os1-128", 131_072),
        ("sick-nanoscan3", 1_651),
        ("hokuyo-utm-30lx", 1_081),
    ] {
        let keys = format!(
            "name = \"s\"\nmodel = {name:?}\nposes = [{{ name = \"p\", list = [{{ position_m = [0, 0, 1], facing = [1, 0, \
             0] }}] }}]"
        );
        let sources = Sources::from_main(Path::new(STUDY));
        let context = sensor::SensorContext {
            seed: 0,
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
        let sensor = sensor::check(&place(), toml::from_str(&keys).unwrap(), &context).unwrap();
        let rays = sensor.kind.rays(&RayScale::new(0.05, false)).unwrap();
        assert_eq!(rays.dirs_q15.len(), expected, "{name}");
    }
}

#[test]
fn what_a_study_writes_goes_before_the_catalogue() {
    let keys = resolve_keys("model = \"realsense-d435\"\nrange_m = [0.2, 9.0]").unwrap();
    assert_eq!(keys["range_m"], Value::try_from([0.2, 9.0]).unwrap());
    assert_eq!(keys["resolution_px"], Value::try_from([848, 480]).unwrap());
    assert!(!keys.contains_key("model"));
}

#[test]
fn other_ways_to_say_a_key_go_before_it_too() {
    let has = |keys: &str| -> Vec<String> { resolve_keys(keys).unwrap().keys().cloned().collect() };
    let vlp = "model = \"velodyne-vlp-16\"\n";
    assert_eq!(has(vlp), ["emits", "fov_deg", "kind", "noise", "range_m", "resolution_deg", "rings_deg"]);
    assert!(!has(&format!("{vlp}elevation_deg = [-10, 10]")).contains(&"rings_deg".into()));
    assert!(!has(&format!("{vlp}fov_deg = [360, 20]")).contains(&"rings_deg".into()));
    assert!(has(&format!("{vlp}fov_deg = 180")).contains(&"rings_deg".into()));
    let info = has("model = \"zed-2\"\ncamera_info = \"left.yaml\"");
    assert_eq!(info, ["camera_info", "kind", "noise", "range_along", "range_m"]);
    let ouster = "model = \"ouster-os0-128\"\n";
    assert!(!has(&format!("{ouster}resolution_deg = 1")).contains(&"beams".into()));
    assert!(!has(&format!("{ouster}resolution_deg = [1, 2]")).contains(&"rings".into()));
}

#[test]
fn a_number_of_rings_without_their_range_is_refused_with_the_rings_of_the_device() {
    let vlp = "model = \"velodyne-vlp-16\"\nrings = 32\n";
    let said = resolve_keys(vlp).unwrap_err().to_string();
    assert!(said.contains("rings = 32: replaces rings_deg = [-15, -13, "), "{said}");
    assert!(said.contains("] of velodyne-vlp-16: remove rings, or write elevation_deg"), "{said}");
    assert!(resolve_keys(&format!("{vlp}elevation_deg = [-10, 10]")).is_ok());
}

#[test]
fn unknown_devices_are_refused_with_names_that_are_near() {
    for (keys, expected) in [
        (
            "model = \"realsense-435\"",
            "study.toml: model = \"realsense-435\": is not in the catalogue (did you mean realsense-d435, \
             realsense-d455, realsense-d415, realsense-d405, realsense-l515?): `perirobot sensors` lists all that ship",
        ),
        ("model = \"KINECT\"", "(did you mean azure-kinect-nfov, "),
        ("model = \"\"", "model = \"\": is not in the catalogue: `perirobot sensors` lists all that ship"),
        ("model = \"lighthouse\"", "is not in the catalogue"),
        ("model = 435", "model = 435: must be a name, as in model = \"realsense-d435\""),
        (
            "model = \"zed-2\"\nkind = \"lidar\"",
            "kind = \"lidar\": the model \"zed-2\" is of kind \"rgbd\": take kind or model away",
        ),
    ] {
        let error = resolve_keys(keys).unwrap_err();
        assert!(error.contains(expected), "no {expected:?} in {error}");
    }
    assert!(resolve_keys("model = \"zed-2\"\nkind = \"rgbd\"").is_ok());
}

#[test]
fn a_study_is_written_out_for_the_fingerprint() {
    let study: Table =
        toml::from_str("[[sensor]]\nmodel = \"safety-mat\"\n[[sensor]]\nname = \"x\"").unwrap();
    let out = written_out(study.clone());
    assert_eq!(out["sensor"][0]["size_m"], Value::try_from([1.0, 0.75]).unwrap());
    assert_eq!(out["sensor"][0]["model"], Value::from("safety-mat"));
    assert_eq!(out["sensor"][1], study["sensor"][1]);
    let strange: Table = toml::from_str("sensor = [1, { model = 3 }, { model = \"none\" }]").unwrap();
    assert_eq!(written_out(strange.clone()), strange);
}
