//! `[stopping]`: regions around the robot at each of its speeds, found again by brute force and the same on every
//! backend; distances that an approach needs; and what cannot be asked.

use std::fs;

use crate::common;
use crate::common::program::{Folder, STOPPING, perirobot, refused, text};
use perirobot_march::voxel::BitGrid;
use perirobot_scene::objects::Role;
use perirobot_study::input::{Overrides, RegionSpec, Study};
use perirobot_study::world::World;

/// Whole squared distances from which a voxel is far enough: those of 3.2125, 4.45 and 7.3 voxels, rounded up.
const SQUARED: [i32; 3] = [11, 20, 54];

/// The small study in which robot and person move, with regions of every kind that belongs to [stopping].
fn moving() -> Folder {
    let folder = Folder::new();
    let moved = |at: &str, to: &str| format!("{at}\n[object.snapshots]\nposition_m = [{to}]");
    for (at, to) in [
        (
            "position_m = [0.2, 0.3, 0.45]\nquaternion = { w = 1, x = 0, y = 0, z = 0 }",
            "[0.2, 0.3, 0.45], [-0.3, 0.3, 0.45]",
        ),
        ("position_m = [0.1, -0.45, 0.65]", "[0.1, -0.45, 0.65], [-0.2, -0.45, 0.65]"),
    ] {
        folder.edit("cell.toml", at, &moved(at, to));
    }
    let regions = "[[region]]\nname = \"near\"\nseparation = {}\n\
         [[region]]\nname = \"slow\"\nseparation = { from = \"robot_swept\", speed_m_s = 0.25 }\n\
         [[region]]\nname = \"arms\"\nswept = \"robot\"\n[[region]]\nname = \"people\"\nswept = \"human\"\n\
         [[region]]\nname = \"shell\"\ndifference = [\"near@1\", \"near@0.5\"]\n";
    folder.edit("study.toml", "[[sensor]]", &format!("{regions}[[sensor]]"));
    folder.edit("study.toml", "", STOPPING);
    folder
}

#[test]
fn regions_are_those_of_a_plain_search_in_each_snapshot() {
    let folder = moving();
    let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    let names: Vec<&str> = study.regions.iter().map(|(name, _)| name.as_str()).collect();
    let own = ["near@0.25", "near@0.5", "near@1", "slow", "arms", "people", "shell"];
    assert_eq!(names, [&["robot", "box", "human"], &own[..]].concat());
    assert!(
        matches!(&study.regions[5].1, RegionSpec::Separation { family, speed: 2, .. } if family == "near")
    );
    let worlds = World::prepare_all(&study).unwrap();
    assert_eq!(worlds.len(), 2);
    let window = worlds[0].grid.window();
    let all = |sets: [BitGrid; 2]| {
        let mut all = BitGrid::new(window);
        sets.iter().for_each(|set| all.add(set));
        all
    };
    let of = |number: usize| worlds[number].truth();
    let robots = all([0, 1].map(|number| of(number).robot_volume.clone()));
    let people = all([0, 1].map(|number| of(number).human.clone()));
    for world in &worlds {
        let truth = world.truth();
        let near = |robot: &BitGrid, far: i32| {
            let robot: Vec<_> = robot.voxels().collect();
            let squared = |a: [i32; 3], b: [i32; 3]| (0..3).map(|r| (a[r] - b[r]).pow(2)).sum::<i32>();
            let is_near = |voxel: &[i32; 3]| robot.iter().any(|&other| squared(*voxel, other) < far);
            let mut found = BitGrid::new(window);
            let voxels = BitGrid::full(window);
            voxels.voxels().filter(is_near).for_each(|voxel| found.set(voxel));
            found
        };
        let shells = SQUARED.map(|far| near(&truth.robot_volume, far));
        let mut shell = shells[2].clone();
        shell.remove(&shells[1]);
        let [slow, medium, fast] = shells;
        let expected = [slow, medium, fast, near(&robots, SQUARED[0]), robots.clone(), people.clone(), shell];
        for ((name, region), mut expected) in own.iter().zip(&world.regions[3..]).zip(expected) {
            expected.remove(&truth.ignored);
            assert!(expected.count() > 20, "{name} in snapshot {}", world.snapshot);
            assert_eq!(region.voxels.to_window(window), expected, "{name} in snapshot {}", world.snapshot);
        }
    }
    // The robot moves, and what is near to it with it; what it sweeps stays.
    let same = |region: usize| worlds[0].regions[region].voxels == worlds[1].regions[region].voxels;
    assert_eq!([3, 4, 5, 6, 7, 8].map(same), [false, false, false, true, true, true]);
    assert!(of(0).objects.iter().any(|object| object.role == Role::Robot));
}

#[test]
fn every_backend_counts_the_same_in_them() {
    let folder = moving();
    let mut tables = Vec::new();
    let mut backends = vec![vec!["--backend", "oracle"], vec!["--backend", "cpu"]];
    backends.extend(common::on_adapter().map(Vec::from));
    for backend in &backends {
        let (study, out) = (folder.path("study.toml"), folder.path(backend[1]));
        let fixed = ["sweep", text(&study), "--out", text(&out), "--progress", "none"];
        let outcome = perirobot(&[&fixed, &backend[..]].concat());
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        tables.push(fs::read(out.join("results.csv")).unwrap());
    }
    assert!(String::from_utf8_lossy(&tables[0]).contains(",near@0.5,"));
    assert!(tables.iter().all(|table| *table == tables[0]), "{backends:?}");
}

/// Whoever changes a time after the sweep has other regions, and is told; a time that changes none is free.
#[test]
fn a_sweep_belongs_to_the_distances_of_its_regions() {
    let folder = moving();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    folder.edit("study.toml", "human_speed_m_s = 1.6", "human_speed_m_s = 1.6000001");
    let again = folder.sweep(&[]);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    folder.edit("study.toml", "human_speed_m_s = 1.6000001", "human_speed_m_s = 2.6");
    let other = folder.sweep(&[]);
    assert_eq!(other.code, Some(2), "{}", other.stderr);
    // The fourth region is near@0.25.
    assert!(other.stderr.contains("scenes[0].regions[3]."), "{}", other.stderr);
}

#[test]
fn what_cannot_be_asked_is_refused_by_name() {
    let study = |from: &'static str, to: &'static str| ("study.toml", from, to);
    let wrong = |from, to, expected: &[&str]| refused(&moving(), &[study(from, to)], expected);
    wrong(
        STOPPING,
        "",
        &["region \"near\".separation: needs to know how the robot stops", "[stopping] formula ="],
    );
    wrong(
        "speed_m_s = 0.25 }",
        "speed_m_s = 0.3 }",
        &["region \"slow\".separation.speed_m_s = 0.3: must be one of robot_speeds_m_s", "[0.25, 0.5, 1.0]"],
    );
    wrong("separation = {}", "separation = { from = \"arm\" }", &["from", "robot_swept"]);
    wrong("swept = \"human\"", "swept = \"dog\"", &["swept", "dog"]);
    wrong(
        "robot_speeds_m_s = [0.25,",
        "robot_speeds_m_s = [0,",
        &["stopping.robot_speeds_m_s = 0: must be speeds"],
    );
    wrong(
        "sensor_reaction_s = 0.05",
        "sensor_reaction_s = -1",
        &["stopping.sensor_reaction_s = -1: must be a time"],
    );
    wrong("sensor_reaction_s = 0.05\n", "", &["sensor_reaction_s"]);
    wrong("\"speed_and_separation\"", "\"iso_13855\"", &["iso_13855", "speed_and_separation"]);
    wrong(
        "robot_deceleration_m_s2 = 5",
        "robot_deceleration_m_s2 = 0.001",
        &["region \"near@0.25\"", "take larger voxels, or check the times of [stopping]"],
    );
    let no_robot = ("cell.toml", "role = \"robot\"", "role = \"environment\"");
    refused(&moving(), &[no_robot], &["region \"near@0.25\": no object of the scene is a robot in the grid"]);
}

/// What reaches beyond the grid is warned of as a bound.
#[test]
fn a_region_beyond_the_grid_is_a_bound() {
    let folder = moving();
    // Without walls, behind which nobody comes.
    folder.edit("cell.toml", "room = { size_m = [2.4, 1.8, 1.6] }", "plane = { size_m = [2.4, 1.8] }");
    folder.edit("cell.toml", "position_m = [0, 0, 0.8]", "position_m = [0, 0, 0]");
    folder.edit("study.toml", "human_speed_m_s = 1.6", "human_speed_m_s = 3");
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let told = |line: &&str| line.contains("region \"near@1\"") && line.contains("lies outside the grid");
    let line = outcome.stderr.lines().find(told).unwrap_or_else(|| panic!("{}", outcome.stderr));
    assert!(line.contains("take what is said of it as a bound"), "{line}");
}
