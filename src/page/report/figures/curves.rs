//! Scores of the best choices of poses over the snapshots of a scene that moves.

use super::names::{axis_name, columns, score_name};
use super::paper::{EDGE, WIDTH, begin, finish};
use super::part::SweepPart;
use crate::render::svg::tenth;
use crate::report::charts::axis::{AxisScale, span};
use crate::report::charts::sheet::{SMALL, lines};
use crate::report::colours;
use crate::report::series::{Series, rank};
use crate::report::table::number;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::{Over, Results};

/// Most curves in a plot.
const MOST: usize = 6;

/// Dashes of curves, to distinguish them without colours.
const DASHES: [&str; MOST] = ["none", "8 4", "2 3", "12 4 2 4", "5 2", "1 5"];

/// The height of a plot.
const HEIGHT: f64 = 250.0;

/// A choice with a drawn curve.
struct ScoreCurve {
    series: Series,
    choice: usize,
    /// `1st by mean`.
    rank: String,
}

/// The caption and the file of the figure of a region and a scene.
pub(super) fn draw(
    results: &Results,
    part: &SweepPart,
    region: usize,
    scene: usize,
) -> Result<(String, Vec<u8>)> {
    let (name, place) = (&results.scenes[scene].name, &results.regions[region]);
    let moments = results.scenes[scene].moments.clone();
    let scores = part.scores.iter().map(|score| score_name(*score)).collect::<Vec<_>>().join(" and ");
    let caption = format!(
        "{scores} in region {place} of the best choices of poses, at each of the {} snapshots of scene {name}",
        moments.len()
    );
    let (repeats, drawn) = match results.repeats {
        1 => ("", ""),
        _ => (" and repeats", " A curve is the mean over the repeats, so the worst may lie below it."),
    };
    let notes = format!(
        "Chosen for each score by itself, by the mean and by the worst of all snapshots{repeats}.{drawn}"
    );
    let mut sheet = begin(&caption, &notes);
    let top = sheet.y;
    let mut end = top;
    for (&score, [left, right]) in part.scores.iter().zip(columns(part.scores.len(), [EDGE, WIDTH - EDGE])) {
        let curves = curves(results, part, (scene, region, score))?;
        let mut values: Vec<Vec<Option<f64>>> = Vec::new();
        for ScoreCurve { series, choice, .. } in &curves {
            let at = |moment| results.summarize(moment..moment + 1, series.key(*choice, region), score);
            let scores: Vec<Option<Over>> = moments.clone().map(at).collect::<Result<_>>()?;
            values.push(scores.into_iter().map(|over| over.map(|over| over.mean)).collect());
        }
        let Some(ends) = span(values.iter().flatten().flatten().copied()) else {
            sheet.words("soft", [left, top + 15.0], "no choice of poses has a value here");
            continue;
        };
        sheet.words("strong", [left, top + 8.0], &axis_name(score));
        let up = AxisScale::new(ends, [top + HEIGHT, top + 22.0]);
        let across = AxisScale::from_whole_numbers([0.0, (moments.len() - 1) as f64], [left + 40.0, right]);
        up.draw_beside(&mut sheet, [left + 40.0, right]);
        sheet.y = top + HEIGHT;
        across.draw_below(&mut sheet, top + 22.0, "snapshot, counted from 0");
        let mut y = top + HEIGHT + 54.0;
        for (n, (curve, values)) in curves.iter().zip(&values).enumerate() {
            let at = |(step, value): (usize, &Option<f64>)| {
                value.map(|v| (step, across.position(step as f64), up.position(v)))
            };
            let combination = &results.combinations[curve.series.combination];
            let all = results.summarize(moments.clone(), curve.series.key(curve.choice, region), score)?;
            let [mean, worst] = [all.map(|over| over.mean), all.map(|over| over.worst)].map(number);
            let named = match part.series.len() {
                1 => combination.label(curve.choice),
                _ => format!("{} · {}", curve.series.title(results), combination.label(curve.choice)),
            };
            let weighted =
                results.weighted_mean(moments.clone(), &curve.series.key(curve.choice, region), score)?;
            let weighted =
                weighted.map_or(String::new(), |mean| format!(", weighted {}", number(Some(mean))));
            let tooltip = format!("{named}: mean {mean}{weighted}, worst {worst} ({})", curve.rank);
            sheet.curve(colours::series(n), DASHES[n], &path(values.iter().enumerate().map(at)), &tooltip);
            let middle = tenth(y - 4.0);
            sheet.curve(colours::series(n), DASHES[n], &format!("M{} {middle}h32", tenth(left)), &tooltip);
            for (line, class) in [(tooltip.as_str(), "soft"), (&combination.place_of(curve.choice), "soft")] {
                for words in lines(line, (right - left - 40.0) / SMALL) {
                    sheet.words(class, [left + 40.0, y], &words);
                    y += 14.0;
                }
            }
            y += 4.0;
        }
        let extent = super::SceneRange { name: name.clone(), moments: moments.clone(), scene: Some(scene) };
        let bounds = extent.bounds(results, region, score);
        sheet.words("soft", [left, y + 2.0], &format!("mean over the snapshots: {bounds}"));
        end = end.max(y + 6.0);
    }
    sheet.y = end;
    Ok((caption + ".", finish(sheet)))
}

/// The curves of a score: for a single series its best three by the mean, else the best of each; and the best by the
/// worst snapshot, if different.
fn curves(
    results: &Results,
    part: &SweepPart,
    (scene, region, score): (usize, usize, Score),
) -> Result<Vec<ScoreCurve>> {
    let each = if part.series.len() == 1 { 3 } else { 1 };
    let (mut by_mean, mut by_worst) = (Vec::new(), Vec::new());
    for &series in &part.series {
        let values = series.summarize(results, &results.scenes[scene].moments, region, score)?;
        let f1 = series.f1_means(results, &results.scenes[scene].moments, region)?;
        let best = |of: fn(&Over) -> f64| rank(score, values.iter().map(|over| over.as_ref().map(of)), &f1);
        by_mean.extend(
            best(|over| over.mean).into_iter().take(each).map(|(choice, value)| (series, choice, value)),
        );
        by_worst.extend(best(|over| over.worst).first().map(|&(choice, value)| (series, choice, value)));
    }
    let sort = |all: &mut Vec<(Series, usize, f64)>| {
        all.sort_by(|a, b| score.merit(b.2).total_cmp(&score.merit(a.2)));
    };
    sort(&mut by_mean);
    sort(&mut by_worst);
    by_mean.truncate(MOST - 1);
    let number = |n: usize| if n == 0 { "best by mean".into() } else { format!("number {} by mean", n + 1) };
    let mut curves: Vec<ScoreCurve> = by_mean
        .iter()
        .enumerate()
        .map(|(n, &(series, choice, _))| ScoreCurve { series, choice, rank: number(n) })
        .collect();
    if let Some(&(series, choice, _)) = by_worst.first() {
        match curves.iter_mut().find(|known| (known.series, known.choice) == (series, choice)) {
            Some(known) => known.rank += ", best by the worst snapshot",
            None => curves.push(ScoreCurve { series, choice, rank: "best by the worst snapshot".into() }),
        }
    }
    Ok(curves)
}

/// A polyline, broken at missing values.
fn path(places: impl Iterator<Item = Option<(usize, f64, f64)>>) -> String {
    let (mut path, mut last) = (String::new(), None);
    for (step, x, y) in places.flatten() {
        let follows = step > 0 && last == Some(step - 1);
        path += &format!("{}{x} {y}", if follows { "L" } else { "M" });
        last = Some(step);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_broken_where_there_is_no_value() {
        let places = [Some((0, 1.0, 2.0)), Some((1, 2.0, 2.5)), None, Some((3, 4.0, 1.0))];
        assert_eq!(path(places.into_iter()), "M1 2L2 2.5M4 1");
    }
}
