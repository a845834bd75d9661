//! How all places compare: maps, distributions and a table, drawn by the script.

use maud::{Markup, html};

use super::tables::plain;
use crate::report::html::facts::Facts;

pub(super) fn section(facts: &Facts) -> Markup {
    html! {
        section #compare {
            h2 { "How do all places compare?" }
            p #selected role="status" aria-live="polite" {}
            div #explore {
                p.hint {
                    "Each position shows its best orientation"
                    @if !facts.maxima.is_empty() { " (and the best poses of the other sensors)" }
                    ". Click on one, or take it from the table below, to select its pose everywhere."
                }
                div #maps.plots {}
                div #positions.plot.tall {}
                @if facts.moves { h3 { "Score over time" } div #times.plot {} }
            }
            div #scores {
                h3 { "Scores of all poses" }
                p {
                    "A row shows all choices of poses of one way to sense in a scene: each as a stroke, or of many how \
                     many there are where; the thick line is their middle half, the black stroke the median, the diamond \
                     the selected choice. The solid line across is what all positions of the study together could reach, \
                     the dashed one the best answer that needs no sensor."
                }
                form.controls aria-label="Which score is shown" { (super::list("measure-of-distributions", "Score")) }
                div #distributions.plots {}
                details.aside {
                    summary { "The same as tables" }
                    @for table in &facts.distributions { (plain(table)) }
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
