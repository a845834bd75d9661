//! The choices in the folder's judge.json, each with its verdicts.

use super::ReportedSweep;
use super::verdicts::{ShownRequirement, current_verdicts};
use crate::report::series::choice_names;
use perirobot_decide::judge::{SetVerdicts, Verdicts};
use perirobot_decide::view::Choice;
use perirobot_decide::view::names::find_choices;
use perirobot_march::Result;

/// A judged choice.
#[derive(Debug)]
pub(super) struct JudgedChoice {
    /// Combination, poses and representation, as in the columns of tables.
    pub(super) names: [String; 3],
    /// Its indices in the sweep; `None` if the set was not swept.
    pub(super) choice: Option<Choice>,
    /// The source of the verdicts.
    pub(super) note: String,
    /// The requirements with their verdicts.
    pub(super) required: Vec<ShownRequirement>,
    /// All verdicts.
    pub(super) verdicts: SetVerdicts,
}

impl JudgedChoice {
    /// Whether it meets all current requirements of the study.
    pub(super) fn passes(&self) -> bool {
        !self.required.is_empty() && self.required.iter().all(|one| one.verdict() == "PASS")
    }
}

/// All judged choices, in the order of the file.
///
/// # Errors
/// Those of [`Verdicts::read`].
pub(super) fn judged_choices(sweep: &ReportedSweep) -> Result<Vec<JudgedChoice>> {
    let sets = Verdicts::read(sweep.folder)?.map_or(Vec::new(), |verdicts| verdicts.sets);
    let of_one = |set: SetVerdicts| {
        let names = set.names().map(String::from);
        let (note, required) = current_verdicts(sweep, &set.requirements);
        JudgedChoice { choice: find_swept(sweep, &names), names, note, required, verdicts: set }
    };
    Ok(sets.into_iter().map(of_one).collect())
}

/// The choice with these names in the sweep.
fn find_swept(sweep: &ReportedSweep, [combination, poses, representation]: &[String; 3]) -> Option<Choice> {
    let known: Vec<_> = sweep.results.combinations.iter().map(choice_names).collect();
    let (number, choice) = find_choices(&known, poses, Some(combination)).ok()?.pop()?;
    let all = &sweep.results.combinations[number].representations;
    let representation = all.iter().position(|known| known == representation)?;
    Some(Choice { combination: number, choice, representation, repeat: 0 })
}
