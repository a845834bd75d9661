//! Presents results: tables for a terminal, the report as a page, and figures for print. Shared modules: the selection
//! of results (`selection`, `series`, `best_choice`), computed values (`maximum`, `bounds`, `quartiles`, `explained`), charts
//! (`charts`, `colours`), places on paper (`unfolded`), and wording (`table`, `apart`, `chosen_sets`, `purchased`,
//! `wording`).

mod apart;
pub mod best_choice;
#[cfg(feature = "report")]
mod bounds;
#[cfg(feature = "report")]
mod charts;
mod chosen_sets;
#[cfg(feature = "report")]
pub(crate) mod colours;
mod explained;
pub use explained::phrase as describe_cause;
#[cfg(feature = "report")]
pub mod figures;
mod maximum;
#[cfg(feature = "report")]
pub mod page;
pub mod purchased;
mod quartiles;
pub mod reasons_file;
mod selection;
mod series;
mod table;
pub mod terminal;
#[cfg(feature = "report")]
mod unfolded;
pub mod wording;

use perirobot_march::metrics::Score;
pub use selection::ReportSelection;

/// The note under tables with an upper bound of human_seen.
const NEAR_SIDE: &str = "Only the near side of a body can be hit: human_seen mostly ends well below 1, while parts_detected can reach it.";

/// The note on unweighted means of snapshots with different durations.
pub const PLAIN_MEANS: &str = "Means count each snapshot once, however long it lasts (dwell_s); weighted means are in scores.csv and in the summary.";

/// The note under the table of a score with an upper bound, if it needs one.
fn bound_note(score: Score) -> String {
    if score == Score::HumanSeen { format!("{NEAR_SIDE}\n") } else { String::new() }
}

#[cfg(test)]
mod tests;
