//! An answer in names and numbers: the cheapest set for each aim, its proof, and the causes if no set passes.
//! `cheapest.json` contains it; texts, tables and pages are made from it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::question::PurchaseQuestion;
use super::terms::PurchaseAim;
use crate::choose::fingerprint;
pub use crate::purchased_sets::CHEAPEST;
pub(super) use crate::purchased_sets::FILE;
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_study::input::{Combination, Member, Overrides, Purchase, Study};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;
use perirobot_sweep::results::Subject;
use perirobot_sweep::results::columns::BETWEEN_MEMBERS;
use perirobot_sweep::results::files::{JOURNAL, remove_files, write_whole};

/// The cheapest sets that pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PurchaseReport {
    /// The format of the file.
    pub format: u32,
    /// The version of the program.
    pub perirobot: String,
    /// The version of the rules of counting.
    pub semantics_version: u32,
    /// The study's file.
    pub study: String,
    /// Fingerprint of everything in the study that affects counts.
    pub fingerprint: String,
    /// The number of candidates.
    pub candidates: usize,
    /// Edge of a voxel in metres.
    pub voxel_size_m: f64,
    /// Whether sensors measured without noise, overriding the study.
    pub noiseless: bool,
    /// The question.
    pub asked: PurchaseQuestion,
    /// The answer for each aim: all requirements first.
    pub points: Vec<PurchasePoint>,
    /// Proof that cheaper sets fail, besides scores of counts: ways in, each noticed by at least one of its candidates
    /// in a passing set, or by one more than may be dead.
    pub ways_in: Vec<ProvenWay>,
    /// Whether the search was stopped.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stopped: bool,
}

/// The cheapest set for one aim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PurchasePoint {
    /// The terms of the set.
    pub aim: AimReport,
    /// The cheapest set found.
    pub set: Option<PurchasedSet>,
    /// Lower bound of the cost of a passing set; `None` if no allowed set passes.
    pub no_set_below: Option<Cost>,
    /// Whether all cheaper sets are proven to fail, or all sets if none passes.
    pub proven: bool,
    /// Whether no set of the same cost has a better score, if a score decides.
    pub best_of_cost: bool,
    /// The number of passing sets of the same cost compared by that score, if not all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared: Option<u64>,
    /// The number of other passing sets of the same cost, if no score decides; at most 9 are counted, and `None` if
    /// that takes too many tests.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ties: Option<usize>,
    /// The number of tested sets.
    pub tested: u64,
    /// Pairs of the set that disturb each other, each as in `camera:wall/8/1`, if that is allowed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disturbed: Vec<[String; 2]>,
    /// Why no set passes: a minimal group of requirements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reasons: Vec<ReasonReport>,
    /// For a set that meets a number of requirements, those that it misses.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missed: Vec<String>,
}

/// The terms of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AimReport {
    /// All requirements.
    All,
    /// All requirements, with sensors that may disturb each other.
    Disturbed,
    /// All requirements at a speed of the robot, in metres per second.
    Speed(f64),
    /// All requirements except this one.
    Without(String),
    /// Any group of at least this many requirements.
    Number(usize),
    /// All requirements except these, which cannot be met.
    Nearest(Vec<String>),
}

/// A set that passes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PurchasedSet {
    /// The name of its combination in results.csv.
    pub name: String,
    /// Its cost.
    pub cost: Cost,
    /// The score that decides among sets of the same cost, if any.
    pub score: Option<f64>,
    /// Its sensors.
    pub sensors: Vec<PurchasedSensor>,
}

/// A sensor of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PurchasedSensor {
    /// The sensor's name.
    pub sensor: String,
    /// The pose's name.
    pub pose: String,
    /// The place in words.
    pub place: String,
    /// Its cost.
    pub cost: Cost,
}

/// A way in, and the candidates that notice it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProvenWay {
    /// The scene.
    pub scene: String,
    /// Whether the people of the scene are there.
    pub people: String,
    /// The repeat, counted from 0.
    pub repeat: usize,
    /// The body.
    pub body: String,
    /// The entry.
    pub entry: String,
    /// The lowest corner of the box around the body at each place, in voxels of the grid.
    pub places: Vec<[i32; 3]>,
    /// Closest distance at the end, in metres.
    pub nearest_m: f64,
    /// The candidates that notice it, as in `camera:wall/8/1`: all others together do not.
    pub noticed_by: Vec<String>,
}

/// A requirement that cannot be met, alone or together with others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReasonReport {
    /// The requirement.
    pub requirement: String,
    /// Why it cannot be met, with a remedy; if several cannot be met together, its limit.
    pub why: String,
}

impl PurchasedSet {
    /// The set as in the column `poses` of results.csv.
    pub fn poses(&self) -> String {
        let each = self.sensors.iter().map(|one| format!("{}:{}", one.sensor, one.pose));
        each.collect::<Vec<_>>().join(BETWEEN_MEMBERS)
    }
}

impl PurchaseReport {
    /// An answer to a study.
    pub(super) fn new(
        (study, purchase, worlds): (&Study, &Purchase, &[World]),
        points: Vec<PurchasePoint>,
        ways_in: Vec<ProvenWay>,
        stopped: bool,
    ) -> PurchaseReport {
        PurchaseReport {
            format: FILE.format,
            perirobot: env!("CARGO_PKG_VERSION").into(),
            semantics_version: perirobot_march::SEMANTICS_VERSION,
            study: study.path.display().to_string(),
            fingerprint: fingerprint(study, worlds),
            candidates: study.sensors.iter().map(|sensor| sensor.candidates.len()).sum(),
            voxel_size_m: study.voxel_size_m,
            noiseless: study.noiseless,
            asked: PurchaseQuestion::new(study, purchase),
            points,
            ways_in,
            stopped,
        }
    }

    /// The overrides of the command line.
    pub fn overrides(&self) -> Overrides {
        Overrides { voxel_size_m: Some(self.voxel_size_m), noiseless: self.noiseless }
    }

    /// Whether results belong to its sets: a later sweep may have replaced them in the folder.
    pub fn is_of(&self, subject: &Subject) -> bool {
        let swept = subject.combinations.iter().map(|one| (one.choices(), one.name_of(0)));
        self.sets().into_iter().map(|set| (1, set.poses())).eq(swept)
    }

    /// Whether the study's requirements and costs are unchanged.
    pub fn is_current(&self, study: &Study) -> bool {
        self.asked.is_current(study)
    }

    /// An amount in the study's currency.
    pub fn amount(&self, cost: Cost) -> String {
        cost.to_text(self.asked.currency.as_deref())
    }

    /// The answer for all requirements.
    pub fn main(&self) -> &PurchasePoint {
        &self.points[0]
    }

    /// The answer without the exclusion of disturbing pairs, if requested and better: the exclusion then explains the
    /// additional cost, or why no set passes.
    pub fn bound_by_disturb(&self) -> Option<&PurchasePoint> {
        let if_disturbed = self.points.iter().find(|point| point.aim == AimReport::Disturbed)?;
        let is_better = match (&self.main().set, &if_disturbed.set) {
            // A superset of allowed sets is never worse.
            (Some(own), Some(other)) if own.cost == other.cost => {
                own.score != other.score && if_disturbed.best_of_cost
            }
            (Some(own), Some(other)) => other.cost < own.cost,
            (own, other) => own.is_none() && other.is_some(),
        };
        (is_better && !if_disturbed.disturbed.is_empty()).then_some(if_disturbed)
    }

    /// The recommended set: the one that passes all, or comes nearest.
    pub fn recommended(&self) -> Option<&PurchasedSet> {
        let is_first = |point: &&PurchasePoint| matches!(point.aim, AimReport::All | AimReport::Nearest(_));
        self.points.iter().filter(is_first).find_map(|point| point.set.as_ref())
    }

    /// All sets, each once, the recommended one first.
    pub fn sets(&self) -> Vec<&PurchasedSet> {
        let mut sets: Vec<&PurchasedSet> = Vec::new();
        let recommended = self.recommended().into_iter();
        for set in recommended.chain(self.points.iter().filter_map(|point| point.set.as_ref())) {
            if sets.iter().all(|known| known.poses() != set.poses()) {
                sets.push(set);
            }
        }
        sets
    }

    /// The study of the sets, each a combination with one choice of poses.
    pub fn study_of_sets(&self, study: &Study, purchase: &Purchase) -> Study {
        let combination = |set: &PurchasedSet| {
            let member = |one: &PurchasedSensor| {
                let sensor = study.sensors.iter().position(|known| known.name == one.sensor)?;
                let candidates = &study.sensors[sensor].candidates;
                let candidate = candidates.iter().position(|known| known.name == one.pose)?;
                Some(Member { sensor, candidates: vec![candidate] })
            };
            let members = set.sensors.iter().filter_map(member).collect();
            Combination { name: set.name.clone(), fusion: purchase.fusion, members }
        };
        let combinations = self.sets().into_iter().map(combination).collect();
        study.with_combinations(&purchase.representations, combinations)
    }

    /// Writes `cheapest.json` and `cheapest.csv`.
    ///
    /// # Errors
    /// When one cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        write_whole(&folder.join(CHEAPEST), &self.csv())?;
        FILE.write(folder, self)
    }

    /// Reads it; `None` if the folder has no answer for a cheapest set.
    ///
    /// # Errors
    /// Those of a file that is damaged or of another version.
    pub fn read(folder: &Path) -> Result<Option<PurchaseReport>> {
        let report: Option<PurchaseReport> = FILE.read(folder)?;
        if report.as_ref().is_some_and(|report| report.points.is_empty()) {
            let issue = Issue::damaged("is empty").with_place("points").with_place(folder.join(FILE.name));
            return Err(issue.cure(FILE.again).into());
        }
        Ok(report)
    }

    /// Removes an earlier answer from a folder, with the counts of its sets, which are not a sweep of the user.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn forget(folder: &Path) -> Result<()> {
        match folder.join(FILE.name).exists() {
            true => remove_files([FILE.name, CHEAPEST, JOURNAL].map(|name| folder.join(name))),
            false => Ok(()),
        }
    }

    /// cheapest.csv.
    pub(super) fn csv(&self) -> Vec<u8> {
        let mut csv = csv::Writer::from_writer(Vec::new());
        let mut row = |fields: [String; 9]| {
            csv.write_record(&fields).expect("all rows are as long as the header, and memory takes them");
        };
        let header =
            ["aim", "value", "cost", "no_set_below", "proven", "sensors", "poses", "reasons", "missed"];
        row(header.map(String::from));
        for point in &self.points {
            let (aim, value) = point.aim.columns();
            let or_empty = |cost: Option<Cost>| cost.map_or(String::new(), |cost| cost.to_string());
            let set = point.set.as_ref();
            row([
                aim.into(),
                value,
                or_empty(set.map(|set| set.cost)),
                or_empty(point.no_set_below),
                u8::from(point.proven).to_string(),
                set.map_or(String::new(), |set| set.sensors.len().to_string()),
                set.map_or(String::new(), PurchasedSet::poses),
                point.reasons.iter().map(|one| one.requirement.as_str()).collect::<Vec<_>>().join("; "),
                point.missed.join("; "),
            ]);
        }
        csv.into_inner().expect("memory takes all bytes")
    }
}

impl AimReport {
    pub(super) fn new(study: &Study, aim: PurchaseAim) -> AimReport {
        match aim {
            PurchaseAim::All => AimReport::All,
            PurchaseAim::Disturbed => AimReport::Disturbed,
            PurchaseAim::Speed(speed) => {
                let speeds = study.stopping.as_ref().map(|stopping| stopping.speeds[speed].speed_m_s);
                AimReport::Speed(speeds.unwrap_or_default())
            }
            PurchaseAim::Number(least) => AimReport::Number(least),
            PurchaseAim::Without(one) => AimReport::Without(study.requirements[one].name.clone()),
        }
    }

    fn columns(&self) -> (&'static str, String) {
        match self {
            AimReport::All => ("all", String::new()),
            AimReport::Disturbed => ("disturbed", String::new()),
            AimReport::Speed(speed) => ("speed", speed.to_string()),
            AimReport::Without(name) => ("without", name.clone()),
            AimReport::Number(least) => ("number", least.to_string()),
            AimReport::Nearest(names) => ("nearest", names.join("; ")),
        }
    }

    /// The name of the combination of its set.
    pub(super) fn title(&self) -> String {
        match self {
            AimReport::All => "cheapest".into(),
            AimReport::Disturbed => "cheapest if disturbed".into(),
            AimReport::Speed(speed) => format!("cheapest at {speed} m/s"),
            AimReport::Without(name) => format!("cheapest without {name}"),
            AimReport::Number(least) => format!("cheapest that meets {least}"),
            AimReport::Nearest(_) => "nearest".into(),
        }
    }
}
