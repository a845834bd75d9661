//! The distribution of a score, as a chart: a row for each scene and series, with each choice as a stroke, or a
//! histogram of many, above the quartiles; and across the rows of a scene the upper bound and the best baseline.

use crate::render::svg::{escape, tenth};
use crate::report::bounds::{best_without_sensor, upper_bound};
use crate::report::charts::axis::{AxisScale, span};
use crate::report::charts::quartile_box::{describe, draw_quartiles};
use crate::report::charts::sheet::Sheet;
use crate::report::colours;
use crate::report::page::measure::{is_share, shown};
use crate::report::page::ranking::{MeanSpread, Ranking};
use crate::report::page::score_chart::{
    ScoreChart, WIDTH, axis_words, names_width, screen_width, write_name,
};
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::swept::SceneResults;

/// Heights: of a row, of its parts, of the name of a scene, of the gap after a scene, and of the names of the bounds.
const ROW: f64 = 22.0;
const STROKE: f64 = 11.0;
const BOX: f64 = 5.0;
const NAME: f64 = 18.0;
const AFTER: f64 = 8.0;
const TOP: f64 = 18.0;

/// The names of the bounds.
const BOUND: &str = "upper bound";

/// The chart of a score in a region.
pub(super) fn distribution_chart(
    results: &Results,
    rankings: &[Ranking],
    part: (usize, Score),
) -> ScoreChart {
    ScoreChart::new(results, part, "", |sheet| draw(sheet, results, rankings, part))
}

/// The rows of a scene, and its bounds.
struct SceneRows<'a> {
    rows: Vec<Option<&'a MeanSpread>>,
    bound: Option<f64>,
    without: Option<(&'static str, f64)>,
}

fn draw(
    sheet: &mut Sheet,
    results: &Results,
    rankings: &[Ranking],
    (region, score): (usize, Score),
) -> Option<AxisScale> {
    let several = results.scenes.len() > 1;
    let of_scene = |(number, scene): (usize, &SceneResults)| SceneRows {
        rows: rankings.iter().map(|ranking| ranking.spread(region, number, score)).collect(),
        bound: upper_bound(results, scene.moments.clone(), region, score),
        without: best_without_sensor(results, scene.moments.clone(), region, score),
    };
    let scenes: Vec<SceneRows> = results.scenes.iter().enumerate().map(of_scene).collect();
    let spreads = || scenes.iter().flat_map(|scene| &scene.rows).flatten();
    spreads().next()?;
    let bounds =
        scenes.iter().flat_map(|scene| scene.bound.into_iter().chain(scene.without.map(|one| one.1)));
    let ends = spreads().flat_map(|spread| [spread.distribution.min, spread.distribution.max]);
    let titles: Vec<String> = rankings.iter().map(|ranking| ranking.series.title(results)).collect();
    let left = names_width(titles.iter().map(String::as_str), 0.36);
    let scale = AxisScale::new(span(ends.chain(bounds))?, [left, WIDTH - 22.0]).in_percent(is_share(score));
    let each = titles.len() as f64 * ROW + AFTER + if several { NAME } else { 0.0 };
    sheet.y = TOP + scenes.len() as f64 * each;
    scale.draw_below(sheet, TOP, axis_words(score));
    let end = sheet.y + 38.0;
    sheet.y = TOP;
    for (number, scene) in scenes.iter().enumerate() {
        let first = sheet.y;
        if several {
            sheet.words("strong", [4.0, sheet.y + 12.0], &format!("scene {}", results.scenes[number].name));
            sheet.y += NAME;
        }
        for (series, (found, title)) in scene.rows.iter().zip(&titles).enumerate() {
            write_name(sheet, left, sheet.y + 15.0, title);
            if let Some(found) = found {
                draw_row(sheet, &scale, found, &tooltip(title, found, score), [series, number]);
            }
            sheet.y += ROW;
        }
        let mut mark = |class: &str, value: f64| {
            sheet.path(class, &format!("M{} {first}V{}", scale.position(value), sheet.y));
        };
        scene.bound.into_iter().for_each(|value| mark("bound", value));
        scene.without.iter().for_each(|(_, value)| mark("floor", *value));
        if number == 0 {
            name_bounds(sheet, scene, &scale);
        }
        sheet.y += AFTER;
    }
    sheet.y = end;
    Some(scale)
}

/// Draws the row of a series and a scene, with their indices for the script.
fn draw_row(
    sheet: &mut Sheet,
    scale: &AxisScale,
    found: &MeanSpread,
    tooltip: &str,
    [series, scene]: [usize; 2],
) {
    let (y, d, fill) = (sheet.y, &found.distribution, colours::series(series));
    let [from, to] = [d.min, d.max].map(|value| scale.position(value));
    let bottom = y + 2.0 + STROKE;
    match &found.single[..] {
        _ if d.min == d.max => sheet.path("median", &format!("M{from} {}v{STROKE}", y + 2.0)),
        [] => {
            let path = hill(&found.bins, [from, to], bottom);
            sheet.add(&format!("<path class=\"hill\" fill=\"{fill}\" d=\"{path}\"/>\n"));
        }
        single => {
            let path = strokes(single, scale, y + 2.0);
            sheet.add(&format!("<path class=\"strip\" stroke=\"{fill}\" d=\"{path}\"/>\n"));
        }
    }
    if d.max > d.min {
        draw_quartiles(sheet, scale, [bottom + 1.0, bottom + 1.0 + BOX], d, fill, "");
    }
    let width = tenth((to - from).max(2.0));
    sheet.add(&format!(
        "<rect class=\"feel\" x=\"{from}\" y=\"{y}\" width=\"{width}\" height=\"{ROW}\" \
         data-series=\"{series}\" data-scene=\"{scene}\"><title>{}</title></rect>\n",
        escape(tooltip)
    ));
}

/// The tooltip of a row.
fn tooltip(title: &str, found: &MeanSpread, score: Score) -> String {
    describe(title, &found.distribution, |value| shown(score, Some(value)))
}

/// A stroke for each value; coinciding ones are drawn once.
fn strokes(values: &[f64], scale: &AxisScale, top: f64) -> String {
    let mut places: Vec<i64> = values.iter().map(|value| scale.position(*value).round() as i64).collect();
    places.sort_unstable();
    places.dedup();
    let steps = places.windows(2).map(|pair| format!("m{}-{STROKE}v{STROKE}", pair[1] - pair[0]));
    format!("M{} {top}v{STROKE}{}", places[0], steps.collect::<String>())
}

/// A histogram with heights as square roots, so that a few good choices are visible next to many useless ones.
fn hill(bins: &[u32], [from, to]: [f64; 2], bottom: f64) -> String {
    let most = f64::from(bins.iter().copied().max().unwrap_or(1).max(1)).sqrt();
    let step = ((to - from) / bins.len() as f64).max(0.05);
    let mut path = format!("M{from} {bottom}");
    for (n, count) in bins.iter().enumerate() {
        let height = tenth(bottom - STROKE * f64::from(*count).sqrt() / most);
        path += &format!("V{height}H{}", tenth(from + (n + 1) as f64 * step));
    }
    path + &format!("V{bottom}Z")
}

/// Writes the names of the upper bound and the best baseline above the first rows.
fn name_bounds(sheet: &mut Sheet, scene: &SceneRows, scale: &AxisScale) {
    let bound = scene.bound.map(|value| (BOUND, value));
    let mut names: Vec<(&str, f64)> =
        scene.without.into_iter().chain(bound).map(|(name, value)| (name, scale.position(value))).collect();
    names.sort_by(|a, b| a.1.total_cmp(&b.1));
    for (name, at) in keep_apart(&names) {
        sheet.words("soft mid", [at, 13.0], name);
    }
}

/// Words around places from left to right, moved to stay inside the drawing and apart from each other.
fn keep_apart<'a>(names: &[(&'a str, f64)]) -> Vec<(&'a str, f64)> {
    let half = |name: &str| screen_width(name) / 2.0 + 4.0;
    let mut free = WIDTH;
    let mut placed: Vec<(&str, f64)> = Vec::new();
    for &(name, at) in names.iter().rev() {
        let at = at.min(free - half(name));
        free = at - half(name);
        placed.insert(0, (name, at));
    }
    let mut free = 0.0;
    for (name, at) in &mut placed {
        *at = at.max(free + half(name));
        free = *at + half(name);
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_on_each_other_are_one() {
        let scale = AxisScale::new([0.0, 1.0], [100.0, 200.0]);
        assert_eq!(strokes(&[0.5, 0.0, 0.5001, 0.53], &scale, 4.0), "M100 4v11m50-11v11m3-11v11");
    }

    #[test]
    fn names_stay_inside_and_apart() {
        let half = |name: &str| screen_width(name) / 2.0;
        for places in [[350.0, 350.0], [340.0, 345.0], [2.0, 3.0], [100.0, 300.0]] {
            let placed = keep_apart(&[("all occupied", places[0]), (BOUND, places[1])]);
            let [(first, a), (second, b)] = placed[..] else { panic!("{placed:?}") };
            assert!(a - half(first) >= 0.0 && b + half(second) <= WIDTH, "{placed:?}");
            assert!(b - a > half(first) + half(second), "{placed:?}");
        }
        assert_eq!(keep_apart(&[("all free", 100.0)]), [("all free", 100.0)]);
    }

    #[test]
    fn hills_are_as_high_as_the_roots() {
        assert_eq!(hill(&[4, 0, 1], [10.0, 40.0], 20.0), "M10 20V9H20V20H30V14.5H40V20Z");
    }
}
