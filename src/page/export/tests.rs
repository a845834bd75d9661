use std::path::Path;

use super::*;
use perirobot_decide::view::{ChoiceSelector, find};
use perirobot_march::backend::cpu::Cpu;
use perirobot_scene::objects::build::build;
use perirobot_scene::objects::octomap as trees;
use perirobot_scene::source::Sources;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// The files of a choice of poses of the tiny study, the view, and the source of its world.
fn export(poses: &str, test: impl FnOnce(&View, &Scene, Vec<ExportedFile>)) {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/tiny.toml");
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let wanted = ChoiceSelector { poses: poses.into(), ..ChoiceSelector::default() };
    let (world, choice) = find(&study, &worlds, &wanted).unwrap();
    let view = View::new(&study, world, choice, &mut Cpu::new(Some(1)).unwrap()).unwrap();
    let scene = build(&study.scenes[0], &study.sources, study.voxel_size_m).unwrap().remove(0);
    let mut files = Vec::new();
    each_file(&view, &scene, |file| {
        files.push(file);
        Ok(())
    })
    .unwrap();
    test(&view, &scene, files);
}

/// A file of a folder, read by the library's own readers.
fn read_in_folder<T>(file: &ExportedFile, read: impl FnOnce(&Path, &Sources) -> T) -> T {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(&file.name);
    std::fs::write(&path, &file.bytes).unwrap();
    read(&path, &Sources::from_main(&path))
}

fn find_file<'f>(files: &'f [ExportedFile], name: &str) -> &'f ExportedFile {
    let names: Vec<_> = files.iter().map(|file| file.name.as_str()).collect();
    files.iter().find(|file| file.name == name).unwrap_or_else(|| panic!("no {name} in {names:?}"))
}

#[test]
fn maps_come_back_voxel_by_voxel() {
    export("camera:wall/1/1", |view, _, files| {
        let grid = &view.world.grid;
        let planes = [
            ("labels.bt", &view.labels.occupied),
            ("truth.bt", &*view.truth.occupied),
            ("evidence-camera.bt", &view.members[0].says.occupied),
        ];
        for (name, plane) in planes {
            let map =
                read_in_folder(find_file(&files, name), |path, sources| trees::read(path, sources).unwrap());
            assert_eq!(map.resolution_m, grid.voxel_size_m);
            let mut keys = map.occupied;
            keys.sort_unstable();
            let mut expected: Vec<[i32; 3]> =
                plane.voxels().map(|voxel| std::array::from_fn(|r| voxel[r] + grid.origin[r])).collect();
            expected.sort_unstable();
            assert!(!keys.is_empty() && keys == expected, "{name}");
        }
        // The description of the map, the counts of its own tools and the planes agree.
        let truth = &view.truth;
        let free = truth.grid.window().volume() - truth.occupied.count() - truth.ignored.count();
        let labels = &view.labels;
        for (name, occupied, free) in [
            ("labels.bt", labels.occupied.count(), labels.free.count()),
            ("truth.bt", truth.occupied.count(), free),
        ] {
            assert_eq!(
                find_file(&files, name).holds,
                format!("{occupied} voxels occupied, {free} free"),
                "{name}"
            );
        }
    });
}

#[test]
fn the_cell_comes_back_with_its_sensor() {
    export("camera:wall/1/0", |view, scene, files| {
        let file = find_file(&files, "cell.glb");
        let checked = ::gltf::Gltf::from_slice(&file.bytes).unwrap();
        assert_eq!(checked.materials().len(), 4);
        let nodes = read_in_folder(file, |path, sources| {
            perirobot_scene::objects::gltf::Gltf::load(path, sources).unwrap().parts(None).unwrap()
        });
        let meshes = scene.objects.iter().filter_map(|object| match &object.surface {
            perirobot_scene::objects::Surface::Mesh(mesh) => Some((object.name.clone(), mesh.clone())),
            perirobot_scene::objects::Surface::Voxels { .. } => None,
        });
        let expected: Vec<_> = meshes.collect();
        assert_eq!(nodes.len(), expected.len() + 1, "and the camera");
        for (node, (name, mesh)) in nodes.iter().zip(&expected) {
            assert_eq!(node.names, [name.as_str()]);
            assert_eq!(node.mesh.triangles.len(), mesh.triangles.len(), "{name}");
            let (found, expected) = (node.mesh.bounds().unwrap(), mesh.bounds().unwrap());
            let near = |a: glam::DVec3, b: glam::DVec3| (a - b).length() < 1e-5;
            assert!(near(found.0, expected.0) && near(found.1, expected.1), "{name}: {found:?}");
        }
        // At (0, −0.75, 1.2), looking along y: the image plane is 0.3 m in front of the lens.
        let camera = &nodes.last().unwrap();
        assert_eq!(camera.names, ["camera:wall/1/0"]);
        let (low, high) = camera.mesh.bounds().unwrap();
        assert!((low.y + 0.75).abs() < 1e-5 && (high.y + 0.45).abs() < 1e-5, "{low} {high}");
        assert!(((low.x + high.x) / 2.0 - 0.05).abs() < 1e-5 && ((low.z + high.z) / 2.0 - 1.2).abs() < 1e-5);
        assert!(high.x - low.x > high.z - low.z, "a wide picture");
        assert_eq!(view.members.len(), 1);
    });
}

#[test]
fn figures_and_voxel_faces_are_closed_and_face_outward() {
    let volume = |mesh: &perirobot_scene::objects::Mesh| {
        let corner = |i: u32| mesh.vertices[i as usize];
        mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum::<f64>()
    };
    export("lidar:posts/upright", |view, _, _| {
        let outline = view.outline(&view.members[0]).unwrap();
        assert_eq!(outline.rim, [], "a lidar looks all around");
        let size: f64 = volume(&glb::figure(&outline));
        assert!((size - 4.0 / 3.0 * 0.06f64.powi(3)).abs() < 1e-9, "{size}");
    });
    export("camera:wall/1/1", |view, _, _| {
        let size = volume(&glb::figure(&view.outline(&view.members[0]).unwrap()));
        // A third of 0.3 m times an image of about 2 · 0.3 · tan(43.5°) by 2 · 0.3 · tan(29°) m.
        assert!((0.017..0.021).contains(&size), "{size}");
    });
    // An L of three quarters of a square metre, in both directions.
    let mut corners = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
        .map(|[x, y]| glam::DVec3::new(f64::from(x) / 2.0, f64::from(y) / 2.0, 1.0))
        .to_vec();
    for _ in 0..2 {
        let plate = glb::plate(&corners).unwrap();
        assert!((volume(&plate) - 0.75 * 0.02).abs() < 1e-12, "{}", volume(&plate));
        corners.reverse();
    }
    // Two adjacent voxels: ten faces.
    let pair = glb::faces(0.5, &[[0, 0, 0], [1, 0, 0]]);
    assert_eq!(pair.triangles.len(), 20);
    assert!((volume(&pair) - 0.25).abs() < 1e-12, "{}", volume(&pair));
}

#[test]
fn names_of_files_are_plain_and_different() {
    assert_eq!(file_name("camera:left wall/15/1"), "camera-left-wall-15-1");
    assert_eq!(file_name("../..\\Straße 1"), "Straße-1");
    export("lidar:posts/corner", |view, _, files| {
        assert_eq!(folder_name(view), "lidar-posts-corner.tiny.points");
        let names: Vec<_> = files.iter().map(|file| file.name.as_str()).collect();
        let expected = [
            "labels.bt",
            "truth.bt",
            "evidence-lidar.bt",
            "points-lidar.ply",
            "points-lidar.pcd",
            "view.npz",
            "cell.glb",
            "transforms.sh",
            "sensors.urdf",
            "view.mcap",
        ];
        assert_eq!(names, expected);
    });
}
