//! Sensors at poses that the study does not list, as somebody else's search asks for them.

use super::{Combination, Member, Study};
use crate::Result;
use crate::backend::Fusion;
use crate::error::Issue;
use crate::pose::Pose;
use crate::sensor::{Candidate, Setting};

impl Study {
    /// The study of some of its sensors together, at these poses instead of their own: the first of each, the second of
    /// each and so on, each time as a combination with one choice. Candidates have their numbers as names. Poses of a sensor
    /// that a robot carries are on its link. Fused as where just these sensors are, else as in the first combination that has
    /// them all.
    ///
    /// # Errors
    /// Where a sensor takes no poses, or has not as many as the first.
    pub fn elsewhere(&self, poses: &[(usize, Vec<Pose>)]) -> Result<Study> {
        let count = poses.first().map_or(0, |(_, poses)| poses.len());
        for (sensor, poses) in poses {
            let spec = &self.sensors[*sensor];
            let wrong = |what: String| Issue::says(what).at(format!("sensor {:?}", spec.name));
            if !spec.kind.takes_poses() {
                return Err(wrong(format!("is of kind {:?}, which takes no poses", spec.kind.name())).into());
            }
            if poses.len() != count {
                let what = format!("has {} poses, and the first sensor has {count}", poses.len());
                return Err(wrong(what).wanted("give each as many").into());
            }
        }
        let mut sensors: Vec<usize> = poses.iter().map(|(sensor, _)| *sensor).collect();
        sensors.sort_unstable();
        let has = |combination: &Combination, one: &usize| {
            combination.members.iter().any(|member| member.sensor == *one)
        };
        let has_them = |combination: &&Combination| sensors.iter().all(|one| has(combination, one));
        let with_them: Vec<&Combination> = self.combinations.iter().filter(has_them).collect();
        let alone = with_them.iter().find(|combination| combination.members.len() == sensors.len());
        let fusion = alone.or(with_them.first()).map_or(Fusion::default(), |combination| combination.fusion);
        let mut study = self.clone();
        for other in &mut study.sensors {
            (other.candidates, other.spreads) = (Vec::new(), Vec::new());
        }
        for (sensor, poses) in poses {
            let candidate = |(number, &pose): (usize, &Pose)| Candidate {
                name: number.to_string(),
                group: String::new(),
                setting: Setting::Pose(pose),
            };
            study.sensors[*sensor].candidates = poses.iter().enumerate().map(candidate).collect();
        }
        let combination = |number: usize| {
            let member = |&sensor: &usize| Member { sensor, candidates: vec![number] };
            let members = sensors.iter().map(member).collect();
            Combination { name: number.to_string(), fusion, members }
        };
        study.combinations = (0..count).map(combination).collect();
        Ok(study)
    }
}
