//! The best placements in each region, beside what simple answers score. How they are mounted is `mount`'s.

use super::mount::{self, Sheet};
use crate::report::html::Sweep;
use crate::report::html::cells::Cells;
use crate::report::html::measure::{self, Baseline, MEASURES};
use crate::report::html::ranking::{Ranking, firsts};
use crate::report::reasons::Explained;
use crate::report::results::SceneResults;
use crate::report::table::number;
use crate::report::{Results, Series};

/// A region's best placements.
#[derive(Debug)]
pub(in crate::report::html) struct Region<'a> {
    pub(in crate::report::html) name: &'a str,
    pub(in crate::report::html) number: usize,
    /// The best choice of each representation by F1, the best of all first.
    pub(in crate::report::html) best: Vec<Row>,
    /// What answers without a sensor score, and the most that any could.
    pub(in crate::report::html) baselines: Vec<(&'static str, [String; MEASURES])>,
    /// How many choices score below the best answer without a sensor, in words.
    pub(in crate::report::html) below: String,
    /// How to mount the first of the best.
    pub(in crate::report::html) sheets: Vec<Sheet>,
    /// What the first of the best misses and why: of each scene's first moment, its name.
    pub(in crate::report::html) missed: Vec<(&'a str, &'a Explained)>,
    /// How much of the region lies outside the grid, in words; empty for nothing.
    pub(in crate::report::html) cut: String,
}

/// A choice of poses and what it scores.
#[derive(Debug)]
pub(in crate::report::html) struct Row {
    pub(in crate::report::html) series: String,
    pub(in crate::report::html) series_number: usize,
    pub(in crate::report::html) choice: usize,
    pub(in crate::report::html) poses: String,
    pub(in crate::report::html) means: [String; MEASURES],
    pub(in crate::report::html) worst_f1: String,
    /// The answers without a sensor that score more, in words; empty for none.
    pub(in crate::report::html) below: String,
}

/// The best of a region.
pub(super) fn region<'a>(
    sweep: &Sweep<'a>,
    rankings: &[Ranking],
    cells: &'a Cells,
    region: usize,
) -> Region<'a> {
    let results = sweep.results;
    let baselines = measure::of_baselines(results, results.moments(), region);
    let firsts = firsts(rankings, region);
    let row = |&(number, (choice, _)): &(usize, (usize, f64))| {
        row(results, (number, rankings[number].series), choice, region, &baselines)
    };
    let cut = sweep.worlds.iter().map(|world| world.regions[region].cut_share).fold(0.0, f64::max);
    Region {
        name: &results.regions[region],
        number: region,
        best: firsts.iter().map(row).collect(),
        sheets: firsts.first().map_or(Vec::new(), |&(number, (choice, _))| {
            mount::sheets(sweep, rankings[number].series.combination, choice)
        }),
        missed: missed(results, cells, region),
        below: below(rankings, region, &baselines),
        baselines: baselines.into_iter().map(|(name, values)| (name, values.map(number))).collect(),
        cut: if cut > 0.0 { format!("{:.1} %", 100.0 * cut) } else { String::new() },
    }
}

fn missed<'a>(results: &'a Results, cells: &'a Cells, region: usize) -> Vec<(&'a str, &'a Explained)> {
    let of_scene = |scene: &'a SceneResults| {
        let there = cells.labels.iter().filter(|labels| labels.moment == scene.moments.start);
        let mut explained = there.flat_map(|labels| &labels.explained);
        Some((scene.name.as_str(), &explained.find(|(of, _)| *of == region)?.1))
    };
    results.scenes.iter().filter_map(of_scene).collect()
}

fn row(
    results: &Results,
    (series_number, series): (usize, Series),
    choice: usize,
    region: usize,
    baselines: &[Baseline],
) -> Row {
    let over = measure::of_choice(results, results.moments(), series.key(choice, region));
    // Of an answer that is always `occupied` all people are seen: only F1 and κ weigh both ways of being wrong.
    let better = (0..2).filter_map(|measure| {
        let (name, to_beat) = measure::to_beat(baselines, measure)?;
        let below = over[measure]?.mean < to_beat;
        below.then(|| format!("{} below “{name}”", measure::ALL[measure].title))
    });
    Row {
        series: series.title(results),
        series_number,
        choice,
        poses: results.combinations[series.combination].label(choice),
        means: over.map(|over| number(over.map(|over| over.mean))),
        worst_f1: number(over[0].map(|over| over.worst)),
        below: better.collect::<Vec<_>>().join(", "),
    }
}

fn below(rankings: &[Ranking], region: usize, baselines: &[Baseline]) -> String {
    let Some((name, to_beat)) = measure::to_beat(baselines, 0) else { return String::new() };
    let all: usize = rankings.iter().map(|ranking| ranking.by_region[region].len()).sum();
    let values = rankings.iter().flat_map(|ranking| &ranking.by_region[region]);
    let below = values.filter(|(_, value)| *value < to_beat).count();
    format!(
        "{below} of {all} choices of poses have a mean F1 below {to_beat:.3}, which a sensor gets that says “{name}” always."
    )
}
