//! Refined sets of a proof: nothing is proven of them, but they are allowed, and score what is said.

use std::path::Path;

use super::allowed::{named, not_allowed};
use super::beside::is_written;
use super::counted::recounted;
use super::{VerifyWatch, holds};
use crate::backend::Backend;
use crate::choose::files::{Chosen, PROOF, REFINED};
use crate::choose::told::ToldRefined;
use crate::study::{Choose, Study};
use crate::world::World;
use crate::{Error, Result};

/// Counts the refined sets of a folder again, and says how many.
///
/// # Errors
/// `Error::Input` that names what does not hold; `Error::Stopped` when it is stopped.
pub fn verify_refined(
    folder: &Path,
    study: &Study,
    choose: &Choose,
    recounter: &mut dyn Backend,
    watch: &dyn VerifyWatch,
) -> Result<usize> {
    let Some(chosen) = Chosen::read(folder)? else { return Ok(0) };
    let told = &chosen.told;
    let Some(study) = told.with_poses(study).map_err(|e| e.at(folder))? else {
        is_written(folder, REFINED, chosen.refined())?;
        return Ok(0);
    };
    let worlds = World::prepare_all(&study)?;
    let path = folder.join(PROOF);
    let all = told.refined.iter().flatten().enumerate();
    let mut counted = 0;
    for (number, refined) in all {
        let ToldRefined { at_most, budget, around, score_before, best: Some(best), gain, .. } = refined
        else {
            continue;
        };
        let place = |key: &str| format!("refined[{number}].{key}");
        let wrong = |key: &str, what: &str| Err(Error::input(place(key), what).at(&path));
        let mut steps = told.steps.iter();
        if !steps.any(|step| step.best.poses == *around && step.best.score == *score_before) {
            return wrong("around", "is not the best set of a step");
        }
        if *gain != Some(best.score - score_before) {
            return wrong("gain", "is not the difference of the scores");
        }
        let set = named(&study, &best.poses).map_err(|issue| issue.at(place("best")).at(&path))?;
        if let Some(why) = not_allowed(&study, choose, &worlds, (*at_most, *budget, best), &set) {
            return wrong("best", &why);
        }
        let counts = recounted(&study, choose, &worlds, &[set], recounter, &|| watch.stop())?;
        holds(choose, best, &counts[0], &place("best")).map_err(|issue| issue.at(&path))?;
        counted += 1;
    }
    is_written(folder, REFINED, chosen.refined())?;
    Ok(counted)
}
