//! What is counted is what is written.

use super::*;

/// The tutorial's study with its camera and scanner at a pose that is written.
fn written(at: &Pose6, sensor: &str) -> perirobot_scene::pose::Pose {
    let path = root().join("scenes/tutorial/study.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let known = Known::new(&load(&path, &text));
    let mut document = Document::new(text);
    let index = document.apply(&add(sensor, *at), None, &known).unwrap().unwrap();
    let placed = &document.plan(&known).unwrap()[index];
    let study = load(&path, document.text());
    let own = Known::new(&study);
    let sensor = own.sensors.iter().find(|own| own.name == placed.sensor).unwrap();
    sensor.poses.iter().find(|(name, _)| *name == placed.pose).unwrap().1.unwrap()
}

#[test]
fn a_rounded_pose_has_the_bits_of_the_written_one() {
    let mut state = 7u64;
    let mut draw = |from: f64, to: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * ((state >> 11) as f64 / (1u64 << 53) as f64)
    };
    for number in 0..60 {
        let mut at = Pose6 {
            position_m: [draw(-20.0, 20.0), draw(-20.0, 20.0), draw(0.0, 10.0)],
            pan_deg: draw(-400.0, 400.0),
            tilt_deg: draw(-90.0, 90.0),
            roll_deg: draw(-180.0, 180.0),
        };
        // Whole numbers, right angles and straight down are where forms differ.
        match number % 6 {
            0 => at.roll_deg = 0.0,
            1 => (at.roll_deg, at.tilt_deg) = (0.0, 0.0),
            2 => (at.roll_deg, at.tilt_deg) = (0.0, -90.0),
            3 => (at.pan_deg, at.tilt_deg, at.roll_deg) = ((at.pan_deg / 45.0).round() * 45.0, 90.0, 0.0),
            4 => at = Pose6 { position_m: at.position_m.map(f64::round), pan_deg: at.pan_deg.round(), ..at },
            _ => {}
        }
        for (sensor, stance) in [("camera", Stance::Facing), ("scanner", Stance::Upright)] {
            let (pose, own) = (written(&at, sensor), rounded(&at, stance));
            let bits = |pose: &perirobot_scene::pose::Pose| {
                (pose.position_m.to_array().map(f64::to_bits), pose.rotation.to_array().map(f64::to_bits))
            };
            assert_eq!(bits(&pose), bits(&own), "{sensor} {at:?}: {pose:?} {own:?}");
            let again = Pose6::new(&own).rounded();
            assert_eq!(again.position_m, at.rounded().position_m);
        }
    }
}
