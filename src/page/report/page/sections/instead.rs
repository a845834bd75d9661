//! The best placements in each region, beside what simple answers score, and how to read the scores.

mod meanings;

use maud::{Markup, html};

use crate::report::page::Findings;
use crate::report::page::measure::{self, BESTS, Baseline};
use crate::report::page::plain_table::{Titled, plain};
use crate::report::page::ranking::{Ranking, firsts};
use crate::report::series::Series;
use crate::report::table::number;
use crate::report::{NEAR_SIDE, PLAIN_MEANS, chosen_sets};
use perirobot_decide::choose::Chosen;
use perirobot_march::Result;
use perirobot_march::metrics::{SCORES, Score};
use perirobot_sweep::results::Results;

/// The columns of the table of a region: what is placed, then those of its scores.
fn columns() -> Vec<String> {
    let scores = score_columns(&[None; SCORES]).into_iter().map(|(name, _)| name);
    ["sensors · representation", "poses"].map(String::from).into_iter().chain(scores).collect()
}

/// What is recommended, and what instead.
pub(super) struct Instead<'a> {
    regions: Vec<RegionBest<'a>>,
    /// Of sets that were chosen: the best set sensor by sensor, and those that are nearly as good.
    sets: Vec<Titled>,
    /// What is said of means where snapshots have weights.
    plain_means: Option<&'static str>,
}

impl<'a> Instead<'a> {
    pub(super) fn new(findings: &Findings<'a>) -> Result<Instead<'a>> {
        let results = findings.sweep.results;
        let regions = 0..results.regions.len();
        Ok(Instead {
            regions: regions
                .map(|region| best_of_region(results, findings.rankings, region))
                .collect::<Result<_>>()?,
            sets: findings.sweep.chosen.map(best_sets).unwrap_or_default(),
            plain_means: results.dwell_s.as_ref().map(|_| PLAIN_MEANS),
        })
    }

    /// The section.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #instead {
                h2 { "What is recommended, and what instead?" }
                @for region in &self.regions {
                    h3 { "Best placements in region “" (region.name) "”" }
                    (best(region))
                }
                @for table in &self.sets { (plain(table)) }
                details {
                    summary { "How to read these numbers" }
                    (meanings::view(self.plain_means))
                }
            }
        }
    }
}

/// A region's best placements.
#[derive(Debug)]
struct RegionBest<'a> {
    name: &'a str,
    number: usize,
    /// By F1, and by human_seen and parts_detected where there are people.
    best: Vec<Best>,
    /// The scores of answers without a sensor, and the upper bound, in the columns of the rows.
    baselines: Vec<(&'static str, Vec<(String, String)>)>,
    /// How many choices score below the best answer without a sensor, in words.
    below: String,
    /// Why the upper bound of human_seen is out of reach.
    near_side: &'static str,
}

/// The best by one score.
#[derive(Debug)]
struct Best {
    by: String,
    /// The best choice of each representation, the best of all first.
    rows: Vec<BestRow>,
}

/// A choice of poses and what it scores.
#[derive(Debug)]
struct BestRow {
    series: String,
    series_number: usize,
    choice: usize,
    poses: String,
    /// Where they are, in words.
    place: String,
    /// For each score its name and its mean; behind it the worst value, if the score is one by which a best is named.
    cells: Vec<(String, String)>,
    /// The answers without a sensor that score more, in words; empty for none.
    below: String,
}

/// The best set, what refining found around sets, and sets that are nearly as good elsewhere.
fn best_sets(chosen: &Chosen) -> Vec<Titled> {
    let mut sets = Vec::new();
    if let Some(best) = chosen.report.best() {
        let title = format!("The best set: {}", chosen_sets::describe_score(chosen, &best.best));
        sets.push((title, chosen_sets::set(chosen, &best.best)));
    }
    for refined in chosen.report.refined.iter().flatten() {
        if let Some(best) = &refined.best {
            sets.push((chosen_sets::refined_words(chosen, refined), chosen_sets::set(chosen, best)));
        }
    }
    for tie in &chosen.report.ties {
        let title = format!("Nearly as good elsewhere: {}", chosen_sets::describe_score(chosen, tie));
        sets.push((title, chosen_sets::set(chosen, tie)));
    }
    sets
}

/// The best of a region.
fn best_of_region<'a>(results: &'a Results, rankings: &[Ranking], region: usize) -> Result<RegionBest<'a>> {
    let baselines = measure::baseline_measures(results, results.moments(), region);
    let mut bests = Vec::new();
    for (best, by) in BESTS.into_iter().enumerate() {
        let firsts = firsts(rankings, region, best);
        if firsts.is_empty() {
            continue;
        }
        let row = |&(number, (choice, _)): &(usize, (usize, f64))| {
            row(results, (number, rankings[number].series), choice, region, &baselines)
        };
        bests.push(Best { by: measure::title(by), rows: firsts.iter().map(row).collect::<Result<_>>()? });
    }
    Ok(RegionBest {
        name: &results.regions[region],
        number: region,
        best: bests,
        below: baselines_note(rankings, region, &baselines),
        near_side: NEAR_SIDE,
        baselines: baselines.into_iter().map(|(name, values)| (name, score_columns(&values))).collect(),
    })
}

fn row(
    results: &Results,
    (series_number, series): (usize, Series),
    choice: usize,
    region: usize,
    baselines: &[Baseline],
) -> Result<BestRow> {
    let over = measure::choice_measures(results, results.moments(), series.key(choice, region))?;
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
fn score_columns(values: &[Option<f64>; SCORES]) -> Vec<(String, String)> {
    let each = Score::ALL.into_iter().zip(values).flat_map(|(score, value)| {
        let worst =
            measure::has_worst(score).then(|| (format!("worst {}", measure::title(score)), String::new()));
        [Some((measure::title(score), number(*value))), worst].into_iter().flatten()
    });
    each.collect()
}

fn baselines_note(rankings: &[Ranking], region: usize, baselines: &[Baseline]) -> String {
    let Some((name, to_beat)) = measure::to_beat(baselines, 0) else { return String::new() };
    let all: usize = rankings.iter().map(|ranking| ranking.choices_by(0)[region].len()).sum();
    let values = rankings.iter().flat_map(|ranking| &ranking.choices_by(0)[region]);
    let below = values.filter(|(_, value)| *value < to_beat).count();
    format!(
        "{below} of {all} choices of poses have a mean F1 below {to_beat:.3}, that of a sensor which always says “{name}” and is \
         useless: one view sees only the near side of things. κ is the fairer guide; all such answers have 0 there."
    )
}

fn best(region: &RegionBest) -> Markup {
    let columns = columns();
    html! {
        div.wide.cards tabindex="0" role="group" aria-label={ "Best placements in region " (region.name) } {
            table.best {
                thead { tr { @for name in &columns { th { (name) } } } }
                @for best in &region.best {
                    tbody.choices {
                        tr.by { th colspan=(columns.len()) scope="rowgroup" { "best by " (best.by) } }
                        @for row in &best.rows { (row_of(region, row)) }
                    }
                }
                tbody.baselines {
                    tr.by { th colspan=(columns.len()) scope="rowgroup" { "answers without a sensor" } }
                    @for (name, values) in &region.baselines {
                        tr {
                            td colspan="2" { (name) }
                            @for (title, value) in values { td data-name=(title) { (value) } }
                        }
                    }
                }
            }
        }
        p { (region.below) }
        p { (region.near_side) }
    }
}

/// A placement; to click on its poses selects it everywhere.
fn row_of(region: &RegionBest, row: &BestRow) -> Markup {
    html! {
        tr class=[(!row.below.is_empty()).then_some("below")] {
            td data-name="sensors" { (row.series) }
            td {
                button.choose type="button" data-series=(row.series_number) data-choice=(row.choice)
                    data-region=(region.number) { (row.poses) }
                br;
                (row.place)
                @if !row.below.is_empty() { br; span.mark { "▼ " (row.below) } }
            }
            @for (name, cell) in &row.cells { td data-name=(name) { (cell) } }
        }
    }
}
