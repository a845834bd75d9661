//! The counts of a moment, with what is drawn of them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use perirobot_march::metrics::Confusion;
use perirobot_scene::pose::Pose;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use serde::Serialize;

use super::{CountsReply, ProblemReply, ScoreQuestion, VoxelWord, problem_replies, runs};
use crate::live::{FloorMap, NOT_COUNTED, ScoreAnswer};
use crate::state::turned_deg;

/// The answer to [`ScoreQuestion`].
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ScoreReply {
    n: u64,
    moment: usize,
    voxel: VoxelWord,
    counts: Vec<CountsReply>,
    /// Runs over the voxels of all regions: 0 called free, 1 called occupied, 2 unknown.
    labels: String,
    /// For each column of the grid, x first, how many sensors watch it; 255 if it is not counted.
    seen_by: String,
    /// Above which floor they are counted, in words.
    floor: String,
    frustums: Vec<Option<FrustumReply>>,
    /// Where each sensor is at this moment that a link carries.
    places: Vec<Option<PlaceReply>>,
    problems: Vec<ProblemReply>,
    ms: f64,
}

/// Where the rays of a sensor end.
#[derive(Clone, Debug, Serialize)]
struct FrustumReply {
    from: [f64; 3],
    ends: Vec<[f64; 3]>,
    rows: usize,
    columns: usize,
}

/// Where a sensor is and how it is turned: pan, tilt and roll.
#[derive(Clone, Debug, Serialize)]
struct PlaceReply {
    at_m: [f64; 3],
    turned_deg: [f64; 3],
}

impl ScoreReply {
    /// Of an answer; `without` are the counts without each sensor.
    pub(crate) fn new(
        question: &ScoreQuestion,
        answer: &ScoreAnswer,
        without: &[Vec<Confusion>],
        (study, world): (&Study, &World),
    ) -> ScoreReply {
        let counts = answer.counts.iter().zip(&study.regions).enumerate();
        let counts = counts.map(|(number, (counts, (name, _)))| {
            let less: Vec<&Confusion> = without.iter().map(|all| &all[number]).collect();
            CountsReply::new(name, counts, &less)
        });
        let label = |voxel: [i32; 3]| match () {
            () if answer.labels.occupied.get(voxel) => 1,
            () if answer.labels.free.get(voxel) => 0,
            () => 2,
        };
        let frustum = |one: &Option<std::sync::Arc<crate::live::Frustum>>| {
            one.as_ref().map(|one| FrustumReply {
                from: tidy(one.from_m),
                ends: one.ends_m.iter().map(|&end| tidy(end)).collect(),
                rows: one.rows,
                columns: one.columns,
            })
        };
        ScoreReply {
            n: question.n,
            moment: question.moment,
            voxel: question.voxel,
            counts: counts.collect(),
            labels: runs(world.region_voxels().voxels().map(label), 3),
            seen_by: columns(&answer.floor, world),
            floor: answer.floor.counted.to_string(),
            frustums: answer.frustums.iter().map(frustum).collect(),
            places: Vec::new(),
            problems: problem_replies(&answer.problems),
            ms: (answer.took.as_secs_f64() * 1e4).round() / 10.0,
        }
    }
}

impl ScoreReply {
    /// With the places of sensors that links carry.
    pub(crate) fn with_places(self, places: &[Option<Pose>]) -> ScoreReply {
        let place = |pose: &Option<Pose>| {
            pose.map(|pose| PlaceReply { at_m: pose.position_m.to_array(), turned_deg: turned_deg(&pose) })
        };
        ScoreReply { places: places.iter().map(place).collect(), ..self }
    }
}

/// Metres to a millimetre, as they are drawn only.
fn tidy(at: glam::DVec3) -> [f64; 3] {
    at.to_array().map(|metres| (metres * 1e3).round() / 1e3)
}

/// The map of the floor over the whole grid.
fn columns(floor: &FloorMap, world: &World) -> String {
    let [nx, ny] = [0, 1].map(|axis| world.grid.size[axis] as usize);
    let mut all = vec![NOT_COUNTED; nx * ny];
    let [width, height] = floor.size.map(|n| n as usize);
    let [left, low] = floor.min.map(|n| n.max(0) as usize);
    for y in 0..height {
        let begin = left + nx * (low + y);
        all[begin..begin + width].copy_from_slice(&floor.sensors[width * y..width * (y + 1)]);
    }
    STANDARD.encode(all)
}
