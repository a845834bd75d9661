//! Plans of all shipped studies: well-formed, with all names, and nothing outside the drawing; and floor areas worked
//! out by hand.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};

use super::*;
use perirobot_study::input::Overrides;

fn shipped_study(file: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes").join(file)
}

fn coarse(file: &str) -> Study {
    let overrides = Overrides { voxel_size_m: Some(0.1), ..Overrides::default() };
    Study::load(&shipped_study(file), &overrides).unwrap()
}

fn first_of(combination: usize) -> Choice {
    Choice { combination, choice: 0, representation: 0, repeat: 0 }
}

/// The vertices of a path.
fn places(path: &str) -> Vec<[f64; 2]> {
    let (mut at, mut begin, mut all) = ([0.0; 2], [0.0; 2], Vec::new());
    let commands = path.split_inclusive(|c: char| c.is_alphabetic()).collect::<Vec<_>>();
    for pair in commands.windows(2) {
        let command = pair[0].chars().last().unwrap();
        let numbers = pair[1].trim_end_matches(|c: char| c.is_alphabetic());
        let numbers = numbers.replace('-', " -");
        let numbers: Vec<f64> = numbers.split_whitespace().map(|n| n.parse().unwrap()).collect();
        let mut go = |x: Option<f64>, y: Option<f64>, is_relative: bool| {
            let to =
                |now: f64, value: Option<f64>| value.map_or(now, |v| if is_relative { now + v } else { v });
            at = [to(at[0], x), to(at[1], y)];
            all.push(at);
        };
        match command {
            'H' | 'h' => numbers.iter().for_each(|&x| go(Some(x), None, command == 'h')),
            'V' | 'v' => numbers.iter().for_each(|&y| go(None, Some(y), command == 'v')),
            'M' | 'm' | 'L' | 'l' => {
                numbers.chunks(2).for_each(|xy| go(Some(xy[0]), Some(xy[1]), command.is_lowercase()));
                if command == 'M' {
                    begin = at;
                }
            }
            'Z' => at = begin,
            other => panic!("{other} in {path}"),
        }
    }
    all
}

fn class<'a>(node: &Node<'a, '_>) -> &'a str {
    node.attribute("class").unwrap_or_default()
}

#[track_caller]
fn number(node: &Node, name: &str) -> f64 {
    node.attribute(name).unwrap_or_else(|| panic!("no {name}")).parse().unwrap()
}

/// The place of a text.
#[track_caller]
fn place_of(node: &Node) -> [f64; 2] {
    match node.attribute("transform") {
        Some(moved) => {
            let numbers = moved.trim_start_matches("translate(").split(')').next().unwrap();
            let numbers: Vec<f64> = numbers.split(' ').map(|n| n.parse().unwrap()).collect();
            [numbers[0], numbers[1]]
        }
        None => ["x", "y"].map(|name| number(node, name)),
    }
}

/// Checks the drawing of a plan, and returns its words and classes.
#[track_caller]
fn check(what: &str, svg: &str) -> (Vec<String>, Vec<String>) {
    let document = Document::parse(svg).unwrap_or_else(|e| panic!("{what}: {e}"));
    let root = document.root_element();
    let view: Vec<f64> = root.attribute("viewBox").unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
    let inside = |[x, y]: [f64; 2], reach: f64, node: &Node| {
        let is_in = (reach..=view[2] - reach).contains(&x) && (reach..=view[3] - reach).contains(&y);
        assert!(
            is_in,
            "{what}: {:?} of class {} is at {x}, {y}, outside of {view:?}",
            node.tag_name(),
            class(node)
        );
    };
    let drawn =
        |node: &Node| !node.ancestors().any(|above| above.has_tag_name("defs") || above.has_tag_name("g"));
    for node in document.descendants().filter(|node| drawn(node)) {
        match node.tag_name().name() {
            "path" => places(node.attribute("d").unwrap()).into_iter().for_each(|at| inside(at, 0.0, &node)),
            "circle" => inside([number(&node, "cx"), number(&node, "cy")], number(&node, "r"), &node),
            "text" => inside(place_of(&node), 0.0, &node),
            _ => {}
        }
    }
    let words = document.descendants().filter(|node| node.has_tag_name("text") || node.has_tag_name("title"));
    let words = words.filter_map(|node| node.text().map(String::from)).collect();
    (words, document.descendants().map(|node| class(&node).to_string()).collect())
}

#[test]
fn every_study_that_ships_has_its_plans() {
    let files = [
        "quick.toml",
        "tiny.toml",
        "cheapest.toml",
        "choose.toml",
        "judge.toml",
        "approach.toml",
        "delivery.toml",
        "latching.toml",
        "sensors.toml",
        "tutorial/study.toml",
        "paper/exp1.toml",
        "paper/exp2.toml",
        "paper/lidar.toml",
    ];
    for file in files {
        let study = coarse(file);
        let worlds = World::prepare_all(&study).unwrap();
        for of_scene in worlds.chunk_by(|a, b| a.scene == b.scene) {
            // The combination of the most sensors draws the most.
            let most =
                (0..study.combinations.len()).max_by_key(|&c| study.combinations[c].members.len()).unwrap();
            let plan = floor_plan(&study, of_scene, of_scene.len() - 1, Some(first_of(most)));
            let what = format!("{file}, scene {}", of_scene[0].name);
            for svg in [plan.inline(), plan.alone()] {
                let (words, classes) = check(&what, &svg);
                let world = of_scene.last().unwrap();
                let truth = world.truth();
                for object in &truth.objects {
                    let is_low = object.bounds_m[0].z < 1.0 && object.bounds_m[1].z > 0.3;
                    let is_shown = object.role != Role::Environment || is_low;
                    let is_there = is_shown && !object.voxels.is_empty();
                    assert!(
                        !is_there || words.contains(&object.name),
                        "{what}: no {:?} in {words:?}",
                        object.name
                    );
                }
                for region in &world.regions {
                    let name = format!("region {}", region.name);
                    assert!(words.contains(&name), "{what}: no {name:?} in {words:?}");
                }
                for needed in ["floor", "ruler", "axis"] {
                    assert!(classes.iter().any(|class| class == needed), "{what}: no {needed}");
                }
                let badges = plan.sensors.iter().filter(|(letter, _)| letter.is_some()).count();
                let drawn = classes.iter().filter(|class| *class == "letter").count();
                assert_eq!(drawn, badges, "{what}: a letter for each sensor that stands somewhere");
            }
            let [floor, blind, hardly] = plan.floor_m2;
            assert!(floor > 0.5 && blind + hardly <= floor, "{what}: {:?}", plan.floor_m2);
            assert!(plan.inline().len() < 200_000, "{what}: {} bytes", plan.inline().len());
        }
    }
}

/// The texts of a class in a plan, with their middles.
fn words_of(plan: &FloorPlan, wanted: &str) -> Vec<(String, [f64; 2])> {
    let svg = plan.inline();
    let document = Document::parse(&svg).unwrap();
    let found = document.descendants().filter(|node| class(node) == wanted && node.has_tag_name("text"));
    found.map(|node| (node.text().unwrap().to_string(), place_of(&node))).collect()
}

#[test]
fn walls_have_the_names_that_poses_have() {
    let study = coarse("judge.toml");
    let worlds = World::prepare_all(&study).unwrap();
    let plan = floor_plan(&study, &worlds, 0, Some(first_of(0)));
    let [_, _, width, height] = plan.paper.view();
    let side = |[x, y]: [f64; 2]| match () {
        () if x < 0.1 * width => "-x",
        () if x > 0.9 * width => "+x",
        () if y < 0.1 * height => "+y",
        () => "-y",
    };
    let found: Vec<(String, &str)> =
        words_of(&plan, "of-wall").into_iter().map(|(name, at)| (name, side(at))).collect();
    let wanted = [("wall at -x", "-x"), ("wall at +x", "+x"), ("right wall", "-y"), ("left wall", "+y")];
    assert_eq!(found, wanted.map(|(name, side)| (name.to_string(), side)));
}

#[test]
fn what_a_sensor_sees_and_what_it_guards_are_told_apart() {
    let study = coarse("tutorial/study.toml");
    let worlds = World::prepare_all(&study).unwrap();
    let both = study.combinations.iter().position(|one| one.members.len() == 2).unwrap();
    let plan = floor_plan(&study, &worlds, 0, Some(first_of(both)));
    let mut labels: Vec<String> = words_of(&plan, "of-field").into_iter().map(|(words, _)| words).collect();
    labels.sort();
    assert_eq!(labels, ["guarded by B", "plane of B", "view of A"]);
    let (_, classes) = check("tutorial", &plan.inline());
    for class in ["field", "plane", "pad"] {
        assert_eq!(classes.iter().filter(|known| *known == class).count(), 1, "{class}");
        assert!(plan.legend.iter().any(|(known, _)| *known == class), "{class} is explained");
    }
}

#[test]
fn things_from_files_have_short_names() {
    assert_eq!(
        ["table", "plant/Fence*", "plant/a/Bench", "*", "plant/*", "bent/0"].map(short_name),
        ["table", "Fence", "Bench", "*", "plant/*", "bent/0"]
    );
}

/// The area of the shapes of a class, in square metres.
fn area_m2(plan: &FloorPlan, wanted: &str, scale: f64) -> f64 {
    let svg = plan.inline();
    let document = Document::parse(&svg).unwrap();
    let mut sum = 0.0;
    for node in document.descendants().filter(|node| class(node) == wanted && node.has_tag_name("path")) {
        for ring in node.attribute("d").unwrap().split('Z').filter(|ring| !ring.is_empty()) {
            let corners = places(&format!("{ring}Z"));
            let next = |i: usize| corners[(i + 1) % corners.len()];
            sum += (0..corners.len())
                .map(|i| next(i)[0] * corners[i][1] - corners[i][0] * next(i)[1])
                .sum::<f64>()
                / 2.0;
        }
    }
    sum / scale / scale
}

#[test]
fn blind_floor_is_what_no_ray_comes_over() {
    let study = coarse("approach.toml");
    let worlds = World::prepare_all(&study).unwrap();
    let truth = Arc::new(worlds[0].truth_without_people());
    let [one, both] = [0, 1].map(|combination| floor_plan(&study, &worlds, 0, Some(first_of(combination))));
    // Column by column, by hand: 4 m by 3 m of floor, with the robot and the shelf on it.
    let watch = Watchers::new(&study, first_of(0)).watch(&worlds[0], truth.clone());
    let mut blind = 0;
    for (x, y) in (0..40).flat_map(|x| (0..30).map(move |y| (x, y))) {
        let is_solid = |z: i32| truth.occupied.get([x, y, z]) || truth.ignored.get([x, y, z]);
        let is_floor = !is_solid(12);
        blind += u64::from(
            is_floor && (1..18).all(|z| !watch.voxels.get([x, y, z])) && (1..18).any(|z| !is_solid(z)),
        );
    }
    assert!(blind > 10, "{blind}");
    assert!((one.floor_m2[1] - blind as f64 / 100.0).abs() < 1e-9, "{:?}, {blind}", one.floor_m2);
    let scale = Paper::new(extent(&study, &worlds[0], None)).scale;
    for plan in [&one, &both] {
        for (class, wanted) in [("blind", plan.floor_m2[1]), ("hardly", plan.floor_m2[2])] {
            let drawn = area_m2(plan, class, scale);
            assert!((drawn - wanted).abs() < 0.01 * wanted.max(1.0), "{class}: {drawn} of {wanted} m²");
        }
    }
    assert!(both.floor_m2[1] < one.floor_m2[1] / 2.0, "a second camera looks behind the shelf");
    let (words, classes) = check("approach", &one.inline());
    assert!(
        words.iter().any(|word| word == "door") && classes.iter().any(|class| class == "entry"),
        "{words:?}"
    );
}

/// With `floor = "auto"` the floor is what carries a body that walks in by the door: here by hand, on one height.
#[test]
fn blind_floor_is_on_surfaces_that_are_walked_on() {
    let mut study = coarse("approach.toml");
    study.approach.step_m = Some(0.25);
    study.approach.bodies.truncate(1);
    let worlds = World::prepare_all(&study).unwrap();
    let truth = Arc::new(worlds[0].truth_without_people());
    let plan = floor_plan(&study, &worlds, 0, Some(first_of(0)));
    let watch = Watchers::new(&study, first_of(0)).watch(&worlds[0], truth.clone());
    // A person of 40 cm and 1.8 m is four voxels across without the corners, in layers 1 to 17; the floor is layer 0.
    let sole = |x: i32, y: i32| {
        let all = (0..4).flat_map(|i| (0..4).map(move |j| [i, j]));
        all.filter(|[i, j]| ![0, 3].contains(i) || ![0, 3].contains(j)).map(move |[i, j]| [x + i, y + j])
    };
    let is_solid = |voxel: [i32; 3]| {
        truth.occupied.get(voxel) || truth.ignored.get(voxel) || truth.robot_volume.get(voxel)
    };
    let has_room = |x: i32, y: i32| {
        let [width, depth, _] = truth.grid.size.map(|n| n as i32);
        let inside = (0..=width - 4).contains(&x) && (0..=depth - 4).contains(&y);
        inside && sole(x, y).all(|[x, y]| (1..18).all(|z| !is_solid([x, y, z])))
    };
    // The door goes from voxel 34 to 39 along x and from 5 to 24 along y.
    let mut places: Vec<[i32; 2]> = (34..=36).flat_map(|x| (5..=21).map(move |y| [x, y])).collect();
    let mut seen: BTreeSet<[i32; 2]> = places.iter().copied().collect();
    let mut floor = BTreeSet::new();
    while let Some([x, y]) = places.pop() {
        floor.extend(sole(x, y).filter(|[x, y]| truth.occupied.get([*x, *y, 0])));
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x + i, y + j]));
        places.extend(around.filter(|&[x, y]| has_room(x, y) && seen.insert([x, y])));
    }
    // The grid has a row and a column beyond the room.
    floor.retain(|[x, y]| *x < 40 && *y < 30);
    let is_blind = |[x, y]: &&[i32; 2]| (1..=18).all(|z| !watch.voxels.get([*x, *y, z]));
    let blind = floor.iter().filter(is_blind).count();
    assert!(blind > 10 && floor.len() > 500, "{blind} of {}", floor.len());
    for (found, expected) in [(plan.floor_m2[0], floor.len()), (plan.floor_m2[1], blind)] {
        assert!(
            (found - expected as f64 / 100.0).abs() < 1e-9,
            "{:?}, {blind} of {}",
            plan.floor_m2,
            floor.len()
        );
    }
}

#[test]
fn what_moves_is_drawn_at_all_its_moments() {
    let study = coarse("tutorial/study.toml");
    let worlds = World::prepare_all(&study).unwrap();
    let plan = floor_plan(&study, &worlds, 2, None);
    let (_, classes) = check("tutorial", &plan.inline());
    for wanted in ["robot", "robot other", "person", "person other", "mesh"] {
        assert!(classes.iter().any(|class| class == wanted), "no {wanted}");
    }
    // Walls from CAD are hollow, and so is the cabinet; the floor is above a slab of 10 cm.
    assert!(classes.iter().any(|class| class == "void"));
    let truth = worlds[2].truth();
    let storey = Storey::new(&truth, room_m(&truth), worlds[2].floor.z_m);
    let at = |x: f64, y: f64| {
        let [x, y, _] =
            perirobot_march::voxel::Grid::voxel_of(truth.grid.position_q16(DVec3::new(x, y, 0.0)));
        [x, y, 0]
    };
    let is_void = |x, y| storey.voids.get(at(x, y));
    assert_eq!([is_void(2.0, 1.55), is_void(0.0, -1.0), is_void(-1.8, 1.0)], [true, false, false]);
    assert!(truth.grid.corner_m([0, 0, storey.layers.start]).z >= 0.0, "{:?}", storey.layers);
    let low: f64 = area_m2(&plan, "low", Paper::new(extent(&study, &worlds[2], None)).scale);
    assert!(low < 6.0, "{low} m² of furniture in a cell of 20 m²");
    assert_eq!((plan.floor_m2, plan.sensors.len()), ([0.0; 3], 0));
    let legend: Vec<&str> = plan.legend.iter().map(|(_, meaning)| meaning.as_str()).collect();
    assert!(legend.contains(&"person; paler: person at other moments"), "{legend:?}");
}

#[test]
fn a_pad_is_the_floor_that_it_guards() {
    let study = coarse("paper/exp2.toml");
    let worlds = World::prepare(&study, 0).unwrap();
    let pads = study.combinations.iter().position(|one| one.name == "pad").unwrap();
    let plan = floor_plan(&study, &worlds, 0, Some(first_of(pads)));
    let drawn = area_m2(&plan, "pad", Paper::new(extent(&study, &worlds[0], None)).scale);
    assert!((drawn - 0.75).abs() < 0.01, "a pad of 1 m by 0.75 m, not {drawn} m²");
    let [floor, blind, hardly] = plan.floor_m2;
    assert!((floor - blind - 0.75).abs() < 0.16, "{floor} m² less a pad are blind, not {blind}");
    assert!(hardly <= 0.8, "a pad watches one layer: {hardly}");
}
