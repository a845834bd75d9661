//! The field of view of a sensor, seen from above: its rays until they leave the room or reach the range. Obstacles are
//! ignored.

use glam::{DVec2, DVec3};

use perirobot_march::backend::Rays;
use perirobot_scene::pose::Pose;
use perirobot_study::sensor::Kind;

/// Rays of a picture that are followed, across and down.
const ACROSS: usize = 17;
/// A ray counts as level if it rises or falls by less than this share of its length.
const LEVEL: f64 = 0.01;
/// Sectors of a turn; the longest ray of each is drawn for other sensors.
const PARTS: usize = 90;

/// The floor area below a sensor's field of view, as its corners.
pub(super) fn field(
    kind: &dyn Kind,
    rays: &Rays,
    pose: &Pose,
    [low, high]: [DVec3; 2],
    voxel_size_m: f64,
) -> Vec<DVec2> {
    let at = pose.position_m;
    let world_from_rays = kind.frame(pose);
    let (low, high) = (low.min(at), high.max(at));
    let end = |ray: usize| {
        let range_m = f64::from(rays.gates_of(ray).range_max_q16) / 65536.0 * voxel_size_m;
        let along = world_from_rays * DVec3::from_array(rays.dirs_q15[ray].map(f64::from)).normalize();
        let leaves = (0..3).map(|axis| match along[axis] {
            0.0 => f64::INFINITY,
            ahead if ahead > 0.0 => (high[axis] - at[axis]) / ahead,
            ahead => (low[axis] - at[axis]) / ahead,
        });
        (at + along * leaves.fold(range_m, f64::min)).truncate()
    };
    match rays.image {
        Some(image) => {
            let [width, height] = image.size_px.map(|n| n as usize);
            let spread = |n: usize, of: usize| n * (of - 1) / (ACROSS - 1);
            let pixels = (0..ACROSS).flat_map(|v| (0..ACROSS).map(move |u| (u, v)));
            let ends = pixels.map(|(u, v)| end(spread(v, height) * width + spread(u, width)));
            hull(ends.chain([at.truncate()]).collect())
        }
        None => star(at.truncate(), (0..rays.dirs_q15.len()).map(end)),
    }
}

/// Whether all rays stay at the sensor's height, so that it sees a single plane.
pub(super) fn is_level(kind: &dyn Kind, rays: &Rays, pose: &Pose) -> bool {
    let world_from_rays = kind.frame(pose);
    let rise = |dir: &[i32; 3]| {
        let along = world_from_rays * DVec3::from_array(dir.map(f64::from));
        along.z.abs() / along.length()
    };
    rays.dirs_q15.iter().all(|dir| rise(dir) < LEVEL)
}

/// The convex hull of some places, anticlockwise.
fn hull(mut places: Vec<DVec2>) -> Vec<DVec2> {
    places.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    places.dedup();
    let half = |places: &mut dyn Iterator<Item = DVec2>| {
        let mut corners: Vec<DVec2> = Vec::new();
        for place in places {
            while let [.., a, b] = corners[..]
                && (b - a).perp_dot(place - a) <= 1e-9
            {
                corners.pop();
            }
            corners.push(place);
        }
        corners.pop();
        corners
    };
    let mut corners = half(&mut places.iter().copied());
    corners.extend(half(&mut places.iter().rev().copied()));
    corners
}

/// The longest ray of each sector, in order; the sensor itself between sectors without rays.
fn star(middle: DVec2, ends: impl Iterator<Item = DVec2>) -> Vec<DVec2> {
    let mut longest: [Option<DVec2>; PARTS] = [None; PARTS];
    for end in ends {
        let along = end - middle;
        let turn = libm::atan2(along.y, along.x) / std::f64::consts::TAU;
        let known = &mut longest[(turn.rem_euclid(1.0) * PARTS as f64) as usize % PARTS];
        if known.is_none_or(|known| (known - middle).length_squared() < along.length_squared()) {
            *known = Some(end);
        }
    }
    let mut corners = Vec::new();
    for part in 0..PARTS {
        match longest[part] {
            Some(end) => corners.push(end),
            None if longest[(part + PARTS - 1) % PARTS].is_some() => corners.push(middle),
            None => {}
        }
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_has_corners_only() {
        let places = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]];
        let found = hull(places.map(DVec2::from_array).to_vec());
        assert_eq!(found, [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(DVec2::from_array));
        assert!(hull(vec![DVec2::ONE]).len() < 3);
    }

    #[test]
    fn a_star_has_a_corner_where_there_are_no_rays() {
        let ray = |degrees: f64, length: f64| DVec2::from_angle(degrees.to_radians()) * length;
        // The longer ray of each sector, in a quarter turn.
        let ends = (0..90).flat_map(|degrees| [1.0, 2.0].map(|length| ray(f64::from(degrees) + 0.5, length)));
        let found = star(DVec2::ZERO, ends);
        let far = found.iter().filter(|place| place.length() > 1.5).count();
        assert_eq!((far, found.len()), (23, 24), "{found:?}");
        assert_eq!(star(DVec2::ZERO, (0..360).map(|d| ray(f64::from(d), 1.0))).len(), PARTS);
    }
}
