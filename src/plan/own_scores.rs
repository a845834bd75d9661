//! What the plan of today scores by each question that *Find* asks, to be drawn beside what is found.

use perirobot_cover::Worth;
use perirobot_march::metrics::{Across, Confusion, Score};
use perirobot_study::input::{Study, Wanted};
use serde::Serialize;

use crate::live::MomentCounts;

/// The scores that *Find* asks for.
const ASKED: [Score; 4] = [Score::HumanSeen, Score::PartsDetected, Score::F1, Score::Kappa];

/// A score of the plan of today.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct OwnScore {
    region: String,
    score: &'static str,
    value: f64,
}

/// The scores of a plan in each region, over its moments as the study's question combines them.
pub(crate) fn own_scores(moments: &[MomentCounts], study: &Study) -> Vec<OwnScore> {
    let over = match &study.choose {
        Some(Wanted::Best(choose)) => choose.over,
        _ => Across::Pooled,
    };
    let mut all = Vec::new();
    for (region, (name, _)) in study.regions.iter().enumerate() {
        let counts: Vec<Confusion> =
            moments.iter().filter_map(|moment| moment.counts.get(region).copied()).collect();
        for score in ASKED {
            let value = Worth::from_counts(score, over, &counts).map(Worth::value);
            let own = |value| OwnScore { region: name.clone(), score: score.name(), value };
            all.extend(value.map(own));
        }
    }
    all
}
