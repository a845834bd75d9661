//! The files of an answer: `front.csv`, `sets.csv` and `choose.json`, which is read back.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::report::FrontReport;
use perirobot_march::backend::Fusion;
use perirobot_march::metrics::{Across, Score};
use perirobot_march::{Error, Result};
use perirobot_scene::source::hex;
use perirobot_study::input::catalogue::{ListPrice, describe_list_prices};
use perirobot_study::input::{Choose, Disturb, Study};
use perirobot_study::sensor::{Cost, Sensor};
use perirobot_study::world::World;
use perirobot_sweep::results::Subject;
use perirobot_sweep::results::files::{JOURNAL, OutputFolder, json_issue, read_regular, write_whole};
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::results::manifest::Manifest;

/// The front, a row for each step.
pub const FRONT: &str = "front.csv";
/// The sets of the front, a row for each sensor.
pub const SETS: &str = "sets.csv";
/// The poses that refining found, as a study can list them.
pub const REFINED: &str = "refined.csv";
/// What was asked, what was found, and what is proven of it.
pub const PROOF: &str = "choose.json";

/// What is certified of each set that is proven.
const CERTIFIED: &str = "the listed poses, at this voxel size, in these scenes, under";

/// What was asked, found and proven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chosen {
    /// The version of the program.
    pub perirobot: String,
    /// That of the rules by which was counted.
    pub semantics_version: u32,
    /// The study's file.
    pub study: String,
    /// What tells the study from every other.
    pub fingerprint: String,
    /// Edge of a voxel in metres.
    pub voxel_size_m: f64,
    /// Whether sensors measured without noise, whatever the study says.
    pub noiseless: bool,
    /// How many poses of all sensors were searched.
    pub candidates: usize,
    /// What was looked for.
    pub asked: ChooseQuestion,
    /// What a proof holds of.
    pub certified: String,
    /// What was found.
    #[serde(flatten)]
    pub report: FrontReport,
}

/// What a study asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChooseQuestion {
    /// The score that is to be high.
    pub objective: Score,
    /// Of which counts.
    pub over: Across,
    /// In which region.
    pub region: String,
    /// How many sensors a set may have.
    pub at_most: usize,
    /// What a set may cost.
    pub budget: Option<Cost>,
    /// The unit of all costs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub currency: Option<String>,
    /// How far two sensors must be from each other.
    pub apart_m: f64,
    /// When sensors disturb each other that may not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturb: Option<Disturb>,
    /// What is in every set.
    pub always: Vec<String>,
    /// What every set must reach.
    pub require: Vec<AskedScore>,
    /// How what sensors say becomes one label.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub fusion: Fusion,
    /// Whether poses around the best sets were looked for.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub refine: bool,
    /// By its name, what was said of each sensor.
    pub sensors: BTreeMap<String, AskedSensor>,
}

/// A score that every set must reach.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AskedScore {
    /// The score.
    pub score: Score,
    /// Of which counts.
    pub over: Across,
    /// What it must be at least.
    pub at_least: f64,
}

/// On which terms a sensor could be had, and how it was taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AskedSensor {
    /// What it was taken to say.
    pub representation: String,
    /// What one costs.
    pub cost: Option<Cost>,
    /// How many a set may have.
    pub at_most: Option<u32>,
    /// Its list price of the catalogue, if that is its cost.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub list_price: Option<ListPrice>,
    /// The kind of light that it emits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub emits: Option<String>,
}

impl AskedSensor {
    /// What a study says of a sensor in a representation.
    pub(crate) fn new(sensor: &Sensor, representation: usize) -> AskedSensor {
        AskedSensor {
            representation: sensor.kind.representations()[representation].into(),
            cost: sensor.terms.cost,
            at_most: sensor.terms.at_most,
            list_price: sensor.list_price.clone(),
            emits: sensor.emits.clone(),
        }
    }
}

/// Which costs of an answer are list prices of the catalogue, in a sentence; `None` if none is.
pub fn describe_asked_prices(sensors: &BTreeMap<String, AskedSensor>) -> Option<String> {
    describe_list_prices(sensors.iter().map(|(name, asked)| (name.as_str(), asked.list_price.as_ref())))
}

impl ChooseQuestion {
    /// What a study asks for.
    pub(super) fn new(study: &Study, choose: &Choose) -> ChooseQuestion {
        let pose = |&[sensor, candidate]: &[usize; 2]| {
            let sensor = &study.sensors[sensor];
            format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
        };
        let sensor = |(sensor, &way): (&Sensor, &usize)| (sensor.name.clone(), AskedSensor::new(sensor, way));
        let require = choose.require.iter();
        ChooseQuestion {
            objective: choose.objective,
            over: choose.over,
            region: study.regions[choose.region].0.clone(),
            at_most: choose.at_most,
            budget: choose.budget,
            currency: study.currency.clone(),
            apart_m: choose.apart_m,
            disturb: choose.disturb,
            always: choose.always.iter().map(pose).collect(),
            require: require
                .map(|one| AskedScore { score: one.score, over: one.over, at_least: one.at_least })
                .collect(),
            fusion: choose.fusion,
            refine: choose.refine,
            sensors: study.sensors.iter().zip(&choose.representations).map(sensor).collect(),
        }
    }
}

/// What tells a study from every other, as far as counts go.
pub(crate) fn fingerprint(study: &Study, worlds: &[World]) -> String {
    hex(&Manifest::new(study, worlds, Shard::WHOLE, &[]).fingerprint())
}

impl Chosen {
    /// What was found for a study.
    pub fn new(study: &Study, choose: &Choose, worlds: &[World], report: FrontReport) -> Chosen {
        Chosen {
            perirobot: env!("CARGO_PKG_VERSION").into(),
            semantics_version: perirobot_march::SEMANTICS_VERSION,
            study: study.path.display().to_string(),
            fingerprint: fingerprint(study, worlds),
            voxel_size_m: study.voxel_size_m,
            noiseless: study.noiseless,
            candidates: study.sensors.iter().map(|sensor| sensor.candidates.len()).sum(),
            asked: ChooseQuestion::new(study, choose),
            certified: format!("{CERTIFIED} {:?}", choose.fusion.name()),
            report,
        }
    }

    /// Reads it from a folder that was written; `None` where no sets were chosen.
    ///
    /// # Errors
    /// `Error::Input` that names the file and what is missing in it or wrong.
    pub fn read(folder: &Path) -> Result<Option<Chosen>> {
        let path = folder.join(PROOF);
        if !path.exists() {
            return Ok(None);
        }
        let chosen = serde_json::from_slice(&read_regular(&path)?);
        chosen.map(Some).map_err(|e| json_issue(&e).cure("choose again").with_place(&path).into())
    }

    /// Whether results are those of its sets: a sweep may have taken their place in the folder.
    pub fn is_of(&self, subject: &Subject) -> bool {
        let swept = subject.combinations.iter().map(|one| (one.choices(), one.name_of(0)));
        self.report.sets().map(|set| (1, set.name())).eq(swept)
    }

    /// Opens a folder for an answer to a study. One that holds an earlier answer will do, one that holds a sweep
    /// will not.
    ///
    /// # Errors
    /// When it cannot be made or written to, or something would be lost.
    pub fn folder(path: &Path, study: &Study) -> Result<OutputFolder> {
        let folder = OutputFolder::open(path)?;
        folder.spare(&study.sources, &[REFINED])?;
        if path.join(JOURNAL).exists() && !path.join(PROOF).exists() {
            let what = "holds a sweep, which would be lost";
            return Err(Error::input(path, what).with_advice("name another folder"));
        }
        Ok(folder)
    }

    /// Writes the files of an answer, each whole or not at all.
    ///
    /// # Errors
    /// When one cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let mut json = serde_json::to_vec_pretty(self).expect("names and numbers make JSON");
        json.push(b'\n');
        write_whole(&folder.join(SETS), &self.sets())?;
        let refined = folder.join(REFINED);
        match self.refined_poses() {
            Some(poses) => write_whole(&refined, &poses)?,
            None if refined.exists() => {
                std::fs::remove_file(&refined).map_err(|e| Error::io(&refined, "cannot be removed", e))?;
            }
            None => {}
        }
        write_whole(&folder.join(PROOF), &json)?;
        write_whole(&folder.join(FRONT), &self.front())
    }

    /// front.csv.
    pub(super) fn front(&self) -> Vec<u8> {
        let score = self.asked.objective.name();
        let mut rows =
            vec![["at_most", "sensors", "cost", score, "bound", "proven", "gain", "poses"].map(String::from)];
        for step in &self.report.steps {
            rows.push([
                step.at_most.to_string(),
                step.best.sensors.len().to_string(),
                or_empty(step.best.cost),
                step.best.score.to_string(),
                or_empty(step.no_set_is_above),
                step.proven.to_string(),
                or_empty(step.gain),
                step.best.name(),
            ]);
        }
        csv(&rows)
    }

    /// The poses that refining found, if it found any. A study names their group, so their names are without it.
    pub(super) fn refined_poses(&self) -> Option<Vec<u8>> {
        let all = self.report.refined.iter().flatten();
        let mut rows =
            vec![["sensor", "pose", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"].map(String::from)];
        for fine in all.flat_map(|refined| &refined.poses) {
            let name = fine.pose.split_once('/').map_or(&*fine.pose, |(_, name)| name);
            let [x, y, z] = fine.position_m.map(|value| value.to_string());
            let [qw, qx, qy, qz] = fine.quaternion_wxyz.map(|value| value.to_string());
            rows.push([fine.sensor.clone(), name.into(), x, y, z, qw, qx, qy, qz]);
        }
        (rows.len() > 1).then(|| csv(&rows))
    }

    /// sets.csv.
    pub(super) fn sets(&self) -> Vec<u8> {
        let without = format!("{}_without", self.asked.objective.name());
        let header = ["at_most", "set_cost", "sensor", "pose", "place", "cost", &without];
        let mut rows = vec![header.map(String::from)];
        for step in &self.report.steps {
            for one in &step.best.sensors {
                rows.push([
                    step.at_most.to_string(),
                    or_empty(step.best.cost),
                    one.sensor.clone(),
                    one.pose.clone(),
                    one.place.clone(),
                    or_empty(one.cost),
                    or_empty(one.score_without),
                ]);
            }
        }
        csv(&rows)
    }
}

fn is_usual(fusion: &Fusion) -> bool {
    *fusion == Fusion::default()
}

fn or_empty(value: Option<impl ToString>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

fn csv<const N: usize>(rows: &[[String; N]]) -> Vec<u8> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in rows {
        csv.write_record(row).expect("all rows are as long as the header, and memory takes them");
    }
    csv.into_inner().expect("memory takes all bytes")
}
