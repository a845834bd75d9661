//! The compass that explains pan.

use crate::render::svg::Svg;

/// Half the size of the drawing, and the length of its arrows.
const HALF: f64 = 70.0;
const ARROW: f64 = 38.0;

/// A compass with the pan of each axis, seen from above.
pub(in crate::report::page) fn compass() -> String {
    let mut svg = Svg::default();
    for (dx, dy, words) in
        [(1.0, 0.0, "x, 0°"), (0.0, -1.0, "y, 90°"), (-1.0, 0.0, "180°"), (0.0, 1.0, "-90°")]
    {
        let path = format!("M{HALF} {HALF}l{} {}", dx * ARROW, dy * ARROW);
        svg.element(
            "path",
            &[("class", &if words.contains(',') { "look" } else { "dimension" }), ("d", &path)],
        );
        let (x, y) = (HALF + dx * (ARROW + 17.0), HALF + dy * (ARROW + 12.0) + 4.0);
        svg.words(&[("x", &x), ("y", &y), ("text-anchor", &"middle")], words);
    }
    svg.element(
        "path",
        &[
            ("class", &"dimension"),
            ("d", &format!("M{} {HALF}A24 24 0 0 0 {HALF} {}", HALF + 24.0, HALF - 24.0)),
        ],
    );
    svg.words(
        &[("class", &"angle"), ("x", &(HALF + 31.0)), ("y", &(HALF - 22.0)), ("text-anchor", &"middle")],
        "pan",
    );
    svg.finish(
        "sketch compass",
        "Pan is counted from x to y, seen from above",
        [0.0, 0.0, 2.0 * HALF, 2.0 * HALF],
    )
}
