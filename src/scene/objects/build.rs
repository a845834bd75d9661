//! Builds the snapshots of a scene from a checked scene file. `parts` reads the parts of an object, `moving`
//! places them in each snapshot.

use std::collections::HashSet;
use std::sync::Arc;

use super::loaded::SceneFiles;
use super::spec::{ObjectSpec, SceneSpec};
use super::{Object, Scene, moving, speed};
use crate::source::Sources;
use perirobot_march::{Error, Result};

/// Reads a scene and gives its snapshots, at least one. Curved bodies stay within an eighth of a voxel of
/// their true surface.
pub fn build(spec: &SceneSpec, sources: &Sources, voxel_size_m: f64) -> Result<Vec<Scene>> {
    build_or_all(spec, sources, voxel_size_m).map_err(Error::first)
}

/// As [`build`], but tells what is wrong with each object that cannot be read.
pub fn build_or_all(
    spec: &SceneSpec,
    sources: &Sources,
    voxel_size_m: f64,
) -> Result<Vec<Scene>, Vec<Error>> {
    let (scenes, problems) = read_all(spec, sources, voxel_size_m);
    if !problems.is_empty() {
        return Err(sources.classify(problems));
    }
    let one = |what: String| Err(vec![Error::input(&spec.path, what)]);
    let objects = &scenes[0].objects;
    if objects.is_empty() {
        return one("nodes: every part of every object is ignored, nothing is left".into());
    }
    // Parts of a glTF file are named by their rules, and may meet another object's name.
    let mut names = HashSet::new();
    if let Some(twice) = objects.iter().find(|object| !names.insert(object.name.as_str())) {
        let name = &twice.name;
        return one(format!("two objects are named {name:?}, one of them by its nodes: rename the other"));
    }
    Ok(scenes)
}

/// The snapshots of a scene with all objects that can be read, and what is wrong with the others.
fn read_all(spec: &SceneSpec, sources: &Sources, voxel_size_m: f64) -> (Vec<Scene>, Vec<Error>) {
    let mut scenes: Vec<Scene> = (0..spec.snapshots)
        .map(|snapshot| Scene {
            name: spec.name.clone(),
            snapshot,
            objects: Vec::new(),
            speeds_mm_s: Vec::new(),
        })
        .collect();
    let (mut files, mut problems) = (SceneFiles::new(sources), Vec::new());
    // The parts of each object in each snapshot, by its place in the file.
    let mut moments: Vec<Vec<Vec<Arc<Object>>>> = vec![Vec::new(); spec.objects.len()];
    let mut unread: Vec<&str> = Vec::new();
    for number in carriers_first(&spec.objects) {
        let object = &spec.objects[number];
        // Its robot has an error of its own.
        if object.on.as_ref().is_some_and(|on| unread.contains(&on.object.as_str())) {
            unread.push(&object.name);
            continue;
        }
        match moving::moments(object, &scenes, &mut files, voxel_size_m / 8.0) {
            Ok(of_object) => {
                for (scene, parts) in scenes.iter_mut().zip(&of_object) {
                    scene.objects.extend(parts.iter().cloned());
                }
                moments[number] = of_object;
            }
            Err(e) => {
                unread.push(&object.name);
                problems.push(e.with_place(format!("object {:?}", object.name)).with_place(&spec.path));
            }
        }
    }
    let of_object =
        |(object, moments): (&ObjectSpec, &Vec<_>)| speed::speeds_mm_s(object, &spec.objects, moments);
    let speeds: Vec<_> = spec.objects.iter().zip(&moments).map(of_object).collect();
    for (snapshot, scene) in scenes.iter_mut().enumerate() {
        let parts = moments.iter_mut().filter_map(|moments| moments.get_mut(snapshot));
        scene.objects = parts.flat_map(std::mem::take).collect();
        scene.speeds_mm_s =
            speeds.iter().filter_map(|speeds| speeds.get(snapshot)).flatten().copied().collect();
    }
    (scenes, problems)
}

/// The numbers of all objects in the order of the file, but each robot before what its links carry. A scene file
/// with robots that carry each other is refused before.
fn carriers_first(objects: &[ObjectSpec]) -> Vec<usize> {
    let (mut placed, mut left): (Vec<usize>, Vec<usize>) = (Vec::new(), (0..objects.len()).collect());
    loop {
        let waits = |number: &usize| {
            objects[*number]
                .on
                .as_ref()
                .is_some_and(|on| left.iter().any(|&other| objects[other].name == on.object))
        };
        let (waiting, ready): (Vec<usize>, Vec<usize>) = left.iter().copied().partition(waits);
        placed.extend(&ready);
        if ready.is_empty() {
            placed.extend(waiting);
            return placed;
        }
        left = waiting;
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::objects::keypoints::{JointLayout, KeypointFile};
    use crate::objects::mesh_file::{MeshFile, MeshFormat};
    use crate::objects::spec::{ObjectSpec, PersonFile, SurfaceSpec};
    use crate::objects::{Interior, Optical, RadarOptics, Role, Surface, Up};

    fn object(name: &str, surface: SurfaceSpec) -> ObjectSpec {
        ObjectSpec {
            name: name.into(),
            role: Role::Robot,
            interior: Interior::Occupied,
            optical: Optical::SeeThrough,
            radar: RadarOptics::Stops,
            speed_m_s: None,
            reflectance: None,
            specular: None,
            shade: 0,
            person_shade: 0,
            tag_only: true,
            on: None,
            position_m: DVec3::new(1.0, 2.0, 3.0),
            // A quarter turn about z: x becomes y.
            rotation: DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
            surface,
            keypoints: None,
            nodes: Vec::new(),
            animated: None,
            motion: Default::default(),
        }
    }

    fn scene(objects: Vec<ObjectSpec>) -> Result<Scene> {
        let (path, name) = ("cell.toml".into(), "cell".into());
        let spec = SceneSpec {
            path,
            text: String::new(),
            name,
            interior: Interior::Ignored,
            snapshots: 1,
            dwell_s: None,
            variant: None,
            objects,
            warnings: Vec::new(),
        };
        // The joints lie in a folder of their own.
        let sources = Sources::from_main(&spec.path).allow_outside();
        build(&spec, &sources, 0.08).map(|mut snapshots| snapshots.remove(0))
    }

    fn table(path: &std::path::Path) -> KeypointFile {
        KeypointFile { path: path.into(), layout: JointLayout::Coco17 }
    }

    #[test]
    fn bodies_are_turned_then_moved_and_keep_what_they_are() {
        let spec = object("bar", SurfaceSpec::Box { size_m: DVec3::new(0.4, 0.2, 0.6) });
        let built = scene(vec![spec]).unwrap();
        let [bar] = &built.objects[..] else { panic!("one object") };
        assert_eq!((bar.name.as_str(), bar.role, bar.interior), ("bar", Role::Robot, Interior::Occupied));
        assert_eq!((bar.optical, bar.tag_only), (Optical::SeeThrough, true));
        let Surface::Mesh(mesh) = &bar.surface else { panic!("a mesh") };
        let (low, high) = mesh.bounds().unwrap();
        assert!((low - DVec3::new(0.9, 1.8, 2.7)).length() < 1e-12, "{low}");
        assert!((high - DVec3::new(1.1, 2.2, 3.3)).length() < 1e-12, "{high}");
    }

    #[test]
    fn round_bodies_stay_within_an_eighth_of_a_voxel() {
        let round = SurfaceSpec::Sphere { radius_m: 0.5 };
        let Surface::Mesh(mesh) = &scene(vec![object("ball", round)]).unwrap().objects[0].surface else {
            panic!("a mesh")
        };
        let centre = DVec3::new(1.0, 2.0, 3.0);
        let deepest = mesh.triangles.iter().map(|t| {
            let middle = t.iter().map(|&i| mesh.vertices[i as usize]).sum::<DVec3>() / 3.0;
            0.5 - (middle - centre).length()
        });
        let deepest = deepest.fold(0.0, f64::max);
        assert!(deepest > 0.0 && deepest <= 0.01, "{deepest}");
    }

    #[test]
    fn joints_are_turned_and_moved_with_their_human() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("joints.csv");
        std::fs::write(&file, format!("{}0.1,0.2,0.3\n0.1,0.2,1.3\n", ",,\n".repeat(15))).unwrap();
        let cuboid = || SurfaceSpec::Box { size_m: DVec3::ONE };
        let with = |role, surface, keypoints: Option<&std::path::Path>| {
            let keypoints = keypoints.map(table);
            scene(vec![ObjectSpec { role, keypoints, ..object("person", surface) }])
        };
        let person = || SurfaceSpec::Mannequin(PersonFile::Joints(table(&file)));
        let joints = |built: Result<Scene>| built.unwrap().objects[0].keypoints;
        // (0.1, 0.2) turned by a quarter is (−0.2, 0.1); the object stands at (1, 2, 3).
        let found = joints(with(Role::Human, cuboid(), Some(&file))).unwrap();
        assert!((found[15].unwrap() - DVec3::new(0.8, 2.1, 3.3)).length() < 1e-12, "{found:?}");
        assert_eq!(found.iter().flatten().count(), 2);
        assert_eq!(joints(with(Role::Human, cuboid(), None)), None);
        // Two ankles are joints of a box, but no limb to draw.
        let error = with(Role::Human, person(), None).unwrap_err().to_string();
        assert!(error.contains("mannequin = ") && error.contains("nothing of a body"), "{error}");
        std::fs::write(&file, format!("0,0,1\n0,0,1\n0,0,1\n{}", "0.1,0.2,0.3\n0.1,-0.2,0.3\n".repeat(7)))
            .unwrap();
        let found = joints(with(Role::Human, person(), None)).unwrap();
        assert!((found[15].unwrap() - DVec3::new(0.8, 2.1, 3.3)).length() < 1e-12, "{found:?}");
        assert_eq!(joints(with(Role::Environment, person(), None)), None, "a dummy is no human");
        let gone = folder.path().join("gone.csv");
        let error = with(Role::Human, cuboid(), Some(&gone)).unwrap_err().to_string();
        assert!(error.starts_with("cell.toml: object \"person\": keypoints = "), "{error}");
    }

    #[test]
    fn what_cannot_be_read_is_named_by_scene_object_key_and_file() {
        for (surface, expected) in [
            (
                SurfaceSpec::Mesh(MeshFile {
                    path: "gone.glb".into(),
                    format: MeshFormat::Gltf,
                    scale: 1.0,
                    up: Up::Z,
                }),
                "cell.toml: object \"part\": mesh = gone.glb: cannot be read",
            ),
            (
                SurfaceSpec::Octomap("gone.bt".into()),
                "cell.toml: object \"part\": octomap = gone.bt: cannot be read",
            ),
            (
                SurfaceSpec::Mannequin(PersonFile::Joints(table("gone.csv".as_ref()))),
                "cell.toml: object \"part\": mannequin = gone.csv: cannot be read",
            ),
        ] {
            let error = scene(vec![object("part", surface)]).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
        assert!(scene(Vec::new()).unwrap_err().to_string().starts_with("cell.toml: "));
    }
}
