//! The best choice of poses of a sweep: by the requirements of the study, else by the score that it asks for.

use crate::report::terminal::reasons::leader;
use perirobot_decide::judge::{LeaderScope, leaders};
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_study::input::{Requirement, Study, Wanted};
use perirobot_sweep::results::Results;

/// The score that ranks choices, and its region.
pub(super) struct AskedScore {
    pub(super) region: usize,
    pub(super) score: Score,
    /// Its source.
    pub(super) source: &'static str,
}

impl AskedScore {
    /// That of `[choose]`; else of the first requirement about a score; else body parts, or F1 without people, in the
    /// region where most moments have a value.
    pub(super) fn new(study: &Study, results: &Results) -> AskedScore {
        if let Some(Wanted::Best(choose)) = &study.choose {
            return AskedScore { region: choose.region, score: choose.objective, source: ", from [choose]" };
        }
        if let Some(counted) = study.requirements.iter().find_map(Requirement::counted_score) {
            return AskedScore { region: counted.region, score: counted.score, source: ", from [[require]]" };
        }
        for score in [Score::PartsDetected, Score::F1] {
            let values = |region: usize| {
                results.baselines_over(results.moments(), region, score)[0].1.map_or(0, |over| over.values)
            };
            let regions = 0..results.regions.len();
            // The first of equal ones.
            let most = regions.rev().max_by_key(|&region| values(region));
            if let Some(region) = most.filter(|&region| values(region) > 0) {
                return AskedScore { region, score, source: "" };
            }
        }
        AskedScore { region: 0, score: Score::F1, source: "" }
    }
}

/// The best choice of poses of a study, the same in every command: the one that meets most requirements as planned; without
/// requirements on scores the best by the score that the study asks for. `None` if none has a value.
///
/// # Errors
/// Those of a journal that cannot be read.
pub fn best_choice(study: &Study, results: &Results) -> Result<Option<Choice>> {
    if study.requirements.iter().any(|one| one.counted_score().is_some()) {
        return Ok(leaders(&study.requirements, results, 1, LeaderScope::default())?.pop());
    }
    let AskedScore { region, score, .. } = AskedScore::new(study, results);
    let found = leader(results, region, score)?;
    Ok(found.map(|[combination, choice, representation]| Choice {
        combination,
        choice,
        representation,
        repeat: 0,
    }))
}
