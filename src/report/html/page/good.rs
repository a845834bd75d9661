//! Whether what is recommended is good enough.

use maud::{Markup, html};

use super::tables::plain;
use crate::report::html::facts::good::Good;

pub(super) fn section(good: &Good) -> Markup {
    html! {
        section #good {
            h2 { "Is it good enough?" }
            @for note in &good.notes { p { (note) } }
            @if !good.required.is_empty() {
                p.overall.(good.verdict()) { "By what the study requires, " (good.overall()) "." }
                ul.verdicts {
                    @for verdict in good.required.iter().flat_map(|one| &one.verdicts) {
                        li.(verdict.verdict) {
                            b { (verdict.verdict) }
                            span { strong { (verdict.name) } " " (verdict.words) }
                        }
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
