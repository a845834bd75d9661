//! Maps world coordinates to a floor plan, with x to the right and y up; draws the axes around it.

use glam::{DVec2, DVec3};

use crate::render::scale::{marks, ruler, step};
use crate::render::svg::{Svg, tenth};

/// Largest width and height of the cell on the paper.
const MOST: [f64; 2] = [660.0, 520.0];
/// Margins around the cell: at the left and below for axes and the names of walls, at the right and above for these
/// names, and for parts outside the cell.
const LEFT: f64 = 66.0;
const BELOW: f64 = 66.0;
const BESIDE: f64 = 31.0;
const ABOVE: f64 = 31.0;
/// Letters of axes.
const SMALL: f64 = 13.0;

/// A sheet with the drawing of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paper {
    low: DVec2,
    high: DVec2,
    /// Units of the drawing per metre.
    pub(super) scale: f64,
}

impl Paper {
    /// The sheet for a part of the floor.
    pub(super) fn new([low, high]: [DVec2; 2]) -> Paper {
        let high = high.max(low + DVec2::splat(1e-3));
        let size = high - low;
        Paper { low, high, scale: (MOST[0] / size.x).min(MOST[1] / size.y) }
    }

    /// The place of a point.
    pub(super) fn project(&self, metres: DVec2) -> [f64; 2] {
        let Paper { low, high, scale } = self;
        [tenth(LEFT + (metres.x - low.x) * scale), tenth(ABOVE + (high.y - metres.y) * scale)]
    }

    /// The same for a place at any height.
    pub(super) fn project_down(&self, metres: DVec3) -> [f64; 2] {
        self.project(metres.truncate())
    }

    /// Left, upper, right and lower edge of the cell.
    pub(super) fn edges(&self) -> [f64; 4] {
        let ([left, top], [right, bottom]) = (
            self.project(DVec2::new(self.low.x, self.high.y)),
            self.project(DVec2::new(self.high.x, self.low.y)),
        );
        [left, top, right, bottom]
    }

    /// The box of the drawing.
    pub(super) fn view(&self) -> [f64; 4] {
        let [_, _, right, bottom] = self.edges();
        [0.0, 0.0, tenth(right + BESIDE), tenth(bottom + BELOW)]
    }

    /// A closed line through places, as a path. Steps along an axis, which outlines of voxels consist of, are relative: a
    /// plan has thousands.
    pub(super) fn ring(&self, places: &[DVec2]) -> String {
        let mut path = String::new();
        let mut before: Option<[f64; 2]> = None;
        for &place in places {
            let [x, y] = self.project(place);
            path += &match before {
                None => format!("M{x} {y}"),
                Some([last_x, last_y]) if last_y == y => format!("h{}", tenth(x - last_x)),
                Some([last_x, last_y]) if last_x == x => format!("v{}", tenth(y - last_y)),
                Some(_) => format!("L{x} {y}"),
            };
            before = Some([x, y]);
        }
        path + "Z"
    }

    /// Axes in metres, the scale bar, and the direction of y.
    pub(super) fn draw_axes(&self, svg: &mut Svg) {
        let [left, top, right, bottom] = self.edges();
        let step = step(((self.high - self.low).max_element() / 8.0).max(45.0 / self.scale));
        for (metres, text) in marks(self.low.x, self.high.x, step) {
            let [x, _] = self.project(DVec2::new(metres, self.low.y));
            svg.element("path", &[("class", &"tick"), ("d", &format!("M{x} {bottom}v5"))]);
            let at: [(&str, &dyn std::fmt::Display); 4] =
                [("class", &"axis"), ("x", &x), ("y", &(bottom + 18.0)), ("text-anchor", &"middle")];
            svg.words(&at, &text);
        }
        for (metres, text) in marks(self.low.y, self.high.y, step) {
            let [_, y] = self.project(DVec2::new(self.low.x, metres));
            svg.element("path", &[("class", &"tick"), ("d", &format!("M{left} {y}h-5"))]);
            let (x, y) = (left - 8.0, tenth(y + SMALL / 3.0));
            let at: [(&str, &dyn std::fmt::Display); 4] =
                [("class", &"axis"), ("x", &x), ("y", &y), ("text-anchor", &"end")];
            svg.words(&at, &text);
        }
        let frame = format!("M{left} {top}V{bottom}H{right}");
        svg.element("path", &[("class", &"tick"), ("d", &frame)]);
        // The arrow of y, and the scale bar at the right end of x.
        let arrow = format!("M14 {}V{top}m-4 9l4 -9l4 9", tenth(top + 36.0));
        svg.element("path", &[("class", &"ruler"), ("d", &arrow)]);
        svg.words(&[("class", &"axis"), ("x", &14), ("y", &(top + 50.0)), ("text-anchor", &"middle")], "y");
        let length = ruler(self.high.x - self.low.x);
        let (begin, y) = (tenth(right - length * self.scale), bottom + 52.0);
        let ruler = format!("M{begin} {}v8m0 -4H{right}m0 -4v8", y - 4.0);
        svg.element("path", &[("class", &"ruler"), ("d", &ruler)]);
        let at: [(&str, &dyn std::fmt::Display); 4] =
            [("class", &"axis"), ("x", &(begin - 6.0)), ("y", &(y + 4.0)), ("text-anchor", &"end")];
        svg.words(&at, &format!("{length} m"));
        svg.words(&[("class", &"axis"), ("x", &left), ("y", &(y + 4.0))], "x and y in metres");
    }

    /// From the cell to the left of the numbers of an axis.
    pub(super) fn number_margin(&self) -> f64 {
        LEFT - SMALL - 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_as_on_a_map() {
        let paper = Paper::new([DVec2::new(-3.0, -2.0), DVec2::new(3.0, 2.0)]);
        assert_eq!(paper.scale, 110.0);
        assert_eq!(paper.project(DVec2::new(-3.0, 2.0)), [LEFT, ABOVE], "the upper left corner");
        assert_eq!(paper.project(DVec2::new(3.0, -2.0)), [LEFT + 660.0, ABOVE + 440.0]);
        assert_eq!(paper.ring(&[DVec2::ZERO, DVec2::X]), "M396 251h110Z");
        let [a, b, c] = [DVec2::ZERO, DVec2::X, DVec2::new(2.0, 1.0)];
        assert_eq!(paper.ring(&[a, b, c, DVec2::new(2.0, 0.0)]), "M396 251h110L616 141v110Z");
    }
}
