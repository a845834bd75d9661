//! A walk along a path: places one step apart, the way that it faces at each, and how long it is there.

use glam::{DQuat, DVec3};

use super::{MAX_SNAPSHOTS, Triple, WalkFile};
use crate::diagnostics::Place;
use perirobot_march::Result;

/// How fast a person walks, in metres a second (ISO 13855).
const WALKING_M_S: f64 = 1.6;
/// A corner nearer than this to the end of a step is there.
const NEARLY_M: f64 = 1e-9;

/// Where somebody is at each moment of a walk.
pub(super) struct Walk {
    pub(super) position_m: Vec<DVec3>,
    /// Turns of +x, about the vertical.
    pub(super) heading: Vec<DQuat>,
    /// How long: half of the way there and half of the way on.
    pub(super) dwell_s: Vec<f64>,
    pub(super) speed_m_s: f64,
}

/// Places along a path, both ends included.
pub(super) fn moments(at: &Place, file: &WalkFile) -> Result<Walk> {
    let corners: Vec<DVec3> = (file.path_m.iter().enumerate())
        .map(|(number, Triple(corner))| at.vector(&format!("path_m[{number}]"), *corner))
        .collect::<Result<_>>()?;
    let step_m = at.number("step_m", file.step_m, 0.001..=1e3, "a length in metres from 0.001 to 1000")?;
    let speed_m_s = file.speed_m_s.unwrap_or(WALKING_M_S);
    at.number("speed_m_s", speed_m_s, 0.01..=100.0, "a speed in metres a second from 0.01 to 100")?;
    let legs = || corners.windows(2).map(|leg| (leg[0], leg[1] - leg[0]));
    if let Some(number) = legs().position(|(_, way)| way.length() < NEARLY_M) {
        let again = corners[number].to_array();
        return Err(at.wrong(
            &format!("path_m[{}]", number + 1),
            format!("{again:?}"),
            "must differ from the corner before it",
        ));
    }
    let whole_m: f64 = legs().map(|(_, way)| way.length()).sum();
    if corners.len() < 2 {
        return Err(at
            .says("path_m has fewer than two corners")
            .with_advice("give where it begins and where it ends"));
    }
    if whole_m / step_m > (MAX_SNAPSHOTS - 2) as f64 {
        let least = whole_m / (MAX_SNAPSHOTS - 2) as f64;
        return Err(at.wrong(
            "step_m",
            step_m,
            &format!("makes more than {MAX_SNAPSHOTS} moments; {least:.3} m or more does not"),
        ));
    }
    let full_steps = ((whole_m + NEARLY_M) / step_m).floor() as usize;
    let mut along_m: Vec<f64> = (0..=full_steps).map(|step| step as f64 * step_m).collect();
    if whole_m - full_steps as f64 * step_m > NEARLY_M {
        along_m.push(whole_m);
    }
    let mut walk = Walk { position_m: Vec::new(), heading: Vec::new(), dwell_s: Vec::new(), speed_m_s };
    let mut yaw = 0.0;
    for (number, &place_m) in along_m.iter().enumerate() {
        let mut behind_m = 0.0;
        let mut legs = legs().peekable();
        while let Some((from, way)) = legs.next() {
            let length_m = way.length();
            if place_m <= behind_m + length_m + NEARLY_M || legs.peek().is_none() {
                // Who only rises or sinks faces as before.
                if way.truncate().length() > NEARLY_M {
                    yaw = libm::atan2(way.y, way.x);
                }
                walk.position_m.push(from + way * ((place_m - behind_m) / length_m).min(1.0));
                break;
            }
            behind_m += length_m;
        }
        let (sin, cos) = libm::sincos(yaw / 2.0);
        walk.heading.push(DQuat::from_xyzw(0.0, 0.0, sin, cos));
        let before_m = number.checked_sub(1).map_or(0.0, |before| place_m - along_m[before]);
        let after_m = along_m.get(number + 1).map_or(0.0, |after| after - place_m);
        walk.dwell_s.push((before_m + after_m) / 2.0 / speed_m_s);
    }
    Ok(walk)
}

#[cfg(test)]
#[path = "walk_tests.rs"]
mod tests;
