//! The counts of all moments, and the verdicts.

use perirobot_march::metrics::Confusion;
use perirobot_study::input::{Condition, Study};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;
use serde::Serialize;

use super::{CountsReply, ProblemReply, problem_replies};
use crate::live::{JudgeAnswer, MomentCounts};
use crate::own_scores::{OwnScore, own_scores};

/// The answer to `POST /judge`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct JudgeReply {
    n: u64,
    moments: Vec<MomentReply>,
    verdicts: Vec<VerdictReply>,
    cost: Option<f64>,
    budget: Option<f64>,
    nearest: Option<NearestReply>,
    worst: Option<WorstReply>,
    problems: Vec<ProblemReply>,
    disturbed: Vec<DisturbedReply>,
    /// What *Find* compares with.
    scores: Vec<OwnScore>,
}

#[derive(Clone, Debug, Serialize)]
struct MomentReply {
    moment: usize,
    repeat: usize,
    counts: Vec<CountsReply>,
}

fn moment_replies(moments: &[MomentCounts], study: &Study) -> Vec<MomentReply> {
    let counts = |counts: &[Confusion]| {
        let of_regions = counts.iter().zip(&study.regions);
        of_regions.map(|(counts, (name, _))| CountsReply::new(name, counts, &[])).collect()
    };
    let moment = |one: &MomentCounts| MomentReply {
        moment: one.moment,
        repeat: one.repeat,
        counts: counts(&one.counts),
    };
    moments.iter().map(moment).collect()
}

/// The answer to `POST /moments`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MomentsReply {
    n: u64,
    moments: Vec<MomentReply>,
}

impl MomentsReply {
    /// Of counts.
    pub(crate) fn new(n: u64, moments: &[MomentCounts], study: &Study) -> MomentsReply {
        MomentsReply { n, moments: moment_replies(moments, study) }
    }
}

#[derive(Clone, Debug, Serialize)]
struct VerdictReply {
    name: String,
    r#for: Option<String>,
    condition: Condition,
    passes: bool,
    value: Option<f64>,
    limit: f64,
    words: String,
}

#[derive(Clone, Debug, Serialize)]
struct NearestReply {
    distance_m: f64,
    words: String,
}

#[derive(Clone, Debug, Serialize)]
struct WorstReply {
    moment: usize,
    words: String,
}

/// Two sensors that may disturb each other.
#[derive(Clone, Debug, Serialize)]
struct DisturbedReply {
    indexes: [usize; 2],
    words: String,
    /// Whether the study forbids it.
    is_forbidden: bool,
}

/// A moment by its scene and snapshot.
fn moment_title(study: &Study, worlds: &[World], moment: usize) -> String {
    let World { name, snapshot, .. } = &worlds[moment];
    let number = format!("snapshot {snapshot}");
    if study.scenes.len() > 1 { format!("{name}, {number}") } else { number }
}

impl JudgeReply {
    /// Of what was judged.
    pub(crate) fn new(
        n: u64,
        answer: &JudgeAnswer,
        budget: Option<f64>,
        (study, worlds): (&Study, &[World]),
    ) -> JudgeReply {
        let verdict = |one: &crate::live::VerdictLine| VerdictReply {
            name: one.name.clone(),
            r#for: one.safety_function.clone(),
            condition: one.condition,
            passes: one.passes,
            value: one.value,
            limit: one.limit,
            words: one.words.clone(),
        };
        let nearest = answer.nearest.as_ref().map(|one| NearestReply {
            distance_m: one.metres,
            words: format!("{:.2} m: {} by {}", one.metres, one.body, one.entry),
        });
        let worst = answer.worst.as_ref().map(|(moment, words)| WorstReply {
            moment: *moment,
            words: format!("{}: {words}", moment_title(study, worlds, *moment)),
        });
        let disturbed = |one: &crate::live::DisturbingPair| DisturbedReply {
            indexes: one.indexes,
            words: one.words.clone(),
            is_forbidden: one.is_forbidden,
        };
        JudgeReply {
            n,
            moments: moment_replies(&answer.moments, study),
            verdicts: answer.verdicts.iter().map(verdict).collect(),
            cost: answer.cost.map(Cost::amount),
            budget,
            nearest,
            worst,
            problems: problem_replies(&answer.problems),
            disturbed: answer.disturbed.iter().map(disturbed).collect(),
            scores: own_scores(&answer.moments, study),
        }
    }
}
