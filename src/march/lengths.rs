//! Lengths as messages say them: without the digits that a sum of binary fractions leaves behind.

use glam::DVec3;

/// A length in metres to a micrometre, as in `1.25 m`.
pub fn describe_length(metres: f64) -> String {
    format!("{} m", to_micrometre(metres))
}

/// A place in metres to a micrometre, as in `[1.25, 0, 2] m`.
pub fn describe_place(metres: DVec3) -> String {
    let [x, y, z] = metres.to_array().map(to_micrometre);
    format!("[{x}, {y}, {z}] m")
}

/// Of what is too large to have micrometres, all digits.
fn to_micrometre(metres: f64) -> f64 {
    let rounded = (metres * 1e6).round() / 1e6 + 0.0;
    if rounded.is_finite() { rounded } else { metres }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::{describe_length, describe_place};

    #[test]
    fn sums_of_binary_fractions_are_said_in_short() {
        assert_eq!(describe_length(2952.0 * 0.01 + 0.0028), "29.5228 m");
        assert_eq!([describe_length(-1e-9), describe_length(1e300)], ["0 m".into(), format!("{} m", 1e300)]);
        assert_eq!(describe_place(DVec3::new(0.1 + 0.2, -1.0, 2.5)), "[0.3, -1, 2.5] m");
    }
}
