//! What counts as seen cannot mislead: noise adds nothing to it, and no sensor takes any of it away.

use std::path::Path;

use crate::common::Random;
use crate::common::cases::{case, job};
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{Backend, Fusion, Shot, cpu::Cpu};
use perirobot_march::metrics::Confusion;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::run;

/// 64 poses of one depth camera around a mannequin, a robot and a table.
const STUDY: &str = r#"
seed = 1
[[scene]]
file = "scene1.toml"
[[region]]
name = "human"
human_box = { object = "operator", margin_m = 0.3 }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [87, 58]
resolution_px = [320, 180]
range_m = [0.6, 6.0]
NOISE
[[sensor.poses]]
name = "right wall"
x_m = { start = -2.1, stop = 2.1, step = 0.6 }
y_m = -1.9
z_m = [1.5, 2.5]
facing = [0, 1, 0]
orientations_deg = [{ pan = 0, tilt = -10 }, { pan = 20, tilt = -20 }]
[[sensor.poses]]
name = "left wall"
x_m = { start = -2.1, stop = 2.1, step = 0.6 }
y_m = 1.9
z_m = [1.5, 2.5]
facing = [0, -1, 0]
orientations_deg = [{ pan = 0, tilt = -10 }, { pan = 20, tilt = -20 }]
"#;

/// The counts of all poses with so much noise.
fn counts(std_m: f64) -> Vec<Confusion> {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let noise = if std_m > 0.0 { format!("noise = {{ std_m = {std_m} }}") } else { String::new() };
    let path = folder.path().join("study.toml");
    std::fs::write(&path, STUDY.replace("NOISE", &noise)).unwrap();
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let rows = run(&study, &worlds, &mut Cpu::new(Some(2)).unwrap()).unwrap();
    rows.into_iter().map(|row| row.counts).collect()
}

/// `cargo test --test backends seen:: -- --nocapture` prints the table of the claims page.
#[test]
fn more_noise_never_raises_what_is_seen() {
    let all = [0.0, 0.05, 0.10, 0.20].map(|std_m| (std_m, counts(std_m)));
    let best = |counts: &[Confusion], of: fn(&Confusion) -> Option<f64>| {
        counts.iter().filter_map(of).reduce(f64::max).unwrap()
    };
    for (std_m, counts) in &all {
        assert_eq!(counts.len(), 64);
        let [seen, claimed, parts] =
            [Confusion::human_seen, Confusion::human_claimed, Confusion::parts_detected]
                .map(|of| best(counts, of));
        let worst_alarm = best(counts, Confusion::false_alarm);
        println!(
            "noise {std_m:.2} m: best human_seen {seen:.3}, human_claimed {claimed:.3}, parts_detected {parts:.3}; \
             largest false_alarm {worst_alarm:.3}"
        );
    }
    for [(_, less), (std_m, more)] in [[&all[0], &all[1]], [&all[1], &all[2]], [&all[2], &all[3]]] {
        for (pose, (less, more)) in less.iter().zip(more).enumerate() {
            let [before, after] = [less, more].map(|counts| counts.detection);
            assert!(after.hit_human <= before.hit_human, "pose {pose}, noise {std_m} m");
            assert!(after.people_detected <= before.people_detected, "pose {pose}, noise {std_m} m");
            assert!(after.parts_detected <= before.parts_detected, "pose {pose}, noise {std_m} m");
        }
    }
    // What is claimed does rise: the check is worth something.
    let claimed = all.each_ref().map(|(_, counts)| best(counts, Confusion::human_claimed));
    assert!(claimed.is_sorted() && claimed[3] > 2.0 * claimed[0], "{claimed:?}");
    let seen = best(&all[0].1, Confusion::human_seen);
    assert!(0.2 < seen && seen < 0.8, "the near side of a person: {seen}");
    assert!(best(&all[0].1, Confusion::parts_detected) > 0.8, "nearly all parts are seen from somewhere");
}

/// In random cells a job of more readings, by either rule.
#[test]
fn another_sensor_takes_nothing_away() {
    let (mut compared, mut gained) = (0, 0);
    for seed in 0..300 {
        let case = case(seed);
        let mut oracle = Oracle::default();
        oracle.tables(&case.tables).unwrap();
        oracle.load(&case.scene).unwrap();
        for shot in &case.shots {
            oracle.sense(shot.table, &[Shot::once(shot.slot, shot.placement)]).unwrap();
        }
        oracle.upload(case.uploads.clone()).unwrap();
        let mut random = Random(seed);
        let readings: Vec<_> = (0..3).flat_map(|_| job(&mut random)).collect();
        let jobs: Vec<_> = (1..=readings.len()).map(|count| readings[..count].to_vec()).collect();
        for fusion in [Fusion::OccupiedWins, Fusion::Octomap] {
            let scored = oracle.score(fusion, &jobs).unwrap();
            for (count, two) in scored.windows(2).enumerate() {
                for (region, (fewer, more)) in two[0].iter().zip(&two[1]).enumerate() {
                    let place = format!("case {seed}, {fusion:?}, region {region}, sensor {}", count + 1);
                    let [before, after] = [fewer, more].map(|counts| counts.detection);
                    assert!(after.hit_human >= before.hit_human, "{place}");
                    assert!(after.people_detected >= before.people_detected, "{place}");
                    assert!(after.parts_detected >= before.parts_detected, "{place}");
                    assert_eq!((after.people, after.parts), (before.people, before.parts), "{place}");
                    compared += 1;
                    gained += u64::from(after.parts_detected > before.parts_detected);
                }
            }
        }
    }
    assert!(gained >= 20 && compared > 1000, "{gained} of {compared} sensors detect another part");
}
