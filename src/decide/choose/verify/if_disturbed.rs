//! The best set without the exclusion of disturbing pairs: counted again, and searched again.

use super::allowed::{AllowedSets, find_named, pose_name};
use super::disturbed::DisturbedPairs;
use super::plain::{Plain, Threshold};
use super::{ProofInput, holds, recount};
use crate::choose::report::{DisturbedReport, FrontReport};
use perirobot_march::backend::Backend;
use perirobot_march::metrics::Across;
use perirobot_march::{Error, Result};
use perirobot_study::sensor::Cost;

/// Checks the best set without the exclusion of disturbing pairs, and whether its search was complete.
///
/// # Errors
/// `Error::Input` that names the wrong claim.
pub(super) fn check(report: &FrontReport, given: ProofInput, recounter: &mut dyn Backend) -> Result<()> {
    let ProofInput { study, choose, worlds, disturbed, evidence, progress, .. } = given;
    let wrong = |key: &str, what: String| Err(Error::input(format!("if_disturbed{key}"), what));
    let Some(DisturbedReport { set: best, proven, disturbed: pairs }) = &report.if_disturbed else {
        return match choose.disturb.is_some() && !report.stopped {
            true => wrong("", "is missing".into()),
            false => Ok(()),
        };
    };
    if choose.disturb.is_none() {
        return wrong("", "is present, but [choose] has no disturb".into());
    }
    let set = find_named(study, &best.poses).map_err(|issue| issue.with_place("if_disturbed"))?;
    let allowed = AllowedSets::from_choose(study, (choose, DisturbedPairs::none()), worlds);
    if let Some(why) = allowed.not_allowed((choose.at_most, choose.budget), best.cost, &set) {
        return wrong("", why);
    }
    let mut own = Vec::new();
    for (number, &a) in set.iter().enumerate() {
        let others = set[number + 1..].iter().filter(|&&b| disturbed.has(a, b));
        let hang_there = |b: [usize; 2]| [a, b].iter().all(|pose| choose.always.contains(pose));
        own.extend(others.filter(|&&b| !hang_there(b)).map(|&b| [pose_name(study, a), pose_name(study, b)]));
    }
    if *pairs != own {
        return wrong(".disturbed", format!("is {pairs:?}, but the study has {own:?}"));
    }
    let counts = recount(study, choose, worlds, std::slice::from_ref(&set), recounter, progress)?;
    let exact = holds(choose, best, &counts[0], "if_disturbed").map_err(Error::from)?;
    if !proven {
        return Ok(());
    }
    if exact.map_or(best.score >= 1.0, |(n, d)| n >= d) {
        return Ok(());
    }
    let bar = exact.map_or(Threshold::AboveMean(best.score), Threshold::Above);
    let budget = choose.budget.map(Cost::thousandths);
    let given = ProofInput { disturbed: DisturbedPairs::none(), ..given };
    let plain = Plain { given, at_most: choose.at_most, budget, bar };
    if !given.is_provable() || (choose.over == Across::Mean && !plain.bounds_means()) {
        return wrong(".proven", "has no proof".into());
    }
    match plain.better() {
        None => Ok(()),
        Some(better) => {
            let names: Vec<String> =
                better.iter().map(|&item| pose_name(study, evidence.items[item])).collect();
            wrong("", format!("this set is better: {}", names.join(";")))
        }
    }
}
