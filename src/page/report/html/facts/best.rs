//! The best placements in each region, beside what simple answers score.

use super::mount::{self, Sheet};
use crate::report::html::ReportedSweep;
use crate::report::html::cells::{Asked, Cells};
use crate::report::html::measure::{self, BESTS, Baseline};
use crate::report::html::ranking::{Ranking, firsts};
use crate::report::html::surroundings::Surroundings;
use crate::report::reasons::Explained;
use crate::report::table::number;
use crate::report::{NEAR_SIDE, Series};
use perirobot_march::Result;
use perirobot_march::metrics::{SCORES, Score};
use perirobot_sweep::results::Results;

/// A region's best placements.
#[derive(Debug)]
pub(crate) struct RegionBest<'a> {
    pub(crate) name: &'a str,
    pub(crate) number: usize,
    /// By F1, and by human_seen and parts_detected where there are people.
    pub(crate) best: Vec<Best<'a>>,
    /// The scores of answers without a sensor, and the upper bound, in the columns of the rows.
    pub(crate) baselines: Vec<(&'static str, Vec<(String, String)>)>,
    /// How many choices score below the best answer without a sensor, in words.
    pub(crate) below: String,
    /// Why the upper bound of human_seen is out of reach.
    pub(crate) near_side: &'static str,
}

/// The best by one score.
#[derive(Debug)]
pub(crate) struct Best<'a> {
    pub(crate) by: String,
    /// The best choice of each representation, the best of all first.
    pub(crate) rows: Vec<BestRow>,
    /// How to mount the first.
    pub(crate) sheets: Vec<Sheet>,
    /// What the first misses and why, at the worst moment of each scene, in words.
    pub(crate) missed: Vec<(String, &'a Explained)>,
}

/// A choice of poses and what it scores.
#[derive(Debug)]
pub(crate) struct BestRow {
    pub(crate) series: String,
    pub(crate) series_number: usize,
    pub(crate) choice: usize,
    pub(crate) poses: String,
    /// Where they are, in words.
    pub(crate) place: String,
    /// For each score its name and its mean; behind it the worst value, if the score is one by which a best is named.
    pub(crate) cells: Vec<(String, String)>,
    /// The answers without a sensor that score more, in words; empty for none.
    pub(crate) below: String,
}

/// The best of a region.
pub(super) fn region<'a>(
    sweep: &ReportedSweep<'a>,
    rankings: &[Ranking],
    (cells, surroundings): (&'a Cells, &Surroundings),
    region: usize,
) -> Result<RegionBest<'a>> {
    let results = sweep.results;
    let baselines = measure::of_baselines(results, results.moments(), region);
    let mut bests = Vec::new();
    for (best, by) in BESTS.into_iter().enumerate() {
        let firsts = firsts(rankings, region, best);
        let Some(&(first, (choice, _))) = firsts.first() else { continue };
        let row = |&(number, (choice, _)): &(usize, (usize, f64))| {
            row(results, (number, rankings[number].series), choice, region, &baselines)
        };
        bests.push(Best {
            by: measure::title(by),
            rows: firsts.iter().map(row).collect::<Result<_>>()?,
            sheets: mount::sheets(sweep, surroundings, rankings[first].series.combination, choice),
            missed: missed(results, cells, Asked::Best { best, region }),
        });
    }
    Ok(RegionBest {
        name: &results.regions[region],
        number: region,
        best: bests,
        below: below(rankings, region, &baselines),
        near_side: NEAR_SIDE,
        baselines: baselines.into_iter().map(|(name, values)| (name, in_columns(&values))).collect(),
    })
}

/// What is explained of a choice that was asked about, scene by scene.
pub(super) fn missed<'a>(results: &Results, cells: &'a Cells, of: Asked) -> Vec<(String, &'a Explained)> {
    let mut missed = Vec::new();
    for scene in &results.scenes {
        let there = cells.labels.iter().filter(|labels| scene.moments.contains(&labels.moment));
        for labels in there {
            let when = match scene.moments.len() {
                1 => String::new(),
                _ => format!(", snapshot {} (its worst)", labels.moment - scene.moments.start),
            };
            let when = if results.repeats > 1 { when + ", first repeat" } else { when };
            let here = labels.explained.iter().filter(|(asked, _)| *asked == of);
            missed.extend(here.map(|(_, explained)| (format!("“{}”{when}", scene.name), explained)));
        }
    }
    missed
}

fn row(
    results: &Results,
    (series_number, series): (usize, Series),
    choice: usize,
    region: usize,
    baselines: &[Baseline],
) -> Result<BestRow> {
    let over = measure::of_choice(results, results.moments(), series.key(choice, region))?;
    // The answer `occupied` everywhere claims all people: only F1 and κ count both kinds of error.
    let better = (0..2).filter_map(|measure| {
        let (name, to_beat) = measure::to_beat(baselines, measure)?;
        let below = over[measure]?.mean < to_beat;
        below.then(|| format!("{} below “{name}”", measure::title(Score::ALL[measure])))
    });
    let cells = over.iter().zip(Score::ALL).flat_map(|(over, score)| {
        let mean = over.map(|over| {
            // A mean of some values only says so, as in the tables of `summary`.
            let part = if over.values < over.of { format!("[{}] ", over.values) } else { String::new() };
            part + &number(Some(over.mean))
        });
        let title = measure::title(score);
        let worst = measure::has_worst(score)
            .then(|| (format!("worst {title}"), number(over.map(|over| over.worst))));
        [Some((title, mean.unwrap_or_else(|| number(None)))), worst].into_iter().flatten()
    });
    Ok(BestRow {
        series: series.title(results),
        series_number,
        choice,
        poses: results.combinations[series.combination].label(choice),
        place: results.combinations[series.combination].place_of(choice),
        cells: cells.collect(),
        below: better.collect::<Vec<_>>().join(", "),
    })
}

/// The scores of an answer without a sensor, which has no worst value of its own.
fn in_columns(values: &[Option<f64>; SCORES]) -> Vec<(String, String)> {
    let each = Score::ALL.into_iter().zip(values).flat_map(|(score, value)| {
        let worst =
            measure::has_worst(score).then(|| (format!("worst {}", measure::title(score)), String::new()));
        [Some((measure::title(score), number(*value))), worst].into_iter().flatten()
    });
    each.collect()
}

fn below(rankings: &[Ranking], region: usize, baselines: &[Baseline]) -> String {
    let Some((name, to_beat)) = measure::to_beat(baselines, 0) else { return String::new() };
    let all: usize = rankings.iter().map(|ranking| ranking.by(0)[region].len()).sum();
    let values = rankings.iter().flat_map(|ranking| &ranking.by(0)[region]);
    let below = values.filter(|(_, value)| *value < to_beat).count();
    format!(
        "{below} of {all} choices of poses have a mean F1 below {to_beat:.3}, that of a sensor which always says “{name}” and is \
         useless: one view sees only the near side of things. κ is the fairer guide; all such answers have 0 there."
    )
}
