//! Makes the meshes that ship with the paper's scenes, the tutorial and the palletising cell, and checks that the committed files
//! are these, that they load as meant, and that the people beside them are people and stand in nothing.
//!
//! `PERIROBOT_REGENERATE=1 cargo test --test input generated_meshes` writes the files instead.

use std::path::{Path, PathBuf};

use crate::common::glb::{self, GlbNode, group, part};
use crate::common::{palletiser, tutorial};
use glam::DVec3;
use perirobot_scene::objects::keypoints::{JointLayout, KeypointFile, Keypoints};
use perirobot_scene::objects::mannequin::body;
use perirobot_scene::objects::{Mesh, Surface, build, gltf};
use perirobot_scene::source::Sources;
use perirobot_study::input::load_scene;

/// Largest distance between a round limb and its triangles, in metres.
const SAG: f64 = 0.002;
/// People in world coordinates, then those whom the scenes of the third experiment and of the tutorial move.
const PEOPLE: [&str; 6] = [
    "scene1_operator",
    "scene2_operator",
    "scene3_operator",
    "scene3_second",
    "exp3_observer",
    "../tutorial/operator",
];

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper").join(name)
}

/// The table of the paper's cell: its top is 1 m high, flush with the legs. Corners are in world coordinates,
/// not moved by nodes, so that f32 rounds each of them only once.
fn table() -> GlbNode {
    let leg = |name, x: f64, y: f64| part(name, [x, y, 0.0], [x + 0.1, y + 0.1, 0.9]);
    let children = vec![
        part("Top", [-0.2, -0.5, 0.9], [1.5, 0.5, 1.0]),
        leg("Leg1", -0.2, -0.5),
        leg("Leg2", 1.4, -0.5),
        leg("Leg3", 1.4, 0.4),
        leg("Leg4", -0.2, 0.4),
    ];
    group("Table", children)
}

/// Panics unless a file that ships holds these bytes; writes them first where that is asked for.
#[track_caller]
fn assert_shipped(path: &Path, bytes: &[u8]) {
    if std::env::var("PERIROBOT_REGENERATE").is_ok_and(|value| value == "1") {
        std::fs::write(path, bytes).unwrap();
    }
    let committed = std::fs::read(path).unwrap_or_default();
    let difference = (0..bytes.len().max(committed.len())).find(|i| bytes.get(*i) != committed.get(*i));
    let cure = "see the top of this file for how to write it anew";
    assert_eq!(difference, None, "{} differs from this byte on; {cure}", path.display());
}

#[test]
fn shipped_meshes_are_the_generated_bytes() {
    assert_shipped(&shipped("table.glb"), &glb::bytes(&table()));
    assert_shipped(&shipped("../tutorial/cell.glb"), &glb::bytes(&tutorial::cell()));
    assert_shipped(&shipped("../tutorial/gearbox.stl"), &tutorial::gearbox());
    assert_shipped(&shipped("../palletiser/plant.glb"), &glb::bytes(&palletiser::plant()));
    assert_shipped(&shipped("../palletiser/pallet.stl"), &palletiser::pallet());
    assert_shipped(&shipped("../palletiser/gripper.stl"), &palletiser::gripper());
}

/// Loads a shipped mesh as (path of names, mesh).
fn load(name: &str) -> Vec<(String, Mesh)> {
    let nodes =
        gltf::Gltf::load(&shipped(name), &Sources::from_main(&shipped(name))).unwrap().parts(None).unwrap();
    (nodes.into_iter()).map(|node| (node.names.join("/"), node.mesh)).collect()
}

#[test]
fn the_table_stands_where_the_study_expects_it() {
    #[rustfmt::skip]
    let expected = [
        ("Table/Top", [-0.2, -0.5, 0.9], [1.5, 0.5, 1.0]),
        ("Table/Leg1", [-0.2, -0.5, 0.0], [-0.1, -0.4, 0.9]),
        ("Table/Leg2", [1.4, -0.5, 0.0], [1.5, -0.4, 0.9]),
        ("Table/Leg3", [1.4, 0.4, 0.0], [1.5, 0.5, 0.9]),
        ("Table/Leg4", [-0.2, 0.4, 0.0], [-0.1, 0.5, 0.9]),
    ];
    let nodes = load("table.glb");
    assert_eq!(nodes.len(), expected.len());
    for ((name, mesh), (expected_name, low, high)) in nodes.iter().zip(expected) {
        assert_eq!(name, expected_name);
        let as_stored = |corner: [f64; 3]| DVec3::from(corner.map(|x| f64::from(x as f32)));
        assert_eq!(mesh.bounds(), Some((as_stored(low), as_stored(high))), "{name}");
        assert_closed(name, mesh);
    }
}

/// The tutorial's scene turns, scales and places what its files hold, and leaves the dimensions out.
#[test]
fn the_tutorials_parts_stand_where_its_text_says() {
    let file = shipped("../tutorial/cell.toml");
    let sources = Sources::from_main(&file);
    let scene = &build::build(&load_scene(&file, &sources).unwrap(), &sources, 0.05).unwrap()[0];
    let bounds = |name: &str| {
        let meshes = scene.objects.iter().filter(|object| object.name.starts_with(name));
        let bounds = meshes.filter_map(|object| {
            let Surface::Mesh(mesh) = &object.surface else { panic!("{name} is a mesh") };
            mesh.bounds()
        });
        bounds.reduce(|(a, b), (c, d)| (a.min(c), b.max(d))).unwrap()
    };
    for (name, low, high) in [
        ("plant", [-2.6, -2.1, -0.1], [2.6, 2.1, 3.1]),
        // 300 x 200 mm; its shaft sticks out towards the person.
        ("gearbox", [-0.15, -0.2, 0.8], [0.15, 0.1, 1.02]),
    ] {
        let (found_low, found_high) = bounds(name);
        let off = (found_low - DVec3::from(low)).abs().max((found_high - DVec3::from(high)).abs());
        assert!(off.max_element() < 1e-6, "{name}: {found_low} to {found_high}");
    }
    for (name, mesh) in ["../tutorial/cell.glb", "../palletiser/plant.glb"].into_iter().flat_map(load) {
        assert_closed(&name, &mesh);
    }
}

/// Panics unless each edge is used equally often in both directions.
#[track_caller]
fn assert_closed(name: &str, mesh: &Mesh) {
    let mut balance = std::collections::HashMap::new();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *balance.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    assert!(balance.values().all(|count| *count == 0), "{name} is open");
}

fn person(name: &str) -> Keypoints {
    let file = shipped(&format!("{name}.csv"));
    let table = KeypointFile { path: file.clone(), layout: JointLayout::Coco17 };
    let keypoints = table.read(&Sources::from_main(&file)).unwrap();
    assert!(keypoints.iter().all(Option::is_some), "{name} lacks a joint");
    keypoints
}

#[test]
fn people_have_the_bones_of_an_adult() {
    // Pairs of joints in COCO's numbers, with the length of the bone between them in a person of 1.75 m.
    let bones = [
        (5, 6, 0.36),
        (5, 7, 0.3),
        (6, 8, 0.3),
        (7, 9, 0.26),
        (8, 10, 0.26),
        (11, 12, 0.2),
        (5, 11, 0.5),
        (6, 12, 0.5),
        (11, 13, 0.43),
        (12, 14, 0.43),
        (13, 15, 0.4),
        (14, 16, 0.4),
        (3, 4, 0.145),
        (0, 3, 0.125),
    ];
    for name in PEOPLE {
        let keypoints = person(name);
        for (a, b, expected) in bones {
            let length = keypoints[a].unwrap().distance(keypoints[b].unwrap());
            assert!((length - expected).abs() < 0.03, "{name}: {a}–{b} is {length}, not {expected}");
        }
        let lowest = body(&keypoints, SAG).bounds().unwrap().0.z;
        let expected = if name == "scene3_operator" { 0.2..0.3 } else { 0.0..0.02 };
        assert!(expected.contains(&lowest), "{name} is lowest at {lowest}");
    }
}

#[test]
fn people_stand_in_nothing() {
    let table = load("table.glb").into_iter().map(|(_, mesh)| mesh).collect();
    let mut solids: Vec<(String, Vec<Mesh>)> = vec![("table.glb".into(), table), ("arm".into(), vec![arm()])];
    solids.extend(PEOPLE[..4].iter().map(|&name| (name.into(), vec![body(&person(name), SAG)])));
    for (i, (person, meshes)) in solids.iter().enumerate().skip(2) {
        for (other, parts) in &solids[..i] {
            // People share a cell only within their own scene.
            if other.starts_with("scene") && other[..6] != person[..6] {
                continue;
            }
            let gap = smallest_gap(&meshes[0], parts);
            // The hand that leans on the table rests within a centimetre of it, in the voxels just above.
            let touches = person == "scene2_operator" && other == "table.glb";
            let expected = if touches { 0.001..0.01 } else { 0.03..9.0 };
            assert!(expected.contains(&gap), "{person} is {gap} m from {other}");
        }
    }
}

/// The arm as it stands in Scene 1; `robots.rs` checks that it stands alike in the others.
fn arm() -> Mesh {
    let file = shipped("scene1.toml");
    let sources = Sources::from_main(&file);
    let spec = load_scene(&file, &sources).unwrap();
    let scene = build::build(&spec, &sources, 0.05).unwrap().remove(0);
    let arm = scene.objects.iter().find(|object| object.name == "robot").unwrap();
    let Surface::Mesh(mesh) = &arm.surface else { panic!("a mesh") };
    mesh.clone()
}

/// Distance from a body to the nearest part, in steps of the samples' spacing; 0 where a part that is a box
/// is entered.
fn smallest_gap(body: &Mesh, parts: &[Mesh]) -> f64 {
    let body_points = samples(body);
    let mut gap = f64::INFINITY;
    for part in parts {
        let (low, high) = part.bounds().unwrap();
        let is_box = part.vertices.len() == 8;
        let part_points = if is_box { vec![] } else { samples(part) };
        for point in &body_points {
            let to_box = (*point - point.clamp(low, high)).length();
            if to_box < gap {
                let to_points = part_points.iter().map(|p| p.distance(*point)).reduce(f64::min);
                gap = gap.min(to_points.unwrap_or(to_box));
            }
        }
    }
    gap
}

/// Points on each triangle, no more than 2 cm apart: a long limb has vertices at its ends only.
fn samples(mesh: &Mesh) -> Vec<DVec3> {
    let mut points = Vec::new();
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let steps = (longest / 0.02).ceil() as u32;
        for i in 0..steps {
            for j in 0..steps - i {
                let (u, v) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
                points.push(a + (b - a) * u + (c - a) * v);
            }
        }
    }
    points
}
