//! How fast objects move at each snapshot of their scene, for sensors that detect motion only.
//!
//! The first of these decides:
//!
//! 1. `speed_m_s` of the object, or its list in `snapshots`, or the speed of its walk;
//! 2. the times of its animation: the farthest way of a point of its surface since the snapshot before, or, at the
//!    first, to the next, over the time between; of lists that begin anew, to the moment that is nearest in time;
//! 3. the same of what carries it: its speed, or its times.
//!
//! Speeds are whole millimetres a second, so that they compare alike everywhere.

use std::sync::Arc;

use super::spec::ObjectSpec;
use super::{Object, ObjectCarrier, Surface};

/// A speed in whole millimetres a second.
pub fn to_mm_s(speed_m_s: f64) -> u32 {
    (speed_m_s * 1e3).round() as u32
}

/// Whether the speed of an object of a scene file is known at every snapshot.
pub fn is_known(object: &ObjectSpec, all: &[ObjectSpec]) -> bool {
    let has_times = |object: &ObjectSpec| {
        let times = &object.motion.times_s;
        times.iter().any(|time| *time != times[0])
    };
    // What is put down does not have its carrier's speed.
    let chain =
        with_carriers(object, all, |one| one.on.clone().filter(|_| !one.motion.carried.contains(&false)));
    chain.into_iter().any(|one| one.speed_m_s.is_some() || !one.motion.speed_m_s.is_empty() || has_times(one))
}

/// For each snapshot how fast each part of an object moves; `moments` are its parts in each snapshot.
pub(super) fn speeds_mm_s(
    object: &ObjectSpec,
    all: &[ObjectSpec],
    moments: &[Vec<Arc<Object>>],
) -> Vec<Vec<Option<u32>>> {
    let of = |(snapshot, parts): (usize, &Vec<Arc<Object>>)| {
        let chain = with_carriers(object, all, |one| one.snapshot(snapshot).on);
        let source = chain.into_iter().find_map(|one| source(one, snapshot, moments.len()));
        let part = |(number, part): (usize, &Arc<Object>)| match source? {
            SpeedSource::Written(speed_m_s) => Some(to_mm_s(speed_m_s)),
            SpeedSource::Since { snapshot, seconds } => {
                Some(to_mm_s(farthest_way_m(moments[snapshot].get(number)?, part) / seconds))
            }
        };
        parts.iter().enumerate().map(part).collect()
    };
    moments.iter().enumerate().map(of).collect()
}

/// An object, what carries it, and so on. Objects that carry each other are refused before.
fn with_carriers<'a>(
    object: &'a ObjectSpec,
    all: &'a [ObjectSpec],
    on: impl Fn(&ObjectSpec) -> Option<ObjectCarrier>,
) -> Vec<&'a ObjectSpec> {
    let carrier = |one: &&'a ObjectSpec| {
        let on = on(one)?;
        all.iter().find(|other| other.name == on.object)
    };
    std::iter::successors(Some(object), carrier).take(all.len() + 1).collect()
}

/// What decides how fast an object is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SpeedSource {
    /// The scene file, in metres a second.
    Written(f64),
    /// Its distance from its place at another snapshot, this many seconds before or after.
    Since { snapshot: usize, seconds: f64 },
}

fn source(object: &ObjectSpec, snapshot: usize, snapshots: usize) -> Option<SpeedSource> {
    if let Some(speed_m_s) = object.snapshot(snapshot).speed_m_s {
        return Some(SpeedSource::Written(speed_m_s));
    }
    let times_s = &object.motion.times_s;
    let time_s = |snapshot: usize| times_s[snapshot % times_s.len()];
    if times_s.is_empty() {
        return None;
    }
    let now_s = time_s(snapshot);
    let since = |other: usize| SpeedSource::Since { snapshot: other, seconds: (now_s - time_s(other)).abs() };
    // Lists that repeat, or are crossed, have the same time again, or begin anew.
    let is_other = |other: &usize| time_s(*other) != now_s;
    let before = (0..snapshot).rev().find(is_other).filter(|&other| time_s(other) < now_s);
    let after = || (snapshot + 1..snapshots).find(is_other).filter(|&other| time_s(other) > now_s);
    let nearest = || {
        let others = (0..snapshots).filter(is_other);
        others.min_by(|a, b| (time_s(*a) - now_s).abs().total_cmp(&(time_s(*b) - now_s).abs()))
    };
    before.or_else(after).or_else(nearest).map(since)
}

/// How far the fastest point of a part is from where it is at another moment, in metres: of its surface, if that has the
/// same points, else of its known joints, else the middle of its box.
fn farthest_way_m(from: &Arc<Object>, to: &Arc<Object>) -> f64 {
    if Arc::ptr_eq(from, to) {
        return 0.0;
    }
    match (&from.surface, &to.surface) {
        (Surface::Mesh(from), Surface::Mesh(to)) if from.triangles == to.triangles => {
            let ways = from.vertices.iter().zip(&to.vertices).map(|(from, to)| (*to - *from).length());
            return ways.fold(0.0, f64::max);
        }
        _ => {}
    }
    if let (Some(from), Some(to)) = (&from.keypoints, &to.keypoints) {
        let joints = from.iter().zip(to).filter_map(|(from, to)| Some((((*to)?) - ((*from)?)).length()));
        return joints.fold(0.0, f64::max);
    }
    let middle = |object: &Object| match &object.surface {
        Surface::Mesh(mesh) => mesh.bounds().map(|(low, high)| (low + high) / 2.0),
        Surface::Voxels { .. } => None,
    };
    middle(from).zip(middle(to)).map_or(0.0, |(from, to)| (to - from).length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::gltf::WhichClip;
    use crate::objects::spec::{MotionSpec, SurfaceSpec};
    use crate::objects::{Interior, ObjectCarrier, Optical, RadarOptics, Role, primitive};
    use glam::{DQuat, DVec3};

    fn object(name: &str, motion: MotionSpec) -> ObjectSpec {
        ObjectSpec {
            name: name.into(),
            role: Role::Human,
            interior: Interior::Ignored,
            optical: Optical::Opaque,
            radar: RadarOptics::Stops,
            speed_m_s: None,
            reflectance: None,
            specular: None,
            shade: 0,
            person_shade: 0,
            tag_only: false,
            on: None,
            position_m: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            surface: SurfaceSpec::Box { size_m: DVec3::ONE },
            keypoints: None,
            nodes: Vec::new(),
            animated: None,
            motion,
        }
    }

    /// A cube at each of these places along x.
    fn moments(along_m: &[f64]) -> Vec<Vec<Arc<Object>>> {
        let at = |x: &f64| {
            let mesh = primitive::cuboid(DVec3::splat(0.1)).transform(DQuat::IDENTITY, DVec3::X * *x);
            vec![Arc::new(Object {
                name: "cube".into(),
                role: Role::Human,
                interior: Interior::Ignored,
                optical: Optical::Opaque,
                radar: RadarOptics::Stops,
                shade: 0,
                tag_only: false,
                takes_unit: false,
                surface: Surface::Mesh(mesh),
                frame: crate::pose::Pose::ORIGIN,
                keypoints: None,
                linkage: None,
                warnings: Vec::new(),
            })]
        };
        along_m.iter().map(at).collect()
    }

    fn speeds(object: &ObjectSpec, all: &[ObjectSpec], along_m: &[f64]) -> Vec<Option<u32>> {
        speeds_mm_s(object, all, &moments(along_m)).into_iter().map(|mut parts| parts.remove(0)).collect()
    }

    fn timed(times_s: &[f64]) -> MotionSpec {
        MotionSpec { times_s: times_s.to_vec(), clip: WhichClip::Only, ..MotionSpec::default() }
    }

    #[test]
    fn written_speeds_come_before_times() {
        let mut walker = object("walker", timed(&[0.0, 1.0, 2.0]));
        let along_m = [0.0, 0.5, 0.6];
        assert_eq!(speeds(&walker, &[], &along_m), [Some(500), Some(500), Some(100)]);
        walker.speed_m_s = Some(1.6);
        assert_eq!(speeds(&walker, &[], &along_m), [Some(1600); 3]);
        walker.motion.speed_m_s = vec![0.0, 0.25, 1.0];
        assert_eq!(speeds(&walker, &[], &along_m), [Some(0), Some(250), Some(1000)]);
        assert!(is_known(&walker, &[]));
    }

    /// Crossed lists hold an entry for several snapshots, and repeated lists begin again.
    #[test]
    fn equal_times_are_one_moment_and_earlier_ones_begin_anew() {
        let crossed = object("crossed", timed(&[0.0, 0.0, 2.0, 2.0]));
        assert_eq!(speeds(&crossed, &[], &[0.0, 0.0, 1.0, 1.0]), [Some(500); 4]);
        let repeated = object("repeated", timed(&[0.0, 2.0, 0.0, 2.0]));
        assert_eq!(speeds(&repeated, &[], &[0.0, 1.0, 0.0, 1.0]), [Some(500); 4]);
        let cycle = object("cycle", MotionSpec { cycle: true, ..timed(&[0.0, 1.0, 3.0]) });
        assert_eq!(
            speeds(&cycle, &[], &[0.0, 1.0, 2.0, 0.0, 1.0]),
            [Some(1000), Some(1000), Some(500), Some(1000), Some(1000)]
        );
    }

    #[test]
    fn the_last_moment_of_a_list_that_begins_anew_has_a_speed() {
        let cycle = object("cycle", MotionSpec { cycle: true, ..timed(&[0.0, 1.0, 2.0]) });
        assert_eq!(speeds(&cycle, &[], &[0.0, 0.5, 0.6, 0.0]), [Some(500), Some(500), Some(100), Some(500)]);
    }

    #[test]
    fn who_is_put_down_does_not_have_the_carts_speed() {
        let cart = ObjectSpec { speed_m_s: Some(1.0), ..object("cart", MotionSpec::default()) };
        let on = Some(ObjectCarrier { object: "cart".into(), link: None });
        let motion = MotionSpec { carried: vec![true, false], ..MotionSpec::default() };
        let driver = ObjectSpec { on, ..object("driver", motion) };
        let all = [cart, driver.clone()];
        assert_eq!(speeds(&driver, &all, &[0.0, 0.0]), [Some(1000), None]);
        assert!(!is_known(&driver, &all));
    }

    #[test]
    fn without_speed_or_times_it_is_unknown() {
        for motion in [MotionSpec::default(), timed(&[3.0]), timed(&[3.0, 3.0])] {
            let still = object("still", motion);
            assert_eq!(speeds(&still, &[], &[0.0, 1.0]), [None, None]);
            assert!(!is_known(&still, &[]));
        }
        let listed =
            MotionSpec { position_m: vec![DVec3::ZERO; 2], dwell_s: vec![1.0; 2], ..Default::default() };
        assert!(!is_known(&object("listed", listed), &[]), "how long it stays is not how fast it moves");
    }

    #[test]
    fn what_a_robot_carries_has_the_robots_speed_or_times() {
        let on = Some(ObjectCarrier { object: "robot".into(), link: Some("tool0".into()) });
        let part = ObjectSpec { on, ..object("part", MotionSpec::default()) };
        let with = |robot: ObjectSpec| speeds(&part, &[robot, part.clone()], &[0.0, 0.5]);
        assert_eq!(with(object("robot", timed(&[0.0, 0.25]))), [Some(2000); 2]);
        assert_eq!(
            with(ObjectSpec { speed_m_s: Some(0.3), ..object("robot", timed(&[0.0, 1.0])) }),
            [Some(300); 2]
        );
        assert_eq!(with(object("robot", MotionSpec::default())), [None; 2]);
    }
}
