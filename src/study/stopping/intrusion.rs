//! How far a person reaches in before a sensor notices anything: C of ISO 13855, which depends on the direction of approach.
//!
//! # Theory
//! By public pages, in the edition of 2010 an approach at a right angle to what is watched, which an arm passes unnoticed, has
//! C = 0.85 m. An approach parallel to it, over a pressure-sensitive mat or through the plane of a level scanner at a height H above the
//! floor, has C = 1.2 m - 0.4 H, and at least 0.85 m, since a person who steps there reaches farther. The edition of 2024 has D_DS = 1.2 m
//! instead, whatever H is.

use std::fmt;

use glam::DVec3;

use crate::sensor::{FieldOfView, Sensor, Setting};

/// What an arm reaches through before its owner is noticed, in metres.
pub(super) const NORMAL_M: f64 = 0.85;
/// The reach of a person who is noticed at floor level, in metres.
pub(super) const PARALLEL_M: f64 = 1.2;
/// What a metre of height takes off.
const BY_HEIGHT: f64 = 0.4;
/// The plane of a scanner is level if it rises by less than this, in radians, and its axis is that near to the vertical.
const LEVEL_RAD: f64 = 0.05;

/// The direction in which a person approaches what a sensor watches.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Approach {
    /// At a right angle, as far as is known.
    Normal,
    /// Along a plane at this height above the floor, in metres.
    Parallel(f64),
}

/// How far a person reaches in before a sensor notices anything.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Intrusion {
    sensor: String,
    approach: Approach,
}

impl Intrusion {
    /// Of a sensor that may notice people who walk at a height in the world; `None` of one that does not.
    pub(super) fn of(sensor: &Sensor, floor_m: f64) -> Option<Intrusion> {
        let approach = match sensor.kind.name() {
            "known_robot" | "recorded" => return None,
            "pad" => Approach::Parallel(0.0),
            "lidar" => level_m(sensor, floor_m).map_or(Approach::Normal, Approach::Parallel),
            _ => Approach::Normal,
        };
        Some(Intrusion { sensor: sensor.name.clone(), approach })
    }

    /// In metres, of the edition of 2010.
    pub(super) fn metres(&self) -> f64 {
        match self.approach {
            Approach::Normal => NORMAL_M,
            Approach::Parallel(height_m) => (PARALLEL_M - BY_HEIGHT * height_m).max(NORMAL_M),
        }
    }

    /// Whether a person approaches along what it watches.
    pub(super) fn is_parallel(&self) -> bool {
        self.approach != Approach::Normal
    }
}

impl fmt::Display for Intrusion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.approach {
            Approach::Normal => {
                write!(f, "{:?}, which an arm passes unnoticed (approach at a right angle)", self.sensor)
            }
            Approach::Parallel(height_m) => write!(
                f,
                "{:?}, which is approached along its plane {height_m:.2} m above the floor (1.2 m - 0.4 H, at least 0.85 m)",
                self.sensor
            ),
        }
    }
}

/// The height of the lowest level plane that a scanner watches, in metres above the floor; 0 on a robot, where it is unknown.
/// `None` where it watches no level plane.
fn level_m(sensor: &Sensor, floor_m: f64) -> Option<f64> {
    let FieldOfView::Turn { elevation_rad: [low, high], .. } = sensor.kind.field_of_view() else {
        return None;
    };
    if low.abs().max(high.abs()) > LEVEL_RAD {
        return None;
    }
    if sensor.on.is_some() {
        return Some(0.0);
    }
    let heights = sensor.candidates.iter().filter_map(|candidate| match &candidate.setting {
        Setting::Pose(pose) if (sensor.kind.frame(pose) * DVec3::Z).z.abs() > libm::cos(LEVEL_RAD) => {
            Some((pose.position_m.z - floor_m).max(0.0))
        }
        _ => None,
    });
    heights.reduce(f64::min)
}
