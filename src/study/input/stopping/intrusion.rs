//! How far a person reaches in before a sensor notices anything: C of ISO 13855, which depends on the direction of approach.
//!
//! # Theory
//! By public pages, in the edition of 2010 an approach at a right angle to what is watched, which an arm passes unnoticed, has
//! C = 0.85 m. An approach parallel to it, over a pressure-sensitive mat or through the plane of a scanner at a height H above the
//! floor, has C = 1.2 m - 0.4 H, and at least 0.85 m, since a person who steps there reaches farther. It is parallel up to an angle of
//! 30 degrees; the lowest part of a tilted plane is taken to be at the floor. The edition of 2024 has D_DS = 1.2 m
//! instead, whatever H is.

use std::f64::consts::PI;
use std::fmt;

use glam::DVec3;

use crate::sensor::{Approached, RayScale, Sensor, Setting};
use perirobot_march::voxel::rounded_down;

/// What an arm reaches through before its owner is noticed, in metres.
pub(super) const NORMAL_M: f64 = 0.85;
/// The reach of a person who is noticed at floor level, in metres.
pub(super) const PARALLEL_M: f64 = 1.2;
/// What a metre of height takes off.
const BY_HEIGHT: f64 = 0.4;
/// A plane is level up to this angle, and rays lie in it up to that, in radians.
const LEVEL_RAD: f64 = 0.05;
/// People approach along a plane that is tilted by up to this, in radians: 30 degrees.
const PARALLEL_RAD: f64 = PI / 6.0;

/// The direction in which a person approaches what a sensor watches.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ApproachDirection {
    /// At a right angle, as far as is known.
    Normal,
    /// Along a plane at this height above the floor, in metres.
    Parallel(f64),
    /// Along a plane that moves, so that its height is not known; the worst is taken, 0.
    ParallelAnywhere,
}

/// How far a person reaches in before a sensor notices anything.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Intrusion {
    sensor: String,
    approach: ApproachDirection,
}

impl Intrusion {
    /// Of a sensor that may notice people who walk at a height in the world; `None` of one that does not.
    pub(super) fn new(sensor: &Sensor, floor_m: f64) -> Option<Intrusion> {
        let approach = match sensor.kind.approached()? {
            Approached::AtRightAngle => ApproachDirection::Normal,
            Approached::OnFloor => ApproachDirection::Parallel(0.0),
            Approached::AlongRays if sensor.on.is_some() => {
                normal(sensor).map_or(ApproachDirection::Normal, |_| ApproachDirection::ParallelAnywhere)
            }
            Approached::AlongRays => {
                plane_m(sensor, floor_m).map_or(ApproachDirection::Normal, ApproachDirection::Parallel)
            }
        };
        Some(Intrusion { sensor: sensor.name.clone(), approach })
    }

    /// In metres, of the edition of 2010.
    pub(super) fn metres(&self) -> f64 {
        match self.approach {
            ApproachDirection::Normal => NORMAL_M,
            ApproachDirection::ParallelAnywhere => PARALLEL_M,
            ApproachDirection::Parallel(height_m) => (PARALLEL_M - BY_HEIGHT * height_m).max(NORMAL_M),
        }
    }

    /// Whether a person approaches along what it watches.
    pub(super) fn is_parallel(&self) -> bool {
        self.approach != ApproachDirection::Normal
    }
}

impl fmt::Display for Intrusion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.approach {
            ApproachDirection::Normal => {
                write!(f, "{:?}, which an arm passes unnoticed (approach at a right angle)", self.sensor)
            }
            ApproachDirection::ParallelAnywhere => write!(
                f,
                "{:?}, which is approached along its plane, at a height that is not known since it moves (0 is taken)",
                self.sensor
            ),
            ApproachDirection::Parallel(height_m) => write!(
                f,
                "{:?}, which is approached along its plane {} m above the floor",
                self.sensor,
                rounded_down(height_m, 2)
            ),
        }
    }
}

/// The height of the lowest plane that a scanner watches, in metres above the floor; 0 of one that is tilted, which may begin
/// there. `None` of a scanner that watches no plane, or only steep ones.
fn plane_m(sensor: &Sensor, floor_m: f64) -> Option<f64> {
    let normal = normal(sensor)?;
    let heights = sensor.candidates.iter().filter_map(|candidate| {
        let Setting::Pose(pose) = &candidate.setting else { return None };
        let cosine = (sensor.kind.frame(pose) * normal).z.abs();
        let is_level = cosine >= libm::cos(LEVEL_RAD);
        let height_m = if is_level { (pose.position_m.z - floor_m).max(0.0) } else { 0.0 };
        (cosine >= libm::cos(PARALLEL_RAD)).then_some(height_m)
    });
    heights.reduce(f64::min)
}

/// The normal of the plane in which all rays of a sensor lie, in the frame of its rays.
fn normal(sensor: &Sensor) -> Option<DVec3> {
    let rays = sensor.kind.rays(&RayScale::new(1.0, false))?;
    let unit = |q15: &[i32; 3]| DVec3::from_array(q15.map(f64::from)).normalize_or_zero();
    let first = unit(rays.dirs_q15.first()?);
    let across = rays.dirs_q15.iter().map(|ray| first.cross(unit(ray)));
    let normal = across.max_by(|a, b| a.length().total_cmp(&b.length()))?.try_normalize()?;
    let is_flat = rays.dirs_q15.iter().all(|ray| unit(ray).dot(normal).abs() <= libm::sin(LEVEL_RAD));
    is_flat.then_some(normal)
}
