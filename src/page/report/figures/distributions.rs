//! Distributions of scores over the choices of poses: a box for each representation of each combination, over all
//! scenes and in each.

use super::names::{axis_name, columns, score_name};
use super::paper::{EDGE, WIDTH, begin, finish};
use super::part::SweepPart;
use crate::report::charts::axis::{AxisScale, span};
use crate::report::charts::quartile_box::{describe, draw_quartiles};
use crate::report::charts::sheet::{cut, width_of};
use crate::report::colours;
use crate::report::quartiles::{Distribution, distribution};
use perirobot_march::Result;
use perirobot_sweep::results::Results;

/// The height of a row, of a line with the name of a scene, and of a box.
const ROW: f64 = 21.0;
const HEAD: f64 = 22.0;
const BOX: f64 = 13.0;

/// The caption and the file of the figure of a region.
pub(super) fn draw(results: &Results, part: &SweepPart, region: usize) -> Result<(String, Vec<u8>)> {
    let titles: Vec<String> = part.series.iter().map(|series| series.title(results)).collect();
    let name = &results.regions[region];
    let scores = part.scores.iter().map(|score| score_name(*score)).collect::<Vec<_>>().join(" and ");
    let caption =
        format!("How {scores} in region {name} are distributed over all choices of poses, by representation");
    let notes = format!(
        "A choice of poses counts with {}{}. Box: the middle half of the choices; thick line: the median; thin lines end \
         at the least and the largest. Dotted line: the best answer that needs no sensor, if it is on the axis.",
        part.whole().is_mean_of(results),
        if part.extents.len() > 1 { ", below it each scene for itself" } else { "" },
    );
    let mut sheet = begin(&caption, &notes);
    let left = titles.iter().map(|title| width_of(title)).fold(60.0, f64::max).min(230.0);
    let places = columns(part.scores.len(), [EDGE + left + 10.0, WIDTH - EDGE]);
    let top = sheet.y;
    let mut end = top;
    for (&score, &places) in part.scores.iter().zip(&places) {
        let mut found: Vec<Vec<Option<Distribution>>> = Vec::new();
        for extent in &part.extents {
            let rows = part.series.iter().map(|series| {
                let values = series.summarize(results, &extent.moments, region, score)?;
                Ok(distribution(values.into_iter().flatten().map(|over| over.mean).collect()))
            });
            found.push(rows.collect::<Result<_>>()?);
        }
        let Some(ends) = span(found.iter().flatten().flatten().flat_map(|d| [d.min, d.max])) else {
            sheet.words("soft", [places[0], top + HEAD], "no choice of poses has a value here");
            continue;
        };
        let scale = AxisScale::new(ends, places);
        sheet.y = top + part.extents.len() as f64 * (HEAD + part.series.len() as f64 * ROW) + 4.0;
        scale.draw_below(&mut sheet, top + HEAD - 4.0, &axis_name(score));
        end = end.max(sheet.y + 40.0);
        let mut y = top;
        for (extent, row) in part.extents.iter().zip(&found) {
            sheet.words("soft over", [places[0], y + 15.0], &extent.bounds(results, region, score));
            y += HEAD;
            let rows_end = y + row.len() as f64 * ROW;
            for ((number, found), title) in row.iter().enumerate().zip(&titles) {
                if let Some(found) = found {
                    let heights = [y + (ROW - BOX) / 2.0, y + (ROW + BOX) / 2.0];
                    let tooltip = describe(title, found, |value| format!("{value:.3}"));
                    draw_quartiles(&mut sheet, &scale, heights, found, colours::series(number), &tooltip);
                }
                y += ROW;
            }
            let without =
                extent.best_baseline(results, region, score).filter(|(_, value)| scale.holds(*value));
            if let Some((_, value)) = without {
                sheet.path(
                    "without",
                    &format!("M{} {}V{rows_end}", scale.position(value), rows_end - row.len() as f64 * ROW),
                );
            }
        }
    }
    sheet.y = top;
    for extent in &part.extents {
        sheet.words("strong", [EDGE, sheet.y + 15.0], &cut(&extent.name, left));
        sheet.y += HEAD;
        for title in &titles {
            sheet.words("end", [EDGE + left, sheet.y + 14.0], &cut(title, left));
            sheet.y += ROW;
        }
    }
    sheet.y = end.max(sheet.y);
    Ok((caption + ".", finish(sheet)))
}
