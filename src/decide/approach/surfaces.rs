//! What carries bodies with `floor = "auto"`: floors, platforms, pits and conveyors, at whatever height they are.
//!
//! # Theory
//! A *surface* is an occupied voxel, of neither a robot nor a person, with nothing solid right above. A body rests at a place if it has room there
//! and a surface is right below one of its voxels, as a rigid body that is put down: on the highest thing under it. Places
//! at which it rests are joined by steps to the 8 columns beside, up or down by at most the layers of `step_m`, rounded up.
//! The body walks on what these steps join to an entry: its places are columns with a height, so it may walk over a
//! platform and under it. It does not go down where a step is higher: it neither climbs nor jumps.

use glam::DVec3;

use super::body::{Body, Sums};
use super::flood::Flood;
use super::ground::{Ground, solid};
use crate::view::watched::Watcher;
use perirobot_march::Result;
use perirobot_march::voxel::grid::length_q16;
use perirobot_march::voxel::{BitGrid, Distances, Grid, Window};
use perirobot_scene::objects::Role;
use perirobot_scene::truth::Truth;
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// The layers of a step of a height, rounded up, so that no step of that height is lost between voxels.
pub(super) fn layers_of_step(step_m: f64, voxel_size_m: f64) -> u32 {
    ((length_q16(step_m, voxel_size_m) + 0xffff) >> 16) as u32
}

/// The occupied voxels, of neither a robot nor a person, with nothing solid right above.
pub(super) fn surfaces(truth: &Truth, solid: &BitGrid) -> BitGrid {
    let mut carriers = BitGrid::clone(&truth.occupied);
    carriers.remove(&truth.robot);
    carriers.remove(&truth.human);
    let layer = carriers.words_per_row() as usize * solid.window().size[1] as usize;
    let above = solid.words().get(layer..).unwrap_or_default();
    carriers.words_mut().iter_mut().zip(above).for_each(|(own, above)| *own &= !above);
    carriers
}

/// Where a body has room, and rests on a surface if it walks.
pub(super) fn room(body: &Body, solid: &Sums, surfaces: &Sums, places: Window) -> BitGrid {
    let mut room = body.covers_at_most(0, solid, places);
    if body.climbs.is_some() {
        room.keep(&body.rests_on(surfaces, places));
    }
    room
}

/// The part of a body's room to which it walks from its entries; all of it if it does not walk.
pub(super) fn walked(body: &Body, begins: &[BitGrid], room: BitGrid) -> BitGrid {
    if body.climbs.is_none() {
        return room;
    }
    let mut begin = BitGrid::new(room.window());
    begins.iter().for_each(|entry| begin.add(entry));
    Flood::from_places(&begin, &room, body.climbs).places().clone()
}

/// The surfaces that bodies of a study walk on in a scene, by the voxel that carries them, all its snapshots at once and
/// without people; `None` if the floor has one height. `worlds` are the snapshots, `watchers` the sensors that are looked at.
///
/// # Errors
/// Those of [`Ground::new`], but that there may be no hazard.
pub fn walked_surfaces(study: &Study, worlds: &[World], watchers: &[Watcher]) -> Result<Option<BitGrid>> {
    if study.approach.step_m.is_none() {
        return Ok(None);
    }
    let ground = Ground::without_hazard(study, worlds, watchers)?;
    let window = worlds[0].grid.window();
    let (mut all_solid, mut all_surfaces) = (BitGrid::full(window), BitGrid::new(window));
    for world in worlds {
        let truth = world.truth_without_people();
        let here = solid(&truth);
        all_surfaces.add(&surfaces(&truth, &here));
        all_solid.keep(&here);
    }
    let sums = [&all_solid, &all_surfaces].map(Sums::new);
    let mut found = BitGrid::new(window);
    for (number, body) in ground.bodies.iter().enumerate().filter(|(_, body)| body.climbs.is_some()) {
        let room = room(body, &sums[0], &sums[1], ground.places[number]);
        let places = walked(body, &ground.begins[number], room);
        places.voxels().flat_map(|place| body.voxels_below(place)).for_each(|voxel| found.set(voxel));
    }
    found.keep(&all_surfaces);
    Ok(Some(found))
}

/// The height in metres of the lowest surface at a spot with `room_m` free above, at the first snapshot of a scene and
/// without its people; rounded down to a voxel. `None` if there is none.
pub(crate) fn spot_height_m(world: &World, spot_m: DVec3, room_m: f64) -> Option<f64> {
    let (truth, grid) = (world.truth_without_people(), &world.grid);
    let solid = solid(&truth);
    let surfaces = surfaces(&truth, &solid);
    let [x, y, _] = Grid::voxel_of(grid.position_q16(spot_m));
    let above = layers_of_step(room_m, grid.voxel_size_m) as i32;
    let has_room = |z: &i32| (z + 1..z + above).all(|z| !solid.get([x, y, z]));
    let lowest = (0..grid.size[2] as i32).filter(|&z| surfaces.get([x, y, z])).find(has_room)?;
    Some(grid.corner_m([x, y, lowest]).z)
}

/// The object that is between a body that walks and the nearest voxel of the hazard, and that it does not climb: the
/// first on the straight line between them, seen from above. The line goes up and down as the body would.
pub(super) fn fence_between(
    (body, place): (&Body, [i32; 3]),
    truth: &Truth,
    (solid, hazard, distances): (&BitGrid, &BitGrid, &Distances),
) -> Option<String> {
    let climbs = body.climbs? as i32;
    let squared_distance = |voxel: &[i32; 3]| distances.squared_distance(*voxel);
    let own = body.voxels(place).min_by_key(squared_distance)?;
    let apart = |voxel: &[i32; 3]| (0..3).map(|r| own[r].abs_diff(voxel[r]).pow(2)).sum::<u32>();
    let to = hazard.voxels().find(|voxel| apart(voxel) == squared_distance(&own))?;
    let from = body.middle(place);
    let stops = |voxel: [i32; 3]| solid.get(voxel) && !hazard.get(voxel);
    let name = |voxel: [i32; 3]| {
        let objects = truth.objects.iter().filter(|object| object.role == Role::Environment);
        objects.into_iter().find(|object| object.voxels.get(voxel)).map(|object| object.name.clone())
    };
    // Twice as many samples as columns, so that it passes no gap between two that meet at a corner.
    let samples = 2 * (0..2).map(|r| (to[r] - from[r]).abs()).max()?.max(1);
    let mut feet = place[2];
    for sample in 0..=samples {
        let [x, y] =
            [0, 1].map(|r| from[r] + (2 * (to[r] - from[r]) * sample + samples).div_euclid(2 * samples));
        let below = (feet - climbs - 1..feet + climbs).rev().find(|&z| stops([x, y, z]));
        feet = below.map_or(feet, |below| below + 1);
        let blocked = (feet..feet + body.size[2] as i32).map(|z| [x, y, z]).find(|&voxel| stops(voxel));
        if let Some(object) = blocked.and_then(name) {
            return Some(object);
        }
    }
    None
}
