//! The section on mounts.

use maud::{Markup, html};

use crate::report::page::Findings;
use crate::report::page::leaders::{Leader, leaders};
use crate::report::page::mount::{MountSheet, explain_sheets, sheets};

/// The mounting sheets of the recommended choice, and of the best placements by each score.
pub(super) struct Whereabouts<'a> {
    sheets: Vec<MountSheet>,
    of_leaders: Vec<(Leader<'a>, Vec<MountSheet>)>,
}

impl<'a> Whereabouts<'a> {
    pub(super) fn new(findings: &Findings<'a>) -> Whereabouts<'a> {
        let Findings { sweep, rankings, surroundings, .. } = findings;
        let sheets_of =
            |combination, choice| sheets((sweep.study, sweep.worlds), surroundings, combination, choice);
        let recommended =
            findings.recommended.map(|one| sheets_of(rankings[one.series].series.combination, one.choice));
        let leaders = leaders(sweep.results, rankings).into_iter();
        Whereabouts {
            sheets: recommended.unwrap_or_default(),
            of_leaders: leaders
                .map(|leader| {
                    let sheets = sheets_of(leader.combination, leader.choice);
                    (leader, sheets)
                })
                .collect(),
        }
    }

    /// The section.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #where {
                h2 { "Where exactly?" }
                @if !self.sheets.is_empty() { (explain_sheets()) }
                @for one in &self.sheets { (one.view_with_sketches()) }
                details.aside {
                    summary { "Mounting sheets of the best placements by each score" }
                    @for (leader, sheets) in &self.of_leaders {
                        (leader.title())
                        p { (leader.place) }
                        div.sheets { @for one in sheets { (one.view()) } }
                    }
                }
            }
        }
    }
}
