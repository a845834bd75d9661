//! What the page knows of a study: its cell, its sensors with their listed poses, the placed ones, and what is
//! required. `GET /state` sends it as JSON after each edit.

mod scene_file;

use serde::Serialize;

use perirobot_page::letters::letter;
use perirobot_page::render::plan::short_name;
use perirobot_page::viewer::sensor::{FrameData, RaysData, grounds};
use perirobot_scene::objects::Role;
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::RegionShape;
use perirobot_study::input::catalogue::{DeviceModel, models};
use perirobot_study::input::{EntryPlace, RegionSpec, Study, Wanted};
use perirobot_study::sensor::prism::Prism;
use perirobot_study::sensor::turned::Turned;
use perirobot_study::sensor::{Candidate, Cost, SaidOfNoise, Sensor, Setting, Stance};
use perirobot_study::world::World;
use perirobot_study::world::place::{Places, is_room, room_m};

use crate::document::{Corners, SensorShape};
use crate::problem::Problem;
pub use scene_file::{SceneFileAccess, SceneFileState};

/// All that the page is told.
#[derive(Debug, Serialize)]
pub struct State {
    /// Grows with each change; answers to questions carry the version that they are about.
    pub version: u64,
    /// The study's name: that of its file.
    pub name: String,
    /// Its file.
    pub path: String,
    /// Whether the file is never written.
    pub read_only: bool,
    /// Whether the text differs from the file as it was read or saved.
    pub changed: bool,
    /// Whether the last change can be taken back.
    pub can_undo: bool,
    /// Whether a change that was taken back can be made again.
    pub can_redo: bool,
    /// Whether another program has changed the file.
    pub disk_changed: bool,
    /// What is wrong with the text; the cell is then that of the last text that was right, if there was one.
    pub problems: Vec<Problem>,
    /// Which sensor of the plan an edit has changed, if it is still there; only in the answer to that edit.
    pub changed_index: Option<usize>,
    /// Whether it was saved since it was opened.
    pub saved: bool,
    /// Grows when the scenes are voxelized anew.
    pub worlds: u64,
    /// The cell.
    #[serde(flatten)]
    pub cell: CellState,
}

/// A study that was read; empty before any was.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CellState {
    /// Edge of a voxel in metres.
    pub voxel_size_m: f64,
    /// The same while a sensor is dragged.
    pub coarse_m: f64,
    /// The unit of all costs.
    pub currency: Option<String>,
    scenes: Vec<SceneState>,
    /// The files that the scenes are made of.
    scene_files: Vec<SceneFileState>,
    regions: Vec<RegionState>,
    entries: Vec<EntryState>,
    sensors: Vec<SensorState>,
    /// The sensors of the plan, in its order.
    pub placed: Vec<PlacedState>,
    catalogue: Vec<ModelState>,
    requirements: Vec<RequirementState>,
    speeds_m_s: Vec<f64>,
    /// What a set may cost.
    pub budget: Option<f64>,
    /// What the plan costs, if each of its sensors has a cost.
    cost: Option<f64>,
    /// Which costs are list prices of the catalogue, in a sentence.
    list_prices: Option<String>,
    /// Whether there is anything to choose from.
    can_find: bool,
}

#[derive(Clone, Debug, Serialize)]
struct SceneState {
    name: String,
    /// The first of its moments, and the one after its last.
    moments: [usize; 2],
    room_m: [[f64; 3]; 2],
    /// Which of the scene files it is made of.
    file: usize,
    things: Vec<ThingState>,
}

#[derive(Clone, Debug, Serialize)]
struct ThingState {
    name: String,
    /// The whole name, with that of its object before it.
    whole_name: String,
    role: &'static str,
    low_m: [f64; 3],
    high_m: [f64; 3],
}

#[derive(Clone, Debug, Serialize)]
struct RegionState {
    name: String,
    shape: Option<ShapeState>,
}

/// A shape that the page may draw and change.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum ShapeState {
    Box { min_m: [f64; 3], max_m: [f64; 3] },
    Sphere { center_m: [f64; 3], radius_m: f64 },
}

#[derive(Clone, Debug, Serialize)]
struct EntryState {
    name: String,
    min_m: [f64; 3],
    max_m: [f64; 3],
}

#[derive(Clone, Debug, Serialize)]
struct SensorState {
    name: String,
    kind: &'static str,
    /// What one of them costs.
    cost: Option<f64>,
    /// Whether it lies or stands level, with its origin at a corner.
    level: bool,
    /// The link that carries it.
    on: Option<LinkState>,
    /// Whether it takes no poses: the robot itself carries it.
    carried: bool,
    rays: Option<RaysData>,
    grounds: Vec<Vec<[f64; 3]>>,
    poses: Vec<PoseState>,
    /// What it guards, if the study says so in keys that can be edited.
    shape: Option<SensorShape>,
    /// Whether it has one place, which its shape says.
    is_fixed: bool,
}

/// A link of a robot.
#[derive(Clone, Debug, Serialize)]
struct LinkState {
    object: String,
    link: String,
}

#[derive(Clone, Debug, Serialize)]
struct PoseState {
    name: String,
    group: String,
    place: String,
    #[serde(flatten)]
    frame: Option<FrameData>,
    /// Pan, tilt and roll.
    turned_deg: Option<[f64; 3]>,
}

/// A sensor of the plan.
#[derive(Clone, Debug, Serialize)]
pub struct PlacedState {
    /// A for the first, B for the second.
    pub letter: String,
    /// The sensor's name.
    sensor: String,
    /// The pose's name.
    pose: String,
    #[serde(flatten)]
    frame: Option<FrameData>,
    turned_deg: Option<[f64; 3]>,
    /// Where it is, in words.
    place: String,
    cost: Option<f64>,
    /// What is odd about where it is.
    pub problem: Option<String>,
}

/// A device of the catalogue.
#[derive(Clone, Debug, Serialize)]
struct ModelState {
    model: String,
    kind: String,
    words: String,
    cost: Option<f64>,
    /// Whether its noise is unknown and that of the study's sensors is not, or the other way round.
    mixes_noise: bool,
}

#[derive(Clone, Debug, Serialize)]
struct RequirementState {
    name: String,
    r#for: Option<String>,
}

impl CellState {
    /// Of a study with its worlds; `placed` are sensors and poses by their indexes, in the order of the plan.
    pub fn new(study: &Study, worlds: &[World], placed: &[[usize; 2]], coarse_m: f64) -> CellState {
        let places = Places::new(study, &worlds[0]);
        let in_world = |sensor: usize, pose: usize| match worlds[0].settings[sensor][pose] {
            Setting::Pose(pose) => Some(pose),
            _ => None,
        };
        let pose = |sensor: usize, number: usize, one: &Candidate| {
            let pose = in_world(sensor, number);
            PoseState {
                name: one.name.clone(),
                group: one.group.clone(),
                place: places.words(sensor, number),
                turned_deg: pose.as_ref().map(turned_deg),
                frame: pose.as_ref().map(FrameData::new),
            }
        };
        let sensor = |(number, sensor): (usize, &Sensor)| SensorState {
            name: sensor.name.clone(),
            kind: sensor.kind.name(),
            cost: sensor.terms.cost.map(Cost::amount),
            level: sensor.kind.stance() == Stance::Level,
            on: sensor.on.as_ref().map(|on| LinkState { object: on.object.clone(), link: on.link.clone() }),
            carried: !sensor.kind.takes_poses(),
            rays: RaysData::new(study, sensor),
            grounds: grounds(sensor),
            shape: sensor_shape(sensor),
            is_fixed: sensor.on.is_none()
                && sensor.candidates.iter().all(|one| one.setting == Setting::Fixed),
            poses: sensor.candidates.iter().enumerate().map(|(n, one)| pose(number, n, one)).collect(),
        };
        let placed_state = |(number, &[sensor, candidate]): (usize, &[usize; 2])| {
            let spec = &study.sensors[sensor];
            let PoseState { name, frame, turned_deg, place, .. } =
                pose(sensor, candidate, &spec.candidates[candidate]);
            PlacedState {
                letter: letter(number),
                sensor: spec.name.clone(),
                pose: name,
                frame,
                turned_deg,
                place,
                cost: spec.terms.cost.map(Cost::amount),
                problem: None,
            }
        };
        let mut costs = placed.iter().map(|&[sensor, _]| study.sensors[sensor].terms.cost);
        let cost: Option<Cost> = costs.try_fold(Cost::ZERO, |sum, cost| Some(sum.plus(cost?)));
        CellState {
            voxel_size_m: study.voxel_size_m,
            coarse_m,
            currency: study.currency.clone(),
            scenes: scenes(study, worlds),
            scene_files: Vec::new(),
            regions: study.regions.iter().map(region).collect(),
            entries: entries(study),
            sensors: study.sensors.iter().enumerate().map(sensor).collect(),
            placed: placed.iter().enumerate().map(placed_state).collect(),
            catalogue: catalogue(study),
            requirements: requirements(study),
            speeds_m_s: study.stopping.iter().flat_map(|one| &one.speeds).map(|at| at.speed_m_s).collect(),
            budget: budget(study).map(Cost::amount),
            cost: cost.map(Cost::amount),
            list_prices: study.describe_list_prices(),
            can_find: study.sensors.iter().any(|sensor| sensor.candidates.len() > 1),
        }
    }
}

impl CellState {
    /// With the files of its scenes, and for each scene of the study the number of its file.
    #[must_use]
    pub fn with_files(mut self, files: Vec<SceneFileState>, of_scenes: &[usize]) -> CellState {
        self.scenes.iter_mut().zip(of_scenes).for_each(|(scene, file)| scene.file = *file);
        CellState { scene_files: files, ..self }
    }
}

/// Pan, tilt and roll of a pose.
pub(crate) fn turned_deg(pose: &Pose) -> [f64; 3] {
    let Turned { pan_deg, tilt_deg, roll_deg } = Turned::new(pose);
    [pan_deg, tilt_deg, roll_deg]
}

/// The scenes with what stands in them at their first moments.
fn scenes(study: &Study, worlds: &[World]) -> Vec<SceneState> {
    let mut first = 0;
    let of_scenes = worlds.chunk_by(|one, next| one.scene == next.scene);
    let scene = |moments: &[World]| {
        let truth = moments[0].truth();
        let room = room_m(&truth);
        let things =
            truth.objects.iter().filter(|object| !object.voxels.is_empty() && !is_room(object, room));
        let things = things.map(|object| {
            let [low_m, high_m] = object.bounds_m.map(|corner| corner.to_array());
            let role = role_name(object.role);
            ThingState {
                name: short_name(&object.name).into(),
                whole_name: object.name.clone(),
                role,
                low_m,
                high_m,
            }
        });
        let begin = first;
        first += moments.len();
        SceneState {
            name: study.scenes[moments[0].scene].name.clone(),
            moments: [begin, first],
            room_m: room.map(|corner| corner.to_array()),
            file: 0,
            things: things.collect(),
        }
    };
    of_scenes.map(scene).collect()
}

/// A role, as the page names it.
pub fn role_name(role: Role) -> &'static str {
    match role {
        Role::Environment => "environment",
        Role::Robot => "robot",
        Role::Human => "human",
    }
}

/// What a sensor guards, in its own frame.
fn sensor_shape(sensor: &Sensor) -> Option<SensorShape> {
    let corners = |prism: &Prism| -> Option<Corners> {
        let [low, _, high, _] = prism.polygon_m[..] else { return None };
        let [bottom, top] = prism.z_m;
        Some(Corners { min_m: [low.x, low.y, bottom], max_m: [high.x, high.y, top] })
    };
    let guarded = sensor.kind.guarded_m(&Pose::ORIGIN);
    match (sensor.kind.name(), &sensor.kind.prisms()[..]) {
        ("gate", [gate, zone]) => Some(SensorShape::Gate { r#box: corners(gate), zone: corners(zone) }),
        ("pad", [column]) => {
            let [width, depth, _] = corners(column)?.max_m;
            Some(SensorShape::Pad { size_m: [width, depth] })
        }
        // That of a scanner whose axis is not upright is drawn in another plane.
        ("lidar", _) if !guarded.is_empty() && sensor.kind.stance() == Stance::Upright => {
            Some(SensorShape::Field { polygon_m: guarded.iter().map(|at| [at.x, at.y]).collect() })
        }
        _ => None,
    }
}

fn region((name, spec): &(String, RegionSpec)) -> RegionState {
    let shape = match spec {
        RegionSpec::RegionShape(RegionShape::Box { min_m, max_m }) => {
            Some(ShapeState::Box { min_m: min_m.to_array(), max_m: max_m.to_array() })
        }
        RegionSpec::RegionShape(RegionShape::Sphere { center_m, radius_m }) => {
            Some(ShapeState::Sphere { center_m: center_m.to_array(), radius_m: *radius_m })
        }
        _ => None,
    };
    RegionState { name: name.clone(), shape }
}

fn entries(study: &Study) -> Vec<EntryState> {
    let boxes = study.approach.entries.iter().filter_map(|entry| match entry.place {
        EntryPlace::Box { min_m, max_m } => {
            Some(EntryState { name: entry.name.clone(), min_m: min_m.to_array(), max_m: max_m.to_array() })
        }
        EntryPlace::Gate(_) | EntryPlace::Edges => None,
    });
    boxes.collect()
}

fn requirements(study: &Study) -> Vec<RequirementState> {
    let of_one = |one: &perirobot_study::input::Requirement| RequirementState {
        name: one.name.clone(),
        r#for: one.safety_function.clone(),
    };
    study.requirements.iter().map(of_one).collect()
}

fn budget(study: &Study) -> Option<Cost> {
    match study.choose.as_ref()? {
        Wanted::Best(choose) => choose.budget,
        Wanted::Cheapest(purchase) => purchase.budget,
    }
}

/// The devices of the study's own catalogue, then those that ship.
fn catalogue(study: &Study) -> Vec<ModelState> {
    let [has_unknown, has_known] = [SaidOfNoise::Unknown, SaidOfNoise::Model]
        .map(|said| study.sensors.iter().any(|sensor| sensor.noise == said));
    let mixes = |said| match said {
        SaidOfNoise::Unknown => has_known && !has_unknown,
        SaidOfNoise::Model => has_unknown && !has_known,
        SaidOfNoise::Nothing => false,
    };
    let model = |one: &DeviceModel| ModelState {
        mixes_noise: mixes(one.noise()),
        model: one.name.clone(),
        kind: one.kind().into(),
        words: match &one.price {
            Some(price) => format!("{}; list price, to be checked: {}", one.title, price.to_text()),
            None => one.title.clone(),
        },
        cost: one.cost(),
    };
    study.models.iter().chain(models()).map(model).collect()
}
