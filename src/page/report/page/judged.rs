//! The choices that `judge` has decided, as its table in the folder says, each with its verdicts.

use super::ReportedSweep;
use super::kept::Kept;
use super::verdicts::{ShownRequirement, of_kept};
use crate::report::series::choice_names;
use perirobot_decide::view::Choice;
use perirobot_decide::view::names::find_choices;
use perirobot_march::Result;
use perirobot_sweep::results::files::REQUIREMENTS;

/// A choice that was judged.
#[derive(Debug)]
pub(super) struct Judged {
    /// Combination, poses and representation, as in the columns of tables.
    pub(super) names: [String; 3],
    /// The same among what was swept; `None` of a set that was not.
    pub(super) choice: Option<Choice>,
    /// Where the verdicts are from.
    pub(super) note: String,
    /// What is required, with its verdicts.
    pub(super) required: Vec<ShownRequirement>,
}

impl Judged {
    /// Whether it meets all that the study requires now.
    pub(super) fn passes(&self) -> bool {
        !self.required.is_empty() && self.required.iter().all(|one| one.verdict() == "PASS")
    }
}

/// All of them, in the order of the table.
///
/// # Errors
/// When the table cannot be read, or is none.
pub(super) fn judged(sweep: &ReportedSweep) -> Result<Vec<Judged>> {
    let table = Kept::read(&sweep.folder.join(REQUIREMENTS))?;
    let mut all: Vec<Judged> = Vec::new();
    for row in table.rows() {
        let names = row.choice();
        if all.iter().any(|known| known.names == names) {
            continue;
        }
        let [own, _] = table.parted(|row| row.is_of(&names));
        let (note, required) = of_kept(sweep, &own);
        all.push(Judged { choice: swept(sweep, &names), names, note, required });
    }
    Ok(all)
}

/// A choice of these names among what was swept.
fn swept(sweep: &ReportedSweep, [combination, poses, representation]: &[String; 3]) -> Option<Choice> {
    let known: Vec<_> = sweep.results.combinations.iter().map(choice_names).collect();
    let (number, choice) = find_choices(&known, poses, Some(combination)).ok()?.pop()?;
    let all = &sweep.results.combinations[number].representations;
    let representation = all.iter().position(|known| known == representation)?;
    Some(Choice { combination: number, choice, representation, repeat: 0 })
}
