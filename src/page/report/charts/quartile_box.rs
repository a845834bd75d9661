//! A row of a distribution: whiskers, the middle half as a box, the median.

use super::axis::AxisScale;
use super::sheet::Sheet;
use crate::render::svg::tenth;
use crate::report::quartiles::Distribution;

/// Draws a distribution between two heights in a colour; the box has the title as its tooltip.
pub(crate) fn draw_quartiles(
    sheet: &mut Sheet,
    scale: &AxisScale,
    [top, bottom]: [f64; 2],
    found: &Distribution,
    fill: &str,
    title: &str,
) {
    let Distribution { min, lower_quartile, median, upper_quartile, max, .. } = *found;
    let [least, lower, middle, upper, most] =
        [min, lower_quartile, median, upper_quartile, max].map(|value| scale.position(value));
    let at = (top + bottom) / 2.0;
    let ends = [least, most].map(|x| format!("M{x} {}v6", tenth(at - 3.0))).concat();
    let at = tenth(at);
    sheet.path("whisker", &format!("M{least} {at}H{lower}M{upper} {at}H{most}{ends}"));
    sheet.add_filled("box", fill, [lower, top, upper - lower, bottom - top], title);
    sheet.path("median", &format!("M{middle} {}V{}", tenth(top), tenth(bottom)));
}

/// The numbers of a distribution in words, after a title; `write` formats each.
pub(crate) fn describe(title: &str, found: &Distribution, write: impl Fn(f64) -> String) -> String {
    let Distribution { min, lower_quartile, median, upper_quartile, max, values } = *found;
    let [min, lower, median, upper, max] = [min, lower_quartile, median, upper_quartile, max].map(write);
    format!("{title}: {min} to {max}, quartiles {lower} and {upper}, median {median}, {values} choices")
}
