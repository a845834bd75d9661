//! A row of a distribution: whiskers, the middle half as a box, the median.

use super::axis::AxisScale;
use super::sheet::Sheet;
use crate::render::svg::tenth;
use crate::report::quartiles::Distribution;

/// Draws a distribution between two heights in a colour; the box shows the title under the mouse.
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

/// The numbers of a distribution in words, after whose they are.
pub(crate) fn describe(title: &str, found: &Distribution) -> String {
    let Distribution { min, lower_quartile, median, upper_quartile, max, values } = *found;
    format!(
        "{title}: {min:.3} to {max:.3}, quartiles {lower_quartile:.3} and {upper_quartile:.3}, median {median:.3}, \
         {values} choices"
    )
}
