//! `judge.json`: verdicts, and scores under each condition, with the values of `requirements.csv` and `conditions.csv`
//! in their types. The report reads it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::cases::{Moment, Passage};
use super::judged::JudgedSet;
use super::speed::Speeds;
use super::spread::{ScoreSpread, Summed, spreads};
use super::tables::tables_sha256;
use super::verdict::{CasePart, Judgement, Where, word};
use crate::approach::Company;
use crate::json_file::JsonFile;
use perirobot_march::Result;
use perirobot_march::metrics::Across;
use perirobot_study::input::{Condition, Limit, Study};
use perirobot_sweep::results::Subject;
use perirobot_sweep::results::files::{JUDGE_JSON, REQUIREMENTS};

const FILE: JsonFile =
    JsonFile { name: JUDGE_JSON, format: 1, table: REQUIREMENTS, again: "run `perirobot judge` again" };

/// The verdicts of `judge` on some sets of sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdicts {
    /// Number of the format: 1.
    pub format: u32,
    /// The version of the program.
    pub perirobot: String,
    /// The sets, in the order of the tables.
    pub sets: Vec<SetVerdicts>,
}

/// The verdicts of `judge` on a set of sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetVerdicts {
    /// Its combination, by its name.
    pub combination: String,
    /// Its poses, as in results.csv.
    pub poses: String,
    /// Its representation.
    pub representation: String,
    /// Each requirement under each of its conditions: the rows of `requirements.csv`.
    pub requirements: Vec<RequirementVerdict>,
    /// Each score under each condition: the rows of `conditions.csv`.
    pub conditions: Vec<ConditionScore>,
    /// What speaks against the verdicts, in sentences: latches that are not proven to hold, and switches that something fixed
    /// trips.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub caveats: Vec<String>,
    /// The allowed robot speed, if requirements depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allowed_speed: Option<AllowedSpeed>,
}

/// The allowed robot speed with a set of sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AllowedSpeed {
    /// The highest speed of the study that is allowed, in metres per second; `None` if the slowest is not.
    pub m_s: Option<f64>,
}

/// The verdict on a requirement under a condition. Scores that end in `_m` are in metres, in `_m2` in square metres; all
/// others are shares or have no unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RequirementVerdict {
    /// The requirement, by its name.
    pub requirement: String,
    /// The condition.
    pub condition: Condition,
    /// Whether all cases of the condition keep to the limit.
    pub is_met: bool,
    /// The score, by its name.
    pub score: String,
    /// The region of the counts, by its name; `None` for scores without a region.
    pub region: Option<String>,
    /// The counts, approaches or moments that the score covers.
    pub over: Across,
    /// Lower limit, if any.
    pub at_least: Option<f64>,
    /// Upper limit, if any.
    pub at_most: Option<f64>,
    /// The value in the worst case; `None` if a case has no value.
    pub value: Option<JsonNumber>,
    /// The number of cases.
    pub cases: usize,
    /// The number of cases that miss the limit.
    pub failed: usize,
    /// The number of moments, or ways in, with a value, over all cases.
    pub values: usize,
    /// The number of moments, or ways in, over all cases.
    pub of: usize,
    /// The number of cases in which a mount stays as planned because no draw was possible.
    pub draws_as_planned: usize,
    /// The worst case.
    pub worst: WorstPlace,
    /// The upper bound of the listed poses, if it misses the limit.
    pub out_of_reach: Option<JsonNumber>,
    /// The hash of the study's tables that decided it; empty if none did.
    pub tables_sha256: String,
    /// The safety function that the requirement represents.
    #[serde(rename = "for", default)]
    pub safety_function: Option<String>,
}

/// A score over all cases of a condition, with the units of [`RequirementVerdict`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConditionScore {
    /// The condition.
    pub condition: Condition,
    /// The region of the counts, by its name; `None` for scores without a region.
    pub region: Option<String>,
    /// The score, by its name.
    pub score: String,
    /// The best value.
    pub best: JsonNumber,
    /// The mean of all values.
    pub mean: JsonNumber,
    /// The 5 % quantile: one in twenty values is no better.
    pub quantile_05: JsonNumber,
    /// The worst value by the score's own direction.
    pub worst: JsonNumber,
    /// The place of the worst value.
    pub worst_at: WorstPlace,
    /// The number of moments, or ways in, with a value, over all cases.
    pub values: usize,
    /// The number of moments, or ways in, over all cases.
    pub of: usize,
    /// The hash of the study's tables that decided it; empty if none did.
    pub tables_sha256: String,
}

/// The worst case, and its worst part. All but the case is `None` if the case has no value, or if no body comes near in
/// it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorstPlace {
    /// The alteration in words; empty as planned.
    pub case: String,
    /// The scene, by its name.
    pub scene: Option<String>,
    /// The snapshot, counted from 0; `None` for ways in, which cover all snapshots at once.
    pub snapshot: Option<usize>,
    /// The repeat, counted from 0.
    pub repeat: Option<usize>,
    /// The company, for a way in.
    pub people: Option<Company>,
    /// The body's name, for a way in.
    pub body: Option<String>,
    /// The entry's name, for a way in.
    pub entry: Option<String>,
}

/// A number that may be infinite, which JSON cannot represent: the distance of a body that never comes near. It is
/// written as `"inf"`, as in the tables.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "WrittenNumber", into = "WrittenNumber")]
pub struct JsonNumber(pub f64);

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum WrittenNumber {
    Finite(f64),
    Infinite(Infinity),
}

#[derive(Serialize, Deserialize)]
enum Infinity {
    #[serde(rename = "inf")]
    Inf,
}

impl From<JsonNumber> for WrittenNumber {
    fn from(JsonNumber(number): JsonNumber) -> WrittenNumber {
        match number.is_finite() {
            true => WrittenNumber::Finite(number),
            false => WrittenNumber::Infinite(Infinity::Inf),
        }
    }
}

impl From<WrittenNumber> for JsonNumber {
    fn from(written: WrittenNumber) -> JsonNumber {
        JsonNumber(match written {
            WrittenNumber::Finite(number) => number,
            WrittenNumber::Infinite(Infinity::Inf) => f64::INFINITY,
        })
    }
}

impl Verdicts {
    /// The verdicts on judged sets, some with their speeds; the study is the judged one.
    pub(super) fn new(
        study: &Study,
        subject: &Subject,
        sets: &[JudgedSet],
        speeds: &[(&JudgedSet, Speeds)],
    ) -> Verdicts {
        let allowed_speed = |set: &JudgedSet| {
            let (_, own) = speeds.iter().find(|(other, _)| std::ptr::eq(*other, set))?;
            let stopping = study.stopping.as_ref()?;
            Some(AllowedSpeed { m_s: own.fastest.map(|fastest| stopping.speeds[fastest].speed_m_s) })
        };
        let of_set = |set: &JudgedSet| SetVerdicts {
            combination: set.combination.clone(),
            poses: set.poses.clone(),
            representation: set.representation.clone(),
            requirements: set.judgements.iter().map(|one| verdict(study, subject, set, one)).collect(),
            conditions: spreads(&set.conditions)
                .iter()
                .map(|spread| condition_score(study, subject, set, spread))
                .collect(),
            caveats: set.caveats.clone(),
            allowed_speed: allowed_speed(set),
        };
        Verdicts {
            format: FILE.format,
            perirobot: env!("CARGO_PKG_VERSION").into(),
            sets: sets.iter().map(of_set).collect(),
        }
    }

    /// Reads them from a folder; `None` if nothing was judged there.
    ///
    /// # Errors
    /// `Error::Input` that names the file and a remedy: if the file is damaged or in another format, or if an older
    /// program judged without it.
    pub fn read(folder: &Path) -> Result<Option<Verdicts>> {
        FILE.read(folder)
    }

    /// Writes them into a folder.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        FILE.write(folder, self)
    }
}

impl SetVerdicts {
    /// Combination, poses and representation, as in the columns of tables.
    pub fn names(&self) -> [&str; 3] {
        [&self.combination, &self.poses, &self.representation]
    }
}

impl RequirementVerdict {
    /// The verdict in a word, as in the tables.
    pub fn word(&self) -> &'static str {
        word(self.is_met)
    }
}

fn verdict(study: &Study, subject: &Subject, set: &JudgedSet, judgement: &Judgement) -> RequirementVerdict {
    let Judgement { requirement, condition, .. } = *judgement;
    let (at_least, at_most) = match requirement.limit {
        Limit::AtLeast(ratio) => (Some(ratio.value()), None),
        Limit::AtMost(ratio) => (None, Some(ratio.value())),
    };
    RequirementVerdict {
        requirement: requirement.name.clone(),
        condition,
        is_met: judgement.is_met,
        score: requirement.score_name().into(),
        region: requirement.region().map(|region| subject.regions[region].clone()),
        over: requirement.scope(),
        at_least,
        at_most,
        value: judgement.value.as_ref().map(|value| JsonNumber(value.number())),
        cases: judgement.cases,
        failed: judgement.failed,
        values: judgement.values,
        of: judgement.of,
        draws_as_planned: judgement.kept,
        worst: worst_place(set, subject, condition, &judgement.worst),
        out_of_reach: judgement.out_of_reach.as_ref().map(|bound| JsonNumber(bound.number())),
        tables_sha256: tables_sha256(study, Summed::from_measure(&requirement.measure), condition),
        safety_function: requirement.safety_function.clone(),
    }
}

fn condition_score(
    study: &Study,
    subject: &Subject,
    set: &JudgedSet,
    spread: &ScoreSpread,
) -> ConditionScore {
    ConditionScore {
        condition: spread.condition,
        region: spread.of_what.region().map(|region| subject.regions[region].clone()),
        score: spread.of_what.name().into(),
        best: JsonNumber(spread.best),
        mean: JsonNumber(spread.mean),
        quantile_05: JsonNumber(spread.twentieth),
        worst: JsonNumber(spread.worst),
        worst_at: worst_place(set, subject, spread.condition, &spread.at),
        values: spread.values,
        of: spread.of,
        tables_sha256: tables_sha256(study, spread.of_what, spread.condition),
    }
}

fn worst_place(set: &JudgedSet, subject: &Subject, condition: Condition, at: &Where) -> WorstPlace {
    let case = set.conditions.cases(condition)[at.case].alteration.words();
    let scene_name = |scene: usize| Some(subject.scenes[scene].name.clone());
    match at.part {
        None => WorstPlace { case, ..WorstPlace::default() },
        Some(CasePart::Moment(moment)) => {
            let Moment { scene, snapshot, repeat } = set.conditions.moments[moment];
            let (snapshot, repeat) = (Some(snapshot), Some(repeat));
            WorstPlace { case, scene: scene_name(scene), snapshot, repeat, ..WorstPlace::default() }
        }
        Some(CasePart::Passage(passage)) => {
            let Passage { scene, company, repeat, body, entry, .. } = &set.conditions.passages[passage];
            WorstPlace {
                case,
                scene: scene_name(*scene),
                snapshot: None,
                repeat: Some(*repeat),
                people: Some(*company),
                body: Some(body.clone()),
                entry: Some(entry.clone()),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdicts() -> Verdicts {
        let at =
            WorstPlace { case: "draw 3".into(), snapshot: Some(2), repeat: Some(0), ..WorstPlace::default() };
        let (people, body, entry) = (Some(Company::Cover), Some("standing".into()), Some("door".into()));
        let way_in = WorstPlace { scene: Some("cell".into()), people, body, entry, ..WorstPlace::default() };
        let missed = RequirementVerdict {
            requirement: "far \"enough\"".into(),
            condition: Condition::MountingError,
            is_met: false,
            score: "nearest_unnoticed_m".into(),
            region: None,
            over: Across::Worst,
            at_least: Some(0.1 + 0.2),
            at_most: None,
            value: Some(JsonNumber(f64::INFINITY)),
            cases: 20,
            failed: 1,
            values: 19,
            of: 20,
            draws_as_planned: 4,
            worst: way_in,
            out_of_reach: None,
            tables_sha256: String::new(),
            safety_function: Some("SF1: protective stop".into()),
        };
        let score = ConditionScore {
            condition: Condition::AsPlanned,
            region: Some("robot".into()),
            score: "f1".into(),
            best: JsonNumber(f64::INFINITY),
            mean: JsonNumber(1.0 / 3.0),
            quantile_05: JsonNumber(f64::MIN_POSITIVE),
            worst: JsonNumber(-2.0),
            worst_at: at,
            values: 1,
            of: usize::MAX,
            tables_sha256: "0123".into(),
        };
        let set = SetVerdicts {
            combination: "best 2".into(),
            poses: "camera:wall/0;lidar:post".into(),
            representation: "points;points".into(),
            requirements: vec![missed.clone(), RequirementVerdict { value: None, is_met: true, ..missed }],
            conditions: vec![score],
            caveats: vec!["sensor \"gate\": its latch is not proven".into()],
            allowed_speed: Some(AllowedSpeed { m_s: None }),
        };
        Verdicts { format: FILE.format, perirobot: "0.1.0".into(), sets: vec![set] }
    }

    #[test]
    fn what_is_read_is_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(Verdicts::read(folder.path()).unwrap(), None);
        let written = verdicts();
        written.write(folder.path()).unwrap();
        assert_eq!(Verdicts::read(folder.path()).unwrap().unwrap(), written);
        let text = std::fs::read_to_string(folder.path().join(JUDGE_JSON)).unwrap();
        for part in [
            "\"best\": \"inf\"",
            "\"at_least\": 0.30000000000000004,",
            "\"people\": \"cover\"",
            "\"worst\": -2.0",
            "\"for\": \"SF1: protective stop\"",
        ] {
            assert!(text.contains(part), "no {part} in {text}");
        }
    }
}
