//! Axes: from scores to places on the paper, with round numbers.

use super::sheet::Sheet;
use crate::render::scale::{marks, step};
use crate::render::svg::tenth;

/// The range of scores, including 0.
pub(crate) fn span(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let [low, high] = extremes(values)?;
    Some(separate([low.min(0.0), high.max(0.0)]))
}

/// The least and the largest score.
pub(crate) fn extremes(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    (ends[0] <= ends[1]).then(|| separate(ends))
}

/// Separates equal ends.
fn separate([low, high]: [f64; 2]) -> [f64; 2] {
    [low, high.max(low + 0.001)]
}

/// A linear scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisScale {
    /// The lowest and the highest number.
    pub(crate) ends: [f64; 2],
    /// Their places on the paper.
    pub(crate) places: [f64; 2],
    /// Whether only whole numbers are marked.
    is_whole: bool,
    /// Whether its numbers are shares, written as percent.
    is_percent: bool,
}

impl AxisScale {
    /// The scale from numbers to places on the paper.
    pub(crate) fn new(ends: [f64; 2], places: [f64; 2]) -> AxisScale {
        AxisScale { ends, places, is_whole: false, is_percent: false }
    }

    /// The scale of a counted quantity, such as snapshots.
    pub(crate) fn from_whole_numbers(ends: [f64; 2], places: [f64; 2]) -> AxisScale {
        AxisScale { is_whole: true, ..AxisScale::new(ends, places) }
    }

    /// The same with or without percent.
    pub(crate) fn in_percent(self, is_percent: bool) -> AxisScale {
        AxisScale { is_percent, ..self }
    }

    /// The place of a number.
    pub(crate) fn position(&self, value: f64) -> f64 {
        let ([low, high], [from, to]) = (self.ends, self.places);
        tenth(from + (value - low) / (high - low) * (to - from))
    }

    /// Whether a number is in its range.
    pub(crate) fn holds(&self, value: f64) -> bool {
        (self.ends[0]..=self.ends[1]).contains(&value)
    }

    /// Round numbers on it, with a least distance on the paper.
    pub(crate) fn marks(&self, apart: f64) -> impl Iterator<Item = (f64, String)> {
        let [low, high] = self.ends;
        let least = (high - low) * apart / (self.places[1] - self.places[0]).abs();
        let step = step(if self.is_whole { least.max(1.0) } else { least });
        let unit = if self.is_percent { 100.0 } else { 1.0 };
        let end = if self.is_percent { "\u{a0}%" } else { "" };
        let all = marks(low * unit, high * unit, step * unit);
        all.map(move |(value, text)| (value / unit, format!("{text}{end}")))
    }

    /// Draws it at the left of a plot, with grid lines to the right, and its numbers.
    pub(crate) fn draw_beside(&self, sheet: &mut Sheet, [left, right]: [f64; 2]) {
        let mut mesh = String::new();
        for (value, text) in self.marks(34.0) {
            let y = self.position(value);
            mesh += &format!("M{} {y}H{}", tenth(left), tenth(right));
            sheet.words("soft end", [left - 5.0, y + 4.0], &text);
        }
        sheet.path("mesh", &mesh);
    }

    /// Draws it below a plot that begins at a height, with grid lines, its numbers and its name; the sheet ends at the
    /// plot's lower edge.
    pub(crate) fn draw_below(&self, sheet: &mut Sheet, top: f64, name: &str) {
        let (bottom, [from, to]) = (sheet.y, self.places.map(tenth));
        let mut mesh = String::new();
        for (value, text) in self.marks(52.0) {
            let x = self.position(value);
            mesh += &format!("M{x} {}V{}", tenth(top), tenth(bottom));
            sheet.words("soft mid tick", [x, bottom + 15.0], &text);
        }
        sheet.path("mesh", &mesh);
        sheet.path("axis", &format!("M{from} {}H{to}", tenth(bottom)));
        sheet.words("mid", [(from + to) / 2.0, bottom + 32.0], name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_hold_nothing_too() {
        assert_eq!(span([0.2, 0.1].into_iter()), Some([0.0, 0.2]));
        assert_eq!(span([-0.1, 0.3].into_iter()), Some([-0.1, 0.3]));
        assert_eq!(span([-0.3, -0.1].into_iter()), Some([-0.3, 0.0]));
        assert_eq!(span([0.0].into_iter()), Some([0.0, 0.001]));
        assert_eq!(extremes([0.2, 0.1].into_iter()), Some([0.1, 0.2]));
        assert_eq!(span(std::iter::empty()), None);
    }

    #[test]
    fn marks_are_round_numbers_within_the_range() {
        let marks = |ends: [f64; 2]| {
            let scale = AxisScale::new(ends, [0.0, 450.0]);
            scale.marks(52.0).map(|(_, text)| text).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(marks([0.0, 1900.0]), "0 500 1000 1500");
        assert_eq!(marks([0.0, 0.8]), "0.0 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8");
        assert_eq!(marks([0.0, 0.07]), "0.00 0.01 0.02 0.03 0.04 0.05 0.06 0.07");
        assert_eq!(marks([-0.1, 0.5]), "-0.1 0.0 0.1 0.2 0.3 0.4 0.5");
    }

    #[test]
    fn numbers_lie_where_the_scale_says() {
        let scale = AxisScale::new([0.0, 0.5], [100.0, 600.0]);
        assert_eq!([0.0, 0.1, 0.5].map(|value| scale.position(value)), [100.0, 200.0, 600.0]);
        let marks: Vec<String> = scale.marks(90.0).map(|(_, text)| text).collect();
        assert_eq!(marks, ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        let sizes = AxisScale::from_whole_numbers([0.5, 3.5], [0.0, 600.0]);
        assert_eq!(sizes.marks(90.0).map(|(_, text)| text).collect::<Vec<_>>(), ["1", "2", "3"]);
    }
}
