//! The comparison of all places: maps and a table, drawn by the script; distributions as charts and as tables; scores
//! over time.

mod distribution_chart;
mod time_chart;

use maud::{Markup, html};

use super::{list, score_in_region, scores_in_regions};
use crate::report::page::measure::shown;
use crate::report::page::plain_table::{Titled, plain};
use crate::report::page::ranking::Ranking;
use crate::report::page::score_chart::{ALWAYS, ScoreCharts};
use crate::report::page::{Findings, ReportedSweep};
use crate::report::quartiles::row;
use crate::report::table::Table;
use distribution_chart::distribution_chart;
use perirobot_march::metrics::Score;
use time_chart::{TimeChart, time_charts};

/// The facts on all places.
pub(super) struct Compare {
    distributions: Vec<Titled>,
    charts: ScoreCharts,
    /// Charts of moving scenes.
    times: Vec<TimeChart>,
    /// Whether positions are those of sets of sensors.
    has_maxima: bool,
    /// Whether each sensor has a single place, so that there is nothing to select.
    is_fixed: bool,
}

impl Compare {
    pub(super) fn new(findings: &Findings, has_maxima: bool) -> Compare {
        let Findings { sweep, rankings, .. } = findings;
        let results = sweep.results;
        Compare {
            distributions: if sweep.has_fixed_poses() { Vec::new() } else { distributions(sweep, rankings) },
            charts: ScoreCharts {
                place: "distributions",
                charts: scores_in_regions(sweep)
                    .map(|part| distribution_chart(results, rankings, part))
                    .collect(),
                first: &ALWAYS,
            },
            times: time_charts(findings),
            has_maxima,
            is_fixed: sweep.has_fixed_poses(),
        }
    }

    /// Charts that are not shown initially.
    pub(super) fn other_charts(&self) -> Markup {
        self.charts.others()
    }

    /// The section; the script draws the maps and the table of the poses.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #compare {
                h2 { @if self.is_fixed { "How do all sets compare?" } @else { "How do all places compare?" } }
                p #selected role="status" aria-live="polite" {}
                @if !self.is_fixed {
                    p.hint {
                        "Each position shows its best orientation"
                        @if self.has_maxima { " (and the best poses of the other sensors)" }
                        ". Click on one, or take it from the table below, to select its pose everywhere."
                    }
                    p #map-note.note hidden {}
                    div #maps.plots {}
                    div #positions.plot.tall {}
                }
                @if !self.times.is_empty() {
                    h3 { "Score over time" }
                    div #times.plots { @for chart in &self.times { (chart.view()) } }
                }
                (self.view_scores())
                @if !self.is_fixed {
                    h3 #poses { "Poses" }
                    p #table-note {}
                    div.wide.cards tabindex="0" role="group" aria-label="Table of the poses" { table #table {} }
                    p { button #more type="button" { "Show more" } }
                }
            }
        }
    }

    fn view_scores(&self) -> Markup {
        html! {
            h3 #scores { @if self.is_fixed { "Scores of all sets" } @else { "Scores of all poses" } }
            p {
                @if self.is_fixed {
                    "A row is a set, its stroke the score; the diamond is the selected set."
                } @else {
                    "A row shows all choices of poses of one way to sense in a scene: each as a stroke, or of many how many \
                     there are where; below them the box is their middle half, the thick stroke in it the median, and thin \
                     lines end at the least and the largest. The diamond is the selected choice."
                }
                " The solid line across is what all positions of the study together could reach, the dashed one the best \
                 answer that needs no sensor."
            }
            form.controls aria-label="Which score is shown" { (list("measure-of-distributions", "Score")) }
            (self.charts.view())
            @if !self.distributions.is_empty() {
                details.aside {
                    summary { "The same as tables" }
                    @for table in &self.distributions { (plain(table)) }
                }
            }
        }
    }
}

fn distributions(sweep: &ReportedSweep, rankings: &[Ranking]) -> Vec<Titled> {
    let results = sweep.results;
    let table = |(region, score): (usize, Score)| {
        let mut table = Table::new(&[
            "<scene",
            "<sensors · representation",
            "poses",
            "min",
            "lower quartile",
            "median",
            "upper quartile",
            "max",
        ]);
        for (number, scene) in results.scenes.iter().enumerate() {
            for ranking in rankings {
                let found = ranking.spread(region, number, score).map(|spread| spread.distribution);
                table.row(row(results, scene, ranking.series, found, |value| shown(score, value)));
            }
        }
        (score_in_region(sweep, (region, score)), table)
    };
    scores_in_regions(sweep).map(table).collect()
}
