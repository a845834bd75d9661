//! Regions of interest: sets of voxels, those whose centre lies inside, decided in integers.
//!
//! | shape | in a study | voxels |
//! |---|---|---|
//! | [`RegionShape::Sphere`] | `sphere = { center_m, radius_m }` | centres strictly within the radius |
//! | [`RegionShape::HalfSphere`] | `half_sphere = { center_m, radius_m, normal = [0, 0, 1] }` | those of the sphere on the normal's side of the plane through its centre, or on that plane |
//! | [`RegionShape::Box`] | `box = { min_m, max_m }` | centres in the half-open box |
//! | [`RegionShape::HumanBox`] | `human_box = { object, margin_m }` | the bounding box of a human's voxels and a margin |
//! | [`RegionShape::RobotReach`] | `robot_reach = { object, tool_m }` | a sphere around a robot's base, as large as its reach and a tool; or, with `joint_limits = true`, what its links reach within the limits of its joints |
//! | [`RegionShape::Separation`] | `separation = { from, speed_m_s }` | those nearer to a voxel of the robot, or of all that it fills at some moment, than people must be by `[stopping]`, between centres |
//! | [`RegionShape::Swept`] | `swept = "robot"` or `"human"` | those that the robot or the people fill at some moment |
//! | [`RegionShape::Mesh`] | `mesh = "zone.stl"` (`unit`, `up`, `position_m`, `rpy_deg`) | centres inside a watertight mesh |
//! | [`RegionShape::Union`] | `union = ["a", "b"]` | those of any of the regions above it in the file |
//! | [`RegionShape::Difference`] | `difference = ["a", "b"]` | those of the first and of none of the others |

mod mesh;
mod near;
mod reached;
mod rows;

use perirobot_march::lengths::describe_length;
use std::sync::Arc;

use super::objects::{ObjectVoxels, RobotReach, Truth};
use crate::objects::{Mesh, Role};
use glam::DVec3;
use mesh::MeshRows;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;
use perirobot_march::voxel::grid::{Grid, MAX_VOXELS_PER_AXIS, ONE_Q16, Window, length_q16, point_q16};
use perirobot_march::voxel::solid::{self, Ball, MAX_RADIUS_Q16};
use perirobot_march::{Error, Result};
pub use reached::ReachedVoxels;
use rows::{CutPlane, RowShape};

/// A plane behind which a robot does not get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyPlane {
    /// A point of it, in the world.
    pub point_m: DVec3,
    /// To the side on which the robot stays; any length but zero.
    pub normal: DVec3,
}

/// What a region is, in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionShape {
    /// Centres strictly within a radius.
    Sphere {
        /// Middle of the sphere, in the world.
        center_m: DVec3,
        /// Radius.
        radius_m: f64,
    },
    /// Centres strictly within a radius, on one side of a plane through the middle.
    HalfSphere {
        /// Middle of the sphere, in the world.
        center_m: DVec3,
        /// Radius.
        radius_m: f64,
        /// Points to the side that is kept; of any length but zero.
        normal: DVec3,
    },
    /// Centres in a half-open box.
    Box {
        /// Lowest corner, included.
        min_m: DVec3,
        /// Highest corner, excluded.
        max_m: DVec3,
    },
    /// The bounding box of a human's voxels, grown on each side.
    HumanBox {
        /// Name of the object, or `None` for all humans of the scene together.
        object: Option<String>,
        /// How far it grows below, on each axis.
        margin_min_m: DVec3,
        /// How far it grows above, on each axis.
        margin_max_m: DVec3,
    },
    /// A sphere around a robot's base, or what its links reach.
    RobotReach {
        /// Name of the object, or `None` for the one robot whose reach is known.
        object: Option<String>,
        /// What the robot holds beyond its own reach.
        tool_m: f64,
        /// What its links and the tool reach within the limits of its joints; `None` for the sphere.
        within_limits: Option<Arc<ReachedVoxels>>,
        /// The planes that its safety controller keeps it from passing.
        planes: Vec<SafetyPlane>,
    },
    /// All that is no farther from the robot than a distance, between centres of voxels.
    Separation {
        /// Whether from all that it fills at some moment, rather than from where it is.
        swept: bool,
        /// The distance.
        distance_m: f64,
    },
    /// All that is of the robot, with the inside of its bodies, or of people at some moment.
    Swept {
        /// Of whom.
        role: Role,
    },
    /// Centres inside a watertight mesh, in world metres. Where several of its bodies overlap is inside; a
    /// body in a body that faces the other way is a hollow.
    Mesh(Arc<Mesh>),
    /// What is in any of several shapes.
    Union(Vec<RegionShape>),
    /// What is in the first of several shapes and in none of the others.
    Difference(Vec<RegionShape>),
}

/// A region of a scene, in voxels.
#[derive(Clone, Debug)]
pub struct Region {
    /// Its name in the study.
    pub name: String,
    /// Its voxels, over the smallest window that holds them.
    pub voxels: Arc<BitGrid>,
    /// The share of the shape's voxels that lie outside the grid, 0 to 1; a union or difference counts as one
    /// shape.
    pub cut_share: f64,
    /// Whether the shape goes beyond the low and the high end of the grid, on each axis.
    pub cut_at: [[bool; 2]; 3],
}

/// Gives what the objects of a role fill at some moment of the scene.
pub type SweptBy<'a> = &'a dyn Fn(Role) -> Arc<BitGrid>;

/// The voxels of a shape in a scene. Ignored insides belong to no region; a region left without voxels is an
/// error.
pub fn region(name: &str, shape: &RegionShape, truth: &Truth, swept_by: SweptBy) -> Result<Region> {
    let wrong = |issue: Issue| Error::from(issue.with_place(format!("region {name:?}")));
    let rows = rows_of(shape, truth, swept_by).map_err(wrong)?;
    let mut voxels = BitGrid::new(truth.grid.window());
    let (mut total, mut cut_at) = (0u64, [[false; 2]; 3]);
    let [ys, zs] = rows.span();
    for z in zs {
        for y in ys.clone() {
            for run in rows.runs(y, z) {
                total += (run.end - run.start) as u64;
                for (axis, voxels) in [run.clone(), y..y + 1, z..z + 1].into_iter().enumerate() {
                    cut_at[axis][0] |= voxels.start < 0;
                    cut_at[axis][1] |= voxels.end > i64::from(truth.grid.size[axis]);
                }
                solid::mark(&mut voxels, &run, y, z);
            }
        }
    }
    let inside = voxels.count();
    if inside == 0 {
        return Err(wrong(nothing_in(shape, total)));
    }
    voxels.remove(&truth.ignored);
    if voxels.is_empty() {
        let what = Issue::says("all its voxels are inside a body whose interior is ignored");
        return Err(wrong(what.cure("if that body is the room itself, give it interior = \"free\"")));
    }
    Ok(Region {
        name: name.into(),
        voxels: Arc::new(voxels.trim()),
        cut_share: (total - inside) as f64 / total as f64,
        cut_at,
    })
}

fn nothing_in(shape: &RegionShape, total: u64) -> Issue {
    match shape {
        _ if total > 0 => Issue::says("lies outside the grid").cure("make it larger or move it"),
        RegionShape::Difference(..) => Issue::says("the others leave nothing of the first")
            .cure("make one of them smaller")
            .with_place("difference"),
        RegionShape::Swept { role } => {
            let role = if *role == Role::Robot { "robot" } else { "human" };
            Issue::says(format!("no object of the scene with role = {role:?} is in the grid"))
                .cure("leave the region out, or widen bounds_m")
        }
        _ => Issue::says("holds no voxel's centre").cure("make it larger or move it"),
    }
}

/// A shape in integers.
fn rows_of(shape: &RegionShape, truth: &Truth, swept_by: SweptBy) -> Result<RowShape, Issue> {
    let grid = &truth.grid;
    let all = |shapes: &[RegionShape]| {
        shapes.iter().map(|shape| rows_of(shape, truth, swept_by)).collect::<Result<_, Issue>>()
    };
    Ok(match shape {
        RegionShape::Sphere { center_m, radius_m } => RowShape::Ball(ball(*center_m, *radius_m, truth)?),
        RegionShape::HalfSphere { center_m, radius_m, normal } => RowShape::Cut {
            part: Box::new(RowShape::Ball(ball(*center_m, *radius_m, truth)?)),
            planes: vec![cut_plane(&SafetyPlane { point_m: *center_m, normal: *normal }, grid)],
        },
        RegionShape::Box { min_m, max_m } => cuboid(grid.position_q16(*min_m), grid.position_q16(*max_m))?,
        RegionShape::HumanBox { object, margin_min_m, margin_max_m } => {
            let bounds = human_bounds(object.as_deref(), truth)?;
            let margin = |m: &DVec3| point_q16(*m, grid.voxel_size_m);
            let (below, above) = (margin(margin_min_m), margin(margin_max_m));
            cuboid(
                std::array::from_fn(|r| bounds.min[r] as i64 * ONE_Q16 - below[r]),
                std::array::from_fn(|r| bounds.end()[r] as i64 * ONE_Q16 + above[r]),
            )?
        }
        RegionShape::RobotReach { object, tool_m, within_limits, planes } => {
            let RobotReach { base_m, radius_m, world_from_root } = reach(object.as_deref(), truth)?;
            let part = match within_limits {
                None => RowShape::Ball(ball(base_m, radius_m + tool_m, truth)?),
                Some(reached) => RowShape::Voxels(BitGrid::clone(&*reached.voxels(&world_from_root, grid)?)),
            };
            RowShape::Cut {
                part: Box::new(part),
                planes: planes.iter().map(|plane| cut_plane(plane, grid)).collect(),
            }
        }
        RegionShape::Separation { swept: true, distance_m } => {
            RowShape::Voxels(near::expand(&swept_by(Role::Robot), *distance_m, grid)?)
        }
        RegionShape::Separation { swept: false, distance_m } => {
            RowShape::Voxels(near::expand(&truth.robot_volume, *distance_m, grid)?)
        }
        RegionShape::Swept { role } => RowShape::Voxels(BitGrid::clone(&swept_by(*role))),
        RegionShape::Mesh(mesh) => {
            let rows = MeshRows::new(mesh, grid.voxel_size_m, grid.origin);
            RowShape::Mesh(rows.map_err(|what| what.with_place("mesh"))?)
        }
        RegionShape::Union(shapes) => RowShape::Union(all(shapes)?),
        RegionShape::Difference(shapes) => RowShape::Difference(all(shapes)?),
    })
}

fn cut_plane(plane: &SafetyPlane, grid: &Grid) -> CutPlane {
    CutPlane {
        point_q16: grid.position_q16(plane.point_m),
        normal_q15: plane.normal.normalize().to_array().map(|n| (n * 32_768.0).round() as i64),
    }
}

fn ball(center_m: DVec3, radius_m: f64, truth: &Truth) -> Result<Ball, Issue> {
    let voxel_size_m = truth.grid.voxel_size_m;
    let radius_q16 = length_q16(radius_m, voxel_size_m);
    if radius_q16 > MAX_RADIUS_Q16 {
        return Err(Issue::value(
            "radius_m",
            radius_m,
            format!("at most 2047 voxels ({})", describe_length(2047.0 * voxel_size_m)),
        ));
    }
    Ok(Ball::new(truth.grid.position_q16(center_m), radius_q16))
}

fn cuboid(low_q16: [i64; 3], high_q16: [i64; 3]) -> Result<RowShape, Issue> {
    let voxels = solid::box_voxels(low_q16, high_q16);
    let longest = 4 * MAX_VOXELS_PER_AXIS;
    if voxels.iter().any(|side| side.end - side.start > longest as i64) {
        return Err(Issue::says(format!(
            "is over {longest} voxels long; is it in millimetres or centimetres?"
        )));
    }
    Ok(RowShape::Box(voxels))
}

/// The scene's objects of a role: the one of a name, or all.
fn find_objects<'t>(
    key: &str,
    wanted: Option<&str>,
    truth: &'t Truth,
    role: Role,
    plural: &str,
) -> Result<Vec<&'t ObjectVoxels>, Issue> {
    let all: Vec<_> =
        truth.objects.iter().map(|object| &**object).filter(|object| object.role == role).collect();
    let Some(wanted) = wanted else { return Ok(all) };
    let found: Vec<_> = all.iter().copied().filter(|object| object.name == wanted).collect();
    if found.is_empty() {
        let known: Vec<_> = all.iter().map(|object| object.name.as_str()).collect();
        return Err(Issue::value(
            format!("{key}.object"),
            format!("{wanted:?}"),
            format!("the scene's {plural} are {known:?}"),
        ));
    }
    Ok(found)
}

fn human_bounds(object: Option<&str>, truth: &Truth) -> Result<Window, Issue> {
    let humans = find_objects("human_box", object, truth, Role::Human, "humans")?;
    let bounds = match object {
        None => truth.human.bounds(),
        Some(_) => {
            humans.iter().map(|human| human.voxels.bounds()).fold(nowhere(), |all, one| all.union(&one))
        }
    };
    if bounds.is_empty() {
        return Err(Issue::says("human_box").with_advice(
            "no voxel of a human lies in the grid: widen bounds_m, or write the region as a box",
        ));
    }
    Ok(bounds)
}

fn reach(object: Option<&str>, truth: &Truth) -> Result<RobotReach, Issue> {
    let robots = find_objects("robot_reach", object, truth, Role::Robot, "robots")?;
    let known: Vec<_> = robots.iter().filter_map(|robot| Some((robot.name.as_str(), robot.reach?))).collect();
    match (known[..].first(), known.len()) {
        (Some((_, reach)), 1) => Ok(*reach),
        (None, _) => {
            let whose = object.map_or("robot_reach".into(), |name| format!("robot_reach.object = {name:?}"));
            Err(Issue::says(whose).with_advice(
                "no robot has a known reach: give the robot as a urdf, or write the region as a sphere",
            ))
        }
        _ => {
            let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
            Err(Issue::says("robot_reach").with_advice(format!(
                "{names:?} all have a reach: say which one with object = {:?}",
                names[0]
            )))
        }
    }
}

fn nowhere() -> Window {
    Window::from_corners([0; 3], [-1; 3])
}

/// The window that holds all regions.
pub fn window_of(regions: &[Region]) -> Window {
    regions.iter().map(|region| region.voxels.window()).fold(nowhere(), |all, one| all.union(&one))
}

#[cfg(test)]
mod tests;
