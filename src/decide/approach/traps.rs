//! Warnings of `perirobot check` if bodies walk on surfaces: platforms and pits that no body reaches.

use super::body::{Body, Sums};
use super::flood::steps;
use super::ground::Ground;
use super::moments::ApproachMoment;
use super::surfaces::room;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::objects::Role;

/// Smaller surfaces are not reported, in square metres.
const LEAST_M2: f64 = 0.25;
/// A surface that is higher above the floor beside it is not expected to be walked on, in metres.
const HIGHEST_M: f64 = 1.0;
/// The most surfaces that are reported.
const FEW: usize = 3;

/// A surface to which no body walks, beside one to which a body does.
struct Unreached {
    places: u64,
    /// How much higher it is than the surface beside it, in layers; below 0 in a pit.
    rise: i32,
    /// The body's place where that is.
    at: [i32; 3],
}

/// The largest surfaces that the first body that walks has room on and does not get to, as warnings.
pub(super) fn traps(ground: &Ground, moment: &ApproachMoment) -> Vec<String> {
    let Some(number) = ground.bodies.iter().position(|body| body.climbs.is_some()) else { return Vec::new() };
    let (body, walked) = (&ground.bodies[number], &moment.free()[number]);
    let sums = [&*moment.solid, &moment.surfaces].map(Sums::new);
    let mut left = room(body, &sums[0], &sums[1], ground.places[number]);
    left.remove(walked);
    let voxel_m = ground.worlds[0].grid.voxel_size_m;
    let is_told = |one: &Unreached| {
        one.places as f64 * voxel_m * voxel_m >= LEAST_M2 && f64::from(one.rise) * voxel_m <= HIGHEST_M
    };
    let mut all: Vec<Unreached> = unreached(body, left, walked).into_iter().filter(is_told).collect();
    all.sort_by_key(|one| (std::cmp::Reverse(one.places), one.at));
    let mut warnings: Vec<String> =
        all.iter().take(FEW).map(|one| describe(ground, moment, body, one)).collect();
    if all.len() > FEW {
        warnings.push(format!("{} smaller surfaces are not reached either", all.len() - FEW));
    }
    warnings
}

/// The parts of some places that steps join, each with the least step to a place that is walked on in a column beside.
fn unreached(body: &Body, mut left: BitGrid, walked: &BitGrid) -> Vec<Unreached> {
    let moves = steps(body.climbs);
    let layers = walked.bounds();
    let layers = layers.min[2]..layers.end()[2];
    let mut found = Vec::new();
    for begin in left.voxels().collect::<Vec<_>>() {
        if !left.get(begin) {
            continue;
        }
        left.unset(begin);
        let mut part = vec![begin];
        let mut nearest: Option<(i32, [i32; 3])> = None;
        let mut next = 0;
        while let Some(&place @ [x, y, z]) = part.get(next) {
            next += 1;
            for (by, _) in &moves {
                let to = std::array::from_fn(|r| place[r] + by[r]);
                if left.get(to) {
                    left.unset(to);
                    part.push(to);
                }
            }
            let beside = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x + i, y + j]));
            for [x, y] in beside {
                for own in layers.clone().filter(|&own| walked.get([x, y, own])) {
                    if nearest.is_none_or(|(rise, _)| (z - own).abs() < rise.abs()) {
                        nearest = Some((z - own, place));
                    }
                }
            }
        }
        found.extend(nearest.map(|(rise, at)| Unreached { places: part.len() as u64, rise, at }));
    }
    found
}

fn describe(ground: &Ground, moment: &ApproachMoment, body: &Body, one: &Unreached) -> String {
    let (grid, truth) = (&ground.worlds[0].grid, ground.worlds[0].truth_without_people());
    let surface = body.voxels_below(one.at).find(|&voxel| moment.surfaces.get(voxel)).unwrap_or(one.at);
    let environment = truth.objects.iter().filter(|object| object.role == Role::Environment);
    let object = environment.into_iter().find(|object| object.voxels.get(surface));
    let on = object.map_or("a surface".into(), |object| format!("{:?}", object.name));
    let (z_m, area_m2) =
        (grid.corner_m(surface).z, one.places as f64 * grid.voxel_size_m * grid.voxel_size_m);
    let rise_m = f64::from(one.rise.abs()) * grid.voxel_size_m;
    let step_m = ground.study.approach.step_m.unwrap_or_default();
    let name = &body.name;
    match one.rise > 0 {
        true => format!(
            "body {name:?} does not get onto {on} at z {z_m:.2} m ({area_m2:.2} m²): the lowest step is {rise_m:.2} m and \
             step_m is {step_m}: raise step_m if people climb it, or add its stairs to the scene"
        ),
        false => format!(
            "{on} at z {z_m:.2} m ({area_m2:.2} m²) is a pit that body {name:?} does not get into or out of: the lowest step \
             is {rise_m:.2} m and step_m is {step_m}: raise step_m if people climb it, or add its stairs to the scene"
        ),
    }
}
