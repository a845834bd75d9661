//! Finds the chosen and swept sets of a manifest in a study.

use super::identity::{Identity, Sensors};
use perirobot_study::input::{Combination, Member, Study};
use perirobot_study::sensor::Sensor;

impl Identity {
    /// The study of the swept sets; `None` if combinations have several choices of poses, sensors have several
    /// representations, or something is not in the study.
    pub(crate) fn study_of_sets(&self, study: &Study) -> Option<Study> {
        let way = |sensor: &Sensor| {
            let swept = self.sensors.iter().find(|swept| swept.name == sensor.name)?;
            let [name] = swept.representations.as_slice() else { return None };
            sensor.kind.representations().iter().position(|known| known == name)
        };
        let ways: Option<Vec<usize>> = study.sensors.iter().map(way).collect();
        let sets: Option<Vec<Combination>> =
            self.combinations.iter().map(|entry| set(study, entry)).collect();
        Some(study.with_combinations(&ways?, sets?))
    }
}

fn set(study: &Study, entry: &Sensors) -> Option<Combination> {
    let member = |(name, ranges): (&String, &Vec<[usize; 2]>)| {
        let sensor = study.sensors.iter().position(|sensor| sensor.name == *name)?;
        let [[candidate, end]] = ranges[..] else { return None };
        let is_one = candidate < study.sensors[sensor].candidates.len() && candidate + 1 == end;
        is_one.then(|| Member { sensor, candidates: vec![candidate] })
    };
    let members: Option<Vec<Member>> = entry.sensors.iter().zip(&entry.poses).map(member).collect();
    Some(Combination { name: entry.name.clone(), fusion: entry.fusion, members: members? })
}
