//! What more money buys: sets of sensors by their cost, and combinations by the best that they reach.

mod cost_plot;

use maud::{Markup, html};

use super::{list, score_in_region, scores_in_regions};
use crate::report::maximum::{most_sensors, row};
use crate::report::page::plain_table::{Titled, plain};
use crate::report::page::ranking::{Ranking, maxima_of};
use crate::report::page::{Findings, ReportedSweep};
use crate::report::table::Table;
use cost_plot::CostPlot;
use perirobot_march::metrics::Score;

/// What there is to spend on.
pub(super) struct Money {
    /// Of sets that were chosen.
    cost_plot: Option<CostPlot>,
    maxima: Vec<Titled>,
}

impl Money {
    /// `None` where there is one way to spend.
    pub(super) fn new(findings: &Findings) -> Option<Money> {
        let Findings { sweep, rankings, .. } = findings;
        let money =
            Money { cost_plot: sweep.chosen.map(CostPlot::new), maxima: maxima_tables(sweep, rankings) };
        (money.cost_plot.is_some() || !money.maxima.is_empty()).then_some(money)
    }

    /// Whether combinations are compared.
    pub(super) fn has_maxima(&self) -> bool {
        !self.maxima.is_empty()
    }

    /// The section.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #money {
                h2 { "What does more money buy?" }
                @if let Some(plot) = &self.cost_plot { (plot.view()) }
                @if !self.maxima.is_empty() {
                    div #combinations {
                        h3 { "Combinations of sensors" }
                        p { "The mean over scenes of the largest score that any choice of poses reaches." }
                        form.controls aria-label="Which score is shown" { (list("measure-of-maxima", "Score")) }
                        div #maxima.plots {}
                        details.aside {
                            summary { "The same as tables" }
                            @for table in &self.maxima { (plain(table)) }
                        }
                    }
                }
            }
        }
    }
}

fn maxima_tables(sweep: &ReportedSweep, rankings: &[Ranking]) -> Vec<Titled> {
    let results = sweep.results;
    // Sensors alone are compared in the first table.
    if results.combinations.len() < 2 || results.combinations.iter().all(|c| c.members.len() < 2) {
        return Vec::new();
    }
    let full = most_sensors(results);
    let relative =
        full.map_or("relative".into(), |full| format!("relative to {}", results.combinations[full].name));
    let scenes: Vec<String> = results.scenes.iter().map(|scene| format!(">{}", scene.name)).collect();
    let scenes = scenes.iter().map(String::as_str);
    let columns: Vec<&str> = ["<sensors"].into_iter().chain(scenes).chain(["mean", &relative]).collect();
    let table = |part: (usize, Score)| {
        let of = |combination| maxima_of(results, rankings, combination, part);
        let of_full = full.and_then(|full| of(full).mean);
        let mut table = Table::new(&columns);
        for combination in 0..results.combinations.len() {
            table.row(row(results, &of(combination), of_full));
        }
        (score_in_region(sweep, part), table)
    };
    scores_in_regions(sweep).map(table).collect()
}
