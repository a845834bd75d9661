//! Finds people whose bodies are no people's: too large or too small, mirrored, or turned into the floor because their
//! file has another axis up.

use glam::DVec3;

use perirobot_march::voxel::{rounded_down, rounded_up};
use perirobot_scene::objects::keypoints::{ANKLES, EARS, HIPS, KNEES, Keypoints, NOSE, SHOULDERS};
use perirobot_scene::truth::ObjectVoxels;

/// How tall people are, in metres.
const STATURE_M: [f64; 2] = [1.2, 2.2];
/// Stature by the length of shank, thigh, trunk and from shoulders to nose: soles and the top of the head are beyond.
const STATURE_OF_BONES: f64 = 1.157;
/// With arms raised a body is longer than it is tall, in metres.
const LONGEST_M: f64 = 2.9;
/// A bone is level, or points down, by its rise over its length.
const LEVEL: f64 = 0.5;
/// Whoever lies on the floor has joints that are on average higher above it, in metres.
const LYING_M: f64 = 0.05;
/// People look to the side, but not so far back, as a cosine.
const BACK: f64 = -0.3;

/// What is wrong with a body, which also explains where it is. A body that is not whole may be small.
pub(super) fn fault(
    joints: Option<&Keypoints>,
    body: &ObjectVoxels,
    is_whole: bool,
    floor_m: f64,
) -> Option<String> {
    match joints {
        Some(joints) => match tall_m(joints) {
            Some(tall_m) => stature(tall_m),
            None => length(body, [0.0, LONGEST_M]),
        }
        .or_else(|| describe_turned(joints, floor_m)),
        None if is_whole => length(body, STATURE_M),
        None => length(body, [0.0, STATURE_M[1]]),
    }
}

/// The mean of what is known of a pair.
fn middle(joints: &Keypoints, pair: [usize; 2]) -> Option<DVec3> {
    let known: Vec<DVec3> = pair.iter().filter_map(|&joint| joints[joint]).collect();
    (!known.is_empty()).then(|| known.iter().sum::<DVec3>() / known.len() as f64)
}

/// How tall a person is by the bones; unknown if one of them is.
fn tall_m(joints: &Keypoints) -> Option<f64> {
    // Of the side of which more is known.
    let bone = |from: [usize; 2], to: [usize; 2]| {
        (0..2).find_map(|side| Some((joints[from[side]]? - joints[to[side]]?).length()))
    };
    let [shoulders, hips] = [SHOULDERS, HIPS].map(|pair| middle(joints, pair));
    let head = (joints[NOSE]? - shoulders?).length();
    let bones_m = bone(KNEES, ANKLES)? + bone(HIPS, KNEES)? + (shoulders? - hips?).length() + head;
    Some(STATURE_OF_BONES * bones_m)
}

fn stature(tall_m: f64) -> Option<String> {
    let [least, most] = STATURE_M;
    (!(least..=most).contains(&tall_m)).then(|| {
        let tall = if tall_m < least { rounded_down(tall_m, 2) } else { rounded_up(tall_m, 2) };
        format!(
            "is {tall} m tall by its joints, and people are {least} to {most} m: is the unit of its file right? Joints in a \
             table are metres"
        )
    })
}

/// The same of a body without joints, or without some of them, by its longest side, which must be within bounds.
fn length(body: &ObjectVoxels, [shortest, longest]: [f64; 2]) -> Option<String> {
    let [least, most] = STATURE_M;
    let size = body.bounds_m[1] - body.bounds_m[0];
    let long_m = size.max_element();
    let [x, y, z] = size.to_array();
    (!(shortest - 1e-6..=longest + 1e-6).contains(&long_m)).then(|| {
        format!(
            "is {x:.2} × {y:.2} × {z:.2} m, and people are {least} to {most} m tall: is its unit or its size right?"
        )
    })
}

/// Somebody who lies in the floor, or stands on the head there.
fn describe_turned(joints: &Keypoints, floor_m: f64) -> Option<String> {
    let [shoulders, hips, ankles] = [SHOULDERS, HIPS, ANKLES].map(|pair| middle(joints, pair));
    let rise = |from: DVec3, to: DVec3| (to - from).normalize_or_zero().z;
    let [trunk, legs] = [rise(hips?, shoulders?), rise(ankles?, hips?)];
    let known = joints.iter().flatten();
    let height_m = known.clone().map(|joint| joint.z).sum::<f64>() / known.count() as f64 - floor_m;
    if trunk.abs() < LEVEL && legs.abs() < LEVEL && height_m < LYING_M {
        return Some(
            "lies in the floor: are its joints y up? Turn it with rpy_deg = [90, 0, 0] (a .bvh file has the key up)"
                .into(),
        );
    }
    (trunk < -LEVEL && legs < -LEVEL).then(|| {
        "stands on its head: do its joints point down along z? Turn it with rpy_deg = [180, 0, 0]".into()
    })
}

/// Whether the nose is where the back is, by the sides that the joints name.
pub(super) fn is_mirrored(joints: &Keypoints) -> bool {
    let side = |pair: [usize; 2]| Some(joints[pair[0]]? - joints[pair[1]]?);
    let ahead = |from: DVec3, left: DVec3, up: DVec3| {
        let forward = left.cross(up).normalize_or_zero();
        Some((joints[NOSE]? - from).normalize_or_zero().dot(forward))
    };
    let [shoulders, hips, ears] = [SHOULDERS, HIPS, EARS].map(|pair| middle(joints, pair));
    let by_shoulders = || ahead(shoulders?, side(SHOULDERS)?, shoulders? - hips?);
    let by_ears = || ahead(ears?, side(EARS)?, ears? - shoulders?);
    [by_shoulders(), by_ears()].into_iter().flatten().any(|cosine| cosine < BACK)
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_scene::objects::keypoints::load_shipped;
    use perirobot_shipped::PEOPLE;

    fn map_joints(joints: &Keypoints, change: impl Fn(DVec3) -> DVec3) -> Keypoints {
        joints.map(|joint| joint.map(&change))
    }

    #[test]
    fn people_that_ship_are_people_and_changed_ones_are_not() {
        for person in &PEOPLE {
            let joints = load_shipped(person).unwrap();
            let told = |joints: &Keypoints| {
                stature(tall_m(joints).unwrap()).or_else(|| describe_turned(joints, 0.0))
            };
            assert_eq!((told(&joints), is_mirrored(&joints)), (None, false), "{}", person.name);
            let twice = told(&map_joints(&joints, |p| 2.0 * p)).unwrap();
            assert!(twice.contains(" m tall by its joints, and people are 1.2 to 2.2 m"), "{twice}");
            assert!(
                told(&map_joints(&joints, |p| 0.01 * p)).unwrap().starts_with("is 0.0"),
                "{}",
                person.name
            );
            assert!(is_mirrored(&map_joints(&joints, |p| p * DVec3::new(1.0, -1.0, 1.0))), "{}", person.name);
        }
        let mut standing = load_shipped(&PEOPLE[0]).unwrap();
        let y_up = map_joints(&standing, |p| DVec3::new(p.y, p.z, p.x));
        assert!(describe_turned(&y_up, 0.0).unwrap().starts_with("lies in the floor"));
        assert!(!is_mirrored(&y_up));
        let down = map_joints(&standing, |p| DVec3::new(p.x, -p.y, -p.z));
        assert!(describe_turned(&down, 0.0).unwrap().starts_with("stands on its head"));
        standing[NOSE] = None;
        assert_eq!(tall_m(&standing), None);
    }
}
