//! The last output of a sweep: the best choices of poses by each score, with the scores of trivial answers. A study
//! with many combinations or representations gets one line for each instead of a block.

use crate::report::NEAR_SIDE;
use crate::report::series::{Series, series};
use crate::report::table::{NONE, Table, number};
use crate::report::wording::extent;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::over::{Over, summarize};
use perirobot_sweep::results::swept::CombinationResults;

/// Choices per list of a block.
const SHOWN: usize = 3;

/// Most combinations, times representations and regions, with a block.
const MOST_BLOCKS: usize = 4;

/// The printed scores; the tables of `summary` have all.
const SCORES: [Score; 4] = [Score::F1, Score::Kappa, Score::HumanSeen, Score::PartsDetected];

/// The note on tables with a mean of only some values.
pub(super) const FEWER: &str =
    "[n] before a mean: only n of the values exist there, and only they are in it\n";

/// Columns of a block; `seen` is human_seen, `parts` parts_detected.
const HEADER: [&str; 2 + 3 * SCORES.len()] = [
    "<",
    "<",
    "F1: mean",
    "worst",
    "pooled",
    "kappa: mean",
    "worst",
    "pooled",
    "seen: mean",
    "worst",
    "pooled",
    "parts: mean",
    "worst",
    "pooled",
];

/// The best choices over all scenes, snapshots and repeats.
pub fn render(results: &Results) -> Result<String> {
    let series = series(results, 0..results.combinations.len());
    let regions = 0..results.regions.len();
    let mut left_out = false;
    let mut text = String::new();
    if series.len() * regions.len() <= MOST_BLOCKS {
        for one in series {
            for region in regions.clone() {
                text += &block(results, one, region, &mut left_out)?;
            }
        }
    } else {
        for region in regions {
            text += &compact(results, &series, region, &mut left_out)?;
        }
        text += "\n`perirobot summary DIR` on the output folder shows more: distributions, maxima, walls, snapshots\n";
    }
    if left_out {
        text.insert_str(0, &format!("\n{FEWER}"));
    }
    Ok(text + NEAR_SIDE + "\n")
}

/// The best few choices of one combination in one region by each score, and the baselines.
fn block(results: &Results, series: Series, region: usize, left_out: &mut bool) -> Result<String> {
    let choices = results.combinations[series.combination].choices();
    let mut table = Table::new(&HEADER);
    let combination = &results.combinations[series.combination];
    let mut shown: Vec<usize> = Vec::new();
    let mut line = |label: String, name: String, scores: [Option<Over>; SCORES.len()]| {
        let scores = scores.into_iter().flat_map(|over| cells(over, left_out));
        table.row([label, name].into_iter().chain(scores));
    };
    for score in SCORES {
        let best = series.best(results, &results.moments(), region, score)?;
        if best.is_empty() {
            line(format!("best {}", score.title()), "no choice has a value".into(), [None; SCORES.len()]);
        }
        for (rank, &(choice, _)) in best.iter().take(SHOWN).enumerate() {
            let label = if rank == 0 { format!("best {}", score.title()) } else { String::new() };
            shown.push(choice);
            let readings = results.readings(results.moments(), &series.key(choice, region))?;
            line(label, combination.label(choice), SCORES.map(|score| summarize(&readings, score)));
        }
    }
    for b in 0..4 {
        let at = |score| results.baselines_over(results.moments(), region, score)[b];
        line("baseline".into(), at(Score::F1).0.into(), SCORES.map(|score| at(score).1));
    }
    let title = format!("{} · region {}", series.title(results), results.regions[region]);
    let places = places(combination, &mut shown);
    Ok(format!("\n{title}: {choices} choices of poses, {}\n{}{places}", extent(results), table.text()))
}

/// The places of some choices, each once.
fn places(combination: &CombinationResults, choices: &mut Vec<usize>) -> String {
    choices.sort_unstable();
    choices.dedup();
    let mut table = Table::new(&["<pose", "<place"]);
    for &choice in choices.iter() {
        table.row([combination.label(choice), combination.place_of(choice)]);
    }
    if choices.is_empty() { String::new() } else { format!("\n{}", table.text()) }
}

/// A line per combination and representation: its best choice by each score. Baselines by their means.
fn compact(results: &Results, all: &[Series], region: usize, left_out: &mut bool) -> Result<String> {
    let mut text =
        format!("\nRegion {}: the best choice of poses, {}\n", results.regions[region], extent(results));
    for score in SCORES {
        text.push('\n');
        let best = format!("<best {}", score.title());
        let mut table = Table::new(&[&best, "mean", "± std", "worst", "pooled", "<poses", "<place"]);
        for series in all {
            let values = series.summarize(results, &results.moments(), region, score)?;
            let best = series.best(results, &results.moments(), region, score)?;
            let combination = &results.combinations[series.combination];
            let (over, name, place) = match best.first() {
                Some(&(choice, _)) => {
                    (values[choice], combination.label(choice), combination.place_of(choice))
                }
                None => (None, NONE.into(), String::new()),
            };
            let [mean, worst, pooled] = cells(over, left_out);
            let std = number(over.and_then(|over| over.std));
            table.row([series.title(results), mean, std, worst, pooled, name, place]);
        }
        let baselines = results.baselines_over(results.moments(), region, score);
        let each = baselines.map(|(name, over)| format!("{name} {}", number(over.map(|over| over.mean))));
        text += &format!("{}  baselines: {}\n", table.text(), each.join(", "));
    }
    Ok(text)
}

/// Mean, worst and pooled. A mean of only some values is marked.
pub(super) fn cells(over: Option<Over>, left_out: &mut bool) -> [String; 3] {
    let Some(Over { mean, worst, pooled, values, of, .. }) = over else { return [NONE; 3].map(String::from) };
    let fewer = values < of;
    *left_out |= fewer;
    let some = if fewer { format!("[{values}] ") } else { String::new() };
    [format!("{some}{}", number(Some(mean))), number(Some(worst)), number(pooled)]
}
