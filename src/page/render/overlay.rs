//! Draws over the voxels: visible returns as dots; sensors as figures of lines, and ways of bodies, visible through
//! everything.

use glam::DVec3;

use super::Samples;
use super::colour::{POINTS, SENSOR, WAY};
use super::eye::PictureCamera;
use perirobot_decide::approach::Way;
use perirobot_decide::view::View;
use perirobot_march::march;
use perirobot_march::voxel::BitGrid;

/// Tolerance for a return on the far side of a voxel's corner, in 1/65536 voxels.
const SLACK_Q16: f64 = 1.5 * 65536.0;
/// Length of a sensor's figure in metres.
const FIGURE_M: f64 = 0.4;
/// Half the width of an all-round sensor's figure, in metres.
const ALL_AROUND_M: f64 = 0.08;

/// Draws about `most` returns of each sensor, or all, at places where dots are allowed.
pub(super) fn points(
    samples: &mut Samples,
    view: &View,
    most: usize,
    places: &BitGrid,
    camera: &PictureCamera,
) {
    if most == 0 {
        return;
    }
    for member in &view.members {
        let returns = view.returns(member);
        // Selected by a hash, to avoid patterns.
        let share = (most as u64 * (1 << 32)).checked_div(returns.len() as u64).unwrap_or(0);
        let chosen = |ray: usize| u64::from(march::pcg(ray as u32)) < share;
        for found in returns.iter().filter(|found| chosen(found.ray) && places.get(found.voxel)) {
            let Some(([x, y], distance_q16)) = camera.project(found.at_m) else { continue };
            let here = ray_index([x.floor(), y.floor()], camera.size);
            if here.is_some_and(|at| distance_q16 <= f64::from(samples.depths_q16[at]) + SLACK_Q16) {
                let is_there = view.truth.occupied.get(found.voxel);
                dot(samples, [x, y], 1.0, POINTS[usize::from(!is_there)], camera.size);
            }
        }
    }
}

/// Draws the figure of each sensor; for a pad and a gate the watched ground.
pub(super) fn sensors(samples: &mut Samples, view: &View, camera: &PictureCamera) {
    let outlines: Vec<_> = view.members.iter().filter_map(|member| view.outline(member)).collect();
    let grounds: Vec<_> = view.members.iter().flat_map(|member| view.grounds(member)).collect();
    // The rims of all lines first, so that the lines stand out.
    for (radius, colour) in [(3.2, [255; 3]), (1.7, SENSOR)] {
        for corners in &grounds {
            ring(samples, corners, radius, colour, camera);
        }
        for outline in &outlines {
            let apex = outline.apex_m;
            let rim: Vec<DVec3> = match outline.rim.is_empty() {
                false => outline.rim.iter().map(|dir| apex + *dir * FIGURE_M).collect(),
                true => {
                    [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y].map(|dir| apex + dir * ALL_AROUND_M).to_vec()
                }
            };
            let ends = match outline.rim.is_empty() {
                false => vec![apex],
                true => vec![apex + DVec3::Z * ALL_AROUND_M, apex - DVec3::Z * ALL_AROUND_M],
            };
            // Four edges are enough for a cone.
            let spoke = (rim.len() / 4).max(1);
            ring(samples, &rim, radius, colour, camera);
            for (i, corner) in rim.iter().enumerate() {
                for end in ends.iter().filter(|_| i % spoke == 0) {
                    line(samples, [*end, *corner], radius, colour, camera);
                }
            }
            if let Some((at, _)) = camera.project(apex) {
                dot(samples, at, 2.0 * radius, colour, camera.size);
            }
        }
    }
}

/// Draws ways of bodies, and the bodies at their ends.
pub(super) fn ways(samples: &mut Samples, ways: &[Way], camera: &PictureCamera) {
    for (radius, colour) in [(3.2, [255; 3]), (1.7, WAY)] {
        for points in ways.iter().flat_map(|way| [&way.points_m].into_iter().chain(&way.outline_m)) {
            points.windows(2).for_each(|ends| line(samples, [ends[0], ends[1]], radius, colour, camera));
        }
    }
}

/// Lines from each point of the world to the next, and from the last to the first.
fn ring(samples: &mut Samples, points: &[DVec3], radius: f64, colour: [u8; 3], camera: &PictureCamera) {
    for (i, from) in points.iter().enumerate() {
        line(samples, [*from, points[(i + 1) % points.len()]], radius, colour, camera);
    }
}

/// A line between two points of the world.
fn line(samples: &mut Samples, [from, to]: [DVec3; 2], radius: f64, colour: [u8; 3], camera: &PictureCamera) {
    let (Some((a, _)), Some((b, _))) = (camera.project(from), camera.project(to)) else { return };
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    // The number of dots follows the length, with a limit for lines that end far outside the picture.
    let steps = (dx.abs().max(dy.abs()).ceil()).clamp(1.0, 10_000.0);
    for i in 0..=steps as u32 {
        let along = f64::from(i) / steps;
        dot(samples, [a[0] + dx * along, a[1] + dy * along], radius, colour, camera.size);
    }
}

/// A disc of the picture.
fn dot(samples: &mut Samples, [x, y]: [f64; 2], radius: f64, colour: [u8; 3], size: [u32; 2]) {
    let reach = radius.ceil() as i32;
    for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
        let (px, py) = (x.floor() + f64::from(dx), y.floor() + f64::from(dy));
        let (from_x, from_y) = (px + 0.5 - x, py + 0.5 - y);
        if from_x * from_x + from_y * from_y <= radius * radius
            && let Some(at) = ray_index([px, py], size)
        {
            samples.colours[at] = colour;
        }
    }
}

/// The index of a ray, if it exists.
fn ray_index([x, y]: [f64; 2], [width, height]: [u32; 2]) -> Option<usize> {
    let is = (0.0..f64::from(width)).contains(&x) && (0.0..f64::from(height)).contains(&y);
    is.then(|| y as usize * width as usize + x as usize)
}
