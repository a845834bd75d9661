//! Axes: from scores to places on the paper, with round numbers beside them.

use super::sheet::Sheet;
use crate::render::scale::{marks, step};
use crate::render::svg::tenth;
use perirobot_march::metrics::Score;

/// What scores lie between, and 0.
pub(super) fn span(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let [low, high] = extremes(values)?;
    Some(apart([low.min(0.0), high.max(0.0)]))
}

/// The least and the largest score.
pub(super) fn extremes(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    (ends[0] <= ends[1]).then(|| apart(ends))
}

/// Ends that are not one.
fn apart([low, high]: [f64; 2]) -> [f64; 2] {
    [low, high.max(low + 0.001)]
}

/// A score as it stands at its axis: it has no unit.
pub(super) fn axis_name(score: Score) -> String {
    let better = if score.less_is_better() { "less is better" } else { "more is better" };
    match score {
        Score::F1 => format!("F1 (0 to 1, {better})"),
        Score::Kappa => format!("Cohen's κ (at most 1, {better})"),
        _ => format!("{} (share, 0 to 1, {better})", score.name()),
    }
}

/// A score in a sentence.
pub(super) fn score_name(score: Score) -> &'static str {
    match score {
        Score::Kappa => "κ",
        _ => score.title(),
    }
}

/// A straight scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisScale {
    /// The lowest and the highest number.
    pub(super) ends: [f64; 2],
    /// Where they lie on the paper.
    pub(super) places: [f64; 2],
}

impl AxisScale {
    /// Where a number lies.
    pub(super) fn position(&self, value: f64) -> f64 {
        let ([low, high], [from, to]) = (self.ends, self.places);
        tenth(from + (value - low) / (high - low) * (to - from))
    }

    /// Whether a number lies on it.
    pub(super) fn holds(&self, value: f64) -> bool {
        (self.ends[0]..=self.ends[1]).contains(&value)
    }

    /// Round numbers on it, at least so far from each other on the paper.
    pub(super) fn marks(&self, apart: f64) -> impl Iterator<Item = (f64, String)> {
        let [low, high] = self.ends;
        let least = (high - low) * apart / (self.places[1] - self.places[0]).abs();
        marks(low, high, step(least))
    }

    /// Draws it below a plot that begins at a height, with lines up through it, its numbers and its name; the sheet ends
    /// at the plot's lower edge.
    pub(super) fn draw_below(&self, sheet: &mut Sheet, top: f64, name: &str) {
        let (bottom, [from, to]) = (sheet.y, self.places.map(tenth));
        for (value, text) in self.marks(52.0) {
            let x = self.position(value);
            sheet.path("mesh", &format!("M{x} {}V{}", tenth(top), tenth(bottom)));
            sheet.words("soft mid tick", [x, bottom + 15.0], &text);
        }
        sheet.path("axis", &format!("M{from} {}H{to}", tenth(bottom)));
        sheet.words("mid", [(from + to) / 2.0, bottom + 32.0], name);
    }
}

/// Places of plots that lie side by side, from one edge to another.
pub(super) fn columns(count: usize, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
    let gap = 34.0;
    let each = (to - from - gap * (count - 1) as f64) / count as f64;
    (0..count).map(|n| from + n as f64 * (each + gap)).map(|left| [left, left + each]).collect()
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
    fn numbers_lie_where_the_scale_says() {
        let scale = AxisScale { ends: [0.0, 0.5], places: [100.0, 600.0] };
        assert_eq!([0.0, 0.1, 0.5].map(|value| scale.position(value)), [100.0, 200.0, 600.0]);
        let marks: Vec<String> = scale.marks(90.0).map(|(_, text)| text).collect();
        assert_eq!(marks, ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(columns(2, [0.0, 234.0]), [[0.0, 100.0], [134.0, 234.0]]);
    }
}
