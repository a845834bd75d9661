//! What the page asks and is answered, as JSON. Voxels are runs of classes in base64; numbers of sensors are those of the
//! plan.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use perirobot_march::metrics::Confusion;
use perirobot_march::voxel::BitGrid;
use perirobot_page::viewer::runs::put_runs;
use perirobot_scene::pose::Pose;
use perirobot_study::input::{Condition, Study};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;
use serde::{Deserialize, Serialize};

use crate::document::Pose6;
use crate::live::{
    FloorMap, JudgeAnswer, MomentCounts, NOT_COUNTED, PlacedProblem, Resolution, Scenery, ScoreAnswer,
    WhyAnswer,
};
use crate::own_scores::{OwnScore, own_scores};
use crate::state::{role_name, turned_deg};

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

/// The answer to [`ScoreQuestion`].
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ScoreReply {
    n: u64,
    moment: usize,
    voxel: VoxelWord,
    counts: Vec<CountsReply>,
    /// Runs over the voxels of all regions: 0 called free, 1 called occupied, 2 unknown.
    labels: String,
    /// For each column of the grid, x first, how many sensors watch it; 255 if it belongs to no region.
    seen_by: String,
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

fn runs(classes: impl Iterator<Item = usize>, kinds: usize) -> String {
    let mut bytes = Vec::new();
    put_runs(classes, kinds, &mut bytes);
    STANDARD.encode(bytes)
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

/// `GET /cell`: a moment in voxels, x the fastest.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CellAnswer {
    voxel_size_m: f64,
    /// World key of the first voxel.
    origin: [i32; 3],
    size: [u32; 3],
    /// Classes: 0 free, 1 environment, 2 robot, 3 human, 4 of no region.
    truth: String,
    /// For each region, 1 where a voxel belongs to it.
    regions: Vec<String>,
}

impl CellAnswer {
    /// Of a world.
    pub(crate) fn new(world: &World) -> CellAnswer {
        let (truth, grid) = (world.truth(), world.grid);
        let voxels = || BitGrid::full(grid.window());
        let role = |voxel| match () {
            () if truth.ignored.get(voxel) => 4,
            () if !truth.occupied.get(voxel) => 0,
            () if truth.human.get(voxel) => 3,
            () if truth.robot.get(voxel) => 2,
            () => 1,
        };
        let region = |region: &perirobot_scene::truth::Region| {
            runs(voxels().voxels().map(|voxel| region.voxels.get(voxel).into()), 2)
        };
        CellAnswer {
            voxel_size_m: grid.voxel_size_m,
            origin: grid.origin,
            size: grid.size,
            truth: runs(voxels().voxels().map(role), 5),
            regions: world.regions.iter().map(region).collect(),
        }
    }
}

/// `GET /scenery`: the surfaces of a moment.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SceneryReply {
    things: Vec<ThingReply>,
}

#[derive(Clone, Debug, Serialize)]
struct ThingReply {
    name: String,
    role: &'static str,
    /// Corners in metres, one after the other.
    at: Vec<f32>,
    /// Three corners of each triangle.
    faces: Vec<u32>,
    /// Two corners of each sharp edge.
    edges: Vec<u32>,
}

impl SceneryReply {
    /// Of surfaces.
    pub(crate) fn new(scenery: &Scenery) -> SceneryReply {
        let metres = |x: f32| (x * 1e4).round() / 1e4;
        let thing = |one: &crate::live::Thing| ThingReply {
            name: one.name.clone(),
            role: role_name(one.role),
            at: one.corners_m.iter().flatten().map(|&x| metres(x)).collect(),
            faces: one.faces.iter().flatten().copied().collect(),
            edges: one.edges.iter().flatten().copied().collect(),
        };
        SceneryReply { things: scenery.things.iter().map(thing).collect() }
    }
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

/// A moment as the page counts them: from 1, in each scene.
fn moment_title(study: &Study, worlds: &[World], moment: usize) -> String {
    let World { name, snapshot, .. } = &worlds[moment];
    let number = format!("moment {}", snapshot + 1);
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
        JudgeReply {
            n,
            moments: moment_replies(&answer.moments, study),
            verdicts: answer.verdicts.iter().map(verdict).collect(),
            cost: answer.cost.map(Cost::amount),
            budget,
            nearest,
            worst,
            problems: problem_replies(&answer.problems),
            scores: own_scores(&answer.moments, study),
        }
    }
}
