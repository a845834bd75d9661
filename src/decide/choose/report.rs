//! An answer in names and numbers: the front, what each sensor of a set is worth, and sets that are nearly as
//! good but different. Tables, texts and files are made from it, and `choose.json` contains it.

use serde::{Deserialize, Serialize};

use super::ties::ties;
use super::verify::pose_name;
use perirobot_cover::{Bound, CutProof, FoundSet, FrontAnswer, FrontStep, Problem, Ratio, Worth};
use perirobot_study::input::Study;
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;
use perirobot_study::world::place::Places;
use perirobot_sweep::results::columns::BETWEEN_MEMBERS;

/// The whole answer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrontReport {
    /// The front: by size, and of each size from the dearest set down. Below the dearest, sets that are no
    /// better than a smaller one that costs no more are left out.
    pub steps: Vec<StepReport>,
    /// Sets nearly as good as the best one, with at least one sensor somewhere else, the best first.
    #[serde(rename = "nearly_as_good")]
    pub ties: Vec<SetReport>,
    /// What was found between the listed poses around the best set of each size, if that was asked for. Nothing is
    /// proven of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refined: Option<Vec<RefinedReport>>,
    /// The best set if sensors might disturb each other, if it is asked that they do not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub if_disturbed: Option<DisturbedReport>,
    /// Whether the search was stopped: larger sets, and cheaper ones, may be missing.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stopped: bool,
    /// Whether refining was stopped: more might have been gained.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub refining_stopped: bool,
}

/// The best set if sensors might disturb each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DisturbedReport {
    /// The set; nothing is said of its sensors.
    #[serde(flatten)]
    pub set: SetReport,
    /// Whether no set is better.
    pub proven: bool,
    /// Which two of its sensors disturb each other, each as in `camera:wall/8/1`.
    pub disturbed: Vec<[String; 2]>,
}

/// What was found around the best set of a size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RefinedReport {
    /// How many sensors were allowed.
    pub at_most: usize,
    /// What the set could cost at most.
    pub budget: Option<Cost>,
    /// The set of listed poses.
    pub around: Vec<String>,
    /// Those of its poses around which there are no others.
    pub stays: Vec<String>,
    /// Its score.
    pub score_before: f64,
    /// How often the poses around a set were cast.
    pub rounds: usize,
    /// How many poses that were, in each scene, snapshot and repeat.
    pub cast: usize,
    /// The poses of the better set that are not listed.
    pub poses: Vec<FinePose>,
    /// The better set, if there is one.
    pub best: Option<SetReport>,
    /// By how much its score is above.
    pub gain: Option<f64>,
}

/// A pose that the study does not list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinePose {
    /// The sensor's name.
    pub sensor: String,
    /// The pose's name.
    pub pose: String,
    /// The listed pose that it was found from.
    pub near: String,
    /// x, y and z.
    pub position_m: [f64; 3],
    /// Its rotation, of the link frame.
    pub quaternion_wxyz: [f64; 4],
    /// Azimuth of where it looks, from x towards y.
    pub pan_deg: f64,
    /// How far above the horizon it looks.
    pub tilt_deg: f64,
    /// How far it is turned about where it looks.
    pub roll_deg: f64,
}

/// A step of the front.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// How many sensors were allowed.
    pub at_most: usize,
    /// What the set could cost at most.
    pub budget: Option<Cost>,
    /// The best set that was found.
    pub best: SetReport,
    /// What no set within these limits scores more than, if that is known.
    pub no_set_is_above: Option<f64>,
    /// Whether that is the best set's own score, because all others were searched.
    pub proven: bool,
    /// If not all were searched, what shows that no set is above; for a mean, for each of its scores.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shown_by: Vec<CutProof>,
    /// By how much the score is above that of the best set of fewer sensors that costs no more, if there is
    /// one.
    pub gain: Option<f64>,
}

/// A set in names and numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetReport {
    /// Its sensors and poses, as in `camera:wall/8/1`.
    pub poses: Vec<String>,
    /// What it costs, if the sensors have costs.
    pub cost: Option<Cost>,
    /// Its score.
    pub score: f64,
    /// The same as a fraction, if it is one. As text: other readers of JSON have no whole numbers of this
    /// size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exactly: Option<[String; 2]>,
    /// What there is to say of each sensor.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<SensorReport>,
}

/// A sensor of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorReport {
    /// The sensor's name.
    pub sensor: String,
    /// The pose's name.
    pub pose: String,
    /// Where that is, in words.
    pub place: String,
    /// What it costs.
    pub cost: Option<Cost>,
    /// The score of the set without it, if that has one.
    pub score_without: Option<f64>,
}

impl SetReport {
    /// A set of these sensors.
    pub(super) fn new(sensors: Vec<SensorReport>, worth: Worth) -> SetReport {
        let cost = |sum: Cost, one: &SensorReport| one.cost.map(|cost| sum.plus(cost));
        SetReport {
            poses: sensors.iter().map(|one| format!("{}:{}", one.sensor, one.pose)).collect(),
            cost: sensors.iter().try_fold(Cost::ZERO, cost),
            score: worth.value(),
            exactly: match worth {
                Worth::Exact(ratio) => Some([ratio.numerator.to_string(), ratio.denominator.to_string()]),
                Worth::Mean(_) => None,
            },
            sensors,
        }
    }

    /// Its score as a fraction, if it is one.
    pub(super) fn fraction(&self) -> Option<(i128, i128)> {
        let [numerator, denominator] = self.exactly.as_ref()?;
        Some((numerator.parse().ok()?, denominator.parse().ok()?))
    }

    /// As in the column `poses` of results.csv: `camera:wall/8/1;lidar:corners/0/0`.
    pub fn name(&self) -> String {
        self.poses.join(BETWEEN_MEMBERS)
    }
}

impl FrontReport {
    /// The step of the best set: that of the most sensors and the largest budget.
    pub fn best(&self) -> Option<&StepReport> {
        let most = self.steps.iter().map(|step| step.at_most).max()?;
        self.steps.iter().find(|step| step.at_most == most)
    }

    /// What would be the best set if sensors might disturb each other, if it is better.
    pub fn bound_by_disturb(&self) -> Option<&DisturbedReport> {
        let (if_disturbed, best) = (self.if_disturbed.as_ref()?, &self.best()?.best);
        let ratio =
            |set: &SetReport| set.fraction().map(|(numerator, denominator)| Ratio { numerator, denominator });
        let is_better = match (ratio(&if_disturbed.set), ratio(best)) {
            (Some(one), Some(other)) => one > other,
            _ => if_disturbed.set.score > best.score,
        };
        (is_better && !if_disturbed.disturbed.is_empty()).then_some(if_disturbed)
    }

    /// All sets, each once.
    pub(crate) fn sets(&self) -> impl Iterator<Item = &SetReport> {
        let refined = || self.refined.iter().flatten().filter_map(|refined| refined.best.as_ref());
        let sets = move || self.steps.iter().map(|step| &step.best).chain(&self.ties).chain(refined());
        let is_new = move |(number, set): &(usize, &SetReport)| {
            sets().take(*number).all(|earlier| earlier.poses != set.poses)
        };
        sets().enumerate().filter(is_new).map(|(_, set)| set)
    }

    /// Tells an answer.
    pub fn new(study: &Study, worlds: &[World], problem: &Problem, answer: &FrontAnswer) -> FrontReport {
        let teller = Teller { study, problem, places: Places::new(study, &worlds[0]) };
        let worth_telling = |(number, step): &(usize, &FrontStep)| {
            let is_first = *number == 0 || answer.steps[number - 1].limits.at_most != step.limits.at_most;
            is_first || (!answer.complete && step.bound != Bound::Proven) || !teller.is_known(step, answer)
        };
        let steps = answer.steps.iter().enumerate().filter(worth_telling);
        let steps: Vec<StepReport> = steps.filter_map(|(_, step)| teller.step(step, answer)).collect();
        // Of the steps of a size the first has the whole budget.
        let most = answer.steps.iter().map(|step| step.limits.at_most).max();
        let best = answer.steps.iter().find(|step| Some(step.limits.at_most) == most);
        let ties = best.map_or(Vec::new(), |step| ties(problem, worlds, step, answer));
        FrontReport {
            steps,
            ties: ties.iter().map(|found| teller.set(found)).collect(),
            refined: None,
            if_disturbed: None,
            stopped: !answer.complete,
            refining_stopped: false,
        }
    }
}

impl DisturbedReport {
    /// The best set of a search in which sensors may disturb each other; `problem` is the one in which they may not.
    pub(super) fn new(
        study: &Study,
        worlds: &[World],
        problem: &Problem,
        answer: &FrontAnswer,
    ) -> Option<DisturbedReport> {
        let report = FrontReport::new(study, worlds, problem, answer);
        let StepReport { best: set, proven, .. } = report.best()?;
        let items = &problem.evidence.items;
        let item = |name: &String| items.iter().position(|&item| pose_name(study, item) == *name);
        let own: Vec<usize> = set.poses.iter().filter_map(item).collect();
        let rules = &problem.rules;
        let hang_there = |a, b| rules.always.contains(&a) && rules.always.contains(&b);
        let pairs =
            own.iter().enumerate().flat_map(|(number, &a)| own[number + 1..].iter().map(move |&b| (a, b)));
        let disturbed = pairs.filter(|&(a, b)| !hang_there(a, b) && !rules.may_join(&[a], b));
        let disturbed = disturbed.map(|(a, b)| [a, b].map(|item| pose_name(study, items[item]))).collect();
        let set = SetReport { sensors: Vec::new(), ..set.clone() };
        Some(DisturbedReport { set, proven: *proven, disturbed })
    }
}

struct Teller<'a> {
    study: &'a Study,
    problem: &'a Problem<'a>,
    places: Places<'a>,
}

impl Teller<'_> {
    /// Whether fewer sensors that cost no more are as good.
    fn is_known(&self, step: &FrontStep, answer: &FrontAnswer) -> bool {
        let Some(best) = &step.best else { return true };
        let cost = self.problem.rules.cost_of(&best.set);
        answer.steps.iter().filter(|other| other.limits.at_most < step.limits.at_most).any(|other| {
            let other = other.best.as_ref();
            other.is_some_and(|other| {
                other.worth >= best.worth && self.problem.rules.cost_of(&other.set) <= cost
            })
        })
    }

    fn step(&self, step: &FrontStep, answer: &FrontAnswer) -> Option<StepReport> {
        let best = step.best.as_ref()?;
        let cost = self.problem.rules.cost_of(&best.set);
        let smaller = answer.steps.iter().filter(|other| other.limits.at_most < step.limits.at_most);
        let smaller = smaller.filter_map(|other| other.best.as_ref());
        let before = smaller
            .filter(|other| self.problem.rules.cost_of(&other.set) <= cost)
            .map(|other| other.worth)
            .max();
        let score = best.worth.value();
        Some(StepReport {
            at_most: step.limits.at_most,
            budget: step.limits.budget.map(Cost::from_thousandths),
            best: self.set(best),
            no_set_is_above: step.bound.upper_score(score),
            proven: step.bound == Bound::Proven,
            shown_by: match &step.bound {
                Bound::AtMost(gaps) => {
                    gaps.iter().map(|gap| CutProof::new(gap, |item| self.name(item))).collect()
                }
                _ => Vec::new(),
            },
            gain: before.map(|before| score - before.value()),
        })
    }

    fn name(&self, item: usize) -> String {
        let [sensor, candidate] = self.problem.evidence.items[item];
        let spec = &self.study.sensors[sensor];
        format!("{}:{}", spec.name, spec.candidates[candidate].name)
    }

    fn set(&self, found: &FoundSet) -> SetReport {
        let mut items = found.set.clone();
        // As in a combination, who speaks last stands last.
        let sensor = |item: usize| &self.study.sensors[self.problem.evidence.items[item][0]];
        items.sort_by_key(|&item| sensor(item).kind.speaks_last());
        SetReport::new(items.iter().map(|&item| self.sensor(item, &found.set)).collect(), found.worth)
    }

    fn sensor(&self, item: usize, set: &[usize]) -> SensorReport {
        let [sensor, candidate] = self.problem.evidence.items[item];
        let spec = &self.study.sensors[sensor];
        let others: Vec<usize> = set.iter().copied().filter(|&other| other != item).collect();
        SensorReport {
            sensor: spec.name.clone(),
            pose: spec.candidates[candidate].name.clone(),
            place: self.places.words(sensor, candidate),
            cost: spec.terms.cost,
            score_without: self.problem.worth_of(&others).map(Worth::value),
        }
    }
}
