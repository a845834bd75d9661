//! Measures the distance from a place to the next surface of the cell along each axis, as with a tape measure, and
//! names its object. Surfaces are those of the scene's files, not voxels; people and robots are left out. A side of the
//! room itself is named as wall, floor or ceiling.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::sketch::things::{Thing, things};
use crate::render::plan::short_name;
use perirobot_march::Result;
use perirobot_scene::objects::build::build;
use perirobot_scene::objects::{Mesh, Object, Role, Scene, Surface};
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_study::world::place::{is_room, names_of_walls, room_m};

/// A surface this close touches the place, and counts as below or in front of it, never as above or behind.
const TOUCHING_M: f64 = 1e-6;

/// A lower object is named if it is at least this high: a fence, a shelf or a cabinet, but not a pallet.
const HIGH_M: f64 = 1.0;

/// A lower object is measured this far below its top.
const BELOW_TOP_M: f64 = 0.001;

/// A surface of the room at most this far from its end is its wall, floor or ceiling.
const SIDE_M: f64 = 0.6;

/// The measured directions, in order.
pub(super) const WAYS: [&str; 6] = ["towards −x", "towards +x", "towards −y", "towards +y", "down", "up"];

/// For each direction, the distance in metres, and the index of the object; `None` without a surface.
pub(super) type Around = [Option<(f64, usize)>; 6];

/// An object that ends below a place, in one of the first four directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LowerObject {
    /// The horizontal distance.
    pub(super) away_m: f64,
    /// The height of the place above its top.
    pub(super) below_m: f64,
    /// Its index.
    pub(super) object: usize,
}

/// The surfaces of a scene's first snapshot, and its objects.
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
    /// The surfaces of the study's first scene, which is that of the world.
    ///
    /// # Errors
    /// If its files cannot be read any more.
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

    /// The objects in the room.
    pub(super) fn things(&self) -> &[Thing] {
        &self.things
    }

    /// The name index of the next surface along a direction: the room's side if it is one, else the object.
    fn named(&self, way: usize, place: f64, object: usize) -> usize {
        let is_side = self.are_rooms[object] && (place - self.room_m[way % 2][way / 2]).abs() <= SIDE_M;
        if is_side { self.scene.objects.len() + way } else { object }
    }

    /// The surroundings of many places, each measured once.
    pub(super) fn measure_all(&self, places: impl Iterator<Item = DVec3>) -> HashMap<[u64; 3], Around> {
        let all: HashMap<[u64; 3], DVec3> = places.map(|at| (key(at), at)).collect();
        all.into_par_iter().map(|(key, at)| (key, self.measure(at))).collect()
    }

    /// The surroundings of a place.
    pub(super) fn measure(&self, at: DVec3) -> Around {
        let mut around: Around = [None; 6];
        for (index, object) in self.environment() {
            for axis in 0..3 {
                for (way, away_m) in hits(&object.surface, at, axis) {
                    if around[way].is_none_or(|(known, _)| away_m < known) {
                        around[way] = Some((away_m, index));
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

    /// The next object in each of the first four directions that ends below a place and is nearer than its
    /// surroundings: a fence under a sensor that is mounted above it.
    pub(super) fn measure_lower(&self, at: DVec3, around: &Around) -> [Option<LowerObject>; 4] {
        let mut lower: [Option<LowerObject>; 4] = [None; 4];
        for (object, it) in self.environment().filter(|(object, _)| !self.are_rooms[*object]) {
            let Some([low, high]) = heights_m(&it.surface) else { continue };
            if high >= at.z || high - low < HIGH_M {
                continue;
            }
            let below = DVec3 { z: high - BELOW_TOP_M, ..at };
            for (way, away_m) in (0..2).flat_map(|axis| hits(&it.surface, below, axis)) {
                let is_nearer = around[way].is_none_or(|(known, _)| away_m < known);
                if is_nearer && lower[way].is_none_or(|known| away_m < known.away_m) {
                    lower[way] = Some(LowerObject { away_m, below_m: at.z - high, object });
                }
            }
        }
        lower
    }

    /// The measured objects: neither people nor robots.
    fn environment(&self) -> impl Iterator<Item = (usize, &Object)> {
        let objects = self.scene.objects.iter().enumerate().map(|(index, object)| (index, &**object));
        objects.filter(|(_, object)| object.role == Role::Environment && !object.tag_only)
    }
}

/// The surfaces on a line through a place along an axis: direction and distance.
fn hits(surface: &Surface, at: DVec3, axis: usize) -> Vec<(usize, f64)> {
    let mut met = Vec::new();
    let mut hit = |metres: f64| {
        let beyond = metres - at[axis];
        met.push((2 * axis + usize::from(beyond > TOUCHING_M), beyond.abs()));
    };
    match surface {
        Surface::Mesh(mesh) => hit_triangles(mesh, at, axis, &mut hit),
        Surface::Voxels { resolution_m, keys } => {
            hit_voxels(keys, at / *resolution_m, axis, &mut |edges| hit(edges * resolution_m));
        }
    }
    met
}

/// The lowest and the highest place of a surface, in metres.
fn heights_m(surface: &Surface) -> Option<[f64; 2]> {
    let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    match surface {
        Surface::Mesh(mesh) => mesh.vertices.iter().map(|corner| [corner.z, corner.z]).reduce(join),
        Surface::Voxels { resolution_m, keys } => {
            let low = |key: &[i32; 3]| f64::from(key[2]) * resolution_m;
            keys.iter().map(|key| [low(key), low(key) + resolution_m]).reduce(join)
        }
    }
}

/// A place as a hash key.
pub(super) fn key(at: DVec3) -> [u64; 3] {
    at.to_array().map(f64::to_bits)
}

/// The intersections of a line through a place along an axis with triangles, including edges. Triangles that contain
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
        // Twice the signed areas of the triangles between the place and each edge.
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

/// The same for voxels, in edges of a voxel: entry and exit of the line.
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
    use perirobot_scene::objects::{Interior, Optical};

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
            frame: perirobot_scene::pose::Pose::ORIGIN,
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
    fn a_fence_below_a_sensor_is_measured_and_a_pallet_is_not() {
        let mut cell = cell();
        let post = |x: i32, high: i32| Surface::Voxels {
            resolution_m: 0.25,
            keys: (0..high).map(|z| [x, 0, z]).collect(),
        };
        cell.scene.objects.push(object("pallet", Role::Environment, post(3, 2)));
        cell.scene.objects.push(object("fence", Role::Environment, post(5, 6)));
        cell.scene.objects.push(object("arm", Role::Robot, post(2, 6)));
        cell.are_rooms = vec![false; 7];
        let lower = |z: f64| {
            let at = DVec3::new(0.125, 0.125, z);
            cell.measure_lower(at, &cell.measure(at))
        };
        let fence = LowerObject { away_m: 1.125, below_m: 0.5, object: 5 };
        assert_eq!(lower(2.0), [None, Some(fence), None, None]);
        // Level with a fence, the fence itself is the next surface.
        assert_eq!(lower(1.4), [None; 4]);
    }

    #[test]
    fn places_are_measured_once() {
        let places = [DVec3::X, DVec3::X, DVec3::Z];
        let all = cell().measure_all(places.into_iter());
        assert_eq!(all.len(), 2);
        assert_eq!(all[&key(DVec3::Z)], cell().measure(DVec3::Z));
    }
}
