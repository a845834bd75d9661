//! The best score of each combination of sensors: bars, over all scenes and in each, beside each other for all scores.

use super::names::{axis_name, columns, score_name};
use super::paper::{EDGE, WIDTH, add_note, begin, finish};
use super::part::SweepPart;
use crate::report::charts::axis::{AxisScale, span};
use crate::report::charts::bar::ScoreBar;
use crate::report::charts::sheet::{cut, width_of};
use crate::report::colours;
use crate::report::maximum::{maxima, most_sensors, relative};
use crate::report::table::number;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;

/// The height of the first bar of a combination with its margin, and of each other.
const FIRST: f64 = 22.0;
const OTHER: f64 = 14.0;

/// Width of the number after a bar.
const NUMBER: f64 = 92.0;

/// The caption and the file of the figure of a region.
pub(super) fn draw(results: &Results, part: &SweepPart, region: usize) -> Result<(String, Vec<u8>)> {
    let name = &results.regions[region];
    let scores = part.scores.iter().map(|score| score_name(*score)).collect::<Vec<_>>().join(" and ");
    let caption = format!("The best {scores} of each combination of sensors in region {name}");
    let reference = most_sensors(results);
    let is_one_scene = part.whole().scene.is_some();
    let over = match part.extents.len() {
        1 if is_one_scene => {
            format!("A bar ends at the largest score of any choice of poses, each with {}", part.whole().is_mean_of(results))
        }
        1 => "A bar ends at the mean of the scenes' maxima: in each scene the best of any choice of poses, each with its mean over \
              snapshots and repeats"
            .into(),
        _ => "The dark bar ends at the mean of the scenes' maxima, the light ones at the maximum of each scene: the best of \
              any choice of poses, each with its mean over snapshots and repeats"
            .into(),
    };
    let relative_to = reference.map_or(String::new(), |reference| {
        format!(" In brackets: as a part of that of {}.", results.combinations[reference].name)
    });
    let mut sheet = begin(&caption, &format!("{over}, in whichever representation.{relative_to}"));
    let names = part.combinations.iter().map(|&one| results.combinations[one].name.as_str());
    let names: Vec<&str> = names.collect();
    let labels = names.iter().copied().chain(part.extents.iter().map(|extent| extent.name.as_str()));
    let left = labels.map(width_of).fold(60.0, f64::max).min(230.0);
    let top = sheet.y;
    let each = FIRST + (part.extents.len() - 1) as f64 * OTHER + 6.0;
    let bottom = top + names.len() as f64 * each;
    for (&score, places) in
        part.scores.iter().zip(columns(part.scores.len(), [EDGE + left + 10.0, WIDTH - EDGE]))
    {
        let all = part.combinations.iter().map(|&one| values(results, part, one, (region, score)));
        let all: Vec<Vec<Option<f64>>> = all.collect::<Result<_>>()?;
        let whole = reference.map(|one| values(results, part, one, (region, score))).transpose()?;
        let Some(ends) = span(all.iter().flatten().flatten().copied()) else {
            sheet.words("soft", [places[0], top + 15.0], "no choice of poses has a value here");
            continue;
        };
        let scale = AxisScale::new(ends, [places[0], places[1] - NUMBER]);
        sheet.y = bottom;
        scale.draw_below(&mut sheet, top, &axis_name(score));
        for ((row, values), name) in all.iter().enumerate().zip(&names) {
            for (n, value) in values.iter().enumerate() {
                let y = top + row as f64 * each + if n == 0 { 0.0 } else { FIRST + (n - 1) as f64 * OTHER };
                let part_of = relative(*value, whole.as_ref().and_then(|whole| whole[n]));
                let part_of = part_of.map_or(String::new(), |part| format!(" ({part:.2})"));
                let tooltip = format!("{}{part_of}", number(*value));
                let (height, class) = if n == 0 { (FIRST - 8.0, "bar") } else { (OTHER - 5.0, "part") };
                let (fill, words_class) =
                    if n == 0 { (colours::series(0), "over") } else { (colours::PART, "soft over") };
                let title = format!("{name}, {}: {tooltip}", part.extents[n].name);
                let words = (tooltip.as_str(), words_class);
                let bar = ScoreBar { class, fill, y: y + 4.0, height, value: *value, words, title: &title };
                bar.draw(&mut sheet, &scale);
            }
        }
    }
    for (row, name) in names.iter().enumerate() {
        let y = top + row as f64 * each;
        sheet.words("strong end", [EDGE + left, y + 15.0], &cut(name, left));
        for (n, extent) in part.extents.iter().enumerate().skip(1) {
            let y = y + FIRST + (n - 1) as f64 * OTHER;
            sheet.words("soft end", [EDGE + left, y + 11.0], &cut(&extent.name, left));
        }
    }
    sheet.y = bottom + 54.0;
    for &score in &part.scores {
        let whole = part.whole();
        let bounds = whole.bounds(results, region, score);
        add_note(&mut sheet, &format!("{}, {}: {bounds}.", score_name(score), whole.name));
    }
    let over = match part.extents.len() {
        1 if is_one_scene => &part.whole().name,
        1 => "the mean of the scenes' maxima",
        _ => "the mean of the scenes' maxima, and each scene",
    };
    Ok((format!("{caption}: {over}."), finish(sheet)))
}

/// The maximum of a combination over each extent.
fn values(
    results: &Results,
    part: &SweepPart,
    combination: usize,
    (region, score): (usize, Score),
) -> Result<Vec<Option<f64>>> {
    let found = maxima(results, combination, region, score)?;
    let value = |scene: usize| found.scenes[scene].map(|maximum| maximum.value);
    Ok(part.extents.iter().map(|extent| extent.scene.map_or(found.mean, value)).collect())
}
