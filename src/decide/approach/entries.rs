//! The places at which bodies enter.

use glam::DVec2;

use super::body::{Body, Sums};
use perirobot_march::error::Issue;
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_scene::pose::Pose;
use perirobot_study::sensor::Kind;
use perirobot_study::sensor::prism::Prism;

/// The places at which a body is wholly inside a box.
pub(super) fn places_in_box(
    body: &Body,
    prism: &Prism,
    grid: &Grid,
    places: Window,
) -> Result<BitGrid, Issue> {
    let inside = prism.voxels(&Pose::ORIGIN, grid, grid.window());
    let around = inside.bounds();
    if around.is_empty() {
        let [low, high] = [grid.corner_m([0; 3]), grid.corner_m(grid.window().end())];
        return Err(Issue::says(format!(
            "lies outside the grid, which goes from {:.2?} to {:.2?} m, or holds no voxel's centre",
            low.to_array(),
            high.to_array()
        ))
        .with_advice("move it, make it larger, or set bounds_m"));
    }
    let max: [i32; 3] = std::array::from_fn(|r| around.end()[r] - body.size[r].min(1 << 20) as i32);
    let within = Window::from_corners(around.min, max).intersection(&places);
    if within.is_empty() {
        let metres = |voxels: u32| f64::from(voxels) * grid.voxel_size_m;
        let size = |size: [u32; 3]| size.map(|n| format!("{:.2}", metres(n))).join(" × ");
        let stands = match body.on_floor && body.climbs.is_none() {
            true => format!(" and stands on the floor, from {:.2} m up", grid.corner_m(places.min).z),
            false => String::new(),
        };
        return Err(Issue::says(format!(
            "is too small for body {:?}: in whole voxels that is {} m{stands}, and the entry is {} m from {:.2?}",
            body.name,
            size(body.size),
            size(around.size),
            grid.corner_m(around.min).to_array(),
        ))
        .with_advice("make it larger, or leave the body out"));
    }
    Ok(BitGrid::full(within).to_window(places))
}

/// The places at which a body touches the edge of the grid: its sides, and, if it does not stand on the floor,
/// top and bottom.
pub(super) fn at_edges(body: &Body, grid: &Grid, places: Window) -> BitGrid {
    let axes = if body.on_floor { 0..2 } else { 0..3 };
    let mut begin = BitGrid::new(places);
    for axis in axes {
        let last = (grid.size[axis] - body.size[axis].min(grid.size[axis])) as i32;
        for at in [0, last] {
            let mut side = places;
            (side.min[axis], side.size[axis]) = (at, 1);
            begin.add(&BitGrid::full(side.intersection(&places)));
        }
    }
    begin
}

/// The places at which a body stands beside a light curtain, on the side that its zone does not lie on, and
/// touches it without being in it.
pub(super) fn places_outside_gate(
    body: &Body,
    gate: &dyn Kind,
    pose: &Pose,
    grid: &Grid,
    places: Window,
) -> Result<BitGrid, Issue> {
    let prisms = gate.prisms();
    let [curtain, zone] = prisms[..] else { return Err(Issue::says("is no light curtain")) };
    let inside = curtain.voxels(pose, grid, grid.window()).to_window(grid.window());
    let mut beside = BitGrid::new(grid.window());
    for [x, y, z] in inside.voxels() {
        (z - 1..=z + 1).for_each(|z| (y - 1..=y + 1).for_each(|y| beside.set_run(x - 1, x + 2, y, z)));
    }
    let mut begin = body.covers_at_most(0, &Sums::new(&inside), places);
    begin.remove(&body.covers_at_most(0, &Sums::new(&beside), places));
    // The curtain's thin side points away from the zone; in the plane of the floor.
    let corners = curtain.corners_q16(pose, grid);
    let middle = |corners: &[[i64; 2]]| {
        let sum = |axis: usize| corners.iter().map(|corner| corner[axis]).sum::<i64>();
        [sum(0) / corners.len() as i64, sum(1) / corners.len() as i64]
    };
    let minus = |a: [i64; 2], b: [i64; 2]| [a[0] - b[0], a[1] - b[1]];
    let length = |a: &[i64; 2]| DVec2::new(a[0] as f64, a[1] as f64).length();
    let sides = [minus(corners[1], corners[0]), minus(corners[3 % corners.len()], corners[0])];
    let thin = if length(&sides[0]) < length(&sides[1]) { sides[0] } else { sides[1] };
    let (here, there) = (middle(&corners), middle(&zone.corners_q16(pose, grid)));
    let along = |way: [i64; 2]| (0..2).map(|r| i128::from(way[r]) * i128::from(thin[r])).sum::<i128>();
    let towards_zone = along(minus(there, here)).signum();
    if towards_zone == 0 {
        return Err(Issue::says("has its zone around its box, so that neither side is outside")
            .with_advice("name the entry by a box"));
    }
    let is_outside = |place: [i32; 3]| {
        let at = |r: usize| (2 * i64::from(place[r]) + i64::from(body.size[r])) << 15;
        along(minus([at(0), at(1)], here)).signum() == -towards_zone
    };
    let mut outside = BitGrid::new(places);
    begin.voxels().filter(|&place| is_outside(place)).for_each(|place| outside.set(place));
    match outside.is_empty() {
        true => Err(Issue::says(format!(
            "no place of body {:?} in the grid touches the outside of its box",
            body.name
        ))
        .with_advice("make room for it there by bounds_m, or name the entry by a box")),
        false => Ok(outside),
    }
}
