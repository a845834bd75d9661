//! The floor that is walked on: heights in words are measured from it, so that a slab below it adds nothing.

use std::ops::Range;

use glam::DVec3;

use crate::input::Study;
use perirobot_scene::objects::{Mesh, Object, Role, Scene, Surface};

/// A level surface this close to the people's feet, or to z 0, may be their floor.
const NEAR_M: f64 = 0.2;
/// Surfaces whose heights differ by less are one floor: scanned floors are not flat.
const ONE_FLOOR_M: f64 = 0.05;
/// Least z of the unit normal of a triangle that is level: within 10°.
const LEVEL: f64 = 0.985;
/// Areas that differ by a smaller share are equal.
const EQUAL: f64 = 1e-6;
/// The top of a slab has at least this share of the area of its underside: it may have pits and rounded edges.
const TOP: f64 = 0.75;

/// The floor that is walked on in a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Its height in the world, in metres.
    pub z_m: f64,
    /// Where that height comes from.
    pub source: FloorSource,
}

/// Where the height of a floor comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FloorSource {
    /// `floor_m` of the study.
    Study,
    /// The largest level surface near the people's feet.
    NearFeet,
    /// The largest level surface below the people's feet, which are not near one.
    BelowFeet,
    /// Without a level surface below people, the largest one near z 0.
    NearZero,
    /// Without one near z 0 either, the largest one below the middle of the cell.
    LowerHalf,
    /// The people's feet: the cell has no level surface.
    Feet,
    /// Nothing of all that: z 0.
    Zero,
}

impl FloorSource {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            FloorSource::Study => "floor_m of the study",
            FloorSource::NearFeet => "the largest level surface near the people's feet",
            FloorSource::BelowFeet => "the largest level surface below the people, who do not stand on one",
            FloorSource::Feet => "the people's feet, without a level surface",
            FloorSource::NearZero => "the largest level surface near z 0",
            FloorSource::LowerHalf => "the largest level surface below the middle of the cell",
            FloorSource::Zero => "no level surface is near z 0",
        }
    }
}

impl Floor {
    /// The floor of a scene at its first moment.
    pub(super) fn new(study: &Study, scene: &Scene) -> Floor {
        let given = study.approach.floor_m.map(|z_m| Floor { z_m, source: FloorSource::Study });
        given.unwrap_or_else(|| Floor::find(scene))
    }

    /// The floor of a scene at its first moment, whatever its study gives.
    fn find(scene: &Scene) -> Floor {
        let surfaces = level_surfaces(scene);
        let feet: Vec<f64> =
            objects_with_role(scene, Role::Human).filter_map(|person| Some(heights_m(person)?[0])).collect();
        let lowest = feet.iter().copied().reduce(f64::min);
        let near = |heights: &[f64]| {
            let at = *heights.first()?;
            largest(&surfaces, at, |z| heights.iter().any(|at| (z - at).abs() <= NEAR_M))
        };
        let below = || {
            let feet_m = lowest?;
            largest(&surfaces, feet_m, |z| z < feet_m)
        };
        let lower = || {
            let ends = objects_with_role(scene, Role::Environment).filter_map(heights_m);
            let [low, high] = ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])?;
            largest(&surfaces, low, |z| z < (low + high) / 2.0)
        };
        let floor = |source: FloorSource| move |z_m: f64| Floor { z_m, source };
        (near(&feet).map(floor(FloorSource::NearFeet)))
            .or_else(|| below().map(floor(FloorSource::BelowFeet)))
            .or_else(|| near(&[0.0]).map(floor(FloorSource::NearZero)))
            .or_else(|| lower().map(floor(FloorSource::LowerHalf)))
            .or_else(|| lowest.map(floor(FloorSource::Feet)))
            .unwrap_or(floor(FloorSource::Zero)(0.0))
    }
}

/// That a study takes another height than that of a scene's floor for it: it gives none, or another one.
pub(super) fn warning(study: &Study, scene: &Scene) -> Option<String> {
    let Floor { z_m, source } = Floor::find(scene);
    let found = format!("the floor is at z {z_m:.2} m ({})", source.words());
    let is_level = matches!(source, FloorSource::NearFeet | FloorSource::NearZero);
    match study.approach.floor_m {
        Some(given) => (is_level && (given - z_m).abs() > NEAR_M).then(|| {
            format!("[approach] floor_m = {given}: {found}: mend floor_m if it is meant to be that one")
        }),
        None if study.approach.step_m.is_some() => {
            (study.stopping.is_some() && z_m.abs() >= study.voxel_size_m).then(|| {
                format!(
                    "[stopping] takes z 0 for the floor if floor = \"auto\", and {found}: write intrusion_m in [stopping]"
                )
            })
        }
        None => {
            let asks = study.has_approach || !study.postures.is_empty() || study.stopping.is_some();
            (asks && z_m.abs() >= study.voxel_size_m).then(|| {
                format!(
                    "[approach], [postures] and [stopping] take z 0 for the floor, and {found}: write floor_m = {z_m:.2} (or \
                     floor_m = 0.0) in [approach]"
                )
            })
        }
    }
}

fn objects_with_role(scene: &Scene, role: Role) -> impl Iterator<Item = &Object> {
    scene.objects.iter().map(AsRef::as_ref).filter(move |object| object.role == role && !object.tag_only)
}

/// The lowest and the highest z of an object; `None` of an empty one.
fn heights_m(object: &Object) -> Option<[f64; 2]> {
    let reach = |[low, high]: [f64; 2], [l, h]: [f64; 2]| [low.min(l), high.max(h)];
    match &object.surface {
        Surface::Mesh(mesh) => {
            let corners = mesh.triangles.iter().flatten();
            corners.map(|corner| [mesh.vertices[*corner as usize].z; 2]).reduce(reach)
        }
        Surface::Voxels { resolution_m, keys } => {
            let ends = keys.iter().map(|[_, _, z]| [f64::from(*z), f64::from(*z) + 1.0]);
            ends.reduce(reach).map(|ends| ends.map(|end| end * resolution_m))
        }
    }
}

/// Height and area of all that is level and belongs to the environment, from the lowest up.
fn level_surfaces(scene: &Scene) -> Vec<[f64; 2]> {
    let mut all = Vec::new();
    for object in objects_with_role(scene, Role::Environment) {
        match &object.surface {
            Surface::Mesh(mesh) => all.extend(level_triangles(mesh)),
            Surface::Voxels { resolution_m, keys } => all.extend(tops(keys, *resolution_m)),
        }
    }
    all.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    all
}

fn level_triangles(mesh: &Mesh) -> impl Iterator<Item = [f64; 2]> {
    mesh.triangles.iter().filter_map(|triangle| {
        let [a, b, c]: [DVec3; 3] = triangle.map(|corner| mesh.vertices[corner as usize]);
        let twice = (b - a).cross(c - a);
        let area = twice.length() / 2.0;
        (area > 0.0 && twice.z.abs() >= LEVEL * 2.0 * area).then(|| [(a.z + b.z + c.z) / 3.0, area])
    })
}

/// The upper faces of voxels that have nothing above them.
fn tops(keys: &[[i32; 3]], resolution_m: f64) -> Vec<[f64; 2]> {
    let mut keys = keys.to_vec();
    keys.sort_unstable();
    let above = |[x, y, z]: [i32; 3]| [x, y, z + 1];
    let open = keys.iter().enumerate().filter(|(at, key)| keys.get(at + 1) != Some(&above(**key)));
    open.map(|(_, key)| [f64::from(key[2] + 1) * resolution_m, resolution_m * resolution_m]).collect()
}

/// The height of the floor with the largest area among surfaces that may be it; of equal ones the nearest to a
/// height. If it is the underside of a slab, it is the height of the slab's top.
fn largest(surfaces: &[[f64; 2]], near_m: f64, may_be: impl Fn(f64) -> bool) -> Option<f64> {
    let surfaces: Vec<[f64; 2]> = surfaces.iter().copied().filter(|[z, _]| may_be(*z)).collect();
    let (mut area, mut floor) = largest_floor(&surfaces, near_m)?;
    let mut above = &surfaces[floor.end..];
    while let Some((own, top)) = largest_floor(above, near_m).filter(|(own, _)| *own >= TOP * area) {
        let begin = surfaces.len() - above.len();
        (area, floor) = (own, begin + top.start..begin + top.end);
        above = &surfaces[floor.end..];
    }
    Some(median(&surfaces[floor]))
}

/// The floor with the largest area, and that area; of equal ones the nearest to a height.
fn largest_floor(surfaces: &[[f64; 2]], near_m: f64) -> Option<(f64, Range<usize>)> {
    // Area, first and last surface.
    let mut best: Option<(f64, usize, usize)> = None;
    let (mut first, mut area) = (0, 0.0);
    for (last, [z, own]) in surfaces.iter().enumerate() {
        area += own;
        while z - surfaces[first][0] > ONE_FLOOR_M {
            area -= surfaces[first][1];
            first += 1;
        }
        let is_better = |(most, _, known): (f64, usize, usize)| {
            let [own, known] = [*z, surfaces[known][0]].map(|z| (z - near_m).abs());
            if (area - most).abs() <= EQUAL * most { own < known } else { area > most }
        };
        if best.is_none_or(is_better) {
            best = Some((area, first, last));
        }
    }
    best.map(|(area, first, last)| (area, first..last + 1))
}

/// The height above which less than half of the area is, of surfaces from the lowest up: no single triangle of a scan decides.
fn median(surfaces: &[[f64; 2]]) -> f64 {
    let half = surfaces.iter().map(|[_, area]| area).sum::<f64>() / 2.0;
    let mut below = 0.0;
    let reaches = |[_, area]: &&[f64; 2]| {
        below += area;
        below > half * (1.0 + EQUAL)
    };
    surfaces.iter().find(reaches).or(surfaces.last()).map_or(0.0, |[z, _]| *z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The floor among level surfaces, each a height and an area, near the feet of people.
    fn check(surfaces: &[[f64; 2]], feet: &[f64], expected: Option<f64>) {
        let near = |z: f64| feet.iter().any(|at| (z - at).abs() <= NEAR_M);
        assert_eq!(largest(surfaces, feet[0], near), expected, "{surfaces:?} near {feet:?}");
    }

    #[test]
    fn the_floor_is_the_largest_level_surface_near_the_feet() {
        // The bottom of a slab is as large as its top, which is where people walk.
        check(&[[-0.1, 20.0], [0.0, 20.0]], &[0.0], Some(0.0));
        check(&[[-0.3, 120.0], [0.0, 120.0], [0.0, 118.0], [6.0, 120.0]], &[0.02], Some(0.0));
        check(&[[-0.02, 30.0], [0.0, 30.0]], &[0.0], Some(0.0));
        // A pit, or a rounded edge, takes from the top alone.
        check(&[[-0.15, 20.0], [-0.08, 3.0], [0.0, 16.0]], &[0.0], Some(0.0));
        // A pallet, a table and a platform without people are no floor.
        check(&[[0.0, 20.0], [0.14, 1.0], [0.8, 2.0]], &[0.14], Some(0.0));
        check(&[[0.0, 20.0], [1.0, 6.0]], &[1.0], Some(1.0));
        check(&[[0.0, 20.0], [1.0, 6.0]], &[0.0, 1.0], Some(0.0));
        check(&[[0.0, 20.0]], &[0.5], None);
        check(&[], &[0.0], None);
    }

    #[test]
    fn of_a_scanned_floor_it_is_the_median() {
        let scan: Vec<[f64; 2]> = (0..=100).map(|n| [f64::from(n) * 4e-4 - 0.02, 0.01]).collect();
        let found = largest(&scan, 0.0, |z| z.abs() <= NEAR_M).unwrap();
        assert!(found.abs() < 1e-3, "{found}");
    }

    #[test]
    fn upper_faces_of_voxels_are_level() {
        assert_eq!(tops(&[[0, 0, -1], [0, 0, 0], [1, 0, -1]], 0.5), [[0.5, 0.25], [0.0, 0.25]]);
    }
}
