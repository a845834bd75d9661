//! The sets of an answer as combinations of their study, so that they are swept and examined like any others.

use super::files::PROOF;
use super::report::{FrontReport, SensorReport, SetReport};
use perirobot_cover::Worth;
use perirobot_march::backend::Fusion;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::pose::{Pose, RotationFrame};
use perirobot_study::input::{Choose, Combination, Member, Study};
use perirobot_study::sensor::{Candidate, Sensor, Setting};
use perirobot_sweep::results::{Results, RowKey};

impl FrontReport {
    /// The study of the found sets, each a combination with one choice of poses; sensors have the representations of
    /// the search.
    pub fn study_of_sets(&self, study: &Study, choose: &Choose) -> Study {
        let combinations =
            self.sets().map(|set| combination(study, choose.fusion, self.title(set), set)).collect();
        study.with_combinations(&choose.representations, combinations)
    }

    /// The study with the poses that refining found, if any.
    ///
    /// # Errors
    /// If they do not belong to the study's sensors.
    pub fn with_poses(&self, study: &Study) -> Result<Option<Study>> {
        let mut with_poses = study.clone();
        let poses: Vec<_> = self.refined.iter().flatten().flat_map(|refined| &refined.poses).collect();
        if poses.is_empty() {
            return Ok(None);
        }
        for fine in poses {
            let sensor = with_poses.sensors.iter_mut().find(|sensor| sensor.name == fine.sensor);
            let near = |sensor: &Sensor| sensor.candidates.iter().find(|one| one.name == fine.near).cloned();
            let pose =
                Pose::from_quaternion(fine.position_m.into(), fine.quaternion_wxyz, RotationFrame::Link).ok();
            let (Some((near, sensor)), Some(pose)) =
                (sensor.and_then(|sensor| Some((near(sensor)?, sensor))), pose)
            else {
                let what = format!("refined: {}:{} is not near a pose of the study", fine.sensor, fine.pose);
                return Err(Issue::damaged(what).cure("choose again").with_place(PROOF).into());
            };
            let (name, group) = (fine.pose.clone(), near.group);
            sensor.candidates.push(Candidate { name, group, setting: Setting::Pose(pose) });
        }
        Ok(Some(with_poses))
    }

    /// The name for the group of refined poses, unused in the study.
    pub(super) fn group_of_refined(study: &Study) -> String {
        let is_free = |group: &String| {
            let begin = format!("{group}/");
            let mut names = study.sensors.iter().flat_map(|sensor| &sensor.candidates);
            !names.any(|candidate| candidate.name.starts_with(&begin))
        };
        let numbered = (2..).map(|number| format!("refined-{number}"));
        let mut names = std::iter::once("refined".to_string()).chain(numbered);
        names.find(is_free).expect("a study has few groups")
    }

    /// The index of the best set among those of [`FrontReport::study_of_sets`].
    pub fn best_set(&self) -> Option<usize> {
        let best = &self.best()?.best;
        self.sets().position(|set| set.poses == best.poses)
    }

    /// Fails unless a sweep of the sets confirms their scores.
    pub fn agrees(&self, choose: &Choose, results: &Results) -> Result<()> {
        for (combination, set) in self.sets().enumerate() {
            let key = RowKey { combination, choice: 0, representation: 0, region: choose.region };
            let counts = results.readings(results.moments(), &key)?.concat();
            let swept = Worth::from_counts(choose.objective, choose.over, &counts).map(Worth::value);
            if swept != Some(set.score) {
                let (name, score, set) = (choose.objective.name(), set.score, set.name());
                let what = format!(
                    "{set} was chosen for {name} {score}, but swept it has {swept:?}: please report this"
                );
                return Err(Error::Disagreement(Issue::says(what)));
            }
        }
        Ok(())
    }

    /// `best 2`, `best 2 for 900`, `tie 1`: the first step whose best set it is, or its place among the ties.
    fn title(&self, set: &SetReport) -> String {
        let is_set = |other: &SetReport| other.poses == set.poses;
        if let Some(step) = self.steps.iter().find(|step| is_set(&step.best)) {
            let cost = set.cost.map_or(String::new(), |cost| format!(" for {cost}"));
            return format!("best {}{cost}", step.at_most);
        }
        let refined = self.refined.iter().flatten().find(|refined| refined.best.as_ref().is_some_and(is_set));
        if let Some(refined) = refined {
            return format!("refined {}", refined.at_most);
        }
        let number = self.ties.iter().position(is_set).unwrap_or_default();
        format!("tie {}", number + 1)
    }
}

fn combination(study: &Study, fusion: Fusion, name: String, set: &SetReport) -> Combination {
    let member = |one: &SensorReport| {
        let sensor = study.sensors.iter().position(|known| known.name == one.sensor);
        let sensor = sensor.expect("an answer names the study's sensors");
        let candidates = &study.sensors[sensor].candidates;
        let candidate = candidates.iter().position(|known| known.name == one.pose);
        Member { sensor, candidates: vec![candidate.expect("an answer names the study's poses")] }
    };
    Combination { name, fusion, members: set.sensors.iter().map(member).collect() }
}
