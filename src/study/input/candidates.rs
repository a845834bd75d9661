//! `[[candidate]]`: places where an object of the scenes may stand, when it is asked where it should. Each choice of
//! a place for each of them makes a variant of a scene, which is a scene of its own in all that follows.

use glam::{DQuat, DVec3};
use serde::Deserialize;

use super::RegionSpec;
use crate::diagnostics::Place;
use crate::keys::{AxisValues, numbers};
use perirobot_march::Result;
use perirobot_scene::objects::spec::{ObjectSpec, SceneSpec, SceneVariant, SurfaceSpec};
use perirobot_scene::truth::RegionShape;

/// Most scenes that places may make.
const MOST_SCENES: usize = 10_000;

/// Places of an object: every x with every y, every z and every turn.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct CandidateFile {
    /// The object, in every scene that has one of this name.
    object: String,
    /// Objects that move with it, as a pedestal with its robot. Default none.
    #[serde(default)]
    with: Vec<String>,
    /// Where its own frame is: a number, a list, or { start, stop, step }. What snapshots move goes along: it keeps
    /// its way from the object's own position_m.
    x_m: AxisValues,
    /// The same along y.
    y_m: AxisValues,
    /// The same along z. Default as high as in the scene.
    z_m: Option<AxisValues>,
    /// How far it is turned from how the scene has it, about the vertical through its own frame. Default 0.
    turn_deg: Option<AxisValues>,
}

/// An entry, checked.
struct CheckedCandidate {
    object: String,
    with: Vec<String>,
    /// By name.
    places: Vec<(String, Standing)>,
}

/// A place of an object.
#[derive(Clone, Copy)]
struct Standing {
    x_m: f64,
    y_m: f64,
    z_m: Option<f64>,
    turn_deg: f64,
}

/// The scenes with each choice of places.
pub(super) fn expand(
    at: &Place,
    files: Vec<CandidateFile>,
    scenes: Vec<SceneSpec>,
) -> Result<Vec<SceneSpec>> {
    let candidates = files.into_iter().map(|file| check(at, file, &scenes)).collect::<Result<Vec<_>>>()?;
    at.unique("candidate object", candidates.iter().map(|candidate| candidate.object.as_str()))?;
    let places = candidates.iter().map(|candidate| candidate.places.len());
    let count = places.chain([scenes.len()]).try_fold(1, usize::checked_mul);
    if count.is_none_or(|count| count > MOST_SCENES) {
        let what = format!("with these, the study has more than {MOST_SCENES} scenes");
        return Err(at.key("candidate").says(what).with_advice("widen a step, or leave some out"));
    }
    let mut variants = scenes;
    for candidate in &candidates {
        let placed = |scene: &SceneSpec| -> Vec<SceneSpec> {
            let places = candidate.places.iter();
            places.map(|(name, standing)| candidate.place(scene, name, standing)).collect()
        };
        variants = variants.iter().flat_map(placed).collect();
    }
    Ok(variants)
}

/// Regions that stay where they are, which a user may not expect.
pub(super) fn warnings(regions: &[(String, RegionSpec)]) -> impl Iterator<Item = String> {
    let stays = |spec: &RegionSpec| match spec {
        RegionSpec::RegionShape(shape) => {
            matches!(
                shape,
                RegionShape::Sphere { .. } | RegionShape::HalfSphere { .. } | RegionShape::Box { .. }
            )
        }
        RegionSpec::Mesh { .. } => true,
        RegionSpec::JointLimits { .. }
        | RegionSpec::Separation { .. }
        | RegionSpec::Union(_)
        | RegionSpec::Difference(_) => false,
    };
    regions.iter().filter(move |(_, spec)| stays(spec)).map(|(name, _)| {
        format!(
            "region {name:?} stays where it is at every place of [[candidate]]: for one that goes with the object take \
             robot_reach, human_box, separation or swept"
        )
    })
}

fn check(at: &Place, file: CandidateFile, scenes: &[SceneSpec]) -> Result<CheckedCandidate> {
    let at = &at.key(&format!("candidate {:?}", file.object));
    let names = file.with.iter().map(|name| ("with", name)).chain([("object", &file.object)]);
    for (key, name) in names {
        let known = || scenes.iter().flat_map(|scene| &scene.objects);
        if !known().any(|object| object.name == *name) {
            let mut names: Vec<&str> = known().map(|object| object.name.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            return Err(at.wrong(
                key,
                format!("{name:?}"),
                &format!("must be an object of a scene: {names:?}"),
            ));
        }
        let lacks = |scene: &&SceneSpec| scene.objects.iter().all(|object| object.name != *name);
        if let (Some(scene), "object") = (scenes.iter().find(lacks), key) {
            let what = format!("scene {:?} has no object {name:?}", scene.name);
            return Err(at
                .says(what)
                .with_advice("places are compared over all scenes, so each must have it"));
        }
        let carried = known().filter(|object| object.name == *name).find_map(|object| object.on.as_ref());
        if let Some(on) = carried {
            let what = format!("{name:?} is carried by {:?}, with which it goes", on.object);
            return Err(at.key(key).says(what).with_advice("place that instead"));
        }
        let is_octomap = |object: &&ObjectSpec| matches!(object.surface, SurfaceSpec::Octomap(_));
        if known().filter(|object| object.name == *name).any(|object| is_octomap(&object)) {
            let what = format!("{name:?} is an octomap");
            return Err(at.says(what).with_advice("its voxels are the grid's; it stays where it is"));
        }
    }
    let unturned = AxisValues::List(vec![0.0]);
    let axis = |key: &str, axis: &AxisValues| numbers(at, key, axis);
    let (xs, ys) = (axis("x_m", &file.x_m)?, axis("y_m", &file.y_m)?);
    let zs = file.z_m.as_ref().map(|z| axis("z_m", z)).transpose()?;
    let turns = axis("turn_deg", file.turn_deg.as_ref().unwrap_or(&unturned))?;
    let zs: Vec<Option<f64>> = zs.map_or(vec![None], |zs| zs.into_iter().map(Some).collect());
    let count = [xs.len(), ys.len(), zs.len(), turns.len()].into_iter().try_fold(1, usize::checked_mul);
    if count.is_none_or(|count| count > MOST_SCENES) {
        let what = format!("has more than {MOST_SCENES} places");
        return Err(at.says(what).with_advice("widen a step, or leave some out"));
    }
    let mut places = Vec::new();
    for &x_m in &xs {
        for &y_m in &ys {
            for &z_m in &zs {
                for &turn_deg in &turns {
                    let height = z_m.map_or(String::new(), |z| format!("/{}", short(z)));
                    let [x, y, turn] = [x_m, y_m, turn_deg].map(short);
                    let name = format!("{}/{x}/{y}{height}/{turn}", file.object);
                    places.push((name, Standing { x_m, y_m, z_m, turn_deg }));
                }
            }
        }
    }
    at.unique("place", places.iter().map(|(name, _)| name.as_str()))?;
    Ok(CheckedCandidate { object: file.object, with: file.with, places })
}

/// A number to the fourth digit behind the point, without zeros at the end.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".into(),
        short => short.into(),
    }
}

impl CheckedCandidate {
    /// A scene with its object at one of its places.
    fn place(&self, scene: &SceneSpec, name: &str, standing: &Standing) -> SceneSpec {
        let mut scene = scene.clone();
        let own = scene.objects.iter().find(|object| object.name == self.object);
        let pivot = own.map_or(DVec3::ZERO, |object| object.position_m);
        let to = DVec3::new(standing.x_m, standing.y_m, standing.z_m.unwrap_or(pivot.z));
        let turned = turn(standing.turn_deg);
        let moves = |object: &&mut ObjectSpec| object.name == self.object || self.with.contains(&object.name);
        for object in scene.objects.iter_mut().filter(moves) {
            let at = |position_m: DVec3| to + turned * (position_m - pivot);
            object.position_m = at(object.position_m);
            object.motion.position_m.iter_mut().for_each(|position_m| *position_m = at(*position_m));
            let rotations = std::iter::once(&mut object.rotation).chain(&mut object.motion.rotation);
            rotations.for_each(|rotation| *rotation = (turned * *rotation).normalize());
        }
        let variant = match scene.variant {
            Some(SceneVariant { scene, place }) => SceneVariant { scene, place: format!("{place}+{name}") },
            None => SceneVariant { scene: scene.name, place: name.into() },
        };
        scene.name = format!("{}@{}", variant.scene, variant.place);
        scene.variant = Some(variant);
        scene
    }
}

/// A turn about the vertical.
fn turn(degrees: f64) -> DQuat {
    let (sin, cos) = libm::sincos(degrees.to_radians() / 2.0);
    DQuat::from_xyzw(0.0, 0.0, sin, cos)
}

#[cfg(test)]
mod tests;
