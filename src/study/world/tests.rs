use glam::DVec3;

use super::baselines::{Reachable, baselines, reachable};
use super::extent::grid;
use super::prepare::carrier;
use super::*;
use crate::input::Overrides;
use crate::sensor::Sensor;
use perirobot_march::metrics::{BODY_PARTS, BodyPart, Confusion, Detection, Overlap, RoleCounts};
use perirobot_march::voxel::BodyVoxel;
use perirobot_scene::objects::build::build;
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::{RadarTruth, RegionShape, voxelize};

/// A scene of 10 × 10 × 10 voxels of a metre, cut in two by a wall at x = 5, with one human voxel on each
/// side and one robot voxel on the far one.
fn walled_truth() -> Truth {
    let grid = Grid { voxel_size_m: 1.0, origin: [0; 3], size: [10; 3] };
    let blank = BitGrid::new(grid.window());
    let (mut occupied, mut human, mut robot) = (blank.clone(), blank.clone(), blank.clone());
    (0..10).for_each(|z| (0..10).for_each(|y| occupied.set([5, y, z])));
    for voxel in [[2, 2, 2], [8, 2, 2]] {
        occupied.set(voxel);
        human.set(voxel);
    }
    occupied.set([8, 8, 8]);
    robot.set([8, 8, 8]);
    Truth {
        grid,
        blockers: occupied.clone().into(),
        radar: RadarTruth { blockers: occupied.clone().into(), speeds_mm_s: Vec::new() },
        shades: None,
        ignored: blank,
        occupied: occupied.into(),
        human,
        robot_volume: robot.clone(),
        robot,
        objects: Vec::new(),
    }
}

#[test]
fn baselines_are_what_trivial_answers_score() {
    let truth = walled_truth();
    let whole = RegionShape::Box { min_m: DVec3::ZERO, max_m: DVec3::splat(10.0) };
    let region = region::region("all", &whole, &truth, &|_| unreachable!()).unwrap();
    let reachable = voxelize::reachable(&truth, [([1 << 16; 3], 0)]);
    // Free and joined to (1, 1, 1): 500 less the human; and beside those, that human and the wall.
    assert_eq!(reachable.count(), 600);
    let voxel = |person, voxel| BodyVoxel { voxel, person, part: BodyPart::Body };
    let people = People { min_hits: 1, voxels: vec![voxel(0, [2, 2, 2]), voxel(1, [8, 2, 2])] };
    let reachable = Reachable { spoken_of: reachable.clone(), hit: reachable };
    let found = baselines(&truth, &region, &people, &reachable);
    let role = |tp, fn_, uo| RoleCounts { tp, fn_, uo };
    let (t, f) = (100 + 2 + 1, 1000 - 103);
    let mut missed = [0; BODY_PARTS];
    missed[BodyPart::Body as usize] = 1;
    let nobody = Detection { people: 2, parts: 2, missed, ..Detection::default() };
    let one = Detection { hit_human: 1, people_detected: 1, parts_detected: 1, ..nobody };
    let none = Confusion::default().with_detection(nobody);
    let all_occupied = Confusion { tp: t, fp: f, human: role(2, 0, 0), robot: role(1, 0, 0), ..none };
    let all_free = Confusion { fn_: t, tn: f, human: role(0, 2, 0), robot: role(0, 1, 0), ..none };
    let nothing_seen = Confusion { uo: t, uf: f, human: role(0, 0, 2), robot: role(0, 0, 1), ..none };
    let ceiling =
        Confusion { tp: 101, tn: 499, uo: 2, uf: 398, human: role(1, 0, 1), robot: role(0, 0, 1), ..none }
            .with_detection(one)
            .with_overlap(Overlap { twice: 600, hit_human_twice: 1 });
    assert_eq!(found, Baselines { all_occupied, all_free, nothing_seen, ceiling });
    assert!(
        [found.all_occupied, found.all_free, found.nothing_seen, found.ceiling]
            .iter()
            .all(|c| c.total() == 1000)
    );
}

fn tiny() -> Study {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/tiny.toml");
    Study::load(&path, &Overrides::default()).unwrap()
}

/// A sensor that is believed to stand before a wall, and in some repeats truly stands behind it.
#[test]
fn the_ceiling_has_what_mounts_that_are_off_may_hit() {
    let scenes = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes");
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("tiny")).unwrap();
    std::fs::copy(scenes.join("tiny/cell.toml"), folder.path().join("tiny/cell.toml")).unwrap();
    let off = [("seed = 7", "seed = 7\nrepeats = 200"), ("3.0]", "3.0]\ncalibration = { position_m = 1 }")];
    let text = std::fs::read_to_string(scenes.join("tiny.toml")).unwrap();
    let text = off.iter().fold(text, |text, (from, to)| text.replacen(from, to, 1));
    let path = folder.path().join("study.toml");
    std::fs::write(&path, text).unwrap();
    let hit = |noiseless| {
        let study = Study::load(&path, &Overrides { noiseless, ..Overrides::default() }).unwrap();
        let before = Setting::Pose(Pose { position_m: DVec3::new(4.2, 5.0, 5.0), ..Pose::ORIGIN });
        let of = |sensor: &Sensor| Arc::new(vec![before; sensor.candidates.len()]);
        let settings: Vec<_> = study.sensors.iter().map(of).collect();
        let Reachable { spoken_of, hit } =
            reachable(&study, [0, 0], &walled_truth(), &settings).ok().unwrap();
        [[2, 2, 2], [8, 2, 2]].map(|person| spoken_of.get(person) && hit.get(person))
    };
    assert_eq!((hit(true), hit(false)), ([true, false], [true, true]));
}

#[test]
fn evidence_over_a_window_counts_the_same_as_over_the_grid() {
    use perirobot_march::backend::{Backend, Fusion, Reading, Shot};
    let study = tiny();
    let world = World::prepare(&study, 0).unwrap().remove(0);
    let sensor = &study.sensors[1];
    let candidates = 0..sensor.candidates.len();
    let placements: Vec<_> = candidates.map(|c| world.placement(&study, 1, c, 0)).collect();
    let table = ray_tables(&study)[1].clone().unwrap();
    let mut cpu = perirobot_march::backend::cpu::Cpu::new(Some(1)).unwrap();
    let mut score = |window| {
        cpu.tables(std::slice::from_ref(&table)).unwrap();
        cpu.load(&world.scene(window)).unwrap();
        let shots: Vec<_> =
            (0..).zip(&placements).map(|(slot, placement)| Shot::once(slot, *placement)).collect();
        cpu.sense(0, &shots).unwrap();
        let alone =
            |shot: &Shot| vec![Reading { slot: shot.slot, volume: None, hit: 1, miss: -1, presence: false }];
        cpu.score(Fusion::OccupiedWins, &shots.iter().map(alone).collect::<Vec<_>>()).unwrap()
    };
    assert_eq!(score(region::window_of(&world.regions)), score(world.grid.window()));
}

#[test]
fn the_grid_grows_to_the_sensors_unless_bounds_say_otherwise() {
    let mut study = tiny();
    let surfaces = Window::from_corners([-12, -9, 0], [12, 9, 16]);
    let scenes = build(&study.scenes[0], &study.sources, study.voxel_size_m).unwrap();
    let grid = |study: &Study| {
        let settings = |sensor: &Sensor| sensor.settings(carrier(sensor, &scenes[0]).unwrap().as_ref());
        let settings = study.sensors.iter().map(|sensor| Arc::new(settings(sensor))).collect();
        grid(study, &scenes, &[settings], &surfaces)
    };
    assert_eq!(grid(&study).unwrap().window().size, surfaces.size);
    let above = Pose { position_m: DVec3::new(0.0, 0.0, 2.05), ..Pose::ORIGIN };
    study.sensors[0].candidates[1].setting = Setting::Pose(above);
    assert_eq!(grid(&study).unwrap().size, [25, 19, 21]);
    study.bounds_m = Some([DVec3::splat(-2.0), DVec3::splat(1.95)]);
    let outside = grid(&study).unwrap_err().to_string();
    assert!(outside.contains("pose wall/0/1 at [0, 0, 2.05] is outside grid.bounds_m"), "{outside}");
    study.bounds_m = Some([DVec3::splat(-2.0), DVec3::splat(2.05)]);
    // −2 to 2.05 at 0.1: the voxels −20 to 20, both ends inside.
    assert_eq!(grid(&study).unwrap().size, [41; 3]);
}

/// The wrist camera goes where the arm goes; its mount is off by as much wherever it is.
#[test]
fn a_mount_is_off_by_as_much_in_every_snapshot_and_inside_the_grid() {
    let path =
        std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/sensors.toml");
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    assert_eq!((study.repeats, worlds.len()), (2, 2));
    let mut errors = Vec::new();
    for (s, sensor) in study.sensors.iter().enumerate() {
        for (c, repeat) in (0..sensor.candidates.len()).flat_map(|c| [(c, 0), (c, 1)]) {
            let truths: Vec<_> = worlds.iter().map(World::truth).collect();
            let seen: Vec<_> = worlds
                .iter()
                .zip(&truths)
                .map(|(world, truth)| world.station(&study, truth, [s, c, repeat]))
                .collect();
            let truly: Vec<Option<Pose>> = seen.iter().map(|station| station.truly).collect();
            assert!(truly.iter().all(|pose| pose.is_some() == (sensor.name == "wrist")), "{}", sensor.name);
            let errors_here = seen.iter().zip(&truly).filter_map(|(station, truly)| {
                let (believed, truly) = (station.pose(), (*truly)?);
                let placement = station.placement(&*sensor.kind);
                let voxel = placement.truly?.origin_q16.map(|x| x >> 16);
                assert!(station.truth.grid.window().contains(voxel), "{voxel:?}");
                assert_ne!(placement.caster(), placement);
                let back = believed.rotation.inverse();
                Some((back * (truly.position_m - believed.position_m), back * truly.rotation))
            });
            let errors_here: Vec<_> = errors_here.collect();
            if let [(first, turn), (second, other_turn)] = errors_here[..] {
                assert!((first - second).length() < 1e-9 && turn.dot(other_turn).abs() > 1.0 - 1e-12);
                errors.push(first);
            }
        }
    }
    // Two poses, two repeats: none like another.
    assert_eq!(errors.len(), 4);
    assert!((0..4).all(|i| (0..i).all(|j| (errors[i] - errors[j]).length() > 1e-6)), "{errors:?}");
    let ideal = Study::load(&path, &Overrides { noiseless: true, ..Default::default() }).unwrap();
    assert!(
        ideal.sensors.iter().all(|sensor| sensor.kind.calibration().is_none() && !sensor.kind.is_noisy())
    );
}

/// Reflectances change no plane but the shades, and their hash.
#[test]
fn shades_have_a_hash_of_their_own() {
    let described = |share: &str| {
        let folder = tempfile::tempdir().unwrap();
        let scene = format!(
            "[[object]]\nname = \"hall\"\nroom = {{ size_m = [2, 2, 2] }}\nposition_m = [0, 0, 1]\n\
             [[object]]\nname = \"box\"\nbox = {{ size_m = [0.4, 0.4, 0.4] }}\nposition_m = [0, 0, 1]\nreflectance = {share}\n"
        );
        std::fs::write(folder.path().join("cell.toml"), scene).unwrap();
        let range = if share == "1.0" { "" } else { "reflectance_ranges_m = [[0.1, 1.0], [0.9, 3.0]]\n" };
        let study = format!(
            "[grid]\nvoxel_size_m = 0.1\n[[scene]]\nfile = \"cell.toml\"\n[[region]]\nname = \"all\"\n\
             box = {{ min_m = [-0.5, -0.5, 0.5], max_m = [0.5, 0.5, 1.5] }}\n[[sensor]]\nname = \"camera\"\n\
             kind = \"rgbd\"\nfov_deg = [60, 40]\nresolution_px = [8, 6]\nrange_m = [0.1, 3]\n{range}\
             poses = [{{ name = \"p\", list = [{{ position_m = [-0.8, 0, 1], facing = [1, 0, 0] }}] }}]\n"
        );
        let path = folder.path().join("study.toml");
        std::fs::write(&path, study).unwrap();
        let study = Study::load(&path, &Overrides::default()).unwrap();
        World::prepare_all(&study).unwrap()[0].described.clone()
    };
    let [plain, dark, bright] = ["1.0", "0.1", "0.2"].map(described);
    assert_eq!(plain.shades_sha256, None);
    assert!(dark.shades_sha256.is_some() && dark.shades_sha256 != bright.shades_sha256);
    assert_eq!(dark.blockers_sha256, bright.blockers_sha256);
    assert_eq!(described("0.1"), dark);
}
