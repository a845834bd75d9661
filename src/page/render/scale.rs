//! Round numbers for axes and scale bars, the same in floor plans and in pictures from above.

/// The smallest of 1, 2 and 5 times a power of ten that is at least a length.
pub(crate) fn step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let found = [1.0, 2.0, 5.0].map(|n| n * power).into_iter().find(|step| *step >= least - 1e-12);
    found.unwrap_or(10.0 * power)
}

/// The multiples of a step in an interval, as text with the digits that the step needs.
pub(crate) fn marks(low: f64, high: f64, step: f64) -> impl Iterator<Item = (f64, String)> {
    let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
    let digits = (-step.log10().floor()).max(0.0) as usize;
    (first..=last).map(move |n| n as f64 * step).map(move |mark| (mark, format!("{mark:.digits$}")))
}

/// A round length that is between a sixth and less than half of a width.
pub(super) fn ruler(width: f64) -> f64 {
    step(width / 6.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        assert_eq!([0.09, 0.1, 0.3, 0.75, 1.0, 2.1, 6.0].map(step), [0.1, 0.1, 0.5, 1.0, 1.0, 5.0, 10.0]);
    }

    #[test]
    fn marks_are_told_with_the_digits_they_need() {
        let texts =
            |low: f64, high: f64, step: f64| marks(low, high, step).map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(texts(-1.05, 1.0, 1.0), ["-1", "0", "1"]);
        assert_eq!(texts(0.0, 0.11, 0.05), ["0.00", "0.05", "0.10"]);
    }
}
