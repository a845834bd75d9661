//! The file of a figure: its title and introduction, its style and its background.

use crate::report::charts::sheet::{SMALL, Sheet, lines};
use crate::report::colours::resolve;

/// The width of each figure in units of the drawing: two columns of print.
pub(super) const WIDTH: f64 = 900.0;

/// Margin at the sides.
pub(super) const EDGE: f64 = 14.0;

/// The height of a line.
const LINE: f64 = 16.0;

/// The width between the margins.
const ACROSS: f64 = WIDTH - 2.0 * EDGE;

/// A sheet with a title and an introduction.
pub(super) fn begin(title: &str, notes: &str) -> Sheet {
    let mut sheet = Sheet::new(title);
    let style = [include_str!("../charts/chart.css"), include_str!("figure.css")].concat();
    sheet.add(&format!("<style>\n{}</style>\n", resolve(&style)));
    sheet.add("<rect class=\"sheet\" width=\"100%\" height=\"100%\"/>\n");
    sheet.y = EDGE + 12.0;
    for line in lines(title, ACROSS / 1.3) {
        sheet.words("title", [EDGE, sheet.y], &line);
        sheet.y += LINE + 2.0;
    }
    add_note(&mut sheet, notes);
    sheet
}

/// Adds a paragraph in small letters.
pub(super) fn add_note(sheet: &mut Sheet, words: &str) {
    for line in lines(words, ACROSS / SMALL) {
        sheet.words("soft", [EDGE, sheet.y], &line);
        sheet.y += LINE - 1.0;
    }
    sheet.y += 4.0;
}

/// The file.
pub(super) fn finish(mut sheet: Sheet) -> Vec<u8> {
    sheet.y += EDGE;
    sheet.finish("chart figure", WIDTH).into_bytes()
}
