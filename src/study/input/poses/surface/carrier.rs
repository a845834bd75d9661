//! Finds the object that carries a sensor in the scenes of a study, and reads its surface.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use super::SurfaceFile;
use crate::diagnostics::Place;
use crate::input::poses::PoseSource;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::carrier::{read_link_surface, read_surface};
use perirobot_scene::objects::spec::{ObjectSpec, SceneSpec, SurfaceSpec, UrdfSpec};
use perirobot_scene::objects::{Mesh, Role};
use perirobot_scene::pose::Pose;
use perirobot_scene::spelling::nearest;

/// The name of an object, and of the link whose surface is read.
type SurfaceName = (String, Option<String>);

/// Surfaces that were read.
#[derive(Debug, Default)]
pub(in crate::input) struct Surfaces(RefCell<HashMap<SurfaceName, Rc<Mesh>>>);

/// What carries the sensor: a surface in its own frame, and where that is.
pub(super) struct Carrier<'a> {
    pub(super) name: &'a str,
    pub(super) mesh: Rc<Mesh>,
    pub(super) frame: Pose,
    /// What does not move in the scenes that have it, if the poses are in the world.
    pub(super) others: Vec<&'a ObjectSpec>,
}

/// What carries the sensor; none where a scene could not be read that may have it.
pub(super) fn find_carrier<'a>(
    at: &Place,
    file: &'a SurfaceFile,
    source: &PoseSource<'a>,
) -> Result<Option<Carrier<'a>>> {
    let name = match (&file.object, source.on) {
        (Some(object), Some(on)) if *object != on.object => {
            let rule = format!("must be {:?}, whose link carries the sensor, or be left out", on.object);
            return Err(at.wrong("object", format!("{object:?}"), &rule));
        }
        (_, Some(on)) => &on.object,
        (Some(object), None) => object,
        (None, None) => {
            return Err(at.wrap(Issue::missing("object")).with_advice("name an object of a scene"));
        }
    };
    let in_scene =
        |scene: &'a SceneSpec| Some((scene, scene.objects.iter().find(|object| object.has_part(name))?));
    let found: Vec<(&SceneSpec, &ObjectSpec)> = source.scenes.iter().filter_map(in_scene).collect();
    let Some(&(scene, object)) = found.first() else {
        return if source.has_all_scenes { Err(unknown(at, name, source.scenes)) } else { Ok(None) };
    };
    let blame = |issue: Issue| at.wrap(issue.with_place(format!("object {name:?}")));
    if object.role == Role::Human {
        return Err(blame(Issue::says("is a person, who carries no sensor")));
    }
    let own = (name.clone(), source.on.map(|on| on.link.clone()));
    let wrong_file = |e: Error| at.wrap(e.with_place(format!("object {name:?}")).with_place(&scene.path));
    let read = || match (source.on, &object.surface) {
        (Some(on), SurfaceSpec::Urdf(robot)) => {
            read_link_surface(robot, &on.link, source.files).map_err(wrong_file)
        }
        (Some(_), _) => Err(blame(
            Issue::says("has no links to carry a sensor")
                .with_advice("name a robot, an object with urdf = ..., in on"),
        )),
        (None, _) => read_surface(object, name, source.files).map_err(wrong_file),
    };
    for (other_scene, other) in &found {
        let differs = |what: &str| {
            let (first, second) = (&scene.name, &other_scene.name);
            blame(Issue::says(format!("{what} in scene {first:?} and in scene {second:?}")).with_advice(
                "poses are the same in every scene: give the object of one of them another name",
            ))
        };
        match (source.on, &object.surface, &other.surface) {
            (Some(_), SurfaceSpec::Urdf(one), SurfaceSpec::Urdf(two)) => {
                let shape =
                    |robot: &'a UrdfSpec| (&robot.path, robot.geometry, &robot.packages, &robot.xacro_args);
                if shape(one) != shape(two) {
                    return Err(differs("is another robot"));
                }
            }
            _ if moves(other) && source.on.is_none() => {
                return Err(blame(
                    Issue::says(format!(
                        "moves from one snapshot of scene {:?} to another",
                        other_scene.name
                    ))
                    .with_advice(
                        "sensors stay where they are, or move with a link of a robot: name it in on",
                    ),
                ));
            }
            _ if (&object.surface, &object.nodes) != (&other.surface, &other.nodes) => {
                return Err(differs("has another shape"));
            }
            _ if (object.position_m, object.rotation) != (other.position_m, other.rotation) => {
                return Err(differs("stands elsewhere"));
            }
            _ => {}
        }
    }
    let known = source.surfaces.0.borrow().get(&own).cloned();
    let mesh = match known {
        Some(mesh) => mesh,
        None => {
            let mesh = Rc::new(read()?);
            source.surfaces.0.borrow_mut().insert(own, mesh.clone());
            mesh
        }
    };
    let is_in_world = source.on.is_none();
    let frame = match is_in_world {
        true => Pose { position_m: object.position_m, rotation: object.rotation },
        false => Pose::ORIGIN,
    };
    let still = |other: &&ObjectSpec| !moves(other) && !other.tag_only && other.role != Role::Human;
    let beside = found
        .iter()
        .flat_map(|(scene, own)| scene.objects.iter().filter(move |other| other.name != own.name));
    let others = beside.filter(|_| is_in_world).filter(still).collect();
    Ok(Some(Carrier { name, mesh, frame, others }))
}

fn unknown(at: &Place, name: &str, scenes: &[SceneSpec]) -> Error {
    let all = scenes.iter().flat_map(|scene| &scene.objects).filter(|object| object.role != Role::Human);
    let mut names: Vec<&str> = all.map(|object| object.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let meant = match nearest(name, names.iter().copied()) {
        Some(near) => format!("; did you mean {near:?}?"),
        None => String::new(),
    };
    at.wrong("object", format!("{name:?}"), &format!("must be an object of a scene: {names:?}{meant}"))
}

/// Whether an object is elsewhere, or has another shape, at another moment.
fn moves(object: &ObjectSpec) -> bool {
    let lists = object.motion.lists();
    object.on.is_some() || lists.iter().any(|(key, _)| !["dwell_s", "speed_m_s"].contains(key))
}
