//! The section on cost: sets of sensors by their cost, and combinations by their maxima.

mod cost_plot;
mod maxima_chart;
mod purchase_front;
mod spot;

use maud::{Markup, html};

use super::{list, score_in_region, scores_in_regions};
use crate::report::maximum::{most_sensors, row};
use crate::report::page::measure::shown;
use crate::report::page::plain_table::{Titled, plain};
use crate::report::page::ranking::{Ranking, maxima_of};
use crate::report::page::score_chart::ScoreCharts;
use crate::report::page::{Findings, ReportedSweep};
use crate::report::table::Table;
use cost_plot::CostPlot;
use maxima_chart::maxima_chart;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use purchase_front::ShownPurchase;

/// The alternatives by cost.
pub(super) struct Money<'a> {
    /// The front of chosen sets.
    cost_plot: Option<CostPlot>,
    /// The cheapest sets that pass.
    purchase: Option<ShownPurchase>,
    charts: ScoreCharts,
    maxima: Vec<Titled>,
    /// The reference of the numbers in brackets.
    full: Option<&'a str>,
}

impl<'a> Money<'a> {
    /// `None` if there is only one alternative.
    ///
    /// # Errors
    /// If a journal cannot be read.
    pub(super) fn new(findings: &Findings<'a>) -> Result<Option<Money<'a>>> {
        let Findings { sweep, rankings, .. } = *findings;
        let (results, maxima) = (sweep.results, maxima_tables(&sweep, rankings));
        let parts = scores_in_regions(&sweep).filter(|_| !maxima.is_empty());
        let charts = ScoreCharts {
            place: "maxima",
            charts: parts.map(|part| maxima_chart(results, rankings, part)).collect(),
            first: &[Score::F1],
        };
        let full = most_sensors(results).map(|full| results.combinations[full].name.as_str());
        let cost_plot = sweep.chosen.map(|chosen| CostPlot::new(findings, chosen));
        let purchase = ShownPurchase::from_findings(findings)?;
        let is_empty = cost_plot.is_none() && purchase.is_none() && maxima.is_empty();
        Ok((!is_empty).then_some(Money { cost_plot, purchase, charts, maxima, full }))
    }

    /// Whether combinations are compared.
    pub(super) fn has_maxima(&self) -> bool {
        !self.maxima.is_empty()
    }

    /// Charts that are not shown initially.
    pub(super) fn other_charts(&self) -> Markup {
        self.charts.others()
    }

    /// The section.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #money {
                h2 { "What does more money buy?" }
                @if let Some(plot) = &self.cost_plot { (plot.view()) }
                @if let Some(purchase) = &self.purchase { (purchase.view()) }
                @if !self.maxima.is_empty() {
                    div #combinations {
                        h3 { "Combinations of sensors" }
                        p {
                            "The mean over scenes of the largest score that any choice of poses reaches"
                            @if let Some(full) = self.full { "; in brackets, as a part of that of " (full) }
                            "."
                        }
                        form.controls aria-label="Which score is shown" { (list("measure-of-maxima", "Score")) }
                        (self.charts.view())
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
    // Single sensors are compared in the first table.
    let are_alone = results.combinations.iter().all(|one| one.members.len() < 2);
    // Sets with fixed poses have their scores in the first table.
    if results.combinations.len() < 2 || are_alone || sweep.has_fixed_poses() {
        return Vec::new();
    }
    let full = most_sensors(results);
    let relative =
        full.map_or("relative".into(), |full| format!("relative to {}", results.combinations[full].name));
    let scenes: Vec<String> = results.scenes.iter().map(|scene| format!(">{}", scene.name)).collect();
    let scenes = scenes.iter().map(String::as_str);
    let columns: Vec<&str> = ["<sensors"].into_iter().chain(scenes).chain(["mean", &relative]).collect();
    let table = |part: (usize, Score)| {
        let maxima = |combination| maxima_of(results, rankings, combination, part);
        let of_full = full.and_then(|full| maxima(full).mean);
        let mut table = Table::new(&columns);
        for combination in 0..results.combinations.len() {
            table.row(row(results, &maxima(combination), of_full, |value| shown(part.1, value)));
        }
        (score_in_region(sweep, part), table)
    };
    scores_in_regions(sweep).map(table).collect()
}
