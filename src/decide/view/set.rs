//! Sets of poses that are not in a combination of the study.

use super::find::choice_names;
use super::names::{find_choices, plain};
use perirobot_march::backend::Fusion;
use perirobot_study::input::{Combination, Member, Study};
use perirobot_sweep::results::columns::BETWEEN_MEMBERS;

/// The study with one more combination, of the poses joined in a name as in `camera:wall/1/0;lidar:post/0`, if no
/// combination has such a choice. Unchanged if one has, if a combination is named, or if the name does not consist of
/// different poses of the study: `view::find` then reports the error.
pub fn with_set(study: Study, poses: &str, combination: Option<&str>) -> Study {
    let all: Vec<_> = study.combinations.iter().map(|known| choice_names(&study, known)).collect();
    if combination.is_some() || find_choices(&all, poses, None).is_ok() {
        return study;
    }
    let members: Option<Vec<[usize; 2]>> =
        poses.split(BETWEEN_MEMBERS).map(|part| pose(&study, part)).collect();
    let Some(mut members) = members else { return study };
    let is_twice = |(number, pose): (usize, &[usize; 2])| members[..number].contains(pose);
    if members.iter().enumerate().any(is_twice) {
        return study;
    }
    // In study order; in a combination, a sensor that takes precedence is last.
    members.sort_by_key(|&[sensor, candidate]| (study.sensors[sensor].kind.speaks_last(), sensor, candidate));
    let mut names = std::iter::successors(Some(String::from("set")), |name| Some(format!("{name}-2")));
    let is_free = |name: &String| study.combinations.iter().all(|known| known.name != *name);
    let name = names.find(is_free).expect("a study has fewer combinations than there are names");
    let member = |&[sensor, candidate]: &[usize; 2]| Member { sensor, candidates: vec![candidate] };
    let own = Combination { name, fusion: fusion(&study), members: members.iter().map(member).collect() };
    let combinations = study.combinations.iter().cloned().chain([own]).collect();
    Study { combinations, ..study }
}

/// The rule of fusion of all combinations, if equal; else that of the study.
fn fusion(study: &Study) -> Fusion {
    let mut all = study.combinations.iter().map(|known| known.fusion);
    all.next().filter(|first| all.all(|other| other == *first)).unwrap_or(study.fusion)
}

/// Sensor and candidate of `sensor:pose`; the sensor's name may be left out if only one sensor has a pose of that name.
fn pose(study: &Study, wanted: &str) -> Option<[usize; 2]> {
    let all = study.sensors.iter().enumerate().flat_map(|(number, sensor)| {
        let own = wanted.strip_prefix(&sensor.name).and_then(|rest| rest.strip_prefix(':')).unwrap_or(wanted);
        let meant = move |name: &str| plain(name) == plain(own);
        let poses = sensor.candidates.iter().enumerate();
        poses.filter(move |(_, pose)| meant(&pose.name)).map(move |(candidate, _)| [number, candidate])
    });
    let found: Vec<[usize; 2]> = all.collect();
    if let [one] = found[..] { Some(one) } else { None }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use perirobot_study::input::Overrides;
    use perirobot_sweep::results::columns::pose_names;

    /// The poses of the set that a name adds to a study, if any.
    fn set(poses: &str) -> Option<String> {
        let path =
            Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/tutorial/study.toml");
        let study = Study::load(&path, &Overrides::default()).unwrap();
        let before = study.combinations.len();
        let study = with_set(study, poses, None);
        study.combinations.get(before).map(|own| pose_names(&study, own, 0))
    }

    #[test]
    fn poses_that_no_combination_lists_are_a_set() {
        let four = "camera:left-wall/0/0;camera:ceiling/0/0;camera:ceiling/1/0;scanner:bench/0";
        assert_eq!(set(four).as_deref(), Some(four));
        let turned = "scanner:Bench/0;camera:ceiling/1/0;ceiling/0/0;camera:Left wall/0/0";
        assert_eq!(set(turned).as_deref(), Some(four), "in any order, spelled another way");
        for none in ["camera:ceiling/0/0", "camera:nowhere;camera:ceiling/0/0", "ceiling/0/0;ceiling/0/0", ""]
        {
            assert_eq!(set(none), None, "{none}");
        }
    }
}
