//! The scene files of a study and the objects in them: where they are, and whether a person may move them.

use std::path::{Path, PathBuf};

use perirobot_scene::objects::spec::{ObjectSpec, SceneSpec, SurfaceSpec};
use perirobot_study::input::Study;
use serde::Serialize;

use super::role_name;
use crate::document::{ObjectPlaces, object_places};

/// A scene file of the study.
#[derive(Clone, Debug, Serialize)]
pub struct SceneFileState {
    /// Its name: edits say it.
    name: String,
    /// The scenes of the study that are made of it.
    scenes: Vec<String>,
    /// Why nothing in it can be moved.
    reason: Option<String>,
    objects: Vec<ObjectState>,
}

/// What may be done with a scene file.
pub struct SceneFileAccess {
    /// What it is called.
    pub name: String,
    /// Why it cannot be edited.
    pub reason: Option<String>,
}

#[derive(Clone, Debug, Serialize)]
struct ObjectState {
    name: String,
    role: &'static str,
    /// What it is made of.
    what: &'static str,
    /// Its position, or each that it has from moment to moment.
    positions_m: Vec<[f64; 3]>,
    /// For each moment of the scene the number of its position; the list repeats.
    position_of: Vec<usize>,
    /// How it is turned about the vertical, in the same way.
    yaws_deg: Vec<f64>,
    yaw_of: Vec<usize>,
    can_move: bool,
    can_turn: bool,
    /// Why it cannot be moved or turned, or what else moves.
    words: Option<String>,
}

impl SceneFileState {
    /// The files of the study's scenes, each once, and for each scene the number of its file. `candidates` are the objects
    /// that have their places from the study.
    pub fn all(
        study: &Study,
        candidates: &[String],
        access: &dyn Fn(&Path) -> SceneFileAccess,
    ) -> (Vec<SceneFileState>, Vec<usize>) {
        let mut paths: Vec<(PathBuf, String)> = Vec::new();
        let mut files: Vec<SceneFileState> = Vec::new();
        let mut of_scenes = Vec::new();
        for scene in &study.scenes {
            let known = paths.iter().find(|(path, _)| *path == scene.path).map(|(_, name)| name.clone());
            let name = known.unwrap_or_else(|| access(&scene.path).name);
            paths.push((scene.path.clone(), name.clone()));
            let found = files.iter().position(|file| file.name == name);
            let number = found.unwrap_or_else(|| {
                files.push(SceneFileState::new(name, scene, candidates, access(&scene.path).reason));
                files.len() - 1
            });
            let title = scene.variant.as_ref().map_or(&scene.name, |variant| &variant.scene);
            let scenes = &mut files[number].scenes;
            if !scenes.contains(title) {
                scenes.push(title.clone());
            }
            of_scenes.push(number);
        }
        (files, of_scenes)
    }

    fn new(name: String, scene: &SceneSpec, candidates: &[String], reason: Option<String>) -> SceneFileState {
        let places = object_places(&scene.text);
        let object = |places: ObjectPlaces| {
            let spec = scene.objects.iter().find(|object| object.name == places.name)?;
            Some(ObjectState::new(places, spec, candidates, reason.is_none()))
        };
        let objects = places.into_iter().filter_map(object).collect();
        SceneFileState { name, scenes: Vec::new(), reason, objects }
    }
}

impl ObjectState {
    fn new(places: ObjectPlaces, spec: &ObjectSpec, candidates: &[String], can_edit: bool) -> ObjectState {
        let stays = match spec.surface {
            SurfaceSpec::Octomap(_) => Some("It stays where it is: its voxels are those of the grid."),
            SurfaceSpec::Room { .. } => {
                Some("It is the room itself: change its size_m and position_m in the scene file.")
            }
            _ if spec.on.is_some() => Some(
                "A robot carries it: change on and position_m, which is in the link's frame, in the scene file.",
            ),
            _ if places.has_walk => Some("It walks along a path: change walk in the scene file."),
            _ if candidates.contains(&spec.name) => {
                Some("It is where a [[candidate]] of the study puts it: change x_m and y_m there.")
            }
            _ => None,
        };
        let unturned = || {
            let words = "A quaternion turns it: write rpy_deg into the scene file instead, to turn it here.";
            places.yaws_deg.is_none().then_some(words)
        };
        let is_recorded = !spec.motion.times_s.is_empty() && spec.motion.joint_table.is_none();
        let recorded = || is_recorded.then_some("Its whole recorded motion moves with it.");
        let words = stays.or_else(unturned).or_else(recorded).map(String::from);
        let motion = &spec.motion;
        let order = |is_list: bool, written: usize, read: usize| -> Vec<usize> {
            match is_list && written > 0 && read >= written {
                // Entries of a list that is crossed with others last for several moments each.
                true if motion.cross => (0..read).map(|moment| moment / (read / written)).collect(),
                true => (0..read).map(|moment| moment % written).collect(),
                false => vec![0],
            }
        };
        let can_move = can_edit && stays.is_none();
        ObjectState {
            position_of: order(places.has_position_list, places.positions_m.len(), motion.position_m.len()),
            yaw_of: order(
                places.has_yaw_list,
                places.yaws_deg.as_ref().map_or(0, Vec::len),
                motion.rotation.len(),
            ),
            name: places.name,
            role: role_name(spec.role),
            what: surface_name(&spec.surface),
            positions_m: places.positions_m,
            can_turn: can_move && places.yaws_deg.is_some(),
            yaws_deg: places.yaws_deg.unwrap_or_else(|| vec![yaw_deg(spec)]),
            can_move,
            words,
        }
    }
}

/// How an object that a quaternion turns is turned about the vertical, to be shown.
fn yaw_deg(spec: &ObjectSpec) -> f64 {
    let ahead = spec.motion.rotation.first().unwrap_or(&spec.rotation).mul_vec3(glam::DVec3::X);
    (ahead.y.atan2(ahead.x).to_degrees() * 10.0).round() / 10.0 + 0.0
}

/// A surface in a word of the scene file.
fn surface_name(surface: &SurfaceSpec) -> &'static str {
    match surface {
        SurfaceSpec::Box { .. } => "box",
        SurfaceSpec::Room { .. } => "room",
        SurfaceSpec::Plane { .. } => "plane",
        SurfaceSpec::Sphere { .. } => "sphere",
        SurfaceSpec::Cylinder { .. } => "cylinder",
        SurfaceSpec::Capsule { .. } => "capsule",
        SurfaceSpec::Mesh(_) => "mesh",
        SurfaceSpec::Octomap(_) => "octomap",
        SurfaceSpec::Mannequin(_) | SurfaceSpec::Shipped(_) => "mannequin",
        SurfaceSpec::Urdf(_) => "urdf",
        SurfaceSpec::Sdf(_) => "sdf",
    }
}
