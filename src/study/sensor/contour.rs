//! Contours in the frame of a scanner: rays of its level ring, and the corners that their ends make.

use std::fmt::Debug;
use std::sync::Arc;

use glam::DVec2;

use super::kinds::lidar::{MAX_CORNERS, bound_area};
use super::{Kind, Station};
use perirobot_march::error::Issue;

/// The shortest ray of a contour, in metres: about the housing of a scanner. Shorter ones would change their direction when
/// they are rounded to millimetres.
pub(crate) const SHORTEST_M: f64 = 0.02;

/// A sensor that may guard a field with a level ring of rays.
pub trait Scanner: Debug {
    /// The rays of its level ring, by azimuth, in the environment alone: without people, robots and noise, dark objects as
    /// bright ones. A ray ends also where one of another ring above or below it meets something up to this height.
    ///
    /// # Errors
    /// If it has no level ring, or is tilted.
    fn clear_rays(&self, at: &Station, height_m: f64) -> Result<Vec<RingRay>, Issue>;

    /// The height of its usual field or of that of a case, in metres, if it has one.
    fn field_height_m(&self, case: Option<usize>) -> Option<f64>;

    /// How far its fields reach, in metres, if it is read by them alone.
    fn field_reach_m(&self) -> Option<f64>;

    /// The names of the cases in which it guards other fields than the usual one.
    fn cases(&self) -> Vec<&str>;

    /// The cases that apply at a station's moment: the first is the one that counts, none leaves the usual field.
    fn applying_cases(&self, at: &Station) -> Vec<usize>;

    /// The same scanner with this field alone.
    fn guard(&self, polygon_m: Vec<DVec2>, height_m: f64) -> Arc<dyn Kind>;
}

/// A ray of a level ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingRay {
    /// Its direction: 0 is ahead, a quarter turn is to the left.
    pub azimuth_rad: f64,
    /// How far it goes, in metres: to what it meets, or to the end of the range.
    pub reach_m: f64,
    /// The voxel that it meets.
    pub hit: Option<[i32; 3]>,
}

/// Whether rays go all round, so that the last one's neighbour is the first.
pub(crate) fn is_full_turn(azimuths_rad: &[f64]) -> bool {
    let [first, second, .., last] = azimuths_rad else { return false };
    let across = first + std::f64::consts::TAU - last;
    across <= (second - first) * (1.0 + 1e-9)
}

/// The least step at which so many rays give a polygon of few enough corners.
pub(crate) fn thinning(rays: usize) -> usize {
    // The last ray and the scanner itself may be corners, too.
    rays.div_ceil(MAX_CORNERS - 2).max(1)
}

/// The rays on either side of a direction: two neighbours, or the first or last ray twice.
pub(crate) fn sector(azimuths_rad: &[f64], towards_rad: f64) -> [usize; 2] {
    let last = azimuths_rad.len() - 1;
    match azimuths_rad.iter().rposition(|azimuth| *azimuth <= towards_rad) {
        Some(before) if before < last => [before, before + 1],
        _ if is_full_turn(azimuths_rad) => [last, 0],
        Some(_) => [last; 2],
        None => [0; 2],
    }
}

/// Corners in millimetres at the ends of rays, each coordinate rounded towards the scanner, which is a corner itself unless
/// the rays go all round. Rounding may change the order of neighbours' directions; the shorter of them is then kept.
///
/// # Errors
/// If the rays bound no area.
pub(crate) fn corners_mm(azimuths_rad: &[f64], reaches_m: &[f64]) -> Result<Vec<[i64; 2]>, Issue> {
    let mut corners: Vec<[i64; 2]> = Vec::new();
    let length = |[x, y]: [i64; 2]| x * x + y * y;
    let turns_left = |a: [i64; 2], b: [i64; 2]| a[0] * b[1] > a[1] * b[0];
    'rays: for (azimuth, reach_m) in azimuths_rad.iter().zip(reaches_m) {
        let (sin, cos) = libm::sincos(*azimuth);
        // A little more, so that 0.3 m along an axis is 300 mm.
        let end = [cos, sin].map(|part| (part * reach_m * 1e3 * (1.0 + 1e-12)) as i64);
        while let Some(&before) = corners.last() {
            if turns_left(before, end) {
                break;
            }
            if length(before) <= length(end) {
                continue 'rays;
            }
            corners.pop();
        }
        corners.push(end);
    }
    if is_full_turn(azimuths_rad) {
        while let [first, .., last] = corners[..]
            && !turns_left(last, first)
        {
            if length(first) < length(last) {
                corners.pop()
            } else {
                Some(corners.remove(0))
            };
        }
    } else {
        corners.push([0; 2]);
    }
    bound_area(&to_metres(&corners)).map_err(|issue| {
        issue.cure("a field needs more rays of the level ring, at most half a turn apart")
    })?;
    Ok(corners)
}

/// Corners in metres.
pub(crate) fn to_metres(corners_mm: &[[i64; 2]]) -> Vec<[f64; 2]> {
    corners_mm.iter().map(|corner| corner.map(|mm| mm as f64 / 1e3)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn azimuths(from_deg: f64, step_deg: f64, count: usize) -> Vec<f64> {
        (0..count).map(|n| (from_deg + n as f64 * step_deg).to_radians()).collect()
    }

    #[test]
    fn corners_are_rounded_towards_the_scanner() {
        let corners = corners_mm(&azimuths(-180.0, 90.0, 4), &[0.3, 1.2345, 2.0, 0.9999]).unwrap();
        assert_eq!(corners, [[-300, 0], [0, -1234], [2000, 0], [0, 999]]);
        let quarter = corners_mm(&azimuths(-45.0, 90.0, 2), &[1.0, 1.0]).unwrap();
        assert_eq!(quarter, [[707, -707], [707, 707], [0, 0]]);
    }

    #[test]
    fn few_rays_bound_no_area() {
        for (azimuths, reaches) in [
            (azimuths(0.0, 1.0, 1), &[1.0][..]),
            (azimuths(-180.0, 180.0, 2), &[1.0, 1.0]),
            (azimuths(-90.0, 180.0, 2), &[1.0, 1.0]),
        ] {
            let said = corners_mm(&azimuths, reaches).unwrap_err().to_string();
            assert!(said.contains("needs more rays"), "{said}");
        }
    }

    #[test]
    fn short_rays_among_long_ones_stay_in_order() {
        // Each ray by turns long and as short as can be, a tenth of a degree apart.
        for (from_deg, count) in [(-180.0, 3600), (-135.0, 2701), (3.0, 500)] {
            for every in [2, 3, 7] {
                let azimuths = azimuths(from_deg, 0.1, count);
                let reaches: Vec<f64> =
                    (0..count).map(|n| if n % every == 0 { SHORTEST_M } else { 20.0 }).collect();
                let corners = corners_mm(&azimuths, &reaches).unwrap();
                assert!(corners.len() > 20, "{} corners", corners.len());
            }
        }
    }

    #[test]
    fn neighbours_of_a_direction() {
        let (turn, part) = (azimuths(-180.0, 90.0, 4), azimuths(-90.0, 90.0, 3));
        assert!(is_full_turn(&turn) && !is_full_turn(&part));
        for (azimuths, towards_deg, expected) in [
            (&turn, -100.0_f64, [0, 1]),
            (&turn, 135.0, [3, 0]),
            (&part, 45.0, [1, 2]),
            (&part, 90.0, [2, 2]),
            (&part, 170.0, [2, 2]),
            (&part, -170.0, [0, 0]),
        ] {
            assert_eq!(sector(azimuths, towards_deg.to_radians()), expected, "{towards_deg}");
        }
        assert_eq!([998, 999, 1996, 1997].map(thinning), [1, 2, 2, 3]);
    }
}
