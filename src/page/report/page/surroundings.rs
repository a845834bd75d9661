//! Measures the distance from a place to the next surface of the cell along each axis, as with a tape
//! measure, and names its object. Surfaces are those of the scene's files, not voxels; people and robots are
//! left out. A side of the room itself is named as the wall, floor or ceiling that it is.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::sketch::things::{Thing, things};
use crate::render::plan::short_name;
use perirobot_march::Result;
use perirobot_scene::objects::build::build;
use perirobot_scene::objects::{Mesh, Role, Scene, Surface};
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_study::world::place::{is_room, names_of_walls, room_m};

/// A surface as near as this touches the place, and counts as below or before it, never as above or behind.
const TOUCHING_M: f64 = 1e-6;

/// A surface of the room at most this far from its end is its wall, floor or ceiling.
const SIDE_M: f64 = 0.6;

/// The directions that are measured, in order.
pub(super) const WAYS: [&str; 6] = ["towards −x", "towards +x", "towards −y", "towards +y", "down", "up"];

/// For each way, how far it is in metres, and to which object by its index; `None` where nothing is.
pub(super) type Around = [Option<(f64, usize)>; 6];

/// The surfaces of a scene's first snapshot, and what stands there.
#[derive(Debug)]
pub(super) struct Surroundings {
    scene: Scene,
    /// The names of the room's sides in the order of [`WAYS`], and its corners.
    sides: [String; 6],
    room_m: [DVec3; 2],
    /// For each object, whether it is the room itself.
    are_rooms: Vec<bool>,
    things: Vec<Thing>,
}

impl Surroundings {
    /// Of the study's first scene, which is that of the world.
    ///
    /// # Errors
    /// When its files cannot be read any more.
    pub(super) fn new(study: &Study, world: &World) -> Result<Surroundings> {
        let scene = build(&study.scenes[0], &study.sources, study.voxel_size_m)?.swap_remove(0);
        let truth = world.truth();
        let room_m = room_m(&truth);
        let rooms: Vec<&str> =
            truth.objects.iter().filter(|one| is_room(one, room_m)).map(|one| &one.name[..]).collect();
        let are_rooms = scene.objects.iter().map(|object| rooms.contains(&&object.name[..])).collect();
        let walls = names_of_walls(study, &truth).map(|names| names.into_iter().next().unwrap_or_default());
        let [a, b, c, d] = walls;
        let sides = [a, b, c, d, "floor".into(), "ceiling".into()];
        Ok(Surroundings { scene, sides, room_m, are_rooms, things: things(&truth) })
    }

    /// The names of the objects, then those of the room's sides.
    pub(super) fn objects(&self) -> Vec<String> {
        let objects = self.scene.objects.iter().map(|object| short_name(&object.name).to_string());
        objects.chain(self.sides.clone()).collect()
    }

    /// What stands in the room.
    pub(super) fn things(&self) -> &[Thing] {
        &self.things
    }

    /// The number of what is next along a way: the room's side if it is one, else the object.
    fn named(&self, way: usize, place: f64, object: usize) -> usize {
        let is_side = self.are_rooms[object] && (place - self.room_m[way % 2][way / 2]).abs() <= SIDE_M;
        if is_side { self.scene.objects.len() + way } else { object }
    }

    /// What is around many places, each of them measured once.
    pub(super) fn measure_all(&self, places: impl Iterator<Item = DVec3>) -> HashMap<[u64; 3], Around> {
        let all: HashMap<[u64; 3], DVec3> = places.map(|at| (key(at), at)).collect();
        all.into_par_iter().map(|(key, at)| (key, self.measure(at))).collect()
    }

    /// What is around a place.
    pub(super) fn measure(&self, at: DVec3) -> Around {
        let mut around = [None; 6];
        let objects = self.scene.objects.iter().enumerate();
        for (index, object) in
            objects.filter(|(_, object)| object.role == Role::Environment && !object.tag_only)
        {
            for axis in 0..3 {
                let mut hit = |metres: f64| {
                    let beyond = metres - at[axis];
                    let way = 2 * axis + usize::from(beyond > TOUCHING_M);
                    let nearest: &mut Option<(f64, usize)> = &mut around[way];
                    if nearest.is_none_or(|(known, _)| beyond.abs() < known) {
                        *nearest = Some((beyond.abs(), index));
                    }
                };
                match &object.surface {
                    Surface::Mesh(mesh) => hit_triangles(mesh, at, axis, &mut hit),
                    Surface::Voxels { resolution_m, keys } => {
                        hit_voxels(keys, at / *resolution_m, axis, &mut |edges| hit(edges * resolution_m));
                    }
                }
            }
        }
        for (way, next) in around.iter_mut().enumerate() {
            if let Some((metres, object)) = next {
                let place = at[way / 2] + if way % 2 == 0 { -*metres } else { *metres };
                *object = self.named(way, place, *object);
            }
        }
        around
    }
}

/// A place to look up.
pub(super) fn key(at: DVec3) -> [u64; 3] {
    at.to_array().map(f64::to_bits)
}

/// Where a line through a place along an axis meets triangles, their edges included. Triangles that contain
/// the line do not count: their neighbours do.
fn hit_triangles(mesh: &Mesh, at: DVec3, axis: usize, hit: &mut impl FnMut(f64)) {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    for triangle in &mesh.triangles {
        let corners = triangle.map(|corner| mesh.vertices[corner as usize]);
        let inside = |n: usize| {
            let values = corners.map(|corner| corner[n]);
            values.iter().any(|&x| x <= at[n]) && values.iter().any(|&x| x >= at[n])
        };
        if !inside(u) || !inside(v) {
            continue;
        }
        // Twice the areas, with sign, of the triangles that the place makes with each edge.
        let area = |a: DVec3, b: DVec3| (a[u] - at[u]) * (b[v] - at[v]) - (a[v] - at[v]) * (b[u] - at[u]);
        let [a, b, c] = corners;
        let weights = [area(b, c), area(c, a), area(a, b)];
        let whole: f64 = weights.iter().sum();
        let is_met = weights.iter().all(|&w| w >= 0.0) || weights.iter().all(|&w| w <= 0.0);
        if is_met && whole != 0.0 {
            hit((weights[0] * a[axis] + weights[1] * b[axis] + weights[2] * c[axis]) / whole);
        }
    }
}

/// The same for voxels, in edges of a voxel: where the line comes in and goes out.
fn hit_voxels(keys: &[[i32; 3]], at: DVec3, axis: usize, hit: &mut impl FnMut(f64)) {
    let cell = at.floor();
    for key in keys {
        let others = (0..3).filter(|&other| other != axis);
        if others.into_iter().all(|other| f64::from(key[other]) == cell[other]) {
            hit(f64::from(key[axis]));
            hit(f64::from(key[axis]) + 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use perirobot_scene::objects::{Interior, Object, Optical};

    fn object(name: &str, role: Role, surface: Surface) -> Arc<Object> {
        let (interior, optical) = (Interior::Free, Optical::Opaque);
        let (keypoints, linkage, warnings) = (None, None, Vec::new());
        let name = name.into();
        Arc::new(Object {
            name,
            role,
            interior,
            optical,
            radar: Default::default(),
            shade: 0,
            tag_only: false,
            takes_unit: false,
            surface,
            keypoints,
            linkage,
            warnings,
        })
    }

    /// A rectangle of two triangles at a height.
    fn level(low: [f64; 2], high: [f64; 2], z: f64) -> Surface {
        let corner = |x: f64, y: f64| DVec3::new(x, y, z);
        let vertices = vec![
            corner(low[0], low[1]),
            corner(high[0], low[1]),
            corner(high[0], high[1]),
            corner(low[0], high[1]),
        ];
        Surface::Mesh(Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] })
    }

    fn cell() -> Surroundings {
        let objects = vec![
            object("slab", Role::Environment, level([-2.0, -2.0], [2.0, 2.0], -0.1)),
            object("floor", Role::Environment, level([-2.0, -2.0], [2.0, 2.0], 0.0)),
            object("robot", Role::Robot, level([-2.0, -2.0], [2.0, 2.0], 0.5)),
            // One voxel of 0.25 m from (1, 0, 1).
            object("map", Role::Environment, Surface::Voxels { resolution_m: 0.25, keys: vec![[4, 0, 4]] }),
        ];
        let sides = ["a", "b", "c", "right wall", "floor", "ceiling"].map(String::from);
        let room_m = [DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 3.0)];
        let are_rooms = vec![false; objects.len()];
        let scene = Scene { name: "cell".into(), snapshot: 0, objects, speeds_mm_s: Vec::new() };
        Surroundings { scene, sides, room_m, are_rooms, things: Vec::new() }
    }

    #[test]
    fn a_side_of_the_room_is_a_wall_and_a_beam_in_it_is_not() {
        let mut cell = cell();
        cell.are_rooms[3] = true;
        cell.room_m[1].x = 1.25;
        // The voxel begins at 1 m, a wall's thickness before the room's end; then far before it.
        assert_eq!(cell.measure(DVec3::new(0.125, 0.125, 1.125))[1], Some((0.875, 4 + 1)));
        assert_eq!(cell.objects()[4 + 1], "b");
        cell.room_m[1].x = 2.0;
        assert_eq!(cell.measure(DVec3::new(0.125, 0.125, 1.125))[1], Some((0.875, 3)));
    }

    #[test]
    fn the_next_surface_counts_and_no_robot() {
        // On the diagonal of the rectangles, and level with the voxel.
        let around = cell().measure(DVec3::new(0.125, 0.125, 1.125));
        assert_eq!(around, [None, Some((0.875, 3)), None, None, Some((1.125, 1)), None]);
        // Above the voxel, beyond the floor's edge in y.
        let around = cell().measure(DVec3::new(1.125, 0.125, 2.0));
        assert_eq!(around, [None, None, None, None, Some((0.75, 3)), None]);
        assert_eq!(cell().measure(DVec3::new(0.0, 2.5, 1.0)), [None; 6]);
    }

    #[test]
    fn what_lies_on_the_floor_touches_it() {
        let around = cell().measure(DVec3::new(0.5, -0.5, 0.0));
        assert_eq!(around, [None, None, None, None, Some((0.0, 1)), None]);
        assert_eq!(cell().objects()[1], "floor");
    }

    #[test]
    fn places_are_measured_once() {
        let places = [DVec3::X, DVec3::X, DVec3::Z];
        let all = cell().measure_all(places.into_iter());
        assert_eq!(all.len(), 2);
        assert_eq!(all[&key(DVec3::Z)], cell().measure(DVec3::Z));
    }
}
