//! The cheapest set that passes, in a sentence, with its proof or the reasons why there is none.

use maud::{Markup, html};

use crate::report::page::Findings;
use crate::report::purchased::{describe_proof, sentence};
use perirobot_decide::cheapest::ReasonReport;

/// The answer, shown before everything else.
#[derive(Debug)]
pub(super) struct PurchaseAnswer {
    sentence: String,
    proof: String,
    /// Why no set passes.
    reasons: Vec<ReasonReport>,
    /// Whether the study's requirements are unchanged.
    is_current: bool,
}

impl PurchaseAnswer {
    /// `None` for another question.
    pub(super) fn from_findings(findings: &Findings) -> Option<PurchaseAnswer> {
        let report = findings.sweep.purchase?;
        let poses = report.recommended()?.poses();
        let judged = findings.judged.iter().find(|judged| judged.verdicts.poses == poses);
        Some(PurchaseAnswer {
            sentence: sentence(report, judged.map(|judged| &judged.verdicts)),
            proof: describe_proof(report),
            reasons: report.main().reasons.clone(),
            is_current: report.is_current(findings.sweep.study),
        })
    }

    /// The full width of the first screen.
    pub(super) fn view(&self) -> Markup {
        html! {
            div.found {
                p.sentence { (self.sentence) "." }
                @if !self.is_current {
                    p.warning {
                        "The study has other requirements or costs now than when this was found: run "
                        code { "perirobot choose" } " again."
                    }
                }
                @if !self.reasons.is_empty() {
                    ul { @for reason in &self.reasons { li { strong { (reason.requirement) } ": " (reason.why) } } }
                }
                p.note { (self.proof) ". " a href="#money" { "What does more money buy?" } }
            }
        }
    }
}
