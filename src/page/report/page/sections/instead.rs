//! The best placements in each region, with the scores of simple baselines, and how to read the scores.

mod meanings;
mod placements;

use maud::{Markup, html};

use super::list;
use crate::report::page::Findings;
use crate::report::page::plain_table::{Titled, plain};
use crate::report::page::question::IN_WORDS;
use crate::report::{PLAIN_MEANS, chosen_sets};
use perirobot_decide::choose::Chosen;
use perirobot_march::Result;
use placements::RegionBest;

/// The recommended choice and its alternatives.
pub(super) struct Instead<'a> {
    regions: Vec<RegionBest<'a>>,
    /// For chosen sets: the best set sensor by sensor, the result of refining, and nearly equal sets.
    sets: Vec<Titled>,
    /// The note on means of snapshots with weights.
    plain_means: Option<&'static str>,
    /// Whether requirements decide, and F1 and answers without a sensor are details.
    has_requirements: bool,
}

impl<'a> Instead<'a> {
    pub(super) fn new(findings: &Findings<'a>) -> Result<Instead<'a>> {
        let results = findings.sweep.results;
        let regions = 0..results.regions.len();
        Ok(Instead {
            regions: regions.map(|region| RegionBest::new(findings, region)).collect::<Result<_>>()?,
            sets: findings.sweep.chosen.map(best_sets).unwrap_or_default(),
            plain_means: results.dwell_s.as_ref().map(|_| PLAIN_MEANS),
            has_requirements: !findings.sweep.study.requirements.is_empty(),
        })
    }

    /// The section; for several regions the script shows the selected one.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #instead {
                h2 { "What is recommended, and what instead?" }
                @if self.regions.len() > 1 {
                    form.controls aria-label="Which region is shown" { (list("region-of-best", "Region")) }
                }
                @if self.has_requirements {
                    p {
                        "The study has requirements, and " a href="#good" { "their verdicts" } " decide, not these scores."
                    }
                    details #scores-of-best {
                        summary { "Best placements by single scores, F1 among them, beside answers without a sensor" }
                        @for region in &self.regions { (region.view()) }
                    }
                } @else {
                    @for region in &self.regions { (region.view()) }
                }
                @if let [best, others @ ..] = &self.sets[..] {
                    (plain(best))
                    @for table @ (title, _) in others { details { summary { (title) } (plain(table)) } }
                }
                details {
                    summary { "How to read these numbers" }
                    (meanings::view(self.plain_means))
                }
            }
        }
    }
}

/// The best set, the refined ones, and nearly equal sets at other places.
fn best_sets(chosen: &Chosen) -> Vec<Titled> {
    let mut sets = Vec::new();
    if let Some(best) = chosen.report.best() {
        let title = format!("The best set: {}", chosen_sets::describe_score(chosen, &IN_WORDS, &best.best));
        sets.push((title, chosen_sets::set(chosen, &IN_WORDS, &best.best)));
    }
    for refined in chosen.report.refined.iter().flatten() {
        if let Some(best) = &refined.best {
            sets.push((
                chosen_sets::refined_words(chosen, &IN_WORDS, refined),
                chosen_sets::set(chosen, &IN_WORDS, best),
            ));
        }
    }
    for tie in &chosen.report.ties {
        let title =
            format!("Nearly as good elsewhere: {}", chosen_sets::describe_score(chosen, &IN_WORDS, tie));
        sets.push((title, chosen_sets::set(chosen, &IN_WORDS, tie)));
    }
    sets
}
