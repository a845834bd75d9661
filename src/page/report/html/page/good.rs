//! Whether what is recommended is good enough.

use maud::{Markup, html};

use super::tables::plain;
use crate::report::html::facts::good::Good;

pub(super) fn section(good: &Good, set: Option<&str>) -> Markup {
    html! {
        section #good {
            h2 { "Is it good enough?" }
            @if let Some(set) = set { p { "The verdicts and tables of this section are of " (set) "." } }
            @for note in &good.notes { p { (note) } }
            @if !good.required.is_empty() {
                p.overall.(good.verdict()) { "By what the study requires, " (good.overall()) "." }
                (verdicts(good))
            }
            @if !good.judged.is_empty() {
                h3 { "All choices that were judged" }
                @for (name, one) in &good.judged {
                    details.judged {
                        summary { b.(one.verdict()) { (one.verdict()) } " " (name) ": " (one.overall()) }
                        (verdicts(one))
                    }
                }
            }
            @for table @ (title, _) in &good.tables { details { summary { (title) } (plain(table)) } }
            @for (name, address) in &good.plans {
                figure.picture { img src=(address) alt=(name); figcaption { (name) } }
            }
            ul { @for (what, command) in &good.commands { li { "To " (what) ": " code { (command) } } } }
        }
    }
}

fn verdicts(good: &Good) -> Markup {
    html! {
        ul.verdicts {
            @for verdict in good.required.iter().flat_map(|one| &one.verdicts) {
                li.(verdict.verdict) {
                    b { (verdict.verdict) }
                    span { strong { (verdict.name) } " " (verdict.words) }
                }
            }
        }
    }
}
