//! The data of the page's script besides scores and voxels: names, poses, fields of view, baselines. It is written as
//! JSON and compressed into the page.
//!
//! The JSON does not come from a [`Table`](crate::report::table::Table): plots need unrounded numbers, indexed by
//! region, score, scene and series. The page's tables are made in `sections` from the same rows as the tables of
//! `summary`.

mod maps;
mod sensor;

use std::sync::Arc;

use glam::DVec3;
use serde::Serialize;

use super::approaches::{WayData, way_data};
use super::cells::Cells;
use super::measure::{self, Baseline};
use super::score_chart::ALWAYS;
use super::scores::Scores;
use super::surroundings::WAYS;
use super::{Findings, ReportedSweep};
use crate::letters::letter;
use crate::render::plan::short_name;
use maps::{Furnished, round_metres};
use perirobot_march::metrics::Score;
use perirobot_scene::objects::Role;
use perirobot_scene::truth::ObjectVoxels;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_study::world::place::{is_room, room_m};
use perirobot_sweep::results::{Results, columns};
use sensor::{SensorData, sensor_data};

/// The root of the JSON.
#[derive(Serialize)]
pub(super) struct Data<'a> {
    /// The command line that renders a pose of this sweep, without the arguments for the pose.
    render: Vec<String>,
    /// The initial selection.
    recommended: Option<RecommendedData<'a>>,
    repeats: usize,
    regions: &'a [String],
    scenes: Vec<SceneData<'a>>,
    measures: Vec<MeasureData>,
    /// The scores in every comparison.
    always: [usize; ALWAYS.len()],
    sensors: Vec<SensorData<'a>>,
    /// The letters of a set's sensors, in its order.
    letters: Vec<String>,
    combinations: Vec<CombinationData<'a>>,
    series: Vec<SeriesData<'a>>,
    /// For each region, extent (all scenes, then each), and baseline: its measures.
    baselines: Vec<Vec<Vec<Baseline>>>,
    between_members: &'static str,
    voxel_size_m: f64,
    /// Objects of the first scene, which name the surroundings of a pose, and the measured directions.
    objects: Vec<String>,
    ways: [&'static str; 6],
    cells: &'a Cells,
    /// The ways of bodies for the recommended choice.
    approaches: Vec<WayData>,
}

#[derive(Serialize)]
struct RecommendedData<'a> {
    series: usize,
    choice: usize,
    region: usize,
    /// The score of the view, by its index.
    measure: usize,
    /// Its distinction, in words.
    why: &'a str,
    /// Its worst moment and scene; scenes count from 1, after the mean of all.
    moment: usize,
    extent: usize,
}

#[derive(Serialize)]
struct SceneData<'a> {
    name: &'a str,
    moments: [usize; 2],
    room_m: [[f64; 3]; 2],
    /// Round metres along its axes.
    metres: [Vec<String>; 3],
    /// Furniture, doors, robots and people, at the scene's first moment.
    things: Vec<ThingData>,
}

impl SceneData<'_> {
    /// Its room and its objects, to be laid on paper.
    fn furnished(&self) -> Furnished {
        let corners = |thing: &ThingData| [thing.low_m, thing.high_m].map(DVec3::from_array);
        Furnished {
            room_m: self.room_m.map(DVec3::from_array),
            things_m: self.things.iter().map(corners).collect(),
        }
    }
}

#[derive(Serialize)]
struct ThingData {
    name: String,
    role: &'static str,
    low_m: [f64; 3],
    high_m: [f64; 3],
}

#[derive(Serialize)]
struct MeasureData {
    name: &'static str,
    title: String,
    less_is_better: bool,
    /// Whether it is written as percent.
    is_share: bool,
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
    /// The number of equal sensors.
    count: usize,
}

#[derive(Serialize)]
struct SeriesData<'a> {
    combination: usize,
    representation: usize,
    title: String,
    scores: &'a Scores,
}

impl<'a> Data<'a> {
    /// The data of a sweep.
    pub(super) fn new(findings: &'a Findings<'a>) -> Data<'a> {
        let Findings { sweep, rankings, scores, recommended, cells, surroundings, ways, .. } = findings;
        let ReportedSweep { results, study, worlds, .. } = *sweep;
        let regions = || 0..results.regions.len();
        let series = rankings.iter().zip(*scores).map(|(ranking, scores)| SeriesData {
            combination: ranking.series.combination,
            representation: ranking.series.representation,
            title: ranking.series.title(results),
            scores,
        });
        let measures = Score::ALL.map(|score| MeasureData {
            name: score.name(),
            title: measure::title(score),
            less_is_better: score.less_is_better(),
            is_share: measure::is_share(score),
        });
        let scenes: Vec<SceneData> = results.scenes.iter().map(|scene| scene_data(scene, worlds)).collect();
        let furnished: Vec<Furnished> = scenes.iter().map(SceneData::furnished).collect();
        Data {
            render: render(sweep),
            recommended: recommended.map(|one| RecommendedData {
                series: one.series,
                choice: one.choice,
                region: one.region,
                measure: one.score as usize,
                why: &one.why,
                moment: one.moments[one.scene],
                extent: if results.scenes.len() > 1 { one.scene + 1 } else { 0 },
            }),
            repeats: results.repeats,
            regions: &results.regions,
            scenes,
            measures: measures.into(),
            always: ALWAYS.map(|score| score as usize),
            sensors: (0..study.sensors.len())
                .map(|sensor| sensor_data(study, worlds, surroundings, &furnished, sensor))
                .collect(),
            letters: (0..most_members(study)).map(letter).collect(),
            combinations: combinations(sweep),
            series: series.collect(),
            baselines: regions().map(|region| baselines(results, region)).collect(),
            between_members: columns::BETWEEN_MEMBERS,
            voxel_size_m: study.voxel_size_m,
            objects: surroundings.objects(),
            ways: WAYS,
            cells,
            approaches: way_data(ways),
        }
    }
}

fn render(sweep: &ReportedSweep) -> Vec<String> {
    let ReportedSweep { study, words, .. } = *sweep;
    let size = study.voxel_size_m.to_string();
    let mut render: Vec<String> =
        ["perirobot", "render", &study.path.display().to_string(), "--voxel-size", &size]
            .map(String::from)
            .into();
    render.extend(study.noiseless.then(|| "--noiseless".to_string()));
    render.extend_from_slice(words);
    render
}

fn scene_data<'a>(
    scene: &'a perirobot_sweep::results::swept::SceneResults,
    worlds: &[World],
) -> SceneData<'a> {
    let truth = worlds[scene.moments.start].truth();
    let room = room_m(&truth);
    let is_thing = |object: &&Arc<ObjectVoxels>| !object.voxels.is_empty() && !is_room(object, room);
    let thing = |object: &Arc<ObjectVoxels>| {
        let [low_m, high_m] =
            object.bounds_m.map(|corner| corner.to_array().map(|x| (x * 1e3).round() / 1e3));
        let role = match object.role {
            Role::Environment => "environment",
            Role::Robot => "robot",
            Role::Human => "human",
        };
        ThingData { name: short_name(&object.name).into(), role, low_m, high_m }
    };
    let things = truth.objects.iter().filter(is_thing).map(thing).collect();
    let moments = [scene.moments.start, scene.moments.end];
    let room_m = room.map(|corner| corner.to_array());
    let metres = [0, 1, 2].map(|axis| round_metres([room_m[0][axis], room_m[1][axis]], 4.0));
    SceneData { name: &scene.name, moments, room_m, metres, things }
}

fn combinations<'a>(sweep: &'a ReportedSweep) -> Vec<CombinationData<'a>> {
    let members = |combination: &'a perirobot_study::input::Combination| {
        let equal = combination.members.chunk_by(|a, b| a == b);
        let one = |equal: &'a [perirobot_study::input::Member]| MemberData {
            sensor: equal[0].sensor,
            candidates: &equal[0].candidates,
            count: equal.len(),
        };
        equal.map(one).collect()
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
    extents.map(|moments| measure::baseline_measures(results, moments, region)).collect()
}

/// The number of sensors in the largest set.
fn most_members(study: &Study) -> usize {
    study.combinations.iter().map(|combination| combination.members.len()).max().unwrap_or(0)
}
