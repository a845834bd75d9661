//! Every kind of sensor in one study that ships: the same bytes from the same seed whoever computes them and
//! however little of it is kept at once, other bytes from another, and sensors that go where the arm goes.

use crate::common::{self, program};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use perirobot_march::backend::gpu::Gpu;
use perirobot_march::backend::{
    Backend, Evidence, Fusion, GridPose, OverTime, Planes, Rays, Reading, Shot, Slot, VoxelScene, cpu::Cpu,
    oracle::Oracle,
};
use perirobot_march::metrics::Confusion;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::Optical;
use perirobot_scene::pose::Pose;
use perirobot_study::input::{Combination, Overrides, Study};
use perirobot_study::sensor::{MountLink, Setting, kinds};
use perirobot_study::world::World;
use perirobot_sweep::results::columns;
use perirobot_sweep::results::journal::Journal;
use perirobot_sweep::scoring::{Row, run};

const STUDY: &str = "scenes/sensors.toml";

fn load(overrides: &Overrides) -> Study {
    Study::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(STUDY), overrides).unwrap()
}

fn study() -> Study {
    load(&Overrides::default())
}

fn rows_by(study: &Study, backend: &mut dyn Backend) -> Vec<Row> {
    run(study, &World::prepare_all(study).unwrap(), backend).unwrap()
}

fn rows(study: &Study) -> Vec<Row> {
    rows_by(study, &mut Cpu::new(None).unwrap())
}

fn index(study: &Study, sensor: &str) -> usize {
    study.sensors.iter().position(|s| s.name == sensor).unwrap()
}

fn combination<'a>(study: &'a mut Study, name: &str) -> &'a mut Combination {
    study.combinations.iter_mut().find(|c| c.name == name).unwrap()
}

#[test]
fn the_study_has_everything() {
    let study = study();
    let found: BTreeSet<_> = study.sensors.iter().map(|s| s.kind.name()).collect();
    // A recording is no example that could be written by hand; `recorded.rs` sweeps some.
    let all: BTreeSet<_> = kinds::NAMES.iter().copied().filter(|kind| *kind != "recorded").collect();
    assert_eq!(found, all);
    assert_eq!((study.repeats, study.scenes[0].snapshots), (2, 2));
    let fusions: Vec<_> = study.combinations.iter().map(|c| c.fusion).collect();
    assert!(fusions.contains(&Fusion::Octomap) && fusions.contains(&Fusion::OccupiedWins));
    let noisy = |s: &str| study.sensors[index(&study, s)].kind.is_noisy();
    assert!(["camera", "wrist", "lidar", "scanner", "ring", "cover"].into_iter().all(noisy));
    assert!(!["watch", "pads", "gate", "robot"].into_iter().any(noisy));
    // All repeats and snapshots of all choices, representations and regions.
    let jobs = |c: &Combination| c.choices() * c.representations(&study.sensors).len();
    let expected = 4 * study.regions.len() * study.combinations.iter().map(jobs).sum::<usize>();
    assert_eq!(rows(&study).len(), expected);
    let spoken: Vec<_> =
        study.combinations[4].members.iter().map(|m| study.sensors[m.sensor].name.as_str()).collect();
    assert_eq!(
        spoken,
        ["gate", "pads", "camera", "wrist", "lidar", "ring", "cover", "robot"],
        "the robot last"
    );
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_every_backend() {
    let study = study();
    let first = rows_by(&study, &mut Cpu::new(Some(1)).unwrap());
    let mut others: Vec<Box<dyn Backend>> = vec![
        Box::new(Cpu::new(Some(1)).unwrap()),
        Box::new(Cpu::new(Some(2)).unwrap()),
        Box::new(Oracle::default()),
    ];
    if let Some(adapter) = common::adapter() {
        others.push(Box::new(Gpu::new(&adapter).unwrap()));
    }
    for backend in &mut others {
        assert!(rows_by(&study, &mut **backend) == first, "{} {}", backend.name(), backend.device());
    }
    let folder = program::Folder::new();
    let out = folder.path("out");
    let arguments = ["sweep", STUDY, "--out", program::text(&out), "--backend", "cpu", "--threads", "2"];
    let outcome = program::perirobot(&arguments);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let journal = Journal::read(&out).unwrap();
    let mut found = Vec::new();
    let keep = |_, counts| {
        found.push(counts);
        Ok(())
    };
    let damaged = journal.scan(keep).unwrap();
    assert!(damaged == 0 && found.into_iter().eq(first.iter().map(|row| row.counts)), "the program");
}

#[test]
fn another_seed_or_repeat_moves_what_is_noisy_and_nothing_else() {
    let mut study = study();
    let first = rows(&study);
    // Above 32 bits, where a seed counts as well.
    study.seed += 1 << 40;
    let second = rows(&study);
    for (c, combination) in study.combinations.iter().enumerate() {
        let noisy = combination.members.iter().any(|m| study.sensors[m.sensor].kind.is_noisy());
        let of = |rows: &[Row], repeat| -> Vec<Confusion> {
            let own = rows.iter().filter(|row| row.combination == c && row.repeat == repeat);
            own.map(|row| row.counts).collect()
        };
        assert_eq!(of(&first, 0) != of(&second, 0), noisy, "seed, {}", combination.name);
        assert_eq!(of(&first, 0) != of(&first, 1), noisy, "repeat, {}", combination.name);
    }
}

#[test]
fn points_without_noise_do_not_err() {
    let wrong = |noiseless: bool| {
        let mut study = load(&Overrides { noiseless, ..Default::default() });
        study.scenes[0].objects.iter_mut().for_each(|object| object.optical = Optical::Opaque);
        let points = ["camera", "lidar", "scanner"].map(|sensor| index(&study, sensor));
        study.combinations.truncate(3);
        for (combination, sensor) in study.combinations.iter_mut().zip(points) {
            combination.members[0].sensor = sensor;
            combination.members[0].candidates = (0..study.sensors[sensor].candidates.len()).collect();
        }
        let rows = rows(&study);
        points.map(|sensor| {
            let of = |row: &&Row| study.combinations[row.combination].members[0].sensor == sensor;
            // Points are the first representation of each.
            let own = rows.iter().filter(of).filter(|row| row.representation == 0);
            let counts: Vec<_> = own.map(|row| row.counts).collect();
            assert!(counts.iter().any(|c| c.tp > 0 && c.tn > 0));
            counts.iter().map(|c| c.fp + c.fn_).sum::<u64>()
        })
    };
    assert_eq!(wrong(true), [0, 0, 0]);
    assert!(wrong(false).iter().all(|&n| n > 0));
}

#[test]
fn a_part_of_the_poses_gives_the_same_rows_as_all() {
    let mut study = study();
    let name = "all, by odds";
    let named = |study: &Study| -> Vec<_> {
        let own = rows(study).into_iter().filter(|row| study.combinations[row.combination].name == name);
        own.map(|row| {
            let poses = columns::pose_names(study, &study.combinations[row.combination], row.choice);
            (row.snapshot, row.repeat, poses, row.representation, row.region, row.counts)
        })
        .collect()
    };
    let part = named(&study);
    let poses: BTreeSet<_> = part.iter().map(|row| row.2.as_str()).collect();
    assert_eq!(poses.len(), 6, "three pads, two cameras: {poses:?}");
    assert!(poses.iter().all(|poses| poses.contains("cover:0.2;watch:corners/0/0;scanner:floor/bench")));
    let all: Vec<usize> = study.sensors.iter().map(|s| s.candidates.len()).collect();
    let whole = combination(&mut study, name);
    whole.members.iter_mut().for_each(|m| m.candidates = (0..all[m.sensor]).collect());
    let whole: BTreeSet<_> = named(&study).into_iter().map(|row| format!("{row:?}")).collect();
    assert!(whole.len() > 50 * part.len());
    for row in part {
        assert!(whole.contains(&format!("{row:?}")), "{row:?}");
    }
}

/// A backend that keeps little, and knows what it was asked to keep.
struct Few {
    cpu: Cpu,
    slots: usize,
    kept: usize,
    /// How many placements' first hits it keeps, were it to keep any.
    first_hit_slots: usize,
    /// The still layers of the cells that were loaded, each once, and for each of these cells which numbers
    /// were given.
    layers: Vec<Arc<OverTime>>,
    numbers: Vec<(usize, BTreeSet<Slot>)>,
    /// What each number of the last layer stands for: a table, and a placement without its draws.
    stands_for: BTreeMap<Slot, (usize, GridPose)>,
    open: usize,
    most_open: usize,
}

impl Few {
    fn new(slots: usize) -> Few {
        Few {
            cpu: Cpu::new(None).unwrap(),
            slots,
            kept: 0,
            first_hit_slots: 0,
            layers: Vec::new(),
            numbers: Vec::new(),
            stands_for: BTreeMap::new(),
            open: 0,
            most_open: 0,
        }
    }

    /// Checks the number of a placement's first hits.
    fn find_hits(&mut self, table: usize, Shot { placement, first_hits, .. }: &Shot) {
        let Some(first_hits) = *first_hits else { return };
        assert!((first_hits as usize) < self.first_hit_slots, "{first_hits} of {}", self.first_hit_slots);
        let known = (table, GridPose { draws: 0, ..*placement });
        let first = *self.stands_for.entry(first_hits).or_insert(known);
        assert_eq!(first, known, "number {first_hits} stands for one placement while a layer is loaded");
        self.numbers.last_mut().unwrap().1.insert(first_hits);
    }

    fn keep(&mut self, slots: impl Iterator<Item = Slot>) {
        let slots: Vec<_> = slots.collect();
        assert!(slots.iter().all(|&slot| (slot as usize) < self.slots), "{slots:?} of {}", self.slots);
        assert_eq!(slots.iter().collect::<BTreeSet<_>>().len(), slots.len(), "a slot twice: {slots:?}");
        self.kept += slots.len();
    }
}

impl Backend for Few {
    fn name(&self) -> &'static str {
        "few"
    }

    fn device(&self) -> String {
        self.cpu.device()
    }

    fn tables(&mut self, tables: &[Rays]) -> Result<()> {
        self.cpu.tables(tables)
    }

    fn load(&mut self, scene: &VoxelScene) -> Result<()> {
        assert_eq!(self.open, 0, "questions are answered before another cell is loaded");
        let all = scene.over_time.as_ref().expect("all scenes here move");
        if !self.layers.last().is_some_and(|last| Arc::ptr_eq(last, all)) {
            assert!(!self.layers.iter().any(|layer| Arc::ptr_eq(layer, all)), "a layer comes back");
            self.layers.push(all.clone());
            self.stands_for.clear();
        }
        self.numbers.push((self.layers.len() - 1, BTreeSet::new()));
        self.cpu.load(scene)
    }

    fn slots(&self) -> usize {
        self.slots
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        shots.iter().for_each(|shot| self.find_hits(table, shot));
        self.keep(shots.iter().map(|shot| shot.slot));
        self.cpu.sense(table, shots)
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        self.keep(evidence.iter().map(|(slot, _)| *slot));
        self.cpu.upload(evidence)
    }

    fn first_hit_slots(&self) -> usize {
        self.first_hit_slots
    }

    fn submit(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        self.open += 1;
        self.most_open = self.most_open.max(self.open);
        self.cpu.submit(fusion, jobs)
    }

    fn receive(&mut self) -> Result<Vec<Vec<Confusion>>> {
        self.open -= 1;
        self.cpu.receive()
    }

    fn planes(&mut self, slots: &[Slot]) -> Result<Vec<Planes>> {
        self.cpu.planes(slots)
    }

    fn read(&mut self, table: usize, placement: &GridPose) -> Result<Evidence> {
        self.cpu.read(table, placement)
    }
}

#[test]
fn little_room_changes_no_row() {
    let study = study();
    let mut plenty = Few::new(4000);
    let expected = rows_by(&study, &mut plenty);
    // The largest combination takes 11: a camera's points and three volumes, and seven others.
    for slots in [11, 12, 17] {
        let mut few = Few::new(slots);
        assert!(rows_by(&study, &mut few) == expected, "{slots} slots");
        assert!(few.kept > plenty.kept, "{} of {} made again", few.kept, plenty.kept);
    }
    let mut small = study.clone();
    small
        .combinations
        .retain(|c| ["watch", "scanner", "wrist", "gate", "arm's own"].contains(&c.name.as_str()));
    combination(&mut small, "arm's own").members.pop();
    assert!(rows_by(&small, &mut Few::new(3)) == rows(&small));
}

#[test]
fn first_hits_are_kept_from_snapshot_to_snapshot() {
    let mut study = study();
    // The last stands on the arm.
    study.combinations.retain(|c| ["watch", "scanner", "wrist"].contains(&c.name.as_str()));
    let [camera, wrist] = ["camera", "wrist"].map(|sensor| index(&study, sensor));
    combination(&mut study, "watch").members[0].sensor = camera;
    let expected = rows(&study);
    let stays = |c: &Combination| if c.members[0].sensor == wrist { 0 } else { c.choices() };
    let all: usize = study.combinations.iter().map(stays).sum();
    assert!(study.sensors[wrist].on.is_some() && all > 3, "{all}");
    for first_hit_slots in [0, 1, 3, all, 1000] {
        let mut few = Few { first_hit_slots, ..Few::new(40) };
        assert!(rows_by(&study, &mut few) == expected, "{first_hit_slots} places for first hits");
        let groups = match first_hit_slots {
            0 => 1,
            _ => all.div_ceil(first_hit_slots),
        };
        assert_eq!((few.layers.len(), few.numbers.len()), (groups, 2 * groups), "{first_hit_slots} places");
        for group in few.numbers.chunks(2) {
            let [(layer, first), (same, second)] = group else { panic!("two snapshots a group") };
            assert_eq!((layer, first), (same, second), "each is found again in the other snapshot");
        }
        let numbered: usize = few.numbers.iter().map(|(_, numbers)| numbers.len()).sum();
        assert_eq!(numbered, if first_hit_slots == 0 { 0 } else { 2 * all }, "{first_hit_slots} places");
    }
    // One choice that has more sensors than places: what does not fit is cast each time.
    let mut whole = load(&Overrides::default());
    whole.combinations.retain(|c| c.members.len() == 8);
    let mut few = Few { first_hit_slots: 1, ..Few::new(40) };
    assert!(rows_by(&whole, &mut few) == rows(&whole));
    assert!(few.numbers.iter().all(|(_, numbers)| numbers.len() <= 1));
}

/// A sensor that stands still has its first hits kept, unless its mount is off: by another pose in each
/// repeat.
#[test]
fn no_first_hits_are_kept_of_a_mount_that_is_off() {
    let mut study = study();
    study.combinations.retain(|c| c.name == "watch");
    let [camera, wrist] = ["camera", "wrist"].map(|sensor| index(&study, sensor));
    study.sensors[camera].kind = study.sensors[wrist].kind.clone();
    assert!(study.sensors[camera].kind.calibration().is_some() && study.sensors[camera].on.is_none());
    combination(&mut study, "watch").members[0].sensor = camera;
    let expected = rows_by(&study, &mut Oracle::default());
    let of = |repeat| expected.iter().filter(move |row| row.repeat == repeat).map(|row| row.counts);
    assert!(!of(0).eq(of(1)), "repeats differ");
    assert!(rows(&study) == expected);
    let mut few = Few { first_hit_slots: 1000, ..Few::new(40) };
    assert!(rows_by(&study, &mut few) == expected);
    assert!(few.numbers.iter().all(|(_, numbers)| numbers.is_empty()));
}

/// The host prepares a batch while the backend works on the one before.
#[test]
fn two_batches_are_under_way() {
    let mut study = study();
    study.combinations.retain(|c| c.name == "watch");
    let (mut few, mut plenty) = (Few::new(4), Few::new(4000));
    assert!(rows_by(&study, &mut few) == rows_by(&study, &mut plenty));
    assert_eq!((few.most_open, few.open), (2, 0));
}

#[test]
fn evidence_is_made_once() {
    let mut study = study();
    study.combinations.retain(|c| ["camera and cover", "arm's own"].contains(&c.name.as_str()));
    let mut few = Few::new(4000);
    rows_by(&study, &mut few);
    // In each of 2 snapshots and 2 repeats 2 covers, 2 rings and 2 wrists; 4 cameras' points; the robot in
    // each snapshot. The rest are volumes around people, at most 3 a camera.
    let fixed = 4 * (2 + 2 + 2 + 4) + 2;
    assert!((fixed + 1..=fixed + 4 * 4 * 3).contains(&few.kept), "{}", few.kept);
}

#[test]
fn a_combination_that_cannot_fit_says_so() {
    let study = study();
    let worlds = World::prepare_all(&study).unwrap();
    let error = run(&study, &worlds, &mut Few::new(10)).unwrap_err();
    assert!(matches!(error, Error::Input(_)), "{error:?}");
    let expected =
        "combination \"all, cautiously\": the evidence of its sensors does not fit backend few at once (10 ";
    assert!(error.to_string().starts_with(expected), "{error}");
    assert!(error.to_string().contains("use larger voxels, smaller regions"), "{error}");
}

fn rounded(v: DVec3) -> [i64; 3] {
    v.to_array().map(|x| (x * 1e6).round() as i64)
}

#[test]
fn a_sensor_on_a_link_goes_where_the_link_goes() {
    let mut study = study();
    let [camera, lidar] = ["wrist", "lidar"].map(|sensor| index(&study, sensor));
    let mount = |study: &mut Study, sensor: usize, link: &str, pose: Pose| {
        study.sensors[sensor].on = Some(MountLink { object: "arm".into(), link: link.into() });
        study.sensors[sensor].candidates[0].setting = Setting::Pose(pose);
    };
    let offset = DVec3::new(0.1, 0.0, 0.05);
    mount(&mut study, camera, "shoulder_link", Pose::facing(offset, DVec3::X, 0.0, 0.0));
    mount(&mut study, lidar, "shoulder_link", Pose::upright(offset, DVec3::X, 0.0));
    let worlds = World::prepare_all(&study).unwrap();
    let pose = |world: usize, sensor: usize| worlds[world].settings[sensor][0].pose();
    // The base stands at (−0.8, 0, 0.8), the shoulder 0.1273 m above it; it pans by −100° and then by −70°,
    // from half a turn: to 80° and 110°.
    let (cos, sin) = (-0.342_020_143, 0.939_692_621);
    for sensor in [camera, lidar] {
        assert_eq!(
            rounded(pose(0, sensor).position_m),
            rounded(DVec3::new(-0.8 + 0.1 * 0.173_648_178, 0.1 * 0.984_807_753, 0.9773))
        );
        assert_eq!(
            rounded(pose(1, sensor).position_m),
            rounded(DVec3::new(-0.8 + 0.1 * cos, 0.1 * sin, 0.9773))
        );
    }
    assert_eq!(rounded(pose(1, camera).optical().z_axis), rounded(DVec3::new(cos, sin, 0.0)));
    assert_eq!(rounded(pose(1, camera).optical().y_axis), [0, 0, -1_000_000], "its picture stays upright");
    assert_eq!(rounded(pose(1, lidar).link().x_axis), rounded(DVec3::new(cos, sin, 0.0)));
    assert_eq!(rounded(pose(1, lidar).link().z_axis), [0, 0, 1_000_000]);
    // Every other sensor stands where it stood.
    assert_eq!(worlds[0].settings[index(&study, "watch")], worlds[1].settings[index(&study, "watch")]);

    // The upper arm is tilted as well: an upright LIDAR on it spins about the link's own z.
    mount(&mut study, lidar, "upper_arm_link", Pose::upright(DVec3::ZERO, DVec3::X, 0.0));
    let tilted = World::prepare_all(&study).unwrap()[1].settings[lidar][0].pose();
    assert!(tilted.link().z_axis.z.abs() < 0.99, "{}", tilted.link().z_axis);
}

#[test]
fn a_gate_on_a_link_without_poses_is_carried_by_it() {
    let mut study = study();
    let gate = index(&study, "gate");
    assert_eq!(World::prepare_all(&study).unwrap()[0].settings[gate][..], [Setting::Fixed]);
    study.sensors[gate].on = Some(MountLink { object: "arm".into(), link: "base_link".into() });
    let carried = World::prepare_all(&study).unwrap()[0].settings[gate][0].pose();
    assert_eq!(rounded(carried.position_m), [-800_000, 0, 800_000]);
}

/// What stands nowhere stretches no grid to the world's origin, and needs none inside its bounds.
#[test]
fn a_gate_without_poses_may_be_far_from_the_origin() {
    let folder = program::Folder::new();
    folder.write(
        "far.toml",
        "[[object]]\nname = \"arm\"\nrole = \"robot\"\nbox = { size_m = [1, 1, 1] }\nposition_m = [150, 0, 0]\n",
    );
    folder.write(
        "study.toml",
        "[grid]\nvoxel_size_m = 0.1\n[[scene]]\nfile = \"far.toml\"\n[[region]]\nname = \"r\"\n\
         sphere = { center_m = [150, 0, 0], radius_m = 0.6 }\n[[sensor]]\nname = \"gate\"\nkind = \"gate\"\n\
         box = { min_m = [149, -1, -1], max_m = [149.8, 1, 1] }\nzone = { min_m = [150, -1, -1], max_m = [151, 1, 1] }\n",
    );
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let poses = std::fs::read_to_string(folder.path("out/poses.csv")).unwrap();
    assert!(poses.ends_with("gate,here,gate,,,,,,,,,,\n"), "{poses}");
}
