//! From a checked scene file to the snapshots of a scene: reads the meshes and tessellates the bodies. Where each
//! object is in which snapshot is for `moving`.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use wildmatch::WildMatch;

use super::gltf::NodeMesh;
use super::moving::Files;
use super::{
    Mesh, Object, Optical, Role, Scene, Surface, gltf, mannequin, moving, octomap, primitive, stl, urdf,
};
use crate::sensor::pose::Pose;
use crate::source::Sources;
use crate::study::{NodeRule, ObjectSpec, SceneSpec, SurfaceSpec, UrdfSpec};
use crate::{Error, Result};

/// Reads a scene and gives its snapshots, at least one. Curved bodies stay within an eighth of a voxel of their true
/// surface.
pub fn build(spec: &SceneSpec, sources: &Sources, voxel_size_m: f64) -> Result<Vec<Scene>> {
    build_or_all(spec, sources, voxel_size_m).map_err(Error::first)
}

/// [`build`], but of each object that cannot be read it is told what is wrong.
pub fn build_or_all(
    spec: &SceneSpec,
    sources: &Sources,
    voxel_size_m: f64,
) -> Result<Vec<Scene>, Vec<Error>> {
    let (scenes, problems) = read_all(spec, sources, voxel_size_m);
    if !problems.is_empty() {
        return Err(sources.judged(problems));
    }
    let one = |what: String| Err(vec![Error::input(spec.path.display(), what)]);
    let objects = &scenes[0].objects;
    if objects.is_empty() {
        return one("nodes: every part of every object is ignored, nothing is left".into());
    }
    // Parts of a glTF file are named by their rules, and may meet another object's name.
    let mut names = HashSet::new();
    if let Some(twice) = objects.iter().find(|object| !names.insert(object.name.as_str())) {
        let name = &twice.name;
        return one(format!("two objects are named {name:?}, one of them by nodes.match: rename the other"));
    }
    Ok(scenes)
}

/// The snapshots of a scene with all objects that can be read, and what is wrong with the others.
fn read_all(spec: &SceneSpec, sources: &Sources, voxel_size_m: f64) -> (Vec<Scene>, Vec<Error>) {
    let mut scenes: Vec<Scene> = (0..spec.snapshots)
        .map(|snapshot| Scene { name: spec.name.clone(), snapshot, objects: Vec::new() })
        .collect();
    let (mut files, mut problems) = (Files::new(sources), Vec::new());
    for object in &spec.objects {
        match moving::moments(object, spec.snapshots, &mut files, voxel_size_m / 8.0) {
            Ok(moments) => {
                scenes.iter_mut().zip(moments).for_each(|(scene, moment)| scene.objects.extend(moment))
            }
            Err(e) => {
                let place = format!("{}: object {:?}", spec.path.display(), object.name);
                problems.push(Error::input(place, e));
            }
        }
    }
    (scenes, problems)
}

/// The parts of an object at one moment, in its own frame.
pub(super) fn parts(object: &ObjectSpec, files: &mut Files, sag_m: f64) -> Result<Vec<Object>> {
    let sources = files.sources;
    let keypoints = object.keypoints.as_deref().map(|path| mannequin::read_keypoints(path, sources));
    let mut keypoints = keypoints.transpose().map_err(at("keypoints"))?;
    let mesh = match &object.surface {
        SurfaceSpec::Box { size_m } => primitive::cuboid(*size_m),
        SurfaceSpec::Room { size_m } => primitive::room(*size_m),
        SurfaceSpec::Plane { size_m } => primitive::plane(*size_m),
        SurfaceSpec::Sphere { radius_m } => primitive::sphere(*radius_m, sag_m),
        SurfaceSpec::Cylinder { radius_m, height_m } => primitive::cylinder(*radius_m, *height_m, sag_m),
        SurfaceSpec::Capsule { radius_m, length_m } => primitive::capsule(*radius_m, *length_m, sag_m),
        SurfaceSpec::Mannequin(path) => {
            let person = mannequin::read_person(path, sources).map_err(at("mannequin"))?;
            keypoints = (object.role == Role::Human).then_some(person);
            mannequin::body(&person, sag_m)
        }
        SurfaceSpec::Stl { path, scale, y_up } => {
            stl_mesh(path, *scale, *y_up, sources).map_err(at("mesh"))?
        }
        SurfaceSpec::Octomap(path) => {
            let map = octomap::read(path, sources).map_err(at("octomap"))?;
            let surface = Surface::Voxels { resolution_m: map.resolution_m, keys: map.occupied };
            let part = part(object, object.name.clone(), object.role, object.optical, surface);
            return Ok(vec![Object { keypoints, ..part }]);
        }
        SurfaceSpec::Gltf { path, scale } => {
            let nodes = files.gltf_nodes(path, object.animated.as_ref())?.into_iter();
            let nodes = nodes.map(|node| NodeMesh { mesh: node.mesh.scaled(*scale), ..node }).collect();
            let mut objects = Vec::new();
            gltf_parts(object, nodes, &mut objects)?;
            // Parts may have other roles; the joints go with the person.
            let mut people = objects.iter_mut().filter(|part| part.role == Role::Human);
            if let (Some(person), Some(_)) = (people.next(), &keypoints) {
                if let Some(other) = people.next() {
                    let what = "are both human, and keypoints belong to one body: let one rule match all of the person";
                    return Err(Error::Input(format!(
                        "nodes: {:?} and {:?} {what}",
                        person.name, other.name
                    )));
                }
                person.keypoints = keypoints;
            }
            return Ok(objects);
        }
        SurfaceSpec::Urdf(robot) => return Ok(vec![urdf_robot(object, robot, sources, sag_m)?]),
    };
    let surface = Surface::Mesh(mesh);
    let part = part(object, object.name.clone(), object.role, object.optical, surface);
    Ok(vec![Object { keypoints, ..part }])
}

/// A loader's message begins with the file, the value of this key.
pub(super) fn at(key: &'static str) -> impl Fn(Error) -> Error {
    move |e| Error::Input(format!("{key} = {e}"))
}

/// Reads a mesh of which only the shape counts, all nodes of a glTF together; other surfaces have none in a file.
pub fn mesh_of_file(surface: &SurfaceSpec, sources: &Sources) -> Result<Mesh> {
    match surface {
        SurfaceSpec::Stl { path, scale, y_up } => stl_mesh(path, *scale, *y_up, sources),
        SurfaceSpec::Gltf { path, scale } => Ok(gltf::Gltf::load(path, sources)?.whole()?.scaled(*scale)),
        _ => Ok(Mesh::default()),
    }
}

fn stl_mesh(path: &Path, scale: f64, y_up: bool, sources: &Sources) -> Result<Mesh> {
    let mesh = stl::load(path, sources)?.scaled(scale);
    Ok(if y_up { z_up(mesh) } else { mesh })
}

/// A glTF file becomes one object for the nodes that no rule names, under the object's own name, and one for each
/// rule, named `object/pattern`. A node follows the first rule that matches it or a node above it.
fn gltf_parts(object: &ObjectSpec, nodes: Vec<NodeMesh>, objects: &mut Vec<Object>) -> Result<()> {
    let rules: Vec<WildMatch> = object.nodes.iter().map(|rule| WildMatch::new(&rule.r#match)).collect();
    let mut rest = Mesh::default();
    let mut parts = vec![Mesh::default(); rules.len()];
    let mut matched = vec![false; rules.len()];
    for node in &nodes {
        let covers = |rule: &WildMatch| node.names.iter().any(|name| rule.matches(name));
        for (seen, rule) in matched.iter_mut().zip(&rules) {
            *seen |= covers(rule);
        }
        match rules.iter().position(covers) {
            Some(rule) => parts[rule].append(&node.mesh),
            None => rest.append(&node.mesh),
        }
    }
    if let Some(rule) = matched.iter().position(|&seen| !seen) {
        let mut names: Vec<&str> =
            nodes.iter().filter_map(|node| node.names.last()).map(String::as_str).collect();
        names.truncate(12);
        return Err(Error::Input(format!(
            "nodes.match = {:?}: no node with triangles has such a name; there are {}",
            object.nodes[rule].r#match,
            names.join(", ")
        )));
    }
    if let Some(rule) = parts.iter().position(|mesh| mesh.triangles.is_empty()) {
        return Err(Error::Input(format!(
            "nodes.match = {:?}: every node that it names already follows a rule above it; the first that matches \
             counts, so put it first",
            object.nodes[rule].r#match
        )));
    }
    if !rest.triangles.is_empty() {
        let rest = Surface::Mesh(rest);
        objects.push(part(object, object.name.clone(), object.role, object.optical, rest));
    }
    for (NodeRule { r#match, role, optical, ignore }, mesh) in object.nodes.iter().zip(parts) {
        if !ignore {
            let name = format!("{}/{match}", object.name);
            let (role, optical) = (role.unwrap_or(object.role), optical.unwrap_or(object.optical));
            objects.push(part(object, name, role, optical, Surface::Mesh(mesh)));
        }
    }
    Ok(())
}

fn part(spec: &ObjectSpec, name: String, role: Role, optical: Optical, surface: Surface) -> Object {
    Object {
        name,
        role,
        interior: spec.interior,
        optical,
        tag_only: spec.tag_only,
        surface,
        keypoints: None,
        linkage: None,
        warnings: Vec::new(),
    }
}

/// All links of a robot as one object, which keeps where they are.
fn urdf_robot(object: &ObjectSpec, robot: &UrdfSpec, sources: &Sources, sag_m: f64) -> Result<Object> {
    let model = urdf::load(&robot.path, sources).map_err(at("urdf"))?;
    let root_from_link = model.pose(&robot.joints)?;
    let meshes = model.meshes(robot.geometry, &robot.packages, sources, sag_m).map_err(at("urdf"))?;
    let surface = Surface::Mesh(urdf::merged(&meshes, &root_from_link));
    let linkage = Some(Arc::new(model.linkage(&root_from_link, &Pose::ORIGIN)));
    Ok(Object { linkage, ..part(object, object.name.clone(), object.role, object.optical, surface) })
}

/// A y-up mesh turned to z up: (x, y, z) → (x, −z, y), exactly.
fn z_up(mut mesh: Mesh) -> Mesh {
    mesh.vertices.iter_mut().for_each(|v| *v = DVec3::new(v.x, -v.z, v.y));
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Interior;
    use glam::DQuat;

    fn object(name: &str, surface: SurfaceSpec) -> ObjectSpec {
        ObjectSpec {
            name: name.into(),
            role: Role::Robot,
            interior: Interior::Occupied,
            optical: Optical::SeeThrough,
            tag_only: true,
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
        let spec = SceneSpec { path, text: String::new(), name, snapshots: 1, objects, warnings: Vec::new() };
        // The joints lie in a folder of their own.
        let sources = Sources::beside(&spec.path).allow_outside();
        build(&spec, &sources, 0.08).map(|mut snapshots| snapshots.remove(0))
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
    fn y_up_files_are_turned_to_z_up() {
        let mesh = Mesh { vertices: vec![DVec3::new(1.0, 2.0, 3.0)], triangles: Vec::new() };
        assert_eq!(z_up(mesh).vertices, [DVec3::new(1.0, -3.0, 2.0)]);
    }

    #[test]
    fn joints_are_turned_and_moved_with_their_human() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("joints.csv");
        std::fs::write(&file, format!("{}0.1,0.2,0.3\n0.1,0.2,1.3\n", ",,\n".repeat(15))).unwrap();
        let cuboid = || SurfaceSpec::Box { size_m: DVec3::ONE };
        let with = |role, surface, keypoints: Option<&std::path::Path>| {
            let keypoints = keypoints.map(Into::into);
            scene(vec![ObjectSpec { role, keypoints, ..object("person", surface) }])
        };
        let person = || SurfaceSpec::Mannequin(file.clone());
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
                SurfaceSpec::Gltf { path: "gone.glb".into(), scale: 1.0 },
                "cell.toml: object \"part\": mesh = gone.glb: cannot be read",
            ),
            (
                SurfaceSpec::Octomap("gone.bt".into()),
                "cell.toml: object \"part\": octomap = gone.bt: cannot be read",
            ),
            (
                SurfaceSpec::Mannequin("gone.csv".into()),
                "cell.toml: object \"part\": mannequin = gone.csv: cannot be read",
            ),
        ] {
            let error = scene(vec![object("part", surface)]).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
        assert!(scene(Vec::new()).unwrap_err().to_string().starts_with("cell.toml: "));
    }
}
