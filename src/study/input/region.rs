//! Regions of a study, checked: shapes in metres, meshes to be read later, and the regions that others are
//! made of.

use std::path::Path;

use glam::{DQuat, DVec3};

use super::Stopping;
use super::approach::Machine;
use super::region_file::{HumanBoxFile, RegionFile, SafetyPlaneFile, SeparationFile, SweptFile};
use super::scene_file::{mesh, unit_and_up_belong};
use super::stopping::EXAMPLE;
use crate::diagnostics::{Place, only_one};
use perirobot_march::Result;
use perirobot_scene::objects::Role;
use perirobot_scene::objects::mesh_file::MeshFile;
use perirobot_scene::objects::urdf::AxisLimits;
use perirobot_scene::pose::{Pose, RotationFrame, from_rpy};
use perirobot_scene::truth::{RegionShape, SafetyPlane};

/// What a region of a study is, before meshes are read.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionSpec {
    /// A shape that is known as it stands.
    RegionShape(RegionShape),
    /// The inside of a mesh in a file.
    Mesh {
        /// The file.
        file: MeshFile,
        /// Where the mesh's own frame is in the world.
        position_m: DVec3,
        /// How it is turned.
        rotation: DQuat,
    },
    /// What a robot reaches within the limits of its joints, which is known once its files are read.
    JointLimits {
        /// The robot, its tool and its planes.
        shape: RegionShape,
        /// Which limits are narrower than the robot's own.
        limits: AxisLimits,
    },
    /// All that is nearer to the robot than people may be at a speed.
    Separation {
        /// From where the distance counts.
        shape: RegionShape,
        /// The name that it shares with those of other speeds.
        family: String,
        /// The number of the speed in [`Stopping::speeds`].
        speed: usize,
    },
    /// The union of these regions, by their index in the study; all come before this one.
    Union(Vec<usize>),
    /// The first of these regions without the others, by their index; all come before this one.
    Difference(Vec<usize>),
}

impl RegionSpec {
    /// The reach of a robot, as a sphere or within the limits of its joints.
    pub(crate) fn robot_reach(&self) -> Option<&RegionShape> {
        match self {
            RegionSpec::RegionShape(shape) | RegionSpec::JointLimits { shape, .. } => {
                matches!(shape, RegionShape::RobotReach { .. }).then_some(shape)
            }
            _ => None,
        }
    }
}

/// Which region a key names.
pub(super) fn index(at: &Place, name: &str, regions: &[(String, RegionSpec)]) -> Result<usize> {
    regions.iter().position(|(known, _)| known == name).ok_or_else(|| {
        let known: Vec<&str> = regions.iter().map(|(name, _)| name.as_str()).collect();
        at.unknown_name("region", name, "a region of the study", &known)
    })
}

/// Checks an entry, which may be a region for each speed; `known` are the names of the regions before it.
pub(super) fn check(
    at: &Place,
    entry: RegionFile,
    known: &[String],
    stopping: Option<&Stopping>,
) -> Result<Vec<(String, RegionSpec)>> {
    let at = &at.key(&format!("region {:?}", entry.name));
    let rule = "a length above 0 and below 1000000";
    let sphere = entry.sphere.as_ref().map(|s| {
        let at = at.key("sphere");
        let radius_m = at.number("radius_m", s.radius_m, f64::MIN_POSITIVE..1e6, rule)?;
        Ok(RegionShape::Sphere { center_m: at.vector("center_m", s.center_m)?, radius_m })
    });
    let half = entry.half_sphere.as_ref().map(|s| {
        let at = at.key("half_sphere");
        let radius_m = at.number("radius_m", s.radius_m, f64::MIN_POSITIVE..1e6, rule)?;
        let normal = normal(&at, s.normal)?;
        Ok(RegionShape::HalfSphere { center_m: at.vector("center_m", s.center_m)?, radius_m, normal })
    });
    let cuboid = entry
        .r#box
        .as_ref()
        .map(|b| b.corners(&at.key("box")).map(|[min_m, max_m]| RegionShape::Box { min_m, max_m }));
    let human = entry.human_box.as_ref().map(|h| human_box(&at.key("human_box"), h));
    let reach = entry.robot_reach.as_ref().map(|r| {
        let rule = "a length in metres from 0 to 1000";
        let at = at.key("robot_reach");
        let tool_m = at.number("tool_m", r.tool_m, 0.0..=1e3, rule)?;
        let plane = |(number, plane): (usize, &SafetyPlaneFile)| {
            let at = at.key(&format!("planes[{number}]"));
            let normal = normal(&at, plane.normal)?;
            Ok(SafetyPlane { point_m: at.vector("point_m", plane.point_m)?, normal })
        };
        let planes = r.planes.iter().enumerate().map(plane).collect::<Result<_>>()?;
        let shape = RegionShape::RobotReach { object: r.object.clone(), tool_m, within_limits: None, planes };
        let limits = AxisLimits { limits_deg: r.limits_deg.clone(), limits_m: r.limits_m.clone() };
        match r.joint_limits {
            true => Ok(RegionSpec::JointLimits { shape, limits }),
            false if limits == AxisLimits::default() => Ok(RegionSpec::RegionShape(shape)),
            false => {
                let what = "limits_deg and limits_m belong to a region within the limits of joints";
                Err(at.says(what).with_advice("add joint_limits = true"))
            }
        }
    });
    let separation =
        entry.separation.as_ref().map(|file| separation(&at.key("separation"), file, &entry.name, stopping));
    let swept = entry.swept.map(|what| match what {
        SweptFile::Robot => Ok(RegionShape::Swept { role: Role::Robot }),
        SweptFile::Human => Ok(RegionShape::Swept { role: Role::Human }),
    });
    let one = |spec: RegionSpec| vec![(entry.name.clone(), spec)];
    let shape =
        |shape: Option<Result<RegionShape>>| shape.map(|shape| shape.map(RegionSpec::RegionShape).map(one));
    let parts =
        |key: &str, names: &Option<Vec<String>>| names.as_ref().map(|names| earlier(at, key, names, known));
    let choices = vec![
        ("sphere", shape(sphere)),
        ("half_sphere", shape(half)),
        ("box", shape(cuboid)),
        ("human_box", shape(human)),
        ("robot_reach", reach.map(|spec| spec.map(one))),
        ("separation", separation),
        ("swept", shape(swept)),
        ("mesh", entry.mesh.as_ref().map(|path| volume(at, path, &entry).map(one))),
        ("union", parts("union", &entry.union).map(|parts| Ok(one(RegionSpec::Union(parts?))))),
        (
            "difference",
            parts("difference", &entry.difference).map(|parts| Ok(one(RegionSpec::Difference(parts?)))),
        ),
    ];
    let specs = only_one(at, "shape", choices)??;
    let file = match specs.as_slice() {
        [(_, RegionSpec::Mesh { file, .. })] => Some(file),
        _ => None,
    };
    unit_and_up_belong(at, file, entry.unit, entry.up)?;
    if entry.mesh.is_none() && (entry.position_m.is_some() || entry.rpy_deg.is_some()) {
        return Err(at
            .says("position_m and rpy_deg belong to a mesh")
            .with_advice("other shapes are given in the world"));
    }
    Ok(specs)
}

/// A direction.
fn normal(at: &Place, written: [f64; 3]) -> Result<DVec3> {
    let normal = at.vector("normal", written)?;
    match normal.length() < 1e-9 {
        true => Err(at.wrong("normal", format!("{written:?}"), "must not be zero")),
        false => Ok(normal),
    }
}

/// The region of a speed, or that of each.
fn separation(
    at: &Place,
    file: &SeparationFile,
    name: &str,
    stopping: Option<&Stopping>,
) -> Result<Vec<(String, RegionSpec)>> {
    let Some(stopping) = stopping else {
        let what = at.says("needs to know how the robot stops");
        return Err(what.with_advice(format!("add a table to the study, as in {EXAMPLE}")));
    };
    let swept = file.from == Machine::RobotSwept;
    let of_speed = |name: String, speed: usize| {
        let shape = RegionShape::Separation { swept, distance_m: stopping.speeds[speed].needed_m };
        (name.clone(), RegionSpec::Separation { shape, family: name, speed })
    };
    let Some(wanted) = file.speed_m_s else {
        let each = stopping.speeds.iter().enumerate().map(|(number, at)| {
            let (own, spec) = of_speed(name.into(), number);
            (format!("{own}@{}", at.speed_m_s), spec)
        });
        return Ok(each.collect());
    };
    let found = stopping.speeds.iter().position(|at| at.speed_m_s == wanted).ok_or_else(|| {
        let known: Vec<f64> = stopping.speeds.iter().map(|at| at.speed_m_s).collect();
        at.wrong("speed_m_s", wanted, &format!("must be one of robot_speeds_m_s of [stopping]: {known:?}"))
    })?;
    Ok(vec![of_speed(name.into(), found)])
}

fn volume(at: &Place, path: &Path, entry: &RegionFile) -> Result<RegionSpec> {
    let folder = at.folder();
    let rpy = at.vector("rpy_deg", entry.rpy_deg.unwrap_or_default())?.to_array().map(f64::to_radians);
    Ok(RegionSpec::Mesh {
        file: mesh(at, folder, path, entry.unit, entry.up)?,
        position_m: at.vector("position_m", entry.position_m.unwrap_or_default())?,
        rotation: Pose::from_rotation(DVec3::ZERO, from_rpy(rpy), RotationFrame::Link).rotation,
    })
}

/// The indices of regions that must stand above this one.
fn earlier(at: &Place, key: &str, names: &[String], known: &[String]) -> Result<Vec<usize>> {
    if names.len() < 2 {
        return Err(at.wrong(key, format!("{names:?}"), "must name two regions or more"));
    }
    let index = |(i, name): (usize, &String)| {
        known.iter().position(|other| other == name).ok_or_else(|| {
            let rule = format!("must be a region that stands above this one in the file: {known:?}");
            at.wrong(&format!("{key}[{i}]"), format!("{name:?}"), &rule)
        })
    };
    names.iter().enumerate().map(index).collect()
}

fn human_box(at: &Place, entry: &HumanBoxFile) -> Result<RegionShape> {
    if entry.margin_m.is_some() && (entry.margin_min_m.is_some() || entry.margin_max_m.is_some()) {
        return Err(at
            .says("margin_m is for all sides")
            .with_advice("give either it or margin_min_m and margin_max_m"));
    }
    let all = at.number(
        "margin_m",
        entry.margin_m.unwrap_or(0.0),
        -1e3..=1e3,
        "a length in metres from -1000 to 1000",
    )?;
    let side = |key, value: Option<[f64; 3]>| match value {
        Some(value) => at.vector(key, value),
        None => Ok(DVec3::splat(all)),
    };
    Ok(RegionShape::HumanBox {
        margin_min_m: side("margin_min_m", entry.margin_min_m)?,
        margin_max_m: side("margin_max_m", entry.margin_max_m)?,
        object: entry.object.clone(),
    })
}
