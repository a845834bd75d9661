//! The legend of a floor plan, and a plan as a file of its own, with its style and its legend.

use std::fmt::Display;

use super::FloorPlan;
use crate::render::svg::{Svg, tenth};

/// The style of all plans of a page.
pub const STYLE: &str = include_str!("plan.css");

/// The patterns of all plans of a page, in a drawing without size.
pub const PATTERNS: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plan\" width=\"0\" height=\"0\" \
    aria-hidden=\"true\"><defs>\
    <pattern id=\"p-blind\" width=\"8\" height=\"8\" patternUnits=\"userSpaceOnUse\">\
    <path class=\"hatch\" d=\"M-2 2L2 -2M0 8L8 0M6 10L10 6\"/></pattern>\
    <pattern id=\"p-guard\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\">\
    <path class=\"guard\" d=\"M3.5 0V7\"/></pattern>\
    <pattern id=\"p-hardly\" width=\"10\" height=\"10\" patternUnits=\"userSpaceOnUse\">\
    <circle class=\"speck\" cx=\"2.5\" cy=\"2.5\" r=\"1.3\"/><circle class=\"speck\" cx=\"7.5\" cy=\"7.5\" r=\"1.3\"/>\
    </pattern></defs></svg>\n";

/// Font size, line height, and margin.
const LETTERS: f64 = 14.0;
const LINE: f64 = 21.0;
const EDGE: f64 = 14.0;
/// The width of a swatch with the gap after it.
const SWATCH: f64 = 30.0;

/// The sign of a class in a legend, in a box of 24 by 16.
pub fn swatch(class: &str) -> String {
    let mut svg = Svg::default();
    match class {
        "badge" => svg.element("circle", &[("class", &class), ("cx", &12), ("cy", &8), ("r", &7)]),
        "reach" | "way" => svg.element("path", &[("class", &class), ("d", &"M1 8H23")]),
        _ => svg.element("path", &[("class", &class), ("d", &"M1 2H23V14H1Z")]),
    }
    svg.into_text()
}

impl FloorPlan {
    /// A part of a page with [`STYLE`] and [`PATTERNS`].
    pub fn inline(&self) -> String {
        self.drawing.clone().finish("plan", &self.title, self.paper.view())
    }

    /// A file with its title and its legend.
    pub fn alone(&self) -> String {
        let [left, top, width, height] = self.paper.view();
        let mut svg = Svg::default();
        svg.add(&format!("<style>\n{STYLE}</style>\n{PATTERNS}"));
        svg.element("rect", &[("class", &"sheet"), ("width", &"100%"), ("height", &"100%")]);
        let mut y = EDGE + LETTERS;
        svg.words(&[("class", &"title"), ("x", &EDGE), ("y", &y)], &self.title);
        y += 6.0;
        svg.add(&format!("<g transform=\"translate(0 {y})\">\n"));
        svg.add(&self.drawing.clone().into_text());
        svg.add("</g>\n");
        y += height + LETTERS;
        let mut x = EDGE;
        for (class, meaning) in &self.legend {
            let needs = SWATCH + meaning.chars().count() as f64 * 0.56 * LETTERS;
            if x > EDGE && x + needs > width - EDGE {
                (x, y) = (EDGE, y + LINE);
            }
            svg.add(&format!("<g transform=\"translate({} {})\">", tenth(x), tenth(y - 12.0)));
            svg.add(&swatch(class));
            svg.add("</g>\n");
            svg.words(&[("x", &tenth(x + SWATCH)), ("y", &tenth(y))], meaning);
            x += needs + 18.0;
        }
        for (letter, name) in &self.sensors {
            y += LINE;
            let letter = letter.as_ref().map_or(String::new(), |letter| format!("{letter}  "));
            let at: [(&str, &dyn Display); 2] = [("x", &EDGE), ("y", &tenth(y))];
            svg.words(&at, &format!("{letter}{name}"));
        }
        svg.finish("plan", &self.title, [left, top, width, tenth(y + EDGE)])
    }
}
