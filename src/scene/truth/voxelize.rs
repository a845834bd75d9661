//! Makes the truth of a scene: which voxels are occupied, which stop rays, and whose they are.

mod odd;

use perirobot_march::lengths::describe_place;
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::objects::{ObjectVoxels, RobotReach, Truth};
use crate::objects::{Interior, Mesh, Object, Optical, RadarOptics, Role, Scene, Surface};
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::voxel::flood::{enclosed_voxels, flood, with_neighbours};
use perirobot_march::voxel::grid::{FARTHEST_VOXEL, Grid, MAX_VOXELS_PER_AXIS, Window};
use perirobot_march::voxel::overlap::{self, Closure, Corner};
use perirobot_march::voxel::{BitGrid, grid};
use perirobot_march::{Error, Result};

/// What is longer, in metres, may be in millimetres if other objects say so, too.
pub const LARGE_M: f64 = 20.0;
/// What is longer, in metres, is in millimetres or no cell.
pub const HUGE_M: f64 = 200.0;

/// An object's surface on the lattice, before any grid.
struct Lattice {
    corners: Vec<Corner>,
    triangles: Vec<[u32; 3]>,
    keys: Vec<[i32; 3]>,
    extent: Window,
}

/// The world keys that the surfaces of all snapshots touch, to size their common grid by. Fails on a surface
/// too far away to count.
pub fn scene_extent(snapshots: &[Scene], voxel_size_m: f64) -> Result<Window> {
    let empty = Window::from_corners([0; 3], [-1; 3]);
    let objects = distinct_objects(snapshots);
    objects.iter().try_fold(empty, |all, object| Ok(all.union(&lattice(object, voxel_size_m)?.extent)))
}

/// Every object once, in the order of its first snapshot.
pub(super) fn distinct_objects(snapshots: &[Scene]) -> Vec<&Arc<Object>> {
    let mut seen = HashSet::new();
    let all = snapshots.iter().flat_map(|scene| &scene.objects);
    all.filter(|object| seen.insert(Arc::as_ptr(object))).collect()
}

/// The grid that holds a box of world keys; refuses one with too many voxels on an axis, with a size that
/// fits where there is one.
pub fn grid_over(extent: &Window, voxel_size_m: f64) -> Result<Grid> {
    grid_unless(extent, voxel_size_m, || None)
}

/// [`grid_over`] all surfaces of these snapshots; the message names objects that make the grid too large.
pub fn grid_over_all(extent: &Window, voxel_size_m: f64, snapshots: &[Scene]) -> Result<Grid> {
    grid_unless(extent, voxel_size_m, || odd::odd_ones_out(snapshots))
}

fn grid_unless(extent: &Window, voxel_size_m: f64, cause: impl Fn() -> Option<String>) -> Result<Grid> {
    let longest = extent.size.into_iter().max().unwrap_or(0);
    if longest > MAX_VOXELS_PER_AXIS {
        let metres = longest as f64 * voxel_size_m;
        // Rounded up to a tenth of a millimetre; two voxels are kept for the layers that both ends may add.
        let fits = (metres / (MAX_VOXELS_PER_AXIS - 2) as f64 * 1e4).ceil() / 1e4;
        // Lengths saturate at the farthest voxel, so from there on no size can be told.
        let far = |key: i32| i64::from(key).abs() >= FARTHEST_VOXEL;
        let told =
            grid::VOXEL_SIZES_M.contains(&fits) && !extent.min.into_iter().chain(extent.end()).any(far);
        let cause = cause();
        let size = if told {
            Words::from(format!("set voxel_size_m = {fits} or more ("))
                + Argument("voxel size")
                + "), or bounds_m"
        } else {
            "set bounds_m".into()
        };
        let before = match cause {
            Some(cause) => format!("{cause} If that is right, "),
            None if told => String::new(),
            None => "is a length in millimetres or centimetres? If not, ".into(),
        };
        let cure = Words::from(before) + size + " around the part that matters";
        let what = format!(
            "{longest} voxels on an axis ({metres:.2} m at voxel_size_m = {voxel_size_m}), \
                    at most {MAX_VOXELS_PER_AXIS}"
        );
        return Err(Issue::too_large(what).with_advice(cure).with_place("grid").into());
    }
    Ok(Grid { voxel_size_m, origin: extent.min, size: extent.size })
}

/// What an object becomes on a grid.
#[derive(Debug)]
pub(super) struct VoxelizedObject {
    pub(super) voxels: Arc<ObjectVoxels>,
    /// The inside that belongs to no region.
    pub(super) ignored: BitGrid,
    /// For a robot, all of its inside.
    pub(super) inside: BitGrid,
    /// How dark it is, from 0 to 3.
    pub(super) shade: u8,
    /// Whether it adds to the truth, rather than only its role.
    pub(super) is_there: bool,
}

pub(super) fn body(object: &Object, grid: &Grid) -> Result<VoxelizedObject> {
    let lattice = lattice(object, grid.voxel_size_m)?;
    let in_grid = lattice.extent.shift(grid.origin.map(|o| -o)).intersection(&grid.window());
    let world = in_grid.shift(grid.origin);
    let mut warnings = object.warnings.clone();
    let nowhere = BitGrid::new(Window::from_corners([0; 3], [-1; 3]));
    let (mut ignored, mut inside) = (nowhere.clone(), nowhere);
    let closure = match &object.surface {
        Surface::Mesh(_) => {
            Some(overlap::closure(lattice.triangles.iter().map(|t| t.map(|i| lattice.corners[i as usize]))))
        }
        Surface::Voxels { .. } => None,
    };
    let watertight = closure.map(|closure| closure == Closure::Closed);
    let mut voxels = surface(&lattice, world);
    // What is inside a robot is the robot's, even of a body that leaks less than a voxel.
    let (is_solid, is_robot) = (watertight.unwrap_or(true), object.role == Role::Robot);
    if (object.interior != Interior::Free && is_solid) || is_robot {
        // The inside is decided over the whole body, so that the grid's cut opens nothing.
        if lattice.extent.size.into_iter().max().unwrap_or(0) <= MAX_VOXELS_PER_AXIS {
            let whole =
                if world == lattice.extent { voxels.clone() } else { surface(&lattice, lattice.extent) };
            let enclosed = enclosed_voxels(&whole).to_window(world);
            match object.interior {
                Interior::Occupied if is_solid => voxels.add(&enclosed),
                Interior::Ignored if is_solid => ignored = to_grid_frame(enclosed.clone(), in_grid),
                _ => {}
            }
            if is_robot {
                inside = to_grid_frame(enclosed, in_grid);
            }
        } else {
            warnings.push(format!(
                "spans more than {MAX_VOXELS_PER_AXIS} voxels: its inside is not looked at, it is kept as a shell"
            ));
        }
    }
    if let Some(why) = closure.and_then(Closure::describe)
        && object.interior == Interior::Occupied
    {
        warnings.push(format!("{why}: it is kept as a shell, not filled"));
    }
    let bounds_m = bounds_m(object);
    warnings.extend(size_warning(object, bounds_m));
    let voxels = ObjectVoxels {
        name: object.name.clone(),
        role: object.role,
        stops_rays: !object.tag_only && object.optical == Optical::Opaque,
        stops_radar: !object.tag_only && object.radar == RadarOptics::Stops,
        triangles: lattice.triangles.len(),
        watertight,
        bounds_m,
        reach: object.linkage.as_ref().map(|robot| RobotReach {
            base_m: robot.base_m,
            radius_m: robot.reach_m,
            world_from_root: robot.links[0].1,
        }),
        voxels: to_grid_frame(voxels, in_grid),
        keypoints: object.keypoints,
        warnings,
    };
    Ok(VoxelizedObject {
        voxels: Arc::new(voxels),
        ignored,
        inside,
        shade: object.shade,
        is_there: !object.tag_only,
    })
}

/// The same words, counted from the grid's corner instead of the world's.
fn to_grid_frame(voxels: BitGrid, window: Window) -> BitGrid {
    BitGrid::from_words(window, voxels.words().to_vec()).unwrap_or_else(|| BitGrid::new(window))
}

fn lattice(object: &Object, voxel_size_m: f64) -> Result<Lattice> {
    let place = || format!("object {:?}", object.name);
    match &object.surface {
        Surface::Mesh(Mesh { vertices, triangles }) => {
            let corners = vertices
                .iter()
                .map(|&vertex| {
                    overlap::corner(vertex, voxel_size_m).ok_or_else(|| {
                        let farthest = FARTHEST_VOXEL as f64 * voxel_size_m;
                        let what = format!(
                            "a corner at {} is more than {farthest:.0} m away: is it in \
                                    millimetres (unit = \"mm\") or centimetres (unit = \"cm\")?",
                            describe_place(vertex)
                        );
                        Error::input(place(), what)
                    })
                })
                .collect::<Result<Vec<_>>>()?;
            // Only corners that a triangle uses count: exporters leave unused ones behind.
            let used = triangles.iter().flatten().map(|&i| &corners[i as usize]);
            let extent = overlap::extent(used);
            Ok(Lattice { extent, corners, triangles: triangles.clone(), keys: Vec::new() })
        }
        Surface::Voxels { resolution_m, keys } => {
            if (resolution_m / voxel_size_m - 1.0).abs() > 1e-6 {
                let what = format!(
                    "the map's voxels are {resolution_m} m and the grid's {voxel_size_m} m: they must be equal \
                     (voxel_size_m = {resolution_m})"
                );
                return Err(Error::input(place(), what));
            }
            let one = |&key: &[i32; 3]| Window::from_corners(key, key);
            let extent =
                keys.iter().map(one).fold(Window::from_corners([0; 3], [-1; 3]), |all, one| all.union(&one));
            Ok(Lattice { corners: Vec::new(), triangles: Vec::new(), keys: keys.clone(), extent })
        }
    }
}

/// The voxels of a surface inside a window of world keys.
fn surface(lattice: &Lattice, window: Window) -> BitGrid {
    let mut voxels = BitGrid::new(window);
    lattice.keys.iter().for_each(|&key| voxels.set(key));
    let words: Vec<AtomicU32> = voxels.words().iter().map(|&word| AtomicU32::new(word)).collect();
    lattice.triangles.par_iter().for_each(|triangle| {
        let triangle = triangle.map(|i| lattice.corners[i as usize]);
        overlap::triangle_voxels(&triangle, &window, |key| {
            if let Some(bit) = voxels.bit_index(key) {
                words[bit >> 5].fetch_or(1 << (bit & 31), Ordering::Relaxed);
            }
        });
    });
    let words = words.into_iter().map(AtomicU32::into_inner).collect();
    BitGrid::from_words(window, words).unwrap_or(voxels)
}

pub(super) fn bounds_m(object: &Object) -> [DVec3; 2] {
    let nowhere = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let grow = |[low, high]: [DVec3; 2], p: DVec3| [low.min(p), high.max(p)];
    match &object.surface {
        Surface::Mesh(mesh) => mesh.bounds().map_or(nowhere, |(low, high)| [low, high]),
        Surface::Voxels { resolution_m, keys } => {
            let corner =
                |key: &[i32; 3], add| DVec3::from_array(key.map(|k| (k + add) as f64 * resolution_m));
            keys.iter().flat_map(|key| [corner(key, 0), corner(key, 1)]).fold(nowhere, grow)
        }
    }
}

/// Asks whether an object that is too long has another unit, with how long it would then be, and what to write.
pub fn unit_question(own_m: f64, takes_unit: bool) -> String {
    let (by_mm, by_cm) = (own_m / 1e3, own_m / 1e2);
    match takes_unit {
        true => format!(
            "is its file in millimetres (unit = \"mm\" beside mesh makes it {by_mm:.2} m) or in centimetres (unit = \"cm\": \
             {by_cm:.2} m)?"
        ),
        false => format!(
            "are its lengths in centimetres (divided by 100: {by_cm:.2} m) or in millimetres (by 1000: {by_mm:.2} m)?"
        ),
    }
}

/// Asks for the unit of an object that is shorter than a voxel.
pub fn speck_question(own_m: f64, voxel_size_m: f64) -> Option<String> {
    (own_m < voxel_size_m).then(|| {
        let mm = own_m * 1e3;
        format!("is {mm:.1} mm long, less than a voxel: is its unit right? Lengths in a scene are metres")
    })
}

/// The classic traps: millimetres for metres, a person lying along y.
fn size_warning(object: &Object, [low, high]: [DVec3; 2]) -> Option<String> {
    let size = high - low;
    if size.max_element() > HUGE_M {
        let own_m = size.max_element();
        return Some(format!("is {own_m:.0} m long: {}", unit_question(own_m, object.takes_unit)));
    }
    if object.role == Role::Human && size.y > 1.3 && size.y > 2.0 * size.z {
        return Some(format!(
            "is {:.2} m along y and {:.2} m high: is its file y-up? (rpy_deg = [90, 0, 0], \
                    or up = \"y\" for an .stl or .obj)",
            size.y, size.z
        ));
    }
    None
}

/// Where a ray may begin: a position (1/65536 voxels from the grid's corner), and how far the sensor's own
/// housing reaches, in voxels.
pub type Begin = ([i64; 3], u32);

/// The voxels that any ray from these positions could pass or end in: free ones joined to a position through
/// faces, and the blockers beside them. Blockers in reach of a housing let rays pass.
pub fn reachable(truth: &Truth, begins: impl IntoIterator<Item = Begin>) -> BitGrid {
    let window = truth.grid.window();
    let mut open = BitGrid::full(window);
    open.remove(&truth.blockers);
    // A sensor's own voxel is never tested, so a ray may leave a blocker.
    let mut by_housing: BTreeMap<u32, BitGrid> = BTreeMap::new();
    for (position, housing) in begins {
        let seeds = by_housing.entry(housing).or_insert_with(|| BitGrid::new(window));
        seeds.set(grid::Grid::voxel_of(position));
    }
    let mut seeds = BitGrid::new(window);
    for (housing, mut around) in by_housing {
        // A ray makes at most √3 crossings a voxel of its way, and three at its ends.
        let crossings = if housing == 0 { 0 } else { 2 * housing + 3 };
        (0..crossings).for_each(|_| around = with_neighbours(&around));
        seeds.add(&around);
    }
    open.add(&seeds);
    with_neighbours(&flood(&open, &seeds))
}

#[cfg(test)]
mod tests;
