//! The choices that `judge` has decided, as judge.json in the folder has them, each with its verdicts.

use super::ReportedSweep;
use super::verdicts::{ShownRequirement, current_verdicts};
use crate::report::series::choice_names;
use perirobot_decide::judge::{SetVerdicts, Verdicts};
use perirobot_decide::view::Choice;
use perirobot_decide::view::names::find_choices;
use perirobot_march::Result;

/// A choice that was judged.
#[derive(Debug)]
pub(super) struct JudgedChoice {
    /// Combination, poses and representation, as in the columns of tables.
    pub(super) names: [String; 3],
    /// The same among what was swept; `None` of a set that was not.
    pub(super) choice: Option<Choice>,
    /// Where the verdicts are from.
    pub(super) note: String,
    /// What is required, with its verdicts.
    pub(super) required: Vec<ShownRequirement>,
    /// All that was decided.
    pub(super) verdicts: SetVerdicts,
}

impl JudgedChoice {
    /// Whether it meets all that the study requires now.
    pub(super) fn passes(&self) -> bool {
        !self.required.is_empty() && self.required.iter().all(|one| one.verdict() == "PASS")
    }
}

/// All of them, in the order of the file.
///
/// # Errors
/// Those of [`Verdicts::read`].
pub(super) fn judged_choices(sweep: &ReportedSweep) -> Result<Vec<JudgedChoice>> {
    let sets = Verdicts::read(sweep.folder)?.map_or(Vec::new(), |verdicts| verdicts.sets);
    let of_one = |set: SetVerdicts| {
        let names = set.names().map(String::from);
        let (note, required) = current_verdicts(sweep, &set.requirements);
        JudgedChoice { choice: swept(sweep, &names), names, note, required, verdicts: set }
    };
    Ok(sets.into_iter().map(of_one).collect())
}

/// A choice of these names among what was swept.
fn swept(sweep: &ReportedSweep, [combination, poses, representation]: &[String; 3]) -> Option<Choice> {
    let known: Vec<_> = sweep.results.combinations.iter().map(choice_names).collect();
    let (number, choice) = find_choices(&known, poses, Some(combination)).ok()?.pop()?;
    let all = &sweep.results.combinations[number].representations;
    let representation = all.iter().position(|known| known == representation)?;
    Some(Choice { combination: number, choice, representation, repeat: 0 })
}
