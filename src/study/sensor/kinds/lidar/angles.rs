//! The angles at which a LIDAR casts, from its keys: by step without the end, or by number with both ends.

use super::LidarFile;
use crate::diagnostics::Place;
use crate::sensor::MAX_RAYS;
use perirobot_march::{Error, Result};

/// How many rings devices have, and the widest step between them, in degrees.
const DEVICE_RINGS: [f64; 4] = [16.0, 32.0, 64.0, 128.0];
const WIDEST_STEP_DEG: f64 = 2.0;

/// Azimuths in degrees, by number or by step.
pub(super) fn azimuths(at: &Place, entry: &LidarFile, span: f64) -> Result<Vec<f64>> {
    match (entry.beams, entry.resolution_deg) {
        (Some(beams), None) if span == 360.0 => {
            number(at, "beams", beams, 1)?;
            Ok(angles(-180.0, 360.0, 360.0 / f64::from(beams)))
        }
        (Some(beams), None) => {
            number(at, "beams", beams, 2)?;
            Ok(spread(-span / 2.0, span, beams))
        }
        (None, Some(step)) => Ok(angles(-span / 2.0, span, step.horizontal)),
        (Some(beams), Some(_)) => {
            let rule = "and resolution_deg: give one of them; with beams, rings gives the number of rings";
            Err(at.wrong("beams", beams, rule))
        }
        (None, None) => Err(at.says("neither resolution_deg nor beams").with_advice(
            "give the step between rays, as in resolution_deg = 0.5, or their number with both ends, as in beams = 1081",
        )),
    }
}

/// Elevations above the ring plane in degrees, from whichever of three keys is given.
pub(super) fn elevations(at: &Place, entry: &LidarFile) -> Result<Vec<f64>> {
    let vertical = entry.fov_deg.and_then(|fov| fov.vertical);
    let within = |key: &str, angle: f64| at.number(key, angle, -90.0..=90.0, "between -90 and 90");
    match (&entry.rings_deg, entry.elevation_deg, vertical) {
        (Some(all), None, None) => {
            at.some("rings_deg", all, "rings_deg = [-15, -13, ...]")?;
            if let Some(count) = entry.rings {
                return Err(at.wrong("rings", count, "and rings_deg: give one of them"));
            }
            all.iter().map(|&angle| within("rings_deg", angle)).collect()
        }
        (None, Some([from, to]), None) => {
            within("elevation_deg", from)?;
            within("elevation_deg", to)?;
            if from >= to {
                return Err(at.wrong("elevation_deg", format!("[{from}, {to}]"), "must rise"));
            }
            rings(at, entry, [from, to])
        }
        (None, None, Some(vertical)) => {
            let rule = "above 0 and at most 180 vertically; a scanner of one plane has one angle and one ring, as in fov_deg = \
                        270 and rings_deg = [0]";
            at.number("fov_deg", vertical, f64::MIN_POSITIVE..=180.0, rule)?;
            rings(at, entry, [-vertical / 2.0, vertical / 2.0])
        }
        (None, None, None) => Err(elevation_error(at, "no elevations")),
        _ => Err(elevation_error(at, "elevations given twice")),
    }
}

fn elevation_error(at: &Place, what: &str) -> Error {
    at.says(what).with_advice(
        "give one of fov_deg = [horizontal, vertical], elevation_deg = [from, to], \
            rings_deg; the last two go with one angle, as in fov_deg = 270 and rings_deg = \
            [0] for a scanner of one plane",
    )
}

/// Angles from one to another in degrees, by number or by step.
fn rings(at: &Place, entry: &LidarFile, [from, to]: [f64; 2]) -> Result<Vec<f64>> {
    let step = entry.resolution_deg.map(|step| (step.horizontal, step.vertical));
    match (entry.rings, step) {
        (Some(rings), Some((_, Some(_)))) => {
            let rule = "and a vertical resolution_deg: give one of them";
            Err(at.wrong("rings", rings, rule))
        }
        (Some(rings), _) => {
            number(at, "rings", rings, 2)?;
            Ok(spread(from, to - from, rings))
        }
        (None, Some((horizontal, vertical))) => Ok(angles(from, to - from, vertical.unwrap_or(horizontal))),
        (None, None) => Err(at
            .says("neither rings nor a vertical step")
            .with_advice("give the number of rings with both ends, as in rings = 16, or rings_deg")),
    }
}

/// Checks how many angles are spread over an interval.
fn number(at: &Place, key: &str, count: u32, least: u32) -> Result<()> {
    match (least..=MAX_RAYS as u32).contains(&count) {
        true => Ok(()),
        false => Err(at.wrong(key, count, &format!("must be from {least} to {MAX_RAYS}"))),
    }
}

/// Warns of an interval whose end lies on a step, and is left out.
pub(super) fn left_out(file: &LidarFile) -> Vec<String> {
    let mut warnings = Vec::new();
    let degrees = |angle: f64| (angle * 1e6).round() / 1e6;
    let mut look = |key: &str, from: f64, span: f64, step: f64, instead: &str| {
        let steps = (span / step).round();
        if span < 360.0 && steps >= 1.0 && (steps * step - span).abs() < 1e-9 * span {
            warnings.push(format!(
                "{key} by steps of {step} leaves its end out: {steps} angles from {from} to {}. If the device has both ends, \
                 write {instead} = {} instead of the step",
                degrees(from + (steps - 1.0) * step),
                steps + 1.0
            ));
        }
    };
    let Some(step) = file.resolution_deg else { return warnings };
    if let Some(fov) = file.fov_deg.filter(|_| file.beams.is_none()) {
        look("fov_deg", -fov.horizontal / 2.0, fov.horizontal, step.horizontal, "beams");
    }
    let vertical_step = step.vertical.unwrap_or(step.horizontal);
    if let Some([from, to]) = file.elevation_deg.filter(|_| file.rings.is_none()) {
        look("elevation_deg", from, to - from, vertical_step, "rings");
    }
    // A vertical angle is a device's own if both ends make a number of rings that devices have.
    let is_device = |span: &f64| {
        vertical_step <= WIDEST_STEP_DEG
            && DEVICE_RINGS.iter().any(|rings| (span / vertical_step + 1.0 - rings).abs() < 1e-9)
    };
    let vertical = file.fov_deg.and_then(|fov| fov.vertical).filter(|_| file.rings.is_none());
    if let Some(span) = vertical.filter(is_device) {
        look("the vertical part of fov_deg", -span / 2.0, span, vertical_step, "rings");
    }
    warnings
}

/// ⌈span/step − 1e-9⌉ angles start + i · step, as many as a scan of `span` holds without its end.
fn angles(start: f64, span: f64, step: f64) -> Vec<f64> {
    let count = (span / step - 1e-9).ceil().max(0.0) as usize;
    (0..count).map(|i| start + i as f64 * step).collect()
}

/// So many angles, two at least, spread evenly over a span from its start to its end, both included.
fn spread(start: f64, span: f64, count: u32) -> Vec<f64> {
    (0..count).map(|i| start + span * f64::from(i) / f64::from(count - 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_have_their_start_and_not_their_end() {
        assert_eq!(angles(0.0, 90.0, 30.0), [0.0, 30.0, 60.0]);
        assert_eq!(angles(-180.0, 360.0, 0.7).len(), 515);
        assert_eq!(angles(45.0, 45.0, 0.7).len(), 65);
        // 0.3 / 0.1 is 2.9999999999999996: still three angles.
        assert_eq!(angles(0.0, 0.3, 0.1).len(), 3);
    }

    #[test]
    fn spread_angles_have_both_ends() {
        assert_eq!(spread(-15.0, 30.0, 16)[..2], [-15.0, -13.0]);
        assert_eq!(spread(-135.0, 270.0, 1081).last(), Some(&135.0));
        assert_eq!(spread(-5.0, 5.0, 2), [-5.0, 0.0]);
    }
}
