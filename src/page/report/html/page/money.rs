//! What more money buys: sets of sensors by their cost, and combinations by the best that they reach.

use maud::{Markup, html};

use super::tables::plain;
use crate::report::html::facts::Facts;

pub(super) fn section(facts: &Facts) -> Markup {
    html! {
        section #money {
            h2 { "What does more money buy?" }
            @if let Some(front) = &facts.front { (super::front::front(front)) }
            @if !facts.maxima.is_empty() {
                div #combinations {
                    h3 { "Combinations of sensors" }
                    p { "The mean over scenes of the largest score that any choice of poses reaches." }
                    form.controls aria-label="Which score is shown" { (super::list("measure-of-maxima", "Score")) }
                    div #maxima.plots {}
                    details.aside {
                        summary { "The same as tables" }
                        @for table in &facts.maxima { (plain(table)) }
                    }
                }
            }
        }
    }
}
