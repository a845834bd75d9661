//! The block of signatures at the end: lines to be filled in by hand on paper.

use maud::{Markup, html};

use crate::report::page::ReportedSweep;

/// Those who sign, by what they do.
const SIGNERS: [&str; 3] = ["planned by", "checked by", "accepted by"];

/// What is signed.
pub(super) struct Signed {
    /// The study, the set, and the fingerprint of the results.
    subject: String,
}

impl Signed {
    /// Of a sweep; `set` is the recommended choice.
    pub(super) fn new(sweep: &ReportedSweep, set: Option<&str>) -> Signed {
        let study = sweep.study.path.file_name().unwrap_or_default().to_string_lossy();
        let set = set.map_or(String::new(), |set| format!(", {set}"));
        Signed { subject: format!("{study}{set}, results {}", sweep.manifest.provenance.fingerprint) }
    }

    /// The section.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #signed {
                h2 { "Signatures" }
                p {
                    "For " (self.subject) ". The report is a planning aid: signing it states that its inputs and assumptions were \
                     checked, and validates no cell."
                }
                table.signatures {
                    thead { tr { th {} th { "name" } th { "role" } th { "date" } th { "signature" } } }
                    tbody { @for signer in SIGNERS { tr { th scope="row" { (signer) } td {} td {} td {} td {} } } }
                }
            }
        }
    }
}
