//! The studies and scenes that ship: each loads and prepares, and the paper's cell is where the paper puts
//! it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::{Backend, Fusion, Noise, Rays, Reading, Shot};
use perirobot_march::voxel::BitGrid;
use perirobot_scene::objects::{Role, build::build, octomap};
use perirobot_scene::pose::RotationFrame;
use perirobot_scene::source::Sources;
use perirobot_scene::truth::{Truth, voxelize};
use perirobot_study::input::{Overrides, Study, Wanted, load_scene};
use perirobot_study::sensor::{Camera, Station, placement};
use perirobot_study::world::{World, ray_tables};
use perirobot_sweep::results::jobs;

/// All `.toml` files below `scenes`, as (studies, scenes): a study has sensors.
fn shipped() -> (Vec<PathBuf>, Vec<PathBuf>) {
    let mut files = Vec::new();
    let mut open = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") && !path.ends_with("Cargo.toml") {
                files.push(path);
            }
        }
    }
    files.sort();
    files.into_iter().partition(|path| fs::read_to_string(path).unwrap().contains("[[sensor]]"))
}

fn study(name: &str) -> Study {
    Study::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name), &Overrides::default())
        .unwrap()
}

/// Experiment 1's scenes, prepared once for all tests.
fn paper() -> &'static [World] {
    static WORLDS: OnceLock<Vec<World>> = OnceLock::new();
    WORLDS.get_or_init(|| {
        let study = study("paper/exp1.toml");
        World::prepare_all(&study).unwrap()
    })
}

/// The voxel of a point in metres; points are chosen inside voxels.
fn voxel(truth: &Truth, x: f64, y: f64, z: f64) -> [i32; 3] {
    perirobot_march::voxel::Grid::voxel_of(truth.grid.position_q16([x, y, z].into()))
}

#[test]
fn every_study_loads_and_prepares_without_a_surprise() {
    let (studies, scenes) = shipped();
    assert!(studies.len() >= 4 && scenes.len() >= 4, "{studies:?} {scenes:?}");
    for path in studies {
        let study = Study::load(&path, &Overrides::default()).unwrap();
        for scene in 0..study.scenes.len() {
            let world = World::prepare(&study, scene).unwrap().remove(0);
            assert!(!world.truth().human.is_empty() && !world.truth().robot.is_empty(), "{}", path.display());
            // Four of the paper's pads stand under legs of the table, and are not tared.
            let is_table = |warning: &str| path.ends_with("exp2.toml") && warning.contains("trips 4 of 24");
            // What is near the robot of the shelf's cell reaches beyond its bounds.
            let is_near =
                |warning: &str| path.ends_with("approach.toml") && warning.starts_with("region \"near@");
            // What its verdicts take for granted is its subject.
            let is_latch =
                |warning: &str| path.ends_with("latching.toml") && warning.contains("latches: people");
            for warning in &world.warnings {
                let is_known = is_table(warning) || is_near(warning) || is_latch(warning);
                assert!(is_known, "{}: {warning}", path.display());
            }
        }
    }
    for path in scenes {
        // A scene beside others may use their meshes; its studies lie above them.
        let sources = Sources::from_main(&path).allow_outside();
        build(&load_scene(&path, &sources).unwrap(), &sources, 0.05).unwrap();
    }
}

#[test]
fn experiment_1_has_the_papers_poses() {
    let study = study("paper/exp1.toml");
    let [camera, zone] = &study.sensors[..] else { panic!("two sensors") };
    assert_eq!(zone.candidates, camera.candidates);
    assert_eq!(camera.kind.representations(), ["points", "spheres", "cylinders", "box"]);
    let mut groups = BTreeMap::new();
    for candidate in &camera.candidates {
        *groups.entry(candidate.group.as_str()).or_insert(0) += 1;
    }
    let expected =
        [("back-wall", 105), ("ceiling", 350), ("front-wall", 105), ("left-wall", 150), ("right-wall", 150)];
    assert_eq!(groups, BTreeMap::from(expected));
    assert_eq!((camera.candidates.len(), study.scenes.len(), study.regions.len()), (860, 3, 2));
    assert_eq!(jobs(&study), 2 * 860 * 3);
    // Position 12 of the right wall: x −2.2 + 4 · 0.5, z 1.5; its orientation 3 is panned left and tilted
    // down.
    let pose = camera.candidates.iter().find(|c| c.name == "right-wall/12/3").unwrap().setting.pose();
    assert!((pose.position_m - glam::DVec3::new(-0.2, -1.9, 1.5)).length() < 1e-12, "{}", pose.position_m);
    let ahead = pose.link().x_axis;
    assert!(ahead.x < -0.3 && ahead.y > 0.8 && ahead.z < -0.3, "{ahead}");
    // Every straight pose looks into the room, and away from its wall.
    for candidate in camera.candidates.iter().filter(|c| c.name.ends_with("/0")) {
        let (at, ahead) = (candidate.setting.pose().position_m, candidate.setting.pose().link().x_axis);
        assert!((at + 0.5 * ahead).abs().cmplt(glam::DVec3::new(3.0, 2.0, 3.0)).all(), "{}", candidate.name);
    }
}

#[test]
fn experiment_2_has_the_papers_choices() {
    let study = study("paper/exp2.toml");
    let poses: Vec<usize> = study.sensors.iter().map(|sensor| sensor.candidates.len()).collect();
    assert_eq!(
        (poses, study.scenes.len(), study.repeats),
        (vec![24, 9, 3, 1], 3, 1),
        "pads, camera, cover, robot"
    );
    let choices: Vec<(&str, usize)> =
        study.combinations.iter().map(|c| (c.name.as_str(), c.choices())).collect();
    #[rustfmt::skip]
    assert_eq!(choices, [
        ("pad + camera + cover", 648), ("pad + camera", 216), ("pad + cover", 72), ("camera + cover", 27),
        ("pad", 24), ("camera", 9), ("cover", 3),
    ]);
    for combination in &study.combinations {
        assert_eq!(combination.fusion, Fusion::Octomap, "{}", combination.name);
        assert_eq!(combination.members.last().unwrap().sensor, 3, "{}: the robot is known", combination.name);
    }
    assert_eq!(jobs(&study), 3 * (648 + 216 + 72 + 27 + 36));
}

/// The authors' table triggers 8 pads, 4 on either side; ours triggers the 4 on the far side. The legs fill
/// the same voxels in both, from −0.5 to 0.55 on y, and pads end at y = −0.5: half-open as all boxes here, a
/// pad has no voxel that begins there, while theirs take it in.
#[test]
fn the_table_alone_triggers_four_pads() {
    let study = study("paper/exp2.toml");
    let mut truth = Truth::clone(&paper()[0].truth());
    let occupied = Arc::make_mut(&mut truth.occupied);
    occupied.remove(&truth.human);
    occupied.remove(&truth.robot);
    let pads = &study.sensors[0];
    let pressed: Vec<[f64; 2]> = (pads.candidates.iter())
        .filter(|pad| {
            let window = truth.grid.window();
            let at = Station {
                moment: [0, 0],
                truth: &truth,
                window,
                setting: pad.setting,
                rays: None,
                truly: None,
                draws: 0,
            };
            !pads.kind.claims(&at).swap_remove(0).planes.unwrap().occupied.is_empty()
        })
        .map(|pad| [pad.setting.pose().position_m.x, pad.setting.pose().position_m.y])
        .collect();
    assert_eq!(pads.candidates.len(), 24);
    assert_eq!(pressed, [[-1.0, 0.5], [-0.5, 0.5], [0.5, 0.5], [1.0, 0.5]], "corners of the pads");
}

/// Where the observer of Experiment 3 stands in each snapshot: along the table, around its corner, and back.
fn walk() -> Vec<[f64; 2]> {
    let along = (0..9).map(|i| [-0.25 + 0.25 * f64::from(i), 0.9]);
    let around = [0.65, 0.4, 0.15, -0.1, -0.35].map(|y| [1.75, y]);
    let there: Vec<[f64; 2]> = along.chain(around).collect();
    there.iter().chain(there.iter().rev().skip(1)).copied().collect()
}

#[test]
fn the_best_three_cameras_are_sought_among_the_poses_of_experiment_1() {
    let [all, asked] = ["paper/exp1.toml", "paper/exp1-choose.toml"].map(study);
    assert_eq!(asked.sensors[0].candidates, all.sensors[0].candidates);
    assert_eq!(asked.sensors[0].candidates.len(), 860);
    assert_eq!((asked.scenes[0].path.clone(), asked.sensors.len()), (all.scenes[0].path.clone(), 1));
    let choose = asked.choose.as_ref().and_then(Wanted::best).unwrap();
    assert_eq!((choose.at_most, choose.budget), (3, None));
}

#[test]
fn experiment_3_has_the_papers_poses_and_snapshots() {
    let study = study("paper/exp3.toml");
    let [lidar] = &study.sensors[..] else { panic!("one sensor") };
    let cone = &self::study("paper/lidar.toml").sensors[0];
    assert_eq!((lidar.name.as_str(), &lidar.candidates), ("cone-45", &cone.candidates));
    let with_noise = format!("{:?}", cone.kind).replace("{ std_m: 0.0", "{ std_m: 0.01");
    assert!(format!("{:?}", lidar.kind) == with_noise, "cone-45 with noise of 0.01 m");
    assert_eq!((study.scenes[0].snapshots, jobs(&study)), (27, 27 * 172));
    let observer = study.scenes[0].objects.iter().find(|object| object.name == "observer").unwrap();
    let (places, turns) = (&observer.motion.position_m, &observer.motion.rotation);
    assert_eq!((walk().len(), places.len(), turns.len()), (27, 27, 27));
    for (i, (place, [x, y])) in places.iter().zip(walk()).enumerate() {
        assert!((*place - glam::DVec3::new(x, y, 0.0)).length() < 1e-9, "snapshot {i}: {place}");
        // It looks where it goes next, and at the end where it came to.
        let from = i.min(25);
        let ahead = (places[from + 1] - places[from]).normalize();
        assert!((turns[i] * glam::DVec3::X - ahead).length() < 1e-9, "snapshot {i}");
    }
}

#[test]
fn nobody_walks_into_anything_in_experiment_3() {
    let worlds = World::prepare(&study("paper/exp3.toml"), 0).unwrap();
    for (world, [x, y]) in worlds.iter().zip(walk()) {
        let truth = world.truth();
        let part = |name: &str| &truth.objects.iter().find(|o| o.name == name).unwrap().voxels;
        for (a, b) in [
            ("observer", "table"),
            ("observer", "robot"),
            ("observer", "operator"),
            ("operator", "table"),
            ("operator", "robot"),
        ] {
            let mut both = part(a).clone();
            both.keep(part(b));
            assert!(
                both.is_empty(),
                "snapshot {}: {a} and {b} share {} voxels",
                world.snapshot,
                both.count()
            );
        }
        let above = voxel(&world.truth(), x + 0.01, y + 0.01, 0.0);
        let column = (above[2]..40).filter(|z| part("observer").get([above[0], above[1], *z])).count();
        assert!(column > 0, "snapshot {}: the observer is at {x}, {y}", world.snapshot);
    }
    assert_eq!(worlds.len(), 27);
    assert!(worlds.windows(2).all(|pair| pair[0].regions[1].voxels == pair[1].regions[1].voxels));
}

#[test]
fn the_lidar_study_casts_the_papers_rays() {
    let study = study("paper/lidar.toml");
    let tables = ray_tables(&study);
    let rays = |i: usize| &tables[i].as_ref().unwrap().dirs_q15;
    assert_eq!((rays(0).len(), rays(1).len()), (515 * 65, 515 * 79));
    assert!(study.sensors.iter().all(|sensor| sensor.candidates.len() == 172));
    // No ray is farther than 45° (and 55°) from the spin axis, which looks into the room.
    for (i, cone_deg) in [(0, 45f64), (1, 55.0)] {
        let least = rays(i).iter().map(|dir| dir[2]).min().unwrap();
        let expected = (cone_deg.to_radians().cos() * 32_768.0).round() as i32;
        assert!((least - expected).abs() <= 1, "{least}, expected {expected}");
        let sensor = &study.sensors[i];
        let wall = sensor.candidates.iter().find(|c| c.group == "right-wall").unwrap();
        let placement = placement(&*sensor.kind, &wall.setting.pose(), &paper()[0].grid, 0);
        assert_eq!(placement.axis_q15.map(|row| row[2]), [0, 32_768, 0], "the axis looks along +y");
    }
}

#[test]
fn the_cell_is_121_by_81_by_61_voxels() {
    for world in paper() {
        let grid = world.grid;
        assert_eq!((grid.size, grid.origin), ([121, 81, 61], [-60, -40, 0]), "{}", world.name);
        // Floor, ceiling and four walls, each one layer.
        let truth = world.truth();
        let walls = &truth.objects.iter().find(|o| o.name == "cell").unwrap().voxels;
        assert_eq!(walls.count(), 121 * 81 * 61 - 119 * 79 * 59, "{}", world.name);
    }
}

#[test]
fn the_table_stands_where_it_should() {
    for world in paper() {
        let truth = &world.truth();
        let table = &truth.objects.iter().find(|o| o.name == "table").unwrap();
        let has = |x, y, z| table.voxels.get(voxel(truth, x, y, z));
        // The top's faces at 0.9 and 1.0 m, and its rim; a surface on a boundary fills the upper layer.
        assert!(has(0.62, 0.02, 1.02) && has(0.62, 0.02, 0.92), "faces of the top");
        assert!(!has(0.62, 0.02, 0.97) && !has(0.62, 0.02, 1.07) && !has(0.62, 0.02, 0.87), "a hollow shell");
        assert!(has(-0.18, 0.02, 0.97) && has(1.52, 0.02, 0.97), "from x −0.2 to 1.5");
        assert!(has(0.62, -0.48, 0.97) && has(0.62, 0.52, 0.97), "from y −0.5 to 0.5");
        assert!(!has(-0.23, 0.02, 0.97) && !has(1.57, 0.02, 0.97));
        for (x, y) in [(-0.2, -0.5), (1.4, -0.5), (1.4, 0.4), (-0.2, 0.4)] {
            assert!(has(x + 0.02, y + 0.02, 0.42) && has(x + 0.12, y + 0.02, 0.42), "leg at {x}, {y}");
            assert!(!has(x + 0.07, y + 0.07, 0.42) && !has(x + 0.17, y + 0.02, 0.42), "leg at {x}, {y}");
        }
        assert!(!has(0.62, 0.02, 0.42), "nothing under the table");
        assert_eq!(table.watertight, Some(true));
    }
}

#[test]
fn people_and_robot_are_there_and_apart() {
    for (world, people) in paper().iter().zip([1, 1, 2]) {
        let truth = &world.truth();
        let humans: Vec<_> = truth.objects.iter().filter(|o| o.role == Role::Human).collect();
        assert_eq!(humans.len(), people, "{}", world.name);
        assert!(humans.iter().all(|human| human.voxels.count() > 1000), "{}", world.name);
        assert!(truth.robot.count() > 300, "{}", world.name);
        assert!(truth.robot.get(voxel(truth, 0.08, 0.02, 1.05)), "the arm stands at (0, 0, 1)");
        let mut both = truth.human.clone();
        both.keep(&truth.robot);
        assert!(both.count() <= 20, "{}: {} voxels are both", world.name, both.count());
        let near = |x: f64, y: f64| {
            humans.iter().any(|h| {
                let middle = (h.bounds_m[0] + h.bounds_m[1]) / 2.0;
                (middle.x - x).abs() < 0.4 && (middle.y - y).abs() < 0.4
            })
        };
        assert!(near(0.35, -0.8), "{}: an operator around (0.2…0.5, −0.8)", world.name);
        assert_eq!(near(0.3, 0.8), people == 2, "{}: the second person", world.name);
    }
    let feet =
        |i: usize| paper()[i].truth().objects.iter().find(|o| o.name == "operator").unwrap().bounds_m[0].z;
    assert!(feet(0) < 0.05 && feet(2) > 0.05, "Scene 3's operator does not touch the floor");
}

/// A scene in a folder of its own, with the shipped table beside it.
fn scene_with(
    toml: &str,
) -> (tempfile::TempDir, perirobot_march::Result<Vec<perirobot_scene::objects::Scene>>) {
    let folder = tempfile::tempdir().unwrap();
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper/table.glb");
    fs::copy(table, folder.path().join("table.glb")).unwrap();
    let people = octomap::write(0.05, [10, 10, 0], [4, 4, 36], &|_| Some(true));
    fs::write(folder.path().join("people.bt"), people).unwrap();
    let voxel = octomap::write(0.05, [0, 0, 0], [40, 40, 40], &|key| Some(key[2] == 0 || key[0] == 39));
    fs::write(folder.path().join("cell.bt"), voxel).unwrap();
    let path = folder.path().join("scene.toml");
    fs::write(&path, toml).unwrap();
    let sources = Sources::from_main(&path);
    let scene = load_scene(&path, &sources).and_then(|spec| build(&spec, &sources, 0.05));
    (folder, scene)
}

fn truth_of(toml: &str) -> Truth {
    let scene = scene_with(toml).1.unwrap();
    let grid = voxelize::grid_over(&voxelize::scene_extent(&scene, 0.05).unwrap(), 0.05).unwrap();
    perirobot_scene::truth::voxelize_all(&scene, grid).unwrap().remove(0)
}

#[test]
fn nodes_of_one_file_take_their_own_parts() {
    const TABLE: &str = "[[object]]\nname = \"table\"\nmesh = \"table.glb\"\n";
    let nodes = |rules: &str| truth_of(&format!("{TABLE}{rules}"));
    let names = |truth: &Truth| truth.objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    let whole = nodes("");
    assert_eq!(names(&whole), ["table"]);

    let glass = nodes("[[object.nodes]]\nmatch = \"Leg*\"\noptical = \"see_through\"\n");
    assert_eq!(names(&glass), ["table", "table/Leg*"]);
    assert_eq!(glass.occupied, whole.occupied, "it is there");
    let mut passed = BitGrid::clone(&glass.occupied);
    passed.remove(&glass.blockers);
    assert!(passed.count() > 0 && passed.get(voxel(&glass, -0.18, -0.48, 0.42)), "and rays pass");
    assert!(glass.blockers.get(voxel(&glass, 0.62, 0.02, 1.02)), "the top stops them");

    let gone = nodes("[[object.nodes]]\nmatch = \"Leg*\"\nignore = true\n");
    assert_eq!(names(&gone), ["table"]);
    assert_eq!(gone.grid.size[2], 3, "the top's three layers are left");

    let robot = nodes(
        "[[object.nodes]]\nmatch = \"Leg1\"\nrole = \"robot\"\n[[object.nodes]]\nmatch = \"Leg?\"\nrole = \"human\"\n",
    );
    assert_eq!(names(&robot), ["table", "table/Leg1", "table/Leg?"]);
    assert!(robot.robot.get(voxel(&robot, -0.18, -0.48, 0.42)), "the first rule that matches");
    assert!(!robot.human.get(voxel(&robot, -0.18, -0.48, 0.42)));
    assert!(robot.human.get(voxel(&robot, 1.42, -0.48, 0.42)));
    assert_eq!(robot.occupied, whole.occupied);

    // A rule for a node covers what is below it.
    assert_eq!(names(&nodes("[[object.nodes]]\nmatch = \"Table\"\nrole = \"robot\"\n")), ["table/Table"]);
    let unknown = scene_with(&format!("{TABLE}[[object.nodes]]\nmatch = \"leg*\"\n")).1.unwrap_err();
    assert!(unknown.to_string().contains("Leg1, Leg2, Leg3, Leg4, Top"), "{unknown}");
}

#[test]
fn an_octomap_is_truth_and_another_tags_the_people_in_it() {
    let walls = "[[object]]\nname = \"cell\"\noctomap = \"cell.bt\"\ninterior = \"free\"\n";
    let people = "[[object]]\nname = \"people\"\nrole = \"human\"\noctomap = \"people.bt\"\n";
    let tagged = truth_of(&format!("{walls}{people}tag_only = true\n"));
    assert_eq!((tagged.grid.size, tagged.grid.origin), ([40; 3], [0; 3]), "lines up with the map's keys");
    assert_eq!(tagged.occupied.count(), 40 * 40 + 40 * 39);
    assert_eq!((tagged.human.count(), &tagged.blockers), (4 * 4 * 36, &tagged.occupied));
    let solid = truth_of(&format!("{walls}{people}"));
    assert_eq!(solid.occupied.count(), 40 * 40 + 40 * 39 + 4 * 4 * 35, "one layer stands in the floor");
    assert_eq!(solid.human, tagged.human);
}

/// A quick proof that a shipped cell is not blind: a camera in it sees the operator.
#[test]
fn the_best_of_a_few_poses_sees_the_operator() {
    let (study, world) = (study("paper/exp1.toml"), &paper()[0]);
    let small = Camera { fov_rad: [87f64, 58.0].map(f64::to_radians), resolution_px: [128, 72] };
    let table = ray_tables(&study)[0].clone().unwrap();
    let mut cpu = Cpu::new(None).unwrap();
    cpu.tables(&[Rays {
        dirs_q15: small.dirs_q15().into(),
        image: Some(small.image()),
        noise: Noise::default(),
        ..table
    }])
    .unwrap();
    cpu.load(&world.scene(world.grid.window())).unwrap();
    let poses = (0..860).step_by(25).map(|pose| world.placement(&study, 0, pose, 0));
    let shots: Vec<_> = (0..).zip(poses).map(|(slot, placement)| Shot::once(slot, placement)).collect();
    cpu.sense(0, &shots).unwrap();
    let alone =
        |shot: &Shot| vec![Reading { slot: shot.slot, volume: None, hit: 1, miss: -1, presence: false }];
    let counts = cpu.score(Fusion::OccupiedWins, &shots.iter().map(alone).collect::<Vec<_>>()).unwrap();
    let best = counts.iter().filter_map(|regions| regions[1].human_seen()).fold(0.0, f64::max);
    assert!(best > 0.2, "{best}");
    assert!(counts.iter().flatten().all(|c| c.fp + c.fn_ == 0), "nothing is see-through");
    assert_eq!(RotationFrame::default(), RotationFrame::Link);
}
