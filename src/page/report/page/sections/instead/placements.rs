//! The best placements in a region: a row for each, its scores as columns.

use maud::{Markup, html};

use crate::report::page::Findings;
use crate::report::page::measure::{self, BESTS, Baseline, shown};
use crate::report::page::ranking::{Ranking, firsts};
use perirobot_march::Result;
use perirobot_march::metrics::{SCORES, Score};

/// The index of a ranking, and a choice of its poses.
type Placement = (usize, usize);

/// A region's best placements.
#[derive(Debug)]
pub(super) struct RegionBest<'a> {
    name: &'a str,
    number: usize,
    /// The names of the scores' columns.
    columns: Vec<String>,
    /// By F1, and by human_seen and parts_detected if there are people.
    best: Vec<Best>,
    /// The scores of baselines without sensors, and the upper bound, in the columns of the rows.
    baselines: Vec<(&'static str, Vec<String>)>,
    /// The number of choices below the best baseline, in words.
    below: String,
}

/// The best by one score, or by several scores with the same winners.
#[derive(Debug)]
struct Best {
    by: String,
    /// The best choice of each representation, best first.
    rows: Vec<BestRow>,
}

/// A choice of poses with its scores.
#[derive(Debug)]
struct BestRow {
    series: String,
    series_number: usize,
    choice: usize,
    poses: String,
    /// The places in words; empty for a chosen set, whose poses have their own table.
    place: String,
    /// In the columns of the scores.
    cells: Vec<String>,
    /// The baselines that score more, in words; empty if none does.
    below: String,
}

/// The scores that have a column for their worst value next to that of their mean: none if there is one moment.
#[derive(Clone, Copy)]
struct Columns {
    has_worst: bool,
}

impl Columns {
    /// For each score the text of its mean, and of its worst value if it has a column.
    fn each<T>(self, mean: impl Fn(Score) -> T, worst: impl Fn(Score) -> T) -> Vec<T> {
        let columns = |score| {
            let second = (self.has_worst && measure::has_worst(score)).then(|| worst(score));
            [Some(mean(score)), second].into_iter().flatten()
        };
        Score::ALL.into_iter().flat_map(columns).collect()
    }
}

impl<'a> RegionBest<'a> {
    /// The best of a region.
    ///
    /// # Errors
    /// Those of a journal that cannot be read.
    pub(super) fn new(findings: &Findings<'a>, region: usize) -> Result<RegionBest<'a>> {
        let (results, rankings) = (findings.sweep.results, findings.rankings);
        let columns = Columns { has_worst: results.moments().len() * results.repeats > 1 };
        let baselines = measure::baseline_measures(results, results.moments(), region);
        let mut groups: Vec<(Vec<String>, Vec<Placement>)> = Vec::new();
        for (best, by) in BESTS.into_iter().enumerate() {
            let own =
                firsts(rankings, region, best).into_iter().map(|(number, (choice, _))| (number, choice));
            let own: Vec<Placement> = own.collect();
            let same = groups.iter_mut().find(|(_, known)| {
                known.len() == own.len() && own.iter().all(|choice| known.contains(choice))
            });
            match same {
                _ if own.is_empty() => {}
                Some((scores, _)) => scores.push(measure::title(by)),
                None => groups.push((vec![measure::title(by)], own)),
            }
        }
        let row = |own: &Placement| row(findings, columns, *own, region, &baselines);
        let best = groups.into_iter().map(|(scores, own)| {
            Ok(Best { by: scores.join(", "), rows: own.iter().map(row).collect::<Result<_>>()? })
        });
        Ok(RegionBest {
            name: &results.regions[region],
            number: region,
            columns: columns.each(measure::title, |score| format!("worst {}", measure::title(score))),
            best: best.collect::<Result<_>>()?,
            below: baselines_note(rankings, region, &baselines),
            baselines: baselines
                .iter()
                .map(|(name, values)| (*name, baseline_cells(columns, values)))
                .collect(),
        })
    }

    /// The table with its notes.
    pub(super) fn view(&self) -> Markup {
        let count = self.columns.len() + 2;
        html! {
            div data-of-region=(self.number) {
                h3 { "Best placements in region “" (self.name) "”" }
                div.wide.cards tabindex="0" role="group" aria-label={ "Best placements in region " (self.name) } {
                    table.best {
                        thead {
                            tr { th { "sensors · representation" } th { "poses" } @for name in &self.columns { th { (name) } } }
                        }
                        @for best in &self.best {
                            tbody.choices {
                                tr.by { th colspan=(count) scope="rowgroup" { "best by " (best.by) } }
                                @for row in &best.rows { (self.view_row(row)) }
                            }
                        }
                        tbody.baselines {
                            tr.by { th colspan=(count) scope="rowgroup" { "answers without a sensor" } }
                            @for (name, values) in &self.baselines {
                                tr { td colspan="2" { (name) } (self.view_cells(values)) }
                            }
                        }
                    }
                }
                p { (self.below) }
            }
        }
    }

    /// A placement; a click on its poses selects it everywhere.
    fn view_row(&self, row: &BestRow) -> Markup {
        html! {
            tr class=[(!row.below.is_empty()).then_some("below")] {
                td data-name="sensors" { (row.series) }
                td {
                    button.choose type="button" data-series=(row.series_number) data-choice=(row.choice)
                        data-region=(self.number) { (row.poses) }
                    @if !row.place.is_empty() { br; (row.place) }
                    @if !row.below.is_empty() { br; span.mark { "▼ " (row.below) } }
                }
                (self.view_cells(&row.cells))
            }
        }
    }

    fn view_cells(&self, cells: &[String]) -> Markup {
        html! { @for (name, cell) in self.columns.iter().zip(cells) { td data-name=(name) { (cell) } } }
    }
}

fn row(
    findings: &Findings,
    columns: Columns,
    (series_number, choice): Placement,
    region: usize,
    baselines: &[Baseline],
) -> Result<BestRow> {
    let results = findings.sweep.results;
    let series = findings.rankings[series_number].series;
    let combination = &results.combinations[series.combination];
    let over = measure::choice_measures(results, results.moments(), series.key(choice, region))?;
    // The baseline `occupied` claims all people: only F1 and κ count both kinds of error.
    let better = (0..2).filter_map(|measure| {
        let (name, to_beat) = measure::to_beat(baselines, measure)?;
        let below = over[measure]?.mean < to_beat;
        below.then(|| format!("{} below “{name}”", measure::title(Score::ALL[measure])))
    });
    let mean = |score: Score| match over[score as usize] {
        // A mean of only some values is marked, as in the tables of `summary`.
        Some(over) if over.values < over.of => format!("[{}] {}", over.values, shown(score, Some(over.mean))),
        over => shown(score, over.map(|over| over.mean)),
    };
    let worst = |score: Score| shown(score, over[score as usize].map(|over| over.worst));
    Ok(BestRow {
        series: series.title(results),
        series_number,
        choice,
        poses: combination.label(choice),
        place: if findings.sweep.chosen.is_some() { String::new() } else { combination.place_of(choice) },
        cells: columns.each(mean, worst),
        below: better.collect::<Vec<_>>().join(", "),
    })
}

/// The scores of a baseline, which has no worst value.
fn baseline_cells(columns: Columns, values: &[Option<f64>; SCORES]) -> Vec<String> {
    columns.each(|score| shown(score, values[score as usize]), |_| String::new())
}

fn baselines_note(rankings: &[Ranking], region: usize, baselines: &[Baseline]) -> String {
    let Some((name, to_beat)) = measure::to_beat(baselines, 0) else { return String::new() };
    let all: usize = rankings.iter().map(|ranking| ranking.choices_by(0)[region].len()).sum();
    let values = rankings.iter().flat_map(|ranking| &ranking.choices_by(0)[region]);
    let below = values.filter(|(_, value)| *value < to_beat).count();
    format!(
        "{below} of {all} choices of poses have a mean F1 below {to_beat:.3}, that of a sensor which always says “{name}” and is \
         useless: one view sees only the near side of objects. κ is the fairer guide; all such answers have 0 there."
    )
}
