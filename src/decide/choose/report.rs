//! An answer in names and numbers: the front, the worth of each sensor of a set, and different sets that are nearly as
//! good. Tables, texts and files are made from it, and `choose.json` contains it.

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
    /// The front: by size, and within a size from the most expensive set down. Cheaper sets that are no better than a
    /// smaller one of at most their cost are left out.
    pub steps: Vec<StepReport>,
    /// Sets nearly as good as the best one, with at least one sensor at another place, best first.
    #[serde(rename = "nearly_as_good")]
    pub ties: Vec<SetReport>,
    /// The sets found between the listed poses around the best set of each size, if requested. They have no proof.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refined: Option<Vec<RefinedReport>>,
    /// The best set without the exclusion of disturbing pairs, if the study excludes them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub if_disturbed: Option<DisturbedReport>,
    /// Whether the search was stopped: larger sets, and cheaper ones, may be missing.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stopped: bool,
    /// Whether refining was stopped: a larger gain may exist.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub refining_stopped: bool,
}

/// The best set without the exclusion of disturbing pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DisturbedReport {
    /// The set, without details of its sensors.
    #[serde(flatten)]
    pub set: SetReport,
    /// Whether it is proven.
    pub proven: bool,
    /// Pairs of its sensors that disturb each other, each as in `camera:wall/8/1`.
    pub disturbed: Vec<[String; 2]>,
}

/// The result of refining the best set of a size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RefinedReport {
    /// The most sensors.
    pub at_most: usize,
    /// The budget.
    pub budget: Option<Cost>,
    /// The set of listed poses.
    pub around: Vec<String>,
    /// Its poses that have no neighbours.
    pub stays: Vec<String>,
    /// Its score.
    pub score_before: f64,
    /// The number of rounds of casting around a set.
    pub rounds: usize,
    /// The number of cast poses, in each scene, snapshot and repeat.
    pub cast: usize,
    /// The unlisted poses of the better set.
    pub poses: Vec<FinePose>,
    /// The better set, if any.
    pub best: Option<SetReport>,
    /// Its gain in score.
    pub gain: Option<f64>,
}

/// A pose that the study does not list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinePose {
    /// The sensor's name.
    pub sensor: String,
    /// The pose's name.
    pub pose: String,
    /// The listed pose that it was refined from.
    pub near: String,
    /// x, y and z.
    pub position_m: [f64; 3],
    /// Its rotation, of the link frame.
    pub quaternion_wxyz: [f64; 4],
    /// Azimuth of its direction of view, from x towards y.
    pub pan_deg: f64,
    /// Elevation of its direction of view above the horizon.
    pub tilt_deg: f64,
    /// Rotation about its direction of view.
    pub roll_deg: f64,
}

/// A step of the front.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// The most sensors.
    pub at_most: usize,
    /// The budget.
    pub budget: Option<Cost>,
    /// The best set found.
    pub best: SetReport,
    /// Upper bound of the score within these limits, if known.
    pub no_set_is_above: Option<f64>,
    /// Whether the best set is proven, because all others were searched.
    pub proven: bool,
    /// If not all were searched, the proof of the bound; for a mean, of each of its scores.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shown_by: Vec<CutProof>,
    /// Gain of the score over the best set of fewer sensors at no higher cost, if any.
    pub gain: Option<f64>,
}

/// A set in names and numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetReport {
    /// Its sensors and poses, as in `camera:wall/8/1`.
    pub poses: Vec<String>,
    /// Its cost, if the sensors have costs.
    pub cost: Option<Cost>,
    /// Its score.
    pub score: f64,
    /// The score as a fraction, if it is one. As text, since JSON readers lack integers of this size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exactly: Option<[String; 2]>,
    /// Details of each sensor.
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
    /// The place in words.
    pub place: String,
    /// Its cost.
    pub cost: Option<Cost>,
    /// The score of the set without it, if defined.
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

    /// The score as a fraction, if it is one.
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

    /// The best set without the exclusion of disturbing pairs, if it is better.
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

    /// The report of an answer.
    pub fn new(study: &Study, worlds: &[World], problem: &Problem, answer: &FrontAnswer) -> FrontReport {
        let reporter = Reporter { study, problem, places: Places::new(study, &worlds[0]) };
        let is_reported = |(number, step): &(usize, &FrontStep)| {
            let is_first = *number == 0 || answer.steps[number - 1].limits.at_most != step.limits.at_most;
            is_first || (!answer.complete && step.bound != Bound::Proven) || !reporter.is_known(step, answer)
        };
        let steps = answer.steps.iter().enumerate().filter(is_reported);
        let steps: Vec<StepReport> = steps.filter_map(|(_, step)| reporter.step(step, answer)).collect();
        // The first step of a size has the whole budget.
        let most = answer.steps.iter().map(|step| step.limits.at_most).max();
        let best = answer.steps.iter().find(|step| Some(step.limits.at_most) == most);
        let ties = best.map_or(Vec::new(), |step| ties(problem, worlds, step, answer));
        FrontReport {
            steps,
            ties: ties.iter().map(|found| reporter.set(found)).collect(),
            refined: None,
            if_disturbed: None,
            stopped: !answer.complete,
            refining_stopped: false,
        }
    }
}

impl DisturbedReport {
    /// The best set of a search without the exclusion of disturbing pairs; `problem` is the one with it.
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

struct Reporter<'a> {
    study: &'a Study,
    problem: &'a Problem<'a>,
    places: Places<'a>,
}

impl Reporter<'_> {
    /// Whether fewer sensors at no higher cost are as good.
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
        // In a combination, the sensor that takes precedence is last.
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
