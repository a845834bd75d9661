//! Refined sets of an answer have no proof, but they must be allowed, have the reported scores, and be found again
//! around the same sets.

use std::path::Path;

use super::allowed::{AllowedSets, find_named};
use super::counted::recount;
use super::disturbed::DisturbedPairs;
use super::tables::is_written;
use super::{Claims, holds};
use crate::choose::files::{Chosen, PROOF, REFINED};
use crate::choose::problem_of;
use crate::choose::refine::{Refinement, refine};
use crate::choose::report::RefinedReport;
use crate::json_file::{Difference, first_difference};
use perirobot_cover::{Bound, CandidateEvidence, FrontAnswer, FrontStep, Problem, SetLimits};
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choose, Study};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;

/// Counts the refined sets of a folder again, and returns their number.
///
/// # Errors
/// `Error::Input` that names the wrong claim; `Error::Stopped`.
pub(super) fn verify_refined(
    folder: &Path,
    (study, choose, _): (&Study, &Choose, &[World]),
    recounter: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<usize> {
    let Some(chosen) = Chosen::read(folder)? else { return Ok(0) };
    let report = &chosen.report;
    let Some(study) = report.with_poses(study).map_err(|e| e.with_place(folder))? else {
        is_written(&folder.join(REFINED), chosen.refined_poses().as_deref())?;
        return Ok(0);
    };
    let worlds = World::prepare_all(&study)?;
    let path = folder.join(PROOF);
    let all = report.refined.iter().flatten().enumerate();
    let mut counted = 0;
    for (number, refined) in all {
        let RefinedReport { at_most, budget, around, score_before, best: Some(best), gain, .. } = refined
        else {
            continue;
        };
        let place = |key: &str| format!("refined[{number}].{key}");
        let wrong = |key: &str, what: &str| Err(Error::input(place(key), what).with_place(&path));
        let mut steps = report.steps.iter();
        if !steps.any(|step| step.best.poses == *around && step.best.score == *score_before) {
            return wrong("around", "is not the best set of a step");
        }
        if *gain != Some(best.score - score_before) {
            return wrong("gain", "is not the difference of the scores");
        }
        let set = find_named(&study, &best.poses)
            .map_err(|issue| issue.with_place(place("best")).with_place(&path))?;
        let disturbed = DisturbedPairs::from_items(&set, (&study, &worlds), choose.disturb);
        let allowed = AllowedSets::from_choose(&study, (choose, &disturbed), &worlds);
        if let Some(why) = allowed.not_allowed((*at_most, *budget), best.cost, &set) {
            return wrong("best", &why);
        }
        let counts = recount(&study, choose, &worlds, &[set], recounter, progress)?;
        holds(choose, best, &counts[0], &place("best")).map_err(|issue| issue.with_place(&path))?;
        counted += 1;
    }
    is_written(&folder.join(REFINED), chosen.refined_poses().as_deref())?;
    Ok(counted)
}

/// Searches again around the best sets, and compares the results.
///
/// # Errors
/// `Error::Input` that names the first value that differs; `Error::Stopped`.
pub(super) fn refine_again(
    claims: &Claims,
    asked: (&Study, &Choose, &[World]),
    evidence: &CandidateEvidence,
    (backends, memory_bytes): (&mut dyn BackendFactory, u64),
    progress: &dyn Progress,
) -> Result<()> {
    let (study, choose, worlds) = asked;
    let problem = problem_of(study, choose, worlds, evidence);
    let found = (&problem, &claims.answer(&problem)?, &claims.chosen.report);
    let again = refine(asked, found, memory_bytes, backends, progress)?;
    if !again.complete {
        progress.check_stop()?;
    }
    claims.is_found_again(&again)
}

impl Claims {
    /// The claimed best sets as a search result, from which refining starts.
    ///
    /// # Errors
    /// If one of them misses the requirements.
    fn answer(&self, problem: &Problem) -> Result<FrontAnswer> {
        let report = &self.chosen.report;
        let step = |(number, set): (usize, &Vec<[usize; 2]>)| {
            let step = &report.steps[number];
            let item = |item: &[usize; 2]| problem.evidence.items.iter().position(|known| known == item);
            let items: Option<Vec<usize>> = set.iter().map(item).collect();
            let best = items.and_then(|items| problem.evaluate(&items));
            let best = best.ok_or_else(|| {
                let what = Issue::says("misses the requirements");
                Error::from(
                    what.with_place(format!("steps[{number}].best")).with_place(self.folder.join(PROOF)),
                )
            })?;
            let limits = SetLimits { at_most: step.at_most, budget: step.budget.map(Cost::thousandths) };
            Ok(FrontStep { limits, best: Some(best), bound: Bound::Unknown })
        };
        let steps = self.sets[..report.steps.len()].iter().enumerate().map(step).collect::<Result<_>>()?;
        Ok(FrontAnswer { steps, others: Vec::new(), complete: true })
    }

    /// Compares the result of refining with its repetition.
    ///
    /// # Errors
    /// `Error::Input` that names the first value that differs.
    fn is_found_again(&self, again: &Refinement) -> Result<()> {
        let json =
            |reports: &[RefinedReport]| serde_json::to_value(reports).expect("names and numbers make JSON");
        let own = self.chosen.report.refined.as_deref().unwrap_or_default();
        match first_difference("refined".into(), &json(own), &json(&again.told)) {
            None => Ok(()),
            Some(Difference { place, own, other }) => {
                let what = format!("is {own}, but searched again it is {other}");
                Err(Issue::says(what).with_place(place).with_place(self.folder.join(PROOF)).into())
            }
        }
    }
}
