//! Places one object in the snapshots of its scene: each shape of its parts is made once, moved to where it
//! is in each snapshot, and shared between the snapshots in which it is the same.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::loaded::{SceneFiles, at};
use super::parts::parts;
use super::{Object, Surface, keypoints};
use crate::error::Issue;
use crate::pose::Pose;
use crate::scene::spec::{MotionSpec, ObjectSpec, PersonFile, SurfaceSpec};
use crate::{Error, Result};

/// The parts of an object in each snapshot, the same parts in the same order. A part that is the same as in
/// an earlier snapshot is the same allocation.
pub(super) fn moments(
    object: &ObjectSpec,
    snapshots: usize,
    files: &mut SceneFiles,
    sag_m: f64,
) -> Result<Vec<Vec<Arc<Object>>>> {
    let warnings = time_warnings(object, files)?;
    let mut shapes: Vec<(ObjectSpec, Vec<Object>)> = Vec::new();
    let mut moments: Vec<Vec<Arc<Object>>> = Vec::new();
    let distinct = if object.motion.is_still() { 1 } else { snapshots };
    for snapshot in 0..distinct {
        let now = object.at(snapshot);
        let (rotation, position_m) = (now.rotation, now.position_m);
        let own = ObjectSpec { rotation: DQuat::IDENTITY, position_m: DVec3::ZERO, ..now };
        let shape = match shapes.iter().position(|(spec, _)| *spec == own) {
            Some(shape) => shape,
            None => {
                // A mistake in the first snapshot is mostly a mistake in all.
                let in_snapshot = |e: Error| match snapshot {
                    0 => e,
                    _ => e.at(format!("snapshot {snapshot}")),
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
        let parts = shapes[shape].1.iter().map(|part| placed(part.clone(), rotation, position_m));
        let moment = shared(parts.collect(), &moments);
        // A part that an earlier snapshot has, too, has two owners.
        moment.iter().filter(|part| Arc::strong_count(part) == 1).try_for_each(|part| files.spend(part))?;
        if let Some(first) = moments.first() {
            same_parts(first, &moment, snapshot)?;
        }
        moments.push(moment);
    }
    // An object that stands still is in every snapshot as in the first.
    let first = moments[0].clone();
    moments.resize(snapshots, first);
    Ok(moments)
}

/// An object turned about the origin, then moved, with its joints and links. Voxels of a map stay: they have
/// no pose.
fn placed(object: Object, rotation: DQuat, position_m: DVec3) -> Object {
    let keypoints = object.keypoints.map(|k| keypoints::transformed(&k, rotation, position_m));
    let surface = match object.surface {
        Surface::Mesh(mesh) => Surface::Mesh(mesh.transformed(rotation, position_m)),
        voxels => voxels,
    };
    let frame = Pose { position_m, rotation };
    let linkage = object.linkage.map(|linkage| Arc::new(linkage.carried_by(&frame)));
    Object { surface, keypoints, linkage, ..object }
}

fn shared(parts: Vec<Object>, earlier: &[Vec<Arc<Object>>]) -> Vec<Arc<Object>> {
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
        .wanted("its animation shrinks a part to nothing")
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
            files.motion(&file.path).map_err(at("mannequin"))?.span_s()
        }
        (_, Some(file)) => files.joint_table(&file.path).map_err(at("snapshots.animation.joints"))?.span_s(),
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
mod tests;
