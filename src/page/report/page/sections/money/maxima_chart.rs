//! The best of each combination by a score, as bars.

use crate::report::charts::axis::{AxisScale, span};
use crate::report::charts::bar::ScoreBar;
use crate::report::charts::sheet::Sheet;
use crate::report::colours;
use crate::report::maximum::{most_sensors, relative};
use crate::report::page::measure::{is_share, percent, shown};
use crate::report::page::ranking::{Ranking, maxima_of};
use crate::report::page::score_chart::{ScoreChart, WIDTH, axis_words, names_width, write_name};
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;

/// The height of a row, and of its bar.
const ROW: f64 = 24.0;
const BAR: f64 = 16.0;

/// Width of the number after a bar.
const NUMBER: f64 = 112.0;

/// The chart of a score in a region.
pub(super) fn maxima_chart(results: &Results, rankings: &[Ranking], part: (usize, Score)) -> ScoreChart {
    ScoreChart::new(results, part, "Largest ", |sheet| draw(sheet, results, rankings, part))
}

fn draw(
    sheet: &mut Sheet,
    results: &Results,
    rankings: &[Ranking],
    part: (usize, Score),
) -> Option<AxisScale> {
    let all = 0..results.combinations.len();
    let values: Vec<Option<f64>> =
        all.map(|combination| maxima_of(results, rankings, combination, part).mean).collect();
    let names = || results.combinations.iter().map(|combination| combination.name.as_str());
    let left = names_width(names(), 0.42);
    let scale = AxisScale::new(span(values.iter().flatten().copied())?, [left, WIDTH - NUMBER]);
    let scale = scale.in_percent(is_share(part.1));
    let full = most_sensors(results);
    sheet.y = values.len() as f64 * ROW + 4.0;
    scale.draw_below(sheet, 0.0, axis_words(part.1));
    for (row, (&value, name)) in values.iter().zip(names()).enumerate() {
        let y = row as f64 * ROW + 4.0;
        let of_full = relative(value, full.and_then(|full| values[full]));
        let of_full = of_full.map_or(String::new(), |share| format!(" ({})", percent(share, 0)));
        let label = format!("{}{of_full}", shown(part.1, value));
        write_name(sheet, left, y + 12.0, name);
        let fill = colours::series(usize::from(full == Some(row)));
        let title = format!("{name}: {label}");
        ScoreBar { class: "bar", fill, y, height: BAR, value, words: (&label, ""), title: &title }
            .draw(sheet, &scale);
    }
    sheet.y += 38.0;
    Some(scale)
}
