//! Sensors at poses that the study does not list, as a search outside of this program requests them.

use std::collections::HashMap;

use super::{Combination, Member, Study};
use crate::sensor::{Candidate, Sensor, Setting, quantise_q15};
use perirobot_march::Result;
use perirobot_march::backend::Fusion;
use perirobot_march::error::Issue;
use perirobot_march::march::fold;
use perirobot_march::voxel::grid::length_q16;
use perirobot_scene::pose::Pose;

impl Study {
    /// The study of some of its sensors together, at these poses instead of their own: the first of each entry, the
    /// second of each and so on, each time as a combination with one choice. A sensor with several entries is several
    /// equal sensors. Candidates have their numbers as names. Poses of a sensor that a robot carries are on its link.
    /// Fusion is that of the combination of exactly these sensors, else of the first that has them all. Draws depend on
    /// nothing but the pose (`SEMANTICS.md`, Noise).
    ///
    /// # Errors
    /// A sensor that takes no poses, or has fewer or more of them than the first.
    pub fn elsewhere(&self, poses: &[(usize, Vec<Pose>)]) -> Result<Study> {
        let count = poses.first().map_or(0, |(_, poses)| poses.len());
        for (sensor, poses) in poses {
            let spec = &self.sensors[*sensor];
            let wrong = |what: String| Issue::says(what).with_place(format!("sensor {:?}", spec.name));
            if !spec.kind.takes_poses() {
                return Err(wrong(format!("is of kind {:?}, which takes no poses", spec.kind.name())).into());
            }
            if poses.len() != count {
                let what = format!("has {} poses, and the first sensor has {count}", poses.len());
                return Err(wrong(what).with_advice("give each as many").into());
            }
        }
        let mut entries: Vec<&(usize, Vec<Pose>)> = poses.iter().collect();
        entries.sort_by_key(|(sensor, _)| *sensor);
        let mut study = self.clone();
        for other in &mut study.sensors {
            (other.candidates, other.spreads, other.draw_words) = (Vec::new(), Vec::new(), Vec::new());
        }
        let mut members: Vec<Member> = Vec::new();
        for of_one in entries.chunk_by(|(one, _), (next, _)| one == next) {
            let sensor = of_one[0].0;
            let listed = self.draw_words(&self.sensors[sensor], of_one.len() > 1);
            for (copy, (_, poses)) in of_one.iter().enumerate() {
                members.push(Member { sensor, candidates: Vec::new() });
                for (number, &pose) in poses.iter().enumerate() {
                    let name = if copy == 0 { number.to_string() } else { format!("{number}/{copy}") };
                    let (group, setting) = (String::new(), Setting::Pose(pose));
                    let spec = &mut study.sensors[sensor];
                    members.last_mut().expect("it was just added").candidates.push(spec.candidates.len());
                    spec.candidates.push(Candidate { name, group, setting });
                    let words = self.quantise(&pose);
                    spec.draw_words.push(*listed.get(&words).unwrap_or(&(1 << 31 | fold(words) >> 1)));
                }
            }
        }
        let fusion = self.fusion_of(&members);
        let combination = |number: usize| {
            let member =
                |all: &Member| Member { sensor: all.sensor, candidates: vec![all.candidates[number]] };
            let mut members: Vec<Member> = members.iter().map(member).collect();
            // Equal sensors speak in the order of their candidates, as in a sweep.
            members.sort_by_key(|one| (one.sensor, study.sensors[one.sensor].draw_word(one.candidates[0])));
            Combination { name: number.to_string(), fusion, members }
        };
        let combinations = (0..count).map(combination).collect();
        study.combinations = combinations;
        Ok(study)
    }

    /// The fusion of the combination of exactly these sensors, else of the first that has them all.
    fn fusion_of(&self, members: &[Member]) -> Fusion {
        let sensors = |members: &[Member]| {
            let mut sensors: Vec<usize> = members.iter().map(|member| member.sensor).collect();
            sensors.sort_unstable();
            sensors
        };
        let wanted = sensors(members);
        let is_just = |combination: &&Combination| sensors(&combination.members) == wanted;
        let has_all = |combination: &&Combination| {
            let known = sensors(&combination.members);
            wanted.iter().all(|one| known.contains(one))
        };
        let all = || self.combinations.iter();
        let found = all().find(is_just).or_else(|| all().find(has_all));
        found.map_or(Fusion::default(), |combination| combination.fusion)
    }

    /// The numbers of a sensor's listed poses by their whole numbers, the first of several; none if they make no
    /// difference.
    fn draw_words(&self, sensor: &Sensor, are_several: bool) -> HashMap<[u32; 12], u32> {
        let matter = are_several || sensor.kind.is_noisy() || sensor.kind.calibration().is_some();
        let candidates = sensor.candidates.iter().filter(|_| matter).zip(0..);
        let mut words = HashMap::new();
        for (candidate, number) in candidates {
            words.entry(self.quantise(&candidate.setting.pose())).or_insert(number);
        }
        words
    }

    /// A pose in whole numbers: its position in 1/65536 voxels, and its rotation row by row in Q15.
    pub(super) fn quantise(&self, pose: &Pose) -> [u32; 12] {
        let (at, link) = (pose.position_m.to_array(), pose.link());
        std::array::from_fn(|number| match number.checked_sub(3) {
            None => length_q16(at[number], self.voxel_size_m) as u32,
            Some(entry) => quantise_q15(link.col(entry % 3)[entry / 3]) as u32,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DVec3;

    use super::*;
    use crate::input::Overrides;
    use crate::world::World;

    /// A listed pose draws as its candidate, any other one as itself, whatever other poses are requested.
    #[test]
    fn a_pose_draws_what_belongs_to_it() {
        let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/sensors.toml");
        let study = Study::load(&file, &Overrides::default()).unwrap();
        let listed: Vec<Pose> = study.sensors[0].candidates.iter().map(|one| one.setting.pose()).collect();
        let mut free = listed[1];
        free.position_m += DVec3::new(0.013, 0.0, 0.007);
        // The other sign of a quaternion is the same rotation.
        let turned = Pose { rotation: -listed[3].rotation, ..listed[3] };
        let words = |poses: &[Pose]| {
            let other = study.elsewhere(&[(0, poses.to_vec())]).unwrap();
            (0..poses.len()).map(|number| other.sensors[0].draw_word(number)).collect::<Vec<_>>()
        };
        let all = words(&[listed[2], free, turned, listed[0]]);
        assert_eq!((all[0], all[2], all[3]), (2, 3, 0));
        assert!(all[1] >= 1 << 31, "{}", all[1]);
        assert_eq!(words(&[free, listed[0]]), [all[1], 0]);
        let hash =
            study.quantise(&free).into_iter().fold(0, |hash, word| perirobot_march::march::pcg(hash ^ word));
        assert_eq!(all[1] as u32, (1 << 31) + hash / 2);
        // Two equal sensors are two candidates of one, each with its own draws.
        let two = study.elsewhere(&[(0, vec![free, listed[0]]), (0, vec![listed[2], free])]).unwrap();
        let chosen = |number: usize| {
            let members = two.combinations[number].members.iter();
            members.map(|one| two.sensors[one.sensor].draw_word(one.candidates[0])).collect::<Vec<_>>()
        };
        assert_eq!([chosen(0), chosen(1)], [[2, all[1]], [0, all[1]]]);
        assert_eq!(two.sensors[0].candidates[3].name, "1/1");
        // The words are those of the draws.
        let worlds = World::prepare_all(&study).unwrap();
        let moved = worlds[0].with_sensors(&two.sensors);
        let draws = |candidate| moved.placement(&two, 0, candidate, 0).draws;
        assert_eq!(draws(2), worlds[0].placement(&study, 0, 2, 0).draws);
        assert_eq!((draws(0), draws(3)), (draws(3), draws(0)));
    }
}
