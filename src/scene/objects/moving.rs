//! Places one object in the snapshots of its scene: each shape of its parts is made once, moved to where it
//! is in each snapshot, and shared between the snapshots in which it is the same.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::loaded::{SceneFiles, with_key};
use super::parts::parts;
use super::{Object, Scene, Surface, keypoints};
use crate::objects::spec::{MotionSpec, ObjectSpec, PersonFile, SurfaceSpec};
use crate::pose::Pose;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

/// The parts of an object in each snapshot, the same parts in the same order. A part that is the same as in
/// an earlier snapshot is the same allocation. The scenes, one a snapshot, have what carries it.
pub(super) fn moments(
    object: &ObjectSpec,
    scenes: &[Scene],
    files: &mut SceneFiles,
    sag_m: f64,
) -> Result<Vec<Vec<Arc<Object>>>> {
    let warnings = time_warnings(object, files)?;
    let mut shapes: Vec<(ObjectSpec, Vec<Object>)> = Vec::new();
    let mut moments: Vec<Vec<Arc<Object>>> = Vec::new();
    let distinct = if object.motion.is_still() && object.on.is_none() { 1 } else { scenes.len() };
    for (snapshot, scene) in scenes[..distinct].iter().enumerate() {
        let now = object.snapshot(snapshot);
        let own_pose = Pose { position_m: now.position_m, rotation: now.rotation };
        let pose = match &now.on {
            Some(on) => own_pose.carried_by(&scene.carrier(on).map_err(|issue| issue.with_place("on"))?),
            None => own_pose,
        };
        let (rotation, position_m) = (DQuat::IDENTITY, DVec3::ZERO);
        let own = ObjectSpec { on: None, rotation, position_m, speed_m_s: None, ..now };
        let shape = match shapes.iter().position(|(spec, _)| *spec == own) {
            Some(shape) => shape,
            None => {
                // A mistake in the first snapshot is mostly a mistake in all.
                let in_snapshot = |e: Error| match snapshot {
                    0 => e,
                    _ => e.with_place(format!("snapshot {snapshot}")),
                };
                let mut parts = parts(&own, files, sag_m).map_err(in_snapshot)?;
                if let Some(first) = parts.first_mut() {
                    first.warnings.extend(warnings.iter().cloned());
                }
                parts.iter().try_for_each(|part| files.spend(part))?;
                shapes.push((own, parts));
                shapes.len() - 1
            }
        };
        let parts = shapes[shape].1.iter().map(|part| place(part.clone(), &pose));
        let moment = share(parts.collect(), &moments);
        // A part that an earlier snapshot has, too, has two owners.
        moment.iter().filter(|part| Arc::strong_count(part) == 1).try_for_each(|part| files.spend(part))?;
        if let Some(first) = moments.first() {
            same_parts(first, &moment, snapshot)?;
        }
        moments.push(moment);
    }
    // An object that stands still is in every snapshot as in the first.
    let first = moments[0].clone();
    moments.resize(scenes.len(), first);
    Ok(moments)
}

/// An object turned about the origin, then moved, with its joints and links. Voxels of a map stay: they have
/// no pose.
fn place(object: Object, pose: &Pose) -> Object {
    let Pose { position_m, rotation } = *pose;
    let keypoints = object.keypoints.map(|k| keypoints::transform(&k, rotation, position_m));
    let surface = match object.surface {
        Surface::Mesh(mesh) => Surface::Mesh(mesh.transform(rotation, position_m)),
        voxels => voxels,
    };
    let linkage = object.linkage.map(|linkage| Arc::new(linkage.carried_by(pose)));
    Object { surface, frame: *pose, keypoints, linkage, ..object }
}

fn share(parts: Vec<Object>, earlier: &[Vec<Arc<Object>>]) -> Vec<Arc<Object>> {
    let part = |(i, part): (usize, Object)| {
        let same = earlier.iter().filter_map(|moment| moment.get(i)).find(|other| ***other == part);
        same.cloned().unwrap_or_else(|| Arc::new(part))
    };
    parts.into_iter().enumerate().map(part).collect()
}

/// A joint that shrinks to nothing takes the triangles of its skin along.
fn same_parts(first: &[Arc<Object>], now: &[Arc<Object>], snapshot: usize) -> Result<()> {
    let names = |parts: &[Arc<Object>]| parts.iter().map(|part| part.name.clone()).collect::<Vec<_>>();
    if names(first) != names(now) {
        let (first, now) = (names(first).join(", "), names(now).join(", "));
        return Err(Issue::says(format!(
            "has the parts {first} in snapshot 0, but {now} in snapshot {snapshot}"
        ))
        .with_advice("its animation shrinks a part to nothing")
        .into());
    }
    Ok(())
}

/// Whether all times at which an object is sampled are outside of what moves it.
fn time_warnings(object: &ObjectSpec, files: &mut SceneFiles) -> Result<Vec<String>> {
    let MotionSpec { clip, joint_table, times_s, .. } = &object.motion;
    if times_s.is_empty() {
        return Ok(Vec::new());
    }
    let [first, last] = match (&object.surface, joint_table) {
        (SurfaceSpec::Mannequin(PersonFile::Motion(file)), _) => {
            files.motion(&file.path).map_err(with_key("mannequin"))?.span_s()
        }
        (_, Some(file)) => {
            files.joint_table(&file.path).map_err(with_key("snapshots.animation.joints"))?.span_s()
        }
        (surface, None) => match surface.gltf() {
            Some(file) => files.clip(&file.path, clip)?.span_s(),
            None => return Ok(Vec::new()),
        },
    };
    let outside = times_s.iter().all(|time| !(first..=last).contains(time)).then(|| {
        format!(
            "is animated from {first} to {last} s, and all of snapshots.animation.times_s are outside: it is held as \
             at the nearer end"
        )
    });
    Ok(outside.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::{Interior, Optical, RadarOptics, Role};
    use crate::source::Sources;

    /// A box of 10 cm that is at each of these places.
    fn box_at(places: &[[f64; 3]]) -> ObjectSpec {
        ObjectSpec {
            name: "box".into(),
            role: Role::Environment,
            interior: Interior::Ignored,
            optical: Optical::Opaque,
            radar: RadarOptics::Stops,
            speed_m_s: None,
            reflectance: None,
            specular: None,
            shade: 0,
            person_shade: 0,
            tag_only: false,
            on: None,
            position_m: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            surface: SurfaceSpec::Box { size_m: DVec3::splat(0.1) },
            keypoints: None,
            nodes: vec![],
            animated: None,
            motion: MotionSpec {
                position_m: places.iter().copied().map(DVec3::from_array).collect(),
                ..MotionSpec::default()
            },
        }
    }

    fn empty(snapshots: usize) -> Vec<Scene> {
        let scene =
            |snapshot| Scene { name: "cell".into(), snapshot, objects: Vec::new(), speeds_mm_s: Vec::new() };
        (0..snapshots).map(scene).collect()
    }

    #[test]
    fn triangles_are_counted_where_an_object_is_another_than_before() {
        let sources = Sources::from_main("cell.toml".as_ref());
        let moving = box_at(&[[2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]]);
        let with = |triangles_left| {
            let mut files = SceneFiles { triangles_left, ..SceneFiles::new(&sources) };
            moments(&moving, &empty(4), &mut files, 0.01).map(|_| files.triangles_left)
        };
        // A box has 12: its shape, and it in two places.
        assert_eq!(with(40).unwrap(), 4);
        assert_eq!(with(36).unwrap(), 0);
        let error = with(35).unwrap_err().to_string();
        assert!(error.contains("unfolds to more than") && error.contains("split the recording"), "{error}");
    }

    /// A file that shrinks a part away would leave it without a place in the results.
    #[test]
    fn a_part_that_is_not_in_every_snapshot_is_named() {
        let sources = Sources::from_main("cell.toml".as_ref());
        let mut files = SceneFiles::new(&sources);
        let made = moments(&box_at(&[]), &empty(1), &mut files, 0.01).unwrap().remove(0).remove(0);
        let parts = |names: &[&str]| {
            let part = |name: &&str| Arc::new(Object { name: (*name).into(), ..(*made).clone() });
            names.iter().map(part).collect::<Vec<_>>()
        };
        let error = same_parts(&parts(&["a", "b"]), &parts(&["b"]), 3).unwrap_err().to_string();
        assert!(error.contains("the parts a, b in snapshot 0, but b in snapshot 3"), "{error}");
    }
}
