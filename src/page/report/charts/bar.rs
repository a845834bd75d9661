//! A bar of a score, with its number after it.

use super::axis::AxisScale;
use super::sheet::Sheet;

/// A bar from 0 to a score.
pub(crate) struct ScoreBar<'a> {
    pub(crate) class: &'a str,
    pub(crate) fill: &'a str,
    /// Its upper edge, and its height.
    pub(crate) y: f64,
    pub(crate) height: f64,
    pub(crate) value: Option<f64>,
    /// The text after it, with its class.
    pub(crate) words: (&'a str, &'a str),
    /// The tooltip.
    pub(crate) title: &'a str,
}

impl ScoreBar<'_> {
    /// Draws it.
    pub(crate) fn draw(&self, sheet: &mut Sheet, scale: &AxisScale) {
        let zero = scale.position(0.0);
        let end = self.value.map_or(zero, |value| scale.position(value));
        let area = [zero.min(end), self.y, (end - zero).abs(), self.height];
        sheet.add_filled(self.class, self.fill, area, self.title);
        let (words, class) = self.words;
        sheet.words(class, [zero.max(end) + 5.0, self.y + self.height - 2.0], words);
    }
}
