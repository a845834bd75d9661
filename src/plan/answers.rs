//! What the page asks and is answered, as JSON. Voxels are runs of classes in base64; numbers of sensors are those of the
//! plan.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use perirobot_march::metrics::Confusion;
use perirobot_page::viewer::runs::put_runs;
use serde::{Deserialize, Serialize};

use crate::document::Pose6;
use crate::live::{PlacedProblem, Resolution, WhyAnswer};

mod cell;
mod judge;
mod score;

pub(crate) use cell::{CellAnswer, SceneryReply};
pub(crate) use judge::{JudgeReply, MomentsReply};
pub(crate) use score::ScoreReply;

/// `POST /score`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ScoreQuestion {
    /// Comes back with the answer.
    #[serde(default)]
    pub(crate) n: u64,
    /// The moment.
    pub(crate) moment: usize,
    /// In which voxels.
    pub(crate) voxel: VoxelWord,
    /// What a person is about to change.
    #[serde(default)]
    pub(crate) r#move: Option<MoveRequest>,
    /// Which sensor is dead.
    #[serde(default)]
    pub(crate) dead: Option<usize>,
}

/// In which voxels something is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum VoxelWord {
    /// In larger ones, while something is dragged.
    Coarse,
    /// In those of the study.
    Fine,
}

impl VoxelWord {
    /// The same for [`crate::live`].
    pub(crate) fn resolution(self) -> Resolution {
        match self {
            VoxelWord::Coarse => Resolution::Coarse,
            VoxelWord::Fine => Resolution::Fine,
        }
    }
}

/// A sensor that is dragged, or about to be added.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MoveRequest {
    /// Which of the plan.
    #[serde(default)]
    pub(crate) index: Option<usize>,
    /// What is added.
    #[serde(default)]
    pub(crate) add: Option<AddedDevice>,
    /// Where.
    pub(crate) at: Pose6,
    /// The listed pose that is there.
    #[serde(default)]
    pub(crate) pose: Option<String>,
}

/// A sensor of the study, or a device of the catalogue.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct AddedDevice {
    /// The sensor's name.
    #[serde(default)]
    pub(crate) sensor: Option<String>,
}

/// What is counted in a region.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CountsReply {
    region: String,
    tp: u64,
    fp: u64,
    r#fn: u64,
    tn: u64,
    uo: u64,
    uf: u64,
    human_seen: Option<f64>,
    people: u64,
    people_detected: u64,
    parts: u64,
    parts_detected: u64,
    parts_missed: Vec<String>,
    seen_twice: Option<f64>,
    f1: Option<f64>,
    kappa: Option<f64>,
    /// What each sensor adds.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    adds: Vec<AddsReply>,
}

/// What a sensor alone knows of a region.
#[derive(Clone, Debug, Serialize)]
struct AddsReply {
    /// Voxels that are unknown without it.
    seen: u64,
    /// Of people's voxels, those that no other sensor hits.
    human_seen: u64,
}

impl CountsReply {
    fn new(region: &str, counts: &Confusion, without: &[&Confusion]) -> CountsReply {
        let unknown = |counts: &Confusion| counts.uo + counts.uf;
        let adds = |less: &&Confusion| AddsReply {
            seen: unknown(less).saturating_sub(unknown(counts)),
            human_seen: counts.detection.hit_human.saturating_sub(less.detection.hit_human),
        };
        let missed = counts.detection.missed_names();
        CountsReply {
            region: region.into(),
            tp: counts.tp,
            fp: counts.fp,
            r#fn: counts.fn_,
            tn: counts.tn,
            uo: counts.uo,
            uf: counts.uf,
            human_seen: counts.human_seen(),
            people: counts.detection.people,
            people_detected: counts.detection.people_detected,
            parts: counts.detection.parts,
            parts_detected: counts.detection.parts_detected,
            parts_missed: missed
                .split('+')
                .filter(|name| !name.is_empty())
                .map(|name| name.replace('_', " "))
                .collect(),
            seen_twice: counts.seen_twice(),
            f1: counts.f1(),
            kappa: counts.kappa(),
            adds: without.iter().map(adds).collect(),
        }
    }
}

/// What is wrong with a placed sensor.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ProblemReply {
    index: usize,
    words: String,
}

fn problem_replies(problems: &[PlacedProblem]) -> Vec<ProblemReply> {
    problems.iter().map(|one| ProblemReply { index: one.index, words: one.words.clone() }).collect()
}

/// The answer to `POST /why`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct WhyReply {
    n: u64,
    object: Option<String>,
    sensors: Vec<SightReply>,
}

#[derive(Clone, Debug, Serialize)]
struct SightReply {
    index: usize,
    sees: bool,
    words: String,
}

impl WhyReply {
    /// Of an answer.
    pub(crate) fn new(n: u64, answer: &WhyAnswer) -> WhyReply {
        let sight = |one: &crate::live::SensorSight| SightReply {
            index: one.index,
            sees: one.sees,
            words: one.words.clone(),
        };
        WhyReply { n, object: answer.object.clone(), sensors: answer.sensors.iter().map(sight).collect() }
    }
}

/// Classes of voxels as runs, in base64.
fn runs(classes: impl Iterator<Item = usize>, kinds: usize) -> String {
    let mut bytes = Vec::new();
    put_runs(classes, kinds, &mut bytes);
    STANDARD.encode(bytes)
}
