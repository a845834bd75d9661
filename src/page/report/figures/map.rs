//! Draws a map of places: walls, ceiling and floor, their objects, and each place in the colour of its score.

use glam::DVec2;

use crate::render::scale::{marks, step};
use crate::report::charts::axis::AxisScale;
use crate::report::charts::sheet::{SMALL, Sheet, width_of};
use crate::report::colours::ramp_colour;
use crate::report::unfolded::{Label, Map, PaperSpot};

/// Largest height of a map, and the side of a spot outside a lattice.
const HIGHEST: f64 = 330.0;
const SQUARE: f64 = 13.0;

/// Margin of a map for the names of walls or its axes.
const BESIDE: f64 = 20.0;

/// A box on the floor: name, style, lowest and highest corner.
pub(super) type Outline = (String, &'static str, [DVec2; 2]);

/// The colour of a value between the lowest and the highest.
pub(super) fn colour(value: f64, [low, high]: [f64; 2]) -> String {
    ramp_colour(((value - low) / (high - low) * 1024.0).round() as u32)
}

/// Draws a map between two sides, at the end of the sheet. `describe` returns a spot's colour, tooltip, and whether it
/// is the best.
pub(super) fn draw_map(
    sheet: &mut Sheet,
    map: &Map,
    [left, right]: [f64; 2],
    describe: impl Fn(&PaperSpot) -> Option<(String, String, bool)>,
    outlines: &[Outline],
) {
    let [low, high] = map.ends;
    let size = high - low;
    let margin = if map.axes.is_some() { 2.0 * BESIDE } else { BESIDE };
    let unit = ((right - left - margin - BESIDE) / size.x).min(HIGHEST / size.y);
    let (begin, top) = (left + margin, sheet.y + if map.axes.is_some() { 4.0 } else { BESIDE });
    let x = |metres: f64| begin + (metres - low.x) * unit;
    let y = |metres: f64| top + (high.y - metres) * unit;
    let area = |[a, b]: [DVec2; 2]| [x(a.x), y(b.y), (b.x - a.x) * unit, (b.y - a.y) * unit];
    if map.axes.is_none() {
        // The ceiling's rectangle with the walls on its edges.
        let [a, b] = map.flat;
        sheet.rectangle("face", area([DVec2::new(a.x, low.y), DVec2::new(b.x, high.y)]));
        sheet.rectangle("face", area([DVec2::new(low.x, a.y), DVec2::new(high.x, b.y)]));
    }
    let mut ring = None;
    for part in &map.parts {
        let size = part.size.unwrap_or(DVec2::splat(SQUARE / unit)) * 0.92;
        for spot in &part.spots {
            let around = area([spot.at - size / 2.0, spot.at + size / 2.0]);
            match describe(spot) {
                Some((colour, words, is_best)) => {
                    sheet.add_filled("spot", &colour, around, &words);
                    if is_best {
                        ring =
                            Some(([x(spot.at.x), y(spot.at.y)], around[2].min(around[3]).max(SQUARE) * 0.62));
                    }
                }
                None => sheet.rectangle("none", around),
            }
        }
    }
    if map.parts.iter().any(|part| part.face.is_plan()) {
        draw_outlines(sheet, outlines, map.flat, area);
    }
    // The title names the ceiling.
    let walls = map.parts.iter().filter(|part| !part.face.is_plan());
    for Label { text: name, at, is_turned } in walls.filter_map(|part| part.label.as_ref()) {
        let [at_x, at_y] = [x(at.x), y(at.y)];
        match is_turned {
            true if at.x < (low.x + high.x) / 2.0 => sheet.add_turned("mid over", [at_x - 6.0, at_y], name),
            true => sheet.add_turned("mid over", [at_x + 14.0, at_y], name),
            false if at.y <= low.y => sheet.words("mid over", [at_x, at_y + 14.0], name),
            false => sheet.words("mid over", [at_x, at_y - 5.0], name),
        }
    }
    if let Some((at, radius)) = ring {
        sheet.ring(at, radius);
    }
    sheet.y = top + size.y * unit + BESIDE;
    match map.axes {
        Some(axes) => draw_axes(sheet, map, axes, [begin, top, unit]),
        None => {
            let bar = step(size.x / 12.0);
            let (from, at) = (x(low.x), sheet.y - 4.0);
            sheet.path("axis", &format!("M{from:.1} {:.1}v6m0 -3h{:.1}m0 -3v6", at - 6.0, bar * unit));
            sheet.words(
                "soft",
                [from + bar * unit + 6.0, at + 1.0],
                &format!("{bar} m; x to the right, y up"),
            );
            sheet.y += 4.0;
        }
    }
}

fn draw_outlines(
    sheet: &mut Sheet,
    outlines: &[Outline],
    [low, high]: [DVec2; 2],
    area: impl Fn([DVec2; 2]) -> [f64; 4],
) {
    let inside = outlines.iter().filter_map(|(name, class, [a, b])| {
        let [a, b] = [a.max(low), b.min(high)];
        a.cmplt(b).all().then_some((name, *class, area([a, b])))
    });
    let inside: Vec<(&String, &str, [f64; 4])> = inside.collect();
    for (_, class, around) in &inside {
        sheet.rectangle("halo", *around);
        sheet.rectangle(class, *around);
    }
    for (name, _, [x, y, width, _]) in inside {
        if width_of(name) * SMALL < width {
            sheet.words("soft mid over", [x + width / 2.0, y + 12.0], name);
        }
    }
}

/// Metres below and at the side of a map of one plane.
fn draw_axes(sheet: &mut Sheet, map: &Map, axes: [usize; 2], [begin, top, unit]: [f64; 3]) {
    let [low, high] = map.ends;
    let [across, up] = axes.map(|axis| ["x", "y", "z"][axis]);
    let bottom = top + (high.y - low.y) * unit;
    sheet.path("axis", &format!("M{begin:.1} {top:.1}V{bottom:.1}h{:.1}", (high.x - low.x) * unit));
    for (metres, text) in marks(low.x, high.x, step(46.0 / unit)) {
        let x = begin + (metres - low.x) * unit;
        sheet.path("axis", &format!("M{x:.1} {bottom:.1}v4"));
        sheet.words("soft mid", [x, bottom + 15.0], &text);
    }
    for (metres, text) in marks(low.y, high.y, step(26.0 / unit)) {
        let y = bottom - (metres - low.y) * unit;
        sheet.path("axis", &format!("M{begin:.1} {y:.1}h-4"));
        sheet.words("soft end", [begin - 6.0, y + 4.0], &text);
    }
    sheet.words(
        "soft mid",
        [begin + (high.x - low.x) * unit / 2.0, bottom + 29.0],
        &format!("{across} in m"),
    );
    sheet.add_turned("soft mid", [begin - 30.0, (top + bottom) / 2.0], &format!("{up} in m"));
    sheet.y = bottom + 36.0;
}

/// The legend of the colours.
pub(super) fn colour_bar(sheet: &mut Sheet, ends: [f64; 2], places: [f64; 2], name: &str) {
    let (parts, top) = (64, sheet.y);
    let each = (places[1] - places[0]) / f64::from(parts);
    for n in 0..parts {
        let colour = ramp_colour((2 * n + 1) * 1024 / (2 * parts));
        let left = places[0] + f64::from(n) * each;
        sheet.add_filled("shade", &colour, [left, top, each + 0.4, 12.0], "");
    }
    sheet.y += 12.0;
    AxisScale::new(ends, places).draw_below(sheet, top + 12.0, name);
}
