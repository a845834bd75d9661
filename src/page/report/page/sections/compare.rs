//! How all places compare: maps, distributions and a table, drawn by the script; and the distributions as tables.

use maud::{Markup, html};

use super::{list, score_in_region, scores_in_regions};
use crate::report::page::plain_table::{Titled, plain};
use crate::report::page::ranking::Ranking;
use crate::report::page::{Findings, ReportedSweep};
use crate::report::quartiles::row;
use crate::report::table::Table;
use perirobot_march::metrics::Score;

/// What is told of all places.
pub(super) struct Compare {
    distributions: Vec<Titled>,
    /// Whether a scene moves.
    moves: bool,
    /// Whether positions are of sets of sensors.
    has_maxima: bool,
}

impl Compare {
    pub(super) fn new(findings: &Findings, has_maxima: bool) -> Compare {
        let Findings { sweep, rankings, .. } = findings;
        let results = sweep.results;
        Compare {
            distributions: distributions(sweep, rankings),
            moves: results.moments().len() > results.scenes.len(),
            has_maxima,
        }
    }

    /// The section.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #compare {
                h2 { "How do all places compare?" }
                p #selected role="status" aria-live="polite" {}
                div #explore {
                    p.hint {
                        "Each position shows its best orientation"
                        @if self.has_maxima { " (and the best poses of the other sensors)" }
                        ". Click on one, or take it from the table below, to select its pose everywhere."
                    }
                    div #maps.plots {}
                    div #positions.plot.tall {}
                    @if self.moves { h3 { "Score over time" } div #times.plot {} }
                }
                div #scores {
                    h3 { "Scores of all poses" }
                    p {
                        "A row shows all choices of poses of one way to sense in a scene: each as a stroke, or of many how \
                         many there are where; the thick line is their middle half, the black stroke the median, the diamond \
                         the selected choice. The solid line across is what all positions of the study together could reach, \
                         the dashed one the best answer that needs no sensor."
                    }
                    form.controls aria-label="Which score is shown" { (list("measure-of-distributions", "Score")) }
                    div #distributions.plots {}
                    details.aside {
                        summary { "The same as tables" }
                        @for table in &self.distributions { (plain(table)) }
                    }
                }
                div #poses {
                    h3 { "Poses" }
                    p #table-note {}
                    div.wide.cards tabindex="0" role="group" aria-label="Table of the poses" { table #table {} }
                    p { button #more type="button" { "Show more" } }
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
                table.row(row(results, scene, ranking.series, found));
            }
        }
        (score_in_region(sweep, (region, score)), table)
    };
    scores_in_regions(sweep).map(table).collect()
}
