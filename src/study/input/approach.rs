//! `[approach]` of a study, checked: which bodies come in where, and what they must not come near to unnoticed.

use glam::DVec3;
use serde::Deserialize;

use super::RegionSpec;
use crate::diagnostics::{Place, only_one};
use crate::keys::{BoxFile, exactly};
use crate::sensor::Sensor;
use perirobot_march::Result;

/// The largest size of a body, in metres.
const LARGEST_M: f64 = 100.0;
/// A step that is walked unless `step_m` is given, in metres: the highest riser of stairs in workplaces is 24 cm (OSHA, 29
/// CFR 1910.25).
const STEP_M: f64 = 0.25;
/// The largest `step_m`.
const HIGHEST_STEP_M: f64 = 3.0;
/// A higher step is climbed with the hands.
const HIGH_STEP_M: f64 = 1.0;

/// What `perirobot approach` looks for: how near a body can come to the robot unnoticed.
#[derive(Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct ApproachFile {
    /// What a body must not come near to: the robot at each moment, or all that it fills at some moment. Default
    /// "robot".
    hazard: Option<Machine>,
    /// The name of a region that a body must not come near to, in place of the robot.
    region: Option<String>,
    /// Of how many of its voxels must be watched for a body to be noticed. Default 3.
    min_voxels: Option<u32>,
    /// The height of the floor in metres: bodies and people of `[postures]` stand on it, and heights in words are
    /// measured from it. Default: bodies stand at 0; heights are above the largest level surface near the people's feet.
    floor_m: Option<f64>,
    /// "auto": bodies stand on what carries them, at any height: floors, platforms, pits, conveyors. Replaces floor_m.
    floor: Option<FloorFile>,
    /// The highest step that bodies walk up or down with floor = "auto", in metres. Default 0.25.
    step_m: Option<f64>,
    /// The bodies, each by itself. Default: one that is standing.
    #[serde(default)]
    body: Vec<BodyFile>,
    /// Where they come in. Default: every opening of the grid's edge.
    #[serde(default)]
    entry: Vec<EntryFile>,
}

impl ApproachFile {
    /// The height above which all that stands on the floor is; as written, before it is checked.
    pub(super) fn standing_m(&self) -> f64 {
        self.floor_m.unwrap_or(0.0)
    }

    /// Whether bodies stand on what carries them; as written, before it is checked.
    pub(super) fn has_several_floors(&self) -> bool {
        self.floor.is_some()
    }

    /// Whether it asks how near bodies come, and does not only give the floor.
    pub(super) fn asks(&self) -> bool {
        let ApproachFile { hazard, region, min_voxels, floor_m, floor, step_m: _, body, entry } = self;
        let is_empty = hazard.is_none() && region.is_none() && min_voxels.is_none();
        let gives_floor = floor_m.is_some() || floor.is_some();
        !(gives_floor && is_empty && body.is_empty() && entry.is_empty())
    }
}

/// How the floor is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum FloorFile {
    Auto,
}

/// A robot where it is at each moment, or wherever it is at some moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(super) enum Machine {
    #[default]
    Robot,
    RobotSwept,
}

/// A body that moves without turning.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct BodyFile {
    /// Its name in results. Alone it is one of those that are known: "standing", "crawling", "arm", "leg", "finger".
    name: String,
    /// An upright cylinder.
    cylinder: Option<BodyCylinderFile>,
    /// A ball.
    ball: Option<BodyBallFile>,
    /// A box along the axes of the world.
    r#box: Option<CuboidFile>,
    /// Whether it stands on the floor. Default true, but for a ball.
    on_floor: Option<bool>,
    /// Of how many of its voxels must be watched for it to be noticed. Default: as for all.
    min_voxels: Option<u32>,
}

/// An upright cylinder.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct BodyCylinderFile {
    /// In metres, above 0.
    diameter_m: f64,
    /// In metres, above 0.
    height_m: f64,
}

/// A ball.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct BodyBallFile {
    /// In metres, above 0.
    diameter_m: f64,
}

/// A box along the axes of the world.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct CuboidFile {
    /// Along x, y and z, in metres, above 0.
    #[serde(deserialize_with = "exactly")]
    size_m: [f64; 3],
}

/// Where bodies come in: a name and one place.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct EntryFile {
    /// Its name in results.
    name: String,
    /// They begin inside this box of the world.
    r#box: Option<BoxFile>,
    /// They begin beside this light curtain, on the side that its zone does not lie on: the name of a sensor.
    gate: Option<String>,
    /// They begin wherever the grid's edge is free; must be true.
    edges: Option<bool>,
}

/// How near bodies can come unnoticed, and to what.
#[derive(Clone, Debug, PartialEq)]
pub struct Approach {
    /// What they must not come near to.
    pub hazard: Hazard,
    /// The height of the floor, if the study gives it.
    pub floor_m: Option<f64>,
    /// With `floor = "auto"`, the highest step that bodies walk up or down; `None` if the floor has one height.
    pub step_m: Option<f64>,
    /// The bodies in study order.
    pub bodies: Vec<BodySpec>,
    /// Where they come in, in study order.
    pub entries: Vec<EntrySpec>,
}

impl Approach {
    /// The height at which bodies and people of `[postures]` stand.
    pub fn standing_m(&self) -> f64 {
        self.floor_m.unwrap_or(0.0)
    }
}

/// What a body must not come near to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hazard {
    /// The robot, where it is at each moment.
    Robot,
    /// Wherever the robot is at some moment of the scene.
    RobotSwept,
    /// A region, by its index.
    Region(usize),
}

/// A body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySpec {
    /// Its name.
    pub name: String,
    /// What it is.
    pub shape: BodyShape,
    /// Whether it stands on the floor.
    pub on_floor: bool,
    /// Of how many of its voxels must be watched for it to be noticed.
    pub min_voxels: u32,
}

/// The shape of a body, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyShape {
    /// An upright cylinder.
    Cylinder {
        /// Across.
        diameter_m: f64,
        /// How high it is.
        height_m: f64,
    },
    /// A ball.
    Ball {
        /// Across.
        diameter_m: f64,
    },
    /// A box along the axes.
    Box {
        /// Along x, y and z.
        size_m: [f64; 3],
    },
}

/// Where bodies come in.
#[derive(Clone, Debug, PartialEq)]
pub struct EntrySpec {
    /// Its name.
    pub name: String,
    /// Where it is.
    pub place: EntryPlace,
}

/// Where an entry is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EntryPlace {
    /// Inside a box.
    Box {
        /// Lowest corner.
        min_m: DVec3,
        /// Highest corner.
        max_m: DVec3,
    },
    /// Outside a light curtain, by its index among the sensors.
    Gate(usize),
    /// At the edge of the grid.
    Edges,
}

/// The bodies that are known by name, and whether they stand on the floor. A person who crawls turns, so that of
/// one only as much is taken as is there whichever way they face; limbs are as thick as those of detection. None has a reach: arms are for intrusion_m.
const KNOWN: [(&str, BodyShape, bool); 5] = [
    ("standing", BodyShape::Cylinder { diameter_m: 0.4, height_m: 1.8 }, true),
    ("crawling", BodyShape::Cylinder { diameter_m: 0.4, height_m: 0.6 }, true),
    ("arm", BodyShape::Ball { diameter_m: 0.08 }, false),
    ("leg", BodyShape::Cylinder { diameter_m: 0.11, height_m: 0.5 }, true),
    ("finger", BodyShape::Ball { diameter_m: 0.02 }, false),
];

/// What the keys of a study may name.
pub(super) struct ApproachNames<'a> {
    pub(super) regions: &'a [(String, RegionSpec)],
    pub(super) sensors: &'a [Sensor],
}

/// Checks the table; without one, a person who stands comes in wherever the grid's edge is free.
pub(super) fn check(at: &Place, file: Option<ApproachFile>, known: &ApproachNames) -> Result<Approach> {
    let (at, file) = (&at.key("approach"), file.unwrap_or_default());
    let hazard = match (file.hazard, &file.region) {
        (Some(_), Some(_)) => {
            return Err(at.says("both hazard and region").with_advice("give one of them"));
        }
        (None | Some(Machine::Robot), None) => Hazard::Robot,
        (Some(Machine::RobotSwept), None) => Hazard::RobotSwept,
        (None, Some(name)) => {
            let names: Vec<_> = known.regions.iter().map(|(name, _)| name.as_str()).collect();
            let found = names.iter().position(|known| known == name);
            let rule = format!("must be a region of the study: {names:?}");
            Hazard::Region(found.ok_or_else(|| at.wrong("region", format!("{name:?}"), &rule))?)
        }
    };
    let min_voxels = at_least_one(at, file.min_voxels.unwrap_or(3))?;
    let rule = "a height in metres from -1000 to 1000";
    let floor_m = file.floor_m.map(|z_m| at.number("floor_m", z_m, -1e3..=1e3, rule)).transpose()?;
    let step_m = step_m(at, &file)?;
    let bodies = match file.body.is_empty() {
        true => vec![known_body(0, min_voxels)],
        false => file.body.into_iter().map(|body| self::body(at, body, min_voxels)).collect::<Result<_>>()?,
    };
    let entries = match file.entry.is_empty() {
        true => vec![EntrySpec { name: "edges".into(), place: EntryPlace::Edges }],
        false => file.entry.into_iter().map(|entry| self::entry(at, entry, known)).collect::<Result<_>>()?,
    };
    at.unique("body", bodies.iter().map(|body| body.name.as_str()))?;
    at.unique("entry", entries.iter().map(|entry| entry.name.as_str()))?;
    Ok(Approach { hazard, floor_m, step_m, bodies, entries })
}

/// The highest step, with `floor = "auto"`.
fn step_m(at: &Place, file: &ApproachFile) -> Result<Option<f64>> {
    let rule = "a height in metres from 0 to 3";
    match (file.floor, file.floor_m, file.step_m) {
        (Some(FloorFile::Auto), Some(_), _) => {
            let cure = "leave out floor_m: with \"auto\" bodies stand on what carries them";
            Err(at.says("both floor and floor_m").with_advice(cure))
        }
        (None, _, Some(_)) => Err(at.says("step_m without floor").with_advice("add floor = \"auto\"")),
        (None, _, None) => Ok(None),
        (Some(FloorFile::Auto), None, step_m) => {
            at.number("step_m", step_m.unwrap_or(STEP_M), 0.0..=HIGHEST_STEP_M, rule).map(Some)
        }
    }
}

impl Approach {
    /// What its author may not expect of a step.
    pub(super) fn warning(&self) -> Option<String> {
        let step_m = self.step_m.filter(|&step_m| step_m == 0.0 || step_m > HIGH_STEP_M)?;
        let what = match step_m {
            0.0 => "bodies cross level floors only, and a scanned floor or a door sill stops them",
            _ => "bodies walk up and down what people climb with their hands",
        };
        Some(format!("approach.step_m = {step_m}: {what}: a step of stairs is up to 0.25"))
    }
}

fn at_least_one(at: &Place, min_voxels: u32) -> Result<u32> {
    match min_voxels {
        0 => Err(at.wrong("min_voxels", 0, "must be 1 or more")),
        count => Ok(count),
    }
}

fn known_body(number: usize, min_voxels: u32) -> BodySpec {
    let (name, shape, on_floor) = KNOWN[number];
    BodySpec { name: name.into(), shape, on_floor, min_voxels }
}

fn body(at: &Place, file: BodyFile, for_all: u32) -> Result<BodySpec> {
    let at = &at.key(&format!("body {:?}", file.name));
    let min_voxels = at_least_one(at, file.min_voxels.unwrap_or(for_all))?;
    let rule = "a size in metres above 0 and up to 100";
    let size = |key: &str, metres: f64| at.number(key, metres, f64::MIN_POSITIVE..=LARGEST_M, rule);
    let cylinder = |c: &BodyCylinderFile| -> Result<(BodyShape, bool)> {
        let (diameter_m, height_m) = (size("diameter_m", c.diameter_m)?, size("height_m", c.height_m)?);
        Ok((BodyShape::Cylinder { diameter_m, height_m }, true))
    };
    let ball =
        |b: &BodyBallFile| Ok((BodyShape::Ball { diameter_m: size("diameter_m", b.diameter_m)? }, false));
    let cuboid = |b: &CuboidFile| {
        b.size_m.iter().try_for_each(|&metres| size("size_m", metres).map(|_| ()))?;
        Ok((BodyShape::Box { size_m: b.size_m }, true))
    };
    let shapes = vec![
        ("cylinder", file.cylinder.as_ref().map(cylinder)),
        ("ball", file.ball.as_ref().map(ball)),
        ("box", file.r#box.as_ref().map(cuboid)),
    ];
    let known = KNOWN.iter().position(|(name, _, _)| *name == file.name);
    let (shape, stands) = match known {
        Some(number) if shapes.iter().all(|(_, shape)| shape.is_none()) => {
            let BodySpec { shape, on_floor, .. } = known_body(number, min_voxels);
            (shape, on_floor)
        }
        None if shapes.iter().all(|(_, shape)| shape.is_none()) => {
            let names = KNOWN.map(|(name, _, _)| name).join(", ");
            return Err(at
                .says("no shape, and its name is none of a known body")
                .with_advice(format!("give one of cylinder, ball, box, or name one of {names}")));
        }
        _ => only_one(at, "shape", shapes)??,
    };
    Ok(BodySpec { name: file.name, shape, on_floor: file.on_floor.unwrap_or(stands), min_voxels })
}

fn entry(at: &Place, file: EntryFile, known: &ApproachNames) -> Result<EntrySpec> {
    let at = &at.key(&format!("entry {:?}", file.name));
    let cuboid =
        |b: &BoxFile| b.corners(&at.key("box")).map(|[min_m, max_m]| EntryPlace::Box { min_m, max_m });
    let gate = |name: &String| {
        let gates: Vec<_> = known.sensors.iter().filter(|sensor| sensor.kind.name() == "gate").collect();
        let names: Vec<_> = gates.iter().map(|gate| gate.name.as_str()).collect();
        let found = known.sensors.iter().position(|sensor| names.contains(&&**name) && sensor.name == *name);
        let rule = format!("must be a sensor of the study with kind = \"gate\": {names:?}");
        found.map(EntryPlace::Gate).ok_or_else(|| at.wrong("gate", format!("{name:?}"), &rule))
    };
    let edges = |said: bool| match said {
        true => Ok(EntryPlace::Edges),
        false => Err(at.wrong("edges", false, "must be true, or left out")),
    };
    let places = vec![
        ("box", file.r#box.as_ref().map(cuboid)),
        ("gate", file.gate.as_ref().map(gate)),
        ("edges", file.edges.map(edges)),
    ];
    Ok(EntrySpec { name: file.name, place: only_one(at, "place", places)?? })
}
