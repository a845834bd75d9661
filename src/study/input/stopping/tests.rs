use std::path::Path;

use super::*;
use crate::input::poses::Surfaces;
use crate::input::sensor::{self, SensorContext};
use perirobot_scene::source::Sources;

fn check_text(text: &str) -> Result<Stopping, String> {
    checked_for(text, &[])
}

fn checked_for(text: &str, sensors: &[Sensor]) -> Result<Stopping, String> {
    checked_above(text, sensors, 0.0)
}

fn checked_above(text: &str, sensors: &[Sensor], floor_m: f64) -> Result<Stopping, String> {
    checked_on(text, sensors, StandingFloor { z_m: floor_m, is_auto: false })
}

fn checked_on(text: &str, sensors: &[Sensor], floor: StandingFloor) -> Result<Stopping, String> {
    let at = Place::new(Path::new("study.toml"));
    check(&at, toml::from_str(text).unwrap(), sensors, floor).map_err(|e| e.to_string())
}

/// A sensor with some keys, that stands at these heights.
fn sensor(name: &str, keys: &str, heights_m: &str) -> Sensor {
    facing(name, keys, heights_m, "[1, 0, 0]")
}

/// The same, that faces somewhere.
fn facing(name: &str, keys: &str, heights_m: &str, facing: &str) -> Sensor {
    let at = Place::new(Path::new("study.toml"));
    let poses =
        format!("poses = [{{ name = \"p\", x_m = 0, y_m = 0, z_m = {heights_m}, facing = {facing} }}]");
    let sources = Sources::from_main(at.file);
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
    let keys = toml::from_str(&format!("name = {name:?}\n{keys}\n{poses}")).unwrap();
    sensor::check(&at, keys, &context).unwrap()
}

fn needed_m(text: &str) -> Vec<f64> {
    check_text(text).unwrap().speeds.iter().map(|at| at.needed_m).collect()
}

#[track_caller]
fn same(found: Vec<f64>, expected: &[f64]) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
    assert!(found.len() == expected.len() && found.iter().zip(expected).all(near), "{found:?}, {expected:?}");
}

const TIMES: &str = "sensor_reaction_s = 0.1\ncontrol_reaction_s = 0.05\n";

/// Worked by hand.
#[test]
fn distances_are_those_of_the_formulas() {
    let speeds = "robot_speeds_m_s = [0.5, 1]\n";
    // 1.6 · (0.15 + 0.3) = 0.72, and 0.85; then 2 · 0.45 = 0.9, and 0.2.
    let iso = format!("formula = \"iso13855\"\nedition = 2010\n{speeds}{TIMES}robot_stopping_s = 0.3\n");
    same(needed_m(&iso), &[1.57, 1.57]);
    same(needed_m(&format!("{iso}human_speed_m_s = 2\nintrusion_m = 0.2")), &[1.1, 1.1]);
    // v / a = 0.25 and 0.5 s: 1.6 · 0.4 = 0.64, 1.6 · 0.65 = 1.04.
    let braking = iso.replace("robot_stopping_s = 0.3", "robot_deceleration_m_s2 = 2");
    same(needed_m(&braking), &[1.49, 1.89]);
    // 0.72 + 0.3 + 0.12.
    let edition = iso.replace("2010", "2024") + "device_distance_m = 0.3\nsupplement_m = 0.12";
    same(needed_m(&edition), &[1.14, 1.14]);
    // Human 1.6 · 0.4 = 0.64, robot 0.5 · 0.15 = 0.075, stopping 0.25 / 4 = 0.0625, and 0.85 + 0.1 + 0.01;
    // then 1.04, 0.15, 0.25, and the same.
    let both = format!(
        "formula = \"speed_and_separation\"\n{speeds}{TIMES}robot_deceleration_m_s2 = 2\n\
         person_uncertainty_m = 0.1\nrobot_uncertainty_m = 0.01\n"
    );
    same(needed_m(&both), &[1.7375, 2.4]);
    // A time for each speed: human 1.6 · 0.35 = 0.56 and 1.6 · 0.55 = 0.88; the robot at its speed all the time:
    // 0.5 · 0.35 = 0.175 and 0.55.
    let times = both.replace("robot_deceleration_m_s2 = 2", "robot_stopping_s = [0.2, 0.4]");
    same(needed_m(&times), &[1.695, 2.39]);
}

#[test]
fn what_is_wrong_is_named() {
    let good = format!(
        "formula = \"speed_and_separation\"\nrobot_speeds_m_s = [0.5, 1.0]\n{TIMES}robot_deceleration_m_s2 = 2.0\n\
         person_uncertainty_m = 0.1\nrobot_uncertainty_m = 0.01\n"
    );
    assert!(check_text(&good).is_ok());
    let iso = "formula = \"iso13855\"";
    for (from, to, expected) in [
        ("[0.5, 1.0]", "[0, 1.0]", "stopping.robot_speeds_m_s = 0: must be speeds in m/s above 0"),
        ("[0.5, 1.0]", "[-0.5, 1.0]", "stopping.robot_speeds_m_s = -0.5: must be speeds"),
        ("[0.5, 1.0]", "[1.0, 0.5]", "robot_speeds_m_s = [1.0, 0.5]: each must be above the one before"),
        (
            "[0.5, 1.0]",
            "{ start = 0.001, stop = 20, step = 0.001 }",
            "stopping: robot_speeds_m_s has 20000 speeds: at most 1000 are possible: take a larger step",
        ),
        ("[0.5, 1.0]", "[]", "robot_speeds_m_s = []: must be at least one number"),
        ("sensor_reaction_s = 0.1", "sensor_reaction_s = -0.1", "sensor_reaction_s = -0.1: must be a time"),
        ("control_reaction_s = 0.05", "control_reaction_s = nan", "control_reaction_s = NaN: must be a time"),
        (
            "robot_deceleration_m_s2 = 2.0",
            "",
            "stopping: neither robot_stopping_s nor robot_deceleration_m_s2",
        ),
        (
            "robot_deceleration_m_s2",
            "robot_stopping_s = 0.3\nrobot_deceleration_m_s2",
            "stopping: both robot_stopping_s and robot_deceleration_m_s2",
        ),
        (
            "robot_deceleration_m_s2 = 2.0",
            "robot_deceleration_m_s2 = 0",
            "robot_deceleration_m_s2 = 0: must be",
        ),
        (
            "robot_deceleration_m_s2 = 2.0",
            "robot_stopping_s = [1, 2, 3]",
            "[1.0, 2.0, 3.0]: must be one number, or one for each of the 2 speeds",
        ),
        (
            "robot_deceleration_m_s2 = 2.0",
            "robot_stopping_s = [0.3, 0.2]",
            "none may be below the one before",
        ),
        ("robot_deceleration_m_s2 = 2.0", "robot_stopping_s = -1", "robot_stopping_s = -1: must be times"),
        ("person_uncertainty_m = 0.1\n", "", "person_uncertainty_m"),
        ("formula = \"speed_and_separation\"", iso, "edition"),
        (
            "formula = \"speed_and_separation\"",
            "formula = \"iso13855\"\nedition = 2016",
            "stopping.edition = 2016: must be 2010 or 2024",
        ),
        (
            "formula = \"speed_and_separation\"",
            "formula = \"speed_and_separation\"\nedition = 2010",
            "edition = 2010: belongs to formula = \"iso13855\"",
        ),
        (
            "formula = \"speed_and_separation\"",
            "formula = \"iso13855\"\nedition = 2010",
            "person_uncertainty_m = 0.1: formula = \"iso13855\" of 2010 has no such term: it has intrusion_m",
        ),
        (
            "person_uncertainty_m = 0.1",
            "person_uncertainty_m = 0.1\nhuman_speed_m_s = 0",
            "human_speed_m_s = 0",
        ),
    ] {
        assert!(good.contains(from), "{from}");
        let what = check_text(&good.replacen(from, to, 1)).unwrap_err();
        assert!(what.starts_with("study.toml: stopping") && what.contains(expected), "{to:?}: {what}");
    }
}

#[test]
fn what_was_assumed_names_each_default_and_each_distance() {
    let text = format!(
        "formula = \"iso13855\"\nedition = 2010\nrobot_speeds_m_s = [0.5, 1]\n{TIMES}robot_stopping_s = 0.3\n"
    );
    let said = check_text(&text).unwrap().assumptions(0.05).join("\n");
    for part in ["1.570 m at 0.5 m/s, 1.570 m at 1 m/s", "ISO 13855:2010", "stop T_r = 0.150 s after"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert_eq!(said.matches("To be checked").count(), 2, "{said}");
    for part in ["at most 0.5 m it is 2", "for a device that an arm passes unnoticed"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let said =
        check_text(&format!("{text}human_speed_m_s = 1.6\nintrusion_m = 0.85")).unwrap().assumptions(0.05);
    assert!(!said.join("\n").contains("To be checked"), "what is written is nobody's default");
}

/// Worked by hand: T = 0.45 s. A pad has C = 1.2 m, a level scanner 0.3 m above the floor 1.2 - 0.12 = 1.08 m, one at 1 m or higher
/// 0.85 m, as what looks down or is tilted.
#[test]
fn intrusions_are_those_of_the_direction_of_approach() {
    let iso = format!(
        "formula = \"iso13855\"\nedition = 2010\nrobot_speeds_m_s = [1]\n{TIMES}robot_stopping_s = 0.3\n"
    );
    let pad = sensor("mat", "kind = \"pad\"\nsize_m = [1, 1]", "0");
    let scanner = |keys: &str, z: &str| {
        sensor("scanner", &format!("kind = \"lidar\"\nrange_m = [0.1, 5]\nresolution_deg = 1\n{keys}"), z)
    };
    let low = scanner("rings_deg = [0]", "[0.3, 0.6]");
    let high = scanner("rings_deg = [0]", "1.1");
    let upwards = scanner("rings_deg = [0]\nmount = \"facing\"", "0.3");
    let rings = scanner("elevation_deg = [-20, 20]", "0.3");
    let tilted = |facing: &str| {
        let keys =
            "kind = \"lidar\"\nrange_m = [0.1, 5]\nresolution_deg = 1\nrings_deg = [0]\nmount = \"facing\"";
        self::facing("scanner", keys, "0.9", facing)
    };
    let camera = sensor(
        "camera",
        "kind = \"rgbd\"\nfov_deg = [80, 60]\nresolution_px = [4, 4]\nrange_m = [0.1, 5]",
        "0.1",
    );
    let all = [camera.clone(), low.clone(), pad.clone()];
    for (sensors, intrusion_m) in [
        (std::slice::from_ref(&pad), 1.2),
        (std::slice::from_ref(&low), 1.08),
        (std::slice::from_ref(&high), 0.85),
        (&[upwards], 0.85),
        (&[rings], 0.85),
        (&[tilted("[0.02, 0, 1]")], 0.85),
        (&[tilted("[0.1, 0, 1]")], 1.2),
        (&[tilted("[0.5, 0, 1]")], 1.2),
        (&[tilted("[0.7, 0, 1]")], 0.85),
        (std::slice::from_ref(&camera), 0.85),
        (&all, 1.2),
    ] {
        let stopping = checked_for(&iso, sensors).unwrap();
        same(vec![stopping.fastest().needed_m], &[0.72 + intrusion_m]);
        assert_eq!(stopping.warnings, [""; 0]);
    }
    // 0.1 m above a floor at 0.2 m: 1.2 - 0.04.
    for (floor_m, intrusion_m) in [(0.2, 1.16), (-0.2, 1.0), (0.4, 1.2)] {
        let stopping = checked_above(&iso, std::slice::from_ref(&low), floor_m).unwrap();
        same(vec![stopping.fastest().needed_m], &[0.72 + intrusion_m]);
    }
    let said = checked_for(&iso, &all).unwrap().assumptions(0.05).join("\n");
    for part in [
        "intrusion_m = 1.20 is a default",
        "\"mat\", which is approached along its plane 0.00 m above",
        "1.08 for \"scanner\"",
        "0.85 for \"camera\"",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    // 0.1 m above z 0, which is not the floor of people on a platform.
    for (is_auto, sensors) in
        [(true, std::slice::from_ref(&low)), (false, std::slice::from_ref(&low)), (true, &all)]
    {
        let stopping = checked_on(&iso, sensors, StandingFloor { z_m: 0.0, is_auto }).unwrap();
        let said = stopping.assumptions(0.05).join("\n");
        let is_said = said.contains("heights are measured from z 0 only, also with floor = \"auto\"");
        assert_eq!(is_said, is_auto && sensors.len() == 1, "{said}");
    }
    // What is written holds, and is told where it is too little.
    let less = format!("{iso}intrusion_m = 0.85");
    let stopping = checked_for(&less, std::slice::from_ref(&low)).unwrap();
    same(vec![stopping.fastest().needed_m], &[1.57]);
    let expected = "stopping: intrusion_m = 0.85 is less than the 1.08 m that public pages tell of ISO 13855:2010 for \"scanner\"";
    assert!(stopping.warnings[0].starts_with(expected), "{:?}", stopping.warnings);
    assert_eq!(
        checked_for(&format!("{iso}intrusion_m = 1.1"), std::slice::from_ref(&low)).unwrap().warnings,
        [""; 0]
    );
    let newer = iso.replace("2010", "2024") + "supplement_m = 0\ndevice_distance_m = ";
    assert_eq!(checked_for(&format!("{newer}1.2"), std::slice::from_ref(&low)).unwrap().warnings, [""; 0]);
    assert_eq!(checked_for(&format!("{newer}1.1"), std::slice::from_ref(&low)).unwrap().warnings.len(), 1);
    // A scanner at the height where C of 2010 is that of a camera is approached along its plane all the same.
    let both = [camera.clone(), high.clone()];
    assert_eq!(checked_for(&format!("{newer}1.1"), &both).unwrap().warnings.len(), 1);
    let said = check_text(&format!("{newer}0")).unwrap().assumptions(0.05).join("\n");
    assert!(said.contains("device_distance_m = 0 is less than the 0.85 m"), "{said}");
}

/// T = 0.1 s: with 2 m/s 0.2 m and what is added, if that is at most 0.5 m; else 0.16 m and that, but at least 0.5 m.
#[test]
fn arms_are_faster_than_people_walk() {
    let iso = "formula = \"iso13855\"\nedition = 2010\nrobot_speeds_m_s = [1]\nsensor_reaction_s = 0.05\ncontrol_reaction_s = 0.05\n\
               robot_stopping_s = 0\n";
    for (intrusion_m, needed) in [(0.1, 0.3), (0.3, 0.5), (0.32, 0.5), (0.4, 0.56)] {
        same(needed_m(&format!("{iso}intrusion_m = {intrusion_m}")), &[needed]);
        same(
            needed_m(&format!("{iso}intrusion_m = {intrusion_m}\nhuman_speed_m_s = 1.6")),
            &[0.16 + intrusion_m],
        );
        let walks = check_text(&format!("{iso}intrusion_m = {intrusion_m}\nhuman_speed_m_s = 1.6")).unwrap();
        let is_told = walks.to_be_checked().any(|line| line.contains("human_speed_m_s = 1.6 makes"));
        assert_eq!(is_told, intrusion_m < 0.34, "{intrusion_m}");
    }
}
