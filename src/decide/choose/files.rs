//! The files of an answer: `front.csv`, `sets.csv` and `choose.json`, which is also read.

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
/// The question, the answer, and its proof.
pub const PROOF: &str = "choose.json";

/// The scope of each proof.
const CERTIFIED: &str = "the listed poses, at this voxel size, in these scenes, under";

/// The question, the answer and its proof.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chosen {
    /// The version of the program.
    pub perirobot: String,
    /// The version of the rules of counting.
    pub semantics_version: u32,
    /// The study's file.
    pub study: String,
    /// Fingerprint of everything in the study that affects counts.
    pub fingerprint: String,
    /// Edge of a voxel in metres.
    pub voxel_size_m: f64,
    /// Whether sensors measured without noise, overriding the study.
    pub noiseless: bool,
    /// The number of searched poses of all sensors.
    pub candidates: usize,
    /// The question.
    pub asked: ChooseQuestion,
    /// The scope of a proof.
    pub certified: String,
    /// The answer.
    #[serde(flatten)]
    pub report: FrontReport,
}

/// The question of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChooseQuestion {
    /// The score to maximise.
    pub objective: Score,
    /// The counts that it covers.
    pub over: Across,
    /// The region.
    pub region: String,
    /// The most sensors of a set.
    pub at_most: usize,
    /// The budget.
    pub budget: Option<Cost>,
    /// The currency of all costs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub currency: Option<String>,
    /// Least distance between two sensors.
    pub apart_m: f64,
    /// When two sensors disturb each other; such pairs are excluded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturb: Option<Disturb>,
    /// The sensors of every set.
    pub always: Vec<String>,
    /// The lower limits of every set.
    pub require: Vec<AskedScore>,
    /// How the sensors' evidence is fused into one label.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub fusion: Fusion,
    /// Whether poses around the best sets were searched.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub refine: bool,
    /// The terms of each sensor, by its name.
    pub sensors: BTreeMap<String, AskedSensor>,
}

/// A score with a lower limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AskedScore {
    /// The score.
    pub score: Score,
    /// The counts that it covers.
    pub over: Across,
    /// The lower limit.
    pub at_least: f64,
}

/// The terms of a sensor, and its representation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AskedSensor {
    /// Its representation.
    pub representation: String,
    /// Its cost.
    pub cost: Option<Cost>,
    /// The most of them in a set.
    pub at_most: Option<u32>,
    /// Its list price of the catalogue, if that is its cost.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub list_price: Option<ListPrice>,
    /// The kind of light that it emits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub emits: Option<String>,
}

impl AskedSensor {
    /// The terms of a sensor in a study, in a representation.
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
    /// The question of a study.
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

/// Fingerprint of everything in a study that affects counts.
pub(crate) fn fingerprint(study: &Study, worlds: &[World]) -> String {
    hex(&Manifest::new(study, worlds, Shard::WHOLE, &[]).fingerprint())
}

impl Chosen {
    /// The answer to a study.
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

    /// Reads the answer in a folder; `None` if no sets were chosen there.
    ///
    /// # Errors
    /// `Error::Input` that names the file and the missing or wrong value.
    pub fn read(folder: &Path) -> Result<Option<Chosen>> {
        let path = folder.join(PROOF);
        if !path.exists() {
            return Ok(None);
        }
        let chosen = serde_json::from_slice(&read_regular(&path)?);
        chosen.map(Some).map_err(|e| json_issue(&e).cure("choose again").with_place(&path).into())
    }

    /// Whether results belong to its sets: a later sweep may have replaced them in the folder.
    pub fn is_of(&self, subject: &Subject) -> bool {
        let swept = subject.combinations.iter().map(|one| (one.choices(), one.name_of(0)));
        self.report.sets().map(|set| (1, set.name())).eq(swept)
    }

    /// Opens a folder for an answer to a study. It may contain an earlier answer, but not a sweep.
    ///
    /// # Errors
    /// If it cannot be created or written to, or if data would be lost.
    pub fn folder(path: &Path, study: &Study) -> Result<OutputFolder> {
        let folder = OutputFolder::open(path)?;
        folder.spare(&study.sources, &[REFINED])?;
        if path.join(JOURNAL).exists() && !path.join(PROOF).exists() {
            let what = "contains a sweep, which would be lost";
            return Err(Error::input(path, what).with_advice("name another folder"));
        }
        Ok(folder)
    }

    /// Writes the files of an answer, each atomically.
    ///
    /// # Errors
    /// If one cannot be written.
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

    /// The poses that refining found, if any. A study adds the name of their group, so it is removed here.
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
