//! What the page's script knows of a sweep, besides scores and voxels: names, poses, where sensors look, baselines. It is
//! written as JSON; how it is shown is the script's business.

use glam::{DMat3, DQuat, DVec3};
use serde::Serialize;

use super::Sweep;
use super::cells::Cells;
use super::measure::{self, Baseline, Measure};
use super::mounting::{Turned, room_m};
use super::packed::Numbers;
use super::ranking::Ranking;
use super::scores::{self, Scores};
use super::surroundings::{Around, Surroundings, WAYS, key};
use crate::report::distribution::distribution;
use crate::report::maxima::{maxima, most_sensors};
use crate::report::{Results, Score};
use crate::sensor::prism::Prism;
use crate::sensor::{Candidate, Pose, Scale, Sensor, Setting, Stance};
use crate::study::Study;
use crate::sweep::{World, table};

/// Rays that stand for the many of a sensor that is no camera.
const RAYS_SHOWN: usize = 48;

/// For each scene and series: minimum, quartiles and maximum.
type Boxes = Vec<Vec<Option<[f64; 5]>>>;

/// The root of the JSON.
#[derive(Serialize)]
pub(super) struct Data<'a> {
    /// The words of a command line that renders a pose of this sweep, but for what names the pose.
    render: Vec<String>,
    repeats: usize,
    regions: &'a [String],
    scenes: Vec<SceneData<'a>>,
    measures: Vec<MeasureData>,
    sensors: Vec<SensorData<'a>>,
    combinations: Vec<CombinationData<'a>>,
    series: Vec<SeriesData>,
    /// For each region, extent (all scenes, then each), and baseline: its measures.
    baselines: Vec<Vec<Vec<Baseline>>>,
    /// For each region and score F1 and κ.
    distributions: Vec<Vec<Boxes>>,
    /// For each region and score F1 and κ: each combination's mean of the scenes' maxima.
    maxima: Vec<Vec<Vec<Option<f64>>>>,
    /// The combination with the most sensors, if there is one.
    full_set: Option<usize>,
    between_members: &'static str,
    voxel_size_m: f64,
    /// Objects of the first scene, by which what is around a pose is named, and the ways that it is looked for.
    objects: Vec<String>,
    ways: [&'static str; 6],
    cells: &'a Cells,
}

#[derive(Serialize)]
struct SceneData<'a> {
    name: &'a str,
    moments: [usize; 2],
    room_m: [[f64; 3]; 2],
}

#[derive(Serialize)]
struct MeasureData {
    name: &'static str,
    title: &'static str,
    less_is_better: bool,
}

#[derive(Serialize)]
struct SensorData<'a> {
    name: &'a str,
    kind: &'static str,
    /// Whether it lies or stands level, with its origin at a corner.
    level: bool,
    /// The ground below what it watches, in its own frame.
    grounds: Vec<Vec<[f64; 3]>>,
    /// What carries it, and where that is in the world at each moment.
    on: Option<Carrier<'a>>,
    poses: Vec<PoseData<'a>>,
    rays: Option<RaysData>,
}

#[derive(Serialize)]
struct Carrier<'a> {
    object: &'a str,
    link: &'a str,
    frames: Vec<FrameData>,
}

#[derive(Serialize)]
struct FrameData {
    at_m: [f64; 3],
    /// Quaternion x, y, z, w.
    turn: [f64; 4],
}

#[derive(Serialize)]
struct PoseData<'a> {
    name: &'a str,
    group: &'a str,
    #[serde(flatten)]
    frame: Option<FrameData>,
    /// Pan, tilt and roll.
    turned_deg: Option<[f64; 3]>,
    /// How far a cover senses.
    senses_m: Option<f64>,
    /// What is around it; of what is on a link nothing is known.
    around: Option<Around>,
}

/// Some rays of a sensor, in its link frame (x forward, y left, z up).
#[derive(Serialize)]
struct RaysData {
    range_m: [f64; 2],
    /// The corners of a camera's picture, in order around it; else some of all rays.
    directions: Vec<[f64; 3]>,
    is_picture: bool,
}

#[derive(Serialize)]
struct CombinationData<'a> {
    name: &'a str,
    representations: &'a [String],
    members: Vec<MemberData<'a>>,
}

#[derive(Serialize)]
struct MemberData<'a> {
    sensor: usize,
    candidates: &'a [usize],
}

#[derive(Serialize)]
struct SeriesData {
    combination: usize,
    representation: usize,
    title: String,
    scores: Scores,
}

/// The scores for which distributions and maxima are shown, as in the paper.
const OF_THE_PAPER: [Score; 2] = [Score::F1, Score::Kappa];

impl<'a> Data<'a> {
    /// Of a sweep; its scores are added to the numbers.
    pub(super) fn new(
        sweep: &'a Sweep,
        rankings: &[Ranking],
        (cells, surroundings): (&'a Cells, &Surroundings),
        numbers: &mut Numbers,
    ) -> Data<'a> {
        let Sweep { results, study, worlds, .. } = *sweep;
        let regions = || 0..results.regions.len();
        let scores = scores::scores(results, rankings, numbers);
        let series = rankings.iter().zip(scores).map(|(ranking, scores)| SeriesData {
            combination: ranking.series.combination,
            representation: ranking.series.representation,
            title: ranking.series.title(results),
            scores,
        });
        let measures = measure::ALL.map(|Measure { name, title, less_is_better, .. }| MeasureData {
            name,
            title,
            less_is_better,
        });
        let of_paper = |of: &dyn Fn(usize, Score) -> _| {
            regions().map(|region| OF_THE_PAPER.iter().map(|&score| of(region, score)).collect()).collect()
        };
        Data {
            render: render(sweep),
            repeats: results.repeats,
            regions: &results.regions,
            scenes: results.scenes.iter().map(|scene| scene_data(scene, worlds)).collect(),
            measures: measures.into(),
            sensors: (0..study.sensors.len())
                .map(|sensor| sensor_data(study, worlds, surroundings, sensor))
                .collect(),
            combinations: combinations(sweep),
            series: series.collect(),
            baselines: regions().map(|region| baselines(results, region)).collect(),
            distributions: regions()
                .map(|region| {
                    OF_THE_PAPER.map(|score| distributions(results, rankings, region, score)).into()
                })
                .collect(),
            maxima: of_paper(&|region, score| {
                let all = 0..results.combinations.len();
                all.map(|combination| maxima(results, combination, region, score).mean).collect()
            }),
            full_set: most_sensors(results),
            between_members: table::BETWEEN_MEMBERS,
            voxel_size_m: study.voxel_size_m,
            objects: surroundings.objects(),
            ways: WAYS,
            cells,
        }
    }
}

fn render(sweep: &Sweep) -> Vec<String> {
    let Sweep { study, words, .. } = *sweep;
    let size = study.voxel_size_m.to_string();
    let mut render: Vec<String> =
        ["perirobot", "render", &study.path.display().to_string(), "--voxel-size", &size]
            .map(String::from)
            .into();
    render.extend(study.noiseless.then(|| "--noiseless".to_string()));
    render.extend_from_slice(words);
    render
}

fn scene_data<'a>(scene: &'a crate::report::results::SceneResults, worlds: &[World]) -> SceneData<'a> {
    let room = room_m(&worlds[scene.moments.start].truth);
    let moments = [scene.moments.start, scene.moments.end];
    SceneData { name: &scene.name, moments, room_m: room.map(|corner| corner.to_array()) }
}

fn combinations<'a>(sweep: &'a Sweep) -> Vec<CombinationData<'a>> {
    let members = |combination: &'a crate::study::Combination| {
        let all = combination.members.iter();
        all.map(|member| MemberData { sensor: member.sensor, candidates: &member.candidates }).collect()
    };
    let pairs = sweep.results.combinations.iter().zip(&sweep.study.combinations);
    pairs
        .map(|(found, asked)| CombinationData {
            name: &found.name,
            representations: &found.representations,
            members: members(asked),
        })
        .collect()
}

fn baselines(results: &Results, region: usize) -> Vec<Vec<Baseline>> {
    let scenes = results.scenes.iter().map(|scene| scene.moments.clone());
    let extents = [results.moments()].into_iter().chain(scenes);
    extents.map(|moments| measure::of_baselines(results, moments, region)).collect()
}

fn distributions(results: &Results, rankings: &[Ranking], region: usize, score: Score) -> Boxes {
    let of_one = |ranking: &Ranking, scene: &crate::report::results::SceneResults| {
        let values = ranking.series.over(results, &scene.moments, region, score);
        let d = distribution(values.into_iter().flatten().map(|over| over.mean).collect())?;
        Some([d.min, d.lower_quartile, d.median, d.upper_quartile, d.max])
    };
    let scenes = results.scenes.iter();
    scenes.map(|scene| rankings.iter().map(|ranking| of_one(ranking, scene)).collect()).collect()
}

fn sensor_data<'a>(
    study: &'a Study,
    worlds: &[World],
    surroundings: &Surroundings,
    number: usize,
) -> SensorData<'a> {
    let sensor = &study.sensors[number];
    let on = sensor.on.as_ref().map(|link| Carrier {
        object: &link.object,
        link: &link.link,
        frames: worlds.iter().map(|world| carrier(sensor, &world.settings[number])).collect(),
    });
    let pose_of = |candidate: &Candidate| match candidate.setting {
        Setting::Pose(pose) => Some(pose),
        _ => None,
    };
    let places = sensor.candidates.iter().filter_map(pose_of).map(|pose| pose.position_m);
    let around = surroundings.around_all(places.filter(|_| sensor.on.is_none()));
    let poses = sensor.candidates.iter().map(|candidate| {
        let pose = pose_of(candidate);
        let turned = pose.as_ref().map(Turned::of);
        PoseData {
            name: &candidate.name,
            group: &candidate.group,
            frame: pose.as_ref().map(frame_data),
            turned_deg: turned.map(|t| [t.pan_deg, t.tilt_deg, t.roll_deg]),
            senses_m: match candidate.setting {
                Setting::Inflation(metres) => Some(metres),
                _ => None,
            },
            around: pose.and_then(|pose| around.get(&key(pose.position_m)).copied().map(tidy)),
        }
    });
    SensorData {
        name: &sensor.name,
        kind: sensor.kind.name(),
        level: sensor.kind.stance() == Stance::Level,
        grounds: grounds(sensor),
        on,
        poses: poses.collect(),
        rays: rays_data(study, sensor),
    }
}

fn grounds(sensor: &Sensor) -> Vec<Vec<[f64; 3]>> {
    let corners = |prism: &Prism| prism.footprint_m(&Pose::ORIGIN).into_iter().map(DVec3::into).collect();
    sensor.kind.prisms().into_iter().map(corners).collect()
}

/// Metres to a tenth of a millimetre, which no tape tells apart.
fn tidy(around: Around) -> Around {
    around.map(|next| next.map(|(metres, object)| ((metres * 1e4).round() / 1e4, object)))
}

/// Where the link that carries a sensor is, from where its first candidate is on it and in the world.
fn carrier(sensor: &Sensor, in_world: &[Setting]) -> FrameData {
    let (world, own) = (in_world[0].pose(), sensor.candidates[0].setting.pose());
    let rotation = (world.rotation * own.rotation.inverse()).normalize();
    frame_data(&Pose { position_m: world.position_m - rotation * own.position_m, rotation })
}

fn frame_data(pose: &Pose) -> FrameData {
    let DQuat { x, y, z, w } = pose.rotation;
    FrameData { at_m: pose.position_m.to_array(), turn: [x, y, z, w] }
}

fn rays_data(study: &Study, sensor: &Sensor) -> Option<RaysData> {
    let scale = Scale { voxel_size_m: study.voxel_size_m, backdrop: study.backdrop };
    let rays = sensor.kind.rays(&scale)?;
    let link_from_rays: DMat3 = sensor.kind.frame(&Pose::ORIGIN);
    let metres = |q16: u32| f64::from(q16) / 65536.0 * study.voxel_size_m;
    let last = rays.dirs_q15.len().checked_sub(1)?;
    let shown: Vec<usize> = match &rays.image {
        Some(image) => {
            let width = image.size_px[0] as usize;
            vec![0, width - 1, last, last + 1 - width]
        }
        None => (0..RAYS_SHOWN.min(last + 1)).map(|i| i * (last + 1) / RAYS_SHOWN.min(last + 1)).collect(),
    };
    let direction = |&ray: &usize| {
        let along = glam::DVec3::from_array(rays.dirs_q15[ray].map(f64::from)).normalize();
        (link_from_rays * along).to_array().map(|x| (x * 1e6).round() / 1e6)
    };
    Some(RaysData {
        range_m: [metres(rays.gates.range_min_q16), metres(rays.gates.range_max_q16)],
        directions: shown.iter().map(direction).collect(),
        is_picture: rays.image.is_some(),
    })
}
