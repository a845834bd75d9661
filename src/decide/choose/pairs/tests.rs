//! Comparison with a plain definition and with values worked out by hand.

use std::fmt::Write;

use super::super::candidates_of;
use super::super::verify::DisturbedPairs;
use super::plain_camera::PlainCamera;
use super::*;
use perirobot_march::march::pcg;
use perirobot_study::input::Overrides;
use perirobot_study::sensor::Candidate;

const SCENE: &str = include_str!("../../../../scenes/approach/cell.toml");
const GRID: &str = "[grid]\nvoxel_size_m = 0.25\nbounds_m = { min = [-3, -3, 0], max = [3, 3, 3] }\n\
                    [[scene]]\nfile = \"cell.toml\"\n\
                    [[region]]\nname = \"all\"\nbox = { min_m = [-3, -3, 0], max_m = [3, 3, 3] }\n";

fn camera(name: &str, emits: &str, poses: &str) -> String {
    format!(
        "[[sensor]]\nname = \"{name}\"\nkind = \"rgbd\"\nfov_deg = [90, 60]\nresolution_px = [30, 20]\n\
         range_m = [0.1, 4.0]\nrange_along = \"axis\"\nemits = \"{emits}\"\n\
         [[sensor.poses]]\nname = \"p\"\nlist = [\n{poses}]\n"
    )
}

fn scanner(emits: &str, poses: &str) -> String {
    format!(
        "[[sensor]]\nname = \"scanner\"\nkind = \"lidar\"\nfov_deg = 270\nbeams = 271\nrings_deg = [0]\n\
         range_m = [0.1, 8.0]\nemits = \"{emits}\"\n[[sensor.poses]]\nname = \"p\"\nlist = [\n{poses}]\n"
    )
}

fn pose(number: usize, at: [f64; 3], facing: [f64; 3]) -> String {
    format!("{{ name = \"{number}\", position_m = {at:?}, facing = {facing:?} }},\n")
}

fn load(text: &str) -> (Study, Vec<World>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(folder.path().join("cell.toml"), SCENE).unwrap();
    std::fs::write(&path, text).unwrap();
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    (study, worlds)
}

fn disturbs(disturb: Disturb, sensors: &str) -> Vec<(usize, usize)> {
    let (study, worlds) = load(&format!("{GRID}{sensors}"));
    let items = candidates_of(&study);
    let terms = PairTerms { apart_m: 0.0, disturb: Some(disturb) };
    let found = forbidden_pairs(&study, &items, &worlds, terms);
    let plain = DisturbedPairs::from_items(&items, (&study, &worlds), Some(disturb));
    let has = |a: usize, b: usize| found[a][b / 64] >> (b % 64) & 1 == 1;
    let mut pairs = Vec::new();
    for (a, &one) in items.iter().enumerate() {
        for (b, &other) in items.iter().enumerate() {
            assert_eq!(has(a, b), plain.has(one, other), "{disturb:?}: {a} and {b} in\n{sensors}");
            assert_eq!(has(a, b), has(b, a), "{disturb:?}: {a} and {b}");
            if a < b && has(a, b) {
                pairs.push((a, b));
            }
        }
    }
    pairs
}

const LENS: Disturb = Disturb { apart_deg: None, overlap: None };

fn lens_within(apart_deg: f64) -> Disturb {
    Disturb { apart_deg: Some(apart_deg), overlap: None }
}

fn overlap(most: f64) -> Disturb {
    Disturb { apart_deg: Some(0.0), overlap: Some(most) }
}

#[test]
fn cameras_that_look_at_each_other_disturb_each_other() {
    let opposite = pose(0, [-2.0, 0.0, 1.0], [1.0, 0.0, 0.0]) + &pose(1, [2.0, 0.0, 1.0], [-1.0, 0.0, 0.0]);
    // 20° off, away from it, behind it.
    let off = pose(2, [2.0, 0.0, 1.0], [-0.9397, 0.342, 0.0]);
    let away = pose(3, [2.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let poses = opposite + &off + &away;
    let one = camera("tof", "tof", &poses);
    assert_eq!(disturbs(LENS, &one), [(0, 1), (0, 2)]);
    assert_eq!(disturbs(lens_within(21.0), &one), [(0, 1), (0, 2)]);
    assert_eq!(disturbs(lens_within(19.0), &one), [(0, 1)]);
    let other = |emits: &str| {
        let [a, b] = [pose(0, [-2.0, 0.0, 1.0], [1.0, 0.0, 0.0]), pose(1, [2.0, 0.0, 1.0], [-1.0, 0.0, 0.0])];
        disturbs(LENS, &(camera("a", "tof", &a) + &camera("b", emits, &b)))
    };
    assert_eq!(other("tof"), [(0, 1)], "two sensors of the study");
    assert_eq!(other("structured_light"), [], "another kind of light");
    assert_eq!(other("none"), [], "no light");
}

#[test]
fn cameras_that_see_the_same_disturb_each_other() {
    let side_by_side =
        pose(0, [-2.0, 0.0, 1.0], [1.0, 0.0, 0.0]) + &pose(1, [-2.0, 0.01, 1.0], [1.0, 0.0, 0.0]);
    let back_to_back = pose(2, [-2.0, 0.0, 1.0], [-1.0, 0.0, 0.0]);
    let sensors = camera("tof", "tof", &(side_by_side + &back_to_back));
    assert_eq!(disturbs(overlap(0.9), &sensors), [(0, 1)]);
    assert_eq!(disturbs(overlap(0.0), &sensors), [(0, 1)]);
    assert_eq!(disturbs(overlap(1.0), &sensors), [], "all of it is not more than all of it");
    assert_eq!(disturbs(LENS, &sensors), [], "neither is in front of the other");
}

#[test]
fn scanners_disturb_each_other_in_one_plane() {
    let one = pose(0, [-2.0, 0.0, 0.3], [1.0, 0.0, 0.0]);
    let level = pose(1, [2.0, 0.5, 0.3], [-1.0, 0.0, 0.0]);
    let higher = pose(2, [2.0, -0.5, 0.4], [-1.0, 0.0, 0.0]);
    let turned = pose(3, [2.0, 0.0, 0.3], [1.0, 0.0, 0.0]);
    let sensors = scanner("lidar", &(one + &level + &higher + &turned));
    // The blind quarter of the last one is towards the first.
    assert_eq!(disturbs(LENS, &sensors), [(0, 1), (1, 3)]);
    assert_eq!(disturbs(overlap(0.3), &sensors), [(0, 1), (0, 3), (1, 3)]);
}

#[test]
fn random_cameras_disturb_each_other_by_the_plain_definition() {
    let mut state = 1u32;
    let mut random = |low: f64, high: f64| {
        state = state.wrapping_add(0x9e37_79b9);
        low + (high - low) * f64::from(pcg(state) % 100_000) / 1e5
    };
    let mut poses = String::new();
    for number in 0..70 {
        let at = [random(-2.9, 2.9), random(-2.9, 2.9), random(0.1, 2.9)];
        let facing = [random(-1.0, 1.0), random(-1.0, 1.0), random(-0.4, 0.4)];
        write!(poses, "{}", pose(number, at, facing)).unwrap();
    }
    let sensors = camera("tof", "tof", &poses);
    let (study, worlds) = load(&format!("{GRID}{sensors}"));
    let camera = |one: &Candidate| PlainCamera {
        pose: one.setting.pose(),
        fov_deg: [90.0, 60.0],
        far_m: 4.0,
        is_depth: true,
        walls_m: PlainCamera::walls_m(&worlds[0].grid),
    };
    let cameras: Vec<PlainCamera> = study.sensors[0].candidates.iter().map(camera).collect();
    for disturb in [
        LENS,
        lens_within(25.0),
        lens_within(40.0),
        overlap(0.1),
        overlap(0.35),
        Disturb { apart_deg: Some(25.0), overlap: Some(0.3) },
    ] {
        let mut expected = Vec::new();
        for (a, one) in cameras.iter().enumerate() {
            for (b, other) in cameras.iter().enumerate().skip(a + 1) {
                if one.disturbs(other, &disturb) {
                    expected.push((a, b));
                }
            }
        }
        assert!(!expected.is_empty() && expected.len() < 70 * 69 / 2, "{disturb:?}: {}", expected.len());
        let found = disturbs(disturb, &sensors);
        let differ = |pair: &&(usize, usize)| found.contains(pair) != expected.contains(pair);
        let differing: Vec<_> = found.iter().chain(&expected).filter(differ).collect();
        assert!(differing.is_empty(), "{disturb:?}: {differing:?}");
    }
}
