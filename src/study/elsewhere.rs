//! A sensor at poses that the study does not list, as somebody else's search asks for them.

use super::{Combination, Member, Study};
use crate::Result;
use crate::backend::Fusion;
use crate::error::Issue;
use crate::pose::Pose;
use crate::sensor::{Candidate, Setting};

impl Study {
    /// The study of one of its sensors alone, at these poses instead of its own: candidates with their numbers as names.
    /// Poses of a sensor that a robot carries are on its link. Fused as where the sensor is alone, else as in the first
    /// combination with it.
    ///
    /// # Errors
    /// Where the sensor takes no poses.
    pub fn elsewhere(&self, sensor: usize, poses: &[Pose]) -> Result<Study> {
        let spec = &self.sensors[sensor];
        if !spec.kind.takes_poses() {
            let what = Issue::says(format!("is of kind {:?}, which takes no poses", spec.kind.name()));
            return Err(what.at(format!("sensor {:?}", spec.name)).into());
        }
        let with_it = || {
            let has_it = |combination: &&Combination| combination.members.iter().any(|m| m.sensor == sensor);
            self.combinations.iter().filter(has_it)
        };
        let alone = with_it().find(|combination| combination.members.len() == 1);
        let fusion = alone.or(with_it().next()).map_or(Fusion::default(), |combination| combination.fusion);
        let mut study = self.clone();
        for other in &mut study.sensors {
            (other.candidates, other.spreads) = (Vec::new(), Vec::new());
        }
        let candidate = |(number, &pose): (usize, &Pose)| Candidate {
            name: number.to_string(),
            group: String::new(),
            setting: Setting::Pose(pose),
        };
        study.sensors[sensor].candidates = poses.iter().enumerate().map(candidate).collect();
        let members = vec![Member { sensor, candidates: (0..poses.len()).collect() }];
        study.combinations = vec![Combination { name: spec.name.clone(), fusion, members }];
        Ok(study)
    }
}
