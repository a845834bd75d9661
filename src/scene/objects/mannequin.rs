//! Makes a person of adult size from the 17 keypoints of COCO: limbs as capsules, head as an ellipsoid.

use std::path::Path;

use glam::{DMat3, DQuat, DVec3};

use super::Mesh;
use super::keypoints::{ANKLES, EARS, ELBOWS, HIPS, KNEES, Keypoints, NOSE, SHOULDERS, WRISTS};
use super::primitive::{capsule_between, ellipsoid};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::metrics::BodyPart;

/// Whether any part of a body can be drawn from these joints.
fn is_drawn(keypoints: &Keypoints) -> bool {
    // The coarsest tessellation tells whether there is any.
    !parts(keypoints, f64::INFINITY).is_empty()
}

/// The same joints, if a body can be drawn from it.
///
/// # Errors
/// When too few joints are known to draw any part of a body.
pub(super) fn require_body(keypoints: Keypoints, path: &Path) -> Result<Keypoints> {
    match is_drawn(&keypoints) {
        true => Ok(keypoints),
        false => Err(Issue::says("no two neighbouring joints are known")
            .with_advice("nothing of a body can be drawn")
            .with_place(path)
            .into()),
    }
}

/// The body's surface in the world: closed parts that overlap. A part is left out unless all the joints it is
/// made from are known, so a missing joint moves nothing else. `sag_m` is as for the primitives.
pub fn body(keypoints: &Keypoints, sag_m: f64) -> Mesh {
    let mut body = Mesh::default();
    for part in parts(keypoints, sag_m) {
        body.append(&part);
    }
    body
}

fn parts(keypoints: &Keypoints, sag_m: f64) -> Vec<Mesh> {
    let limbs = bones(keypoints).into_iter();
    let limbs = limbs.map(|Limb { ends_m: [a, b], radius_m, .. }| capsule_between(a, b, radius_m, sag_m));
    head(keypoints, sag_m).into_iter().chain(limbs).collect()
}

/// A bone with flesh around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limb {
    /// What it is part of.
    pub part: BodyPart,
    /// Where the bone begins and ends, in world metres; the same for a ball.
    pub ends_m: [DVec3; 2],
    /// How thick the flesh is.
    pub radius_m: f64,
}

impl Limb {
    /// How far a point is from the surface of the limb; negative inside.
    pub(crate) fn away_m(&self, place_m: DVec3) -> f64 {
        let [a, b] = self.ends_m;
        let (along, way) = (b - a, place_m - a);
        let length = along.length_squared();
        let share = if length > 0.0 { (way.dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        way.distance(share * along) - self.radius_m
    }
}

/// The limbs of a person whose joints are known: the head, a ball about the middle of the face's joints, then
/// the bones.
pub(crate) fn limbs(keypoints: &Keypoints) -> Vec<Limb> {
    let face: Vec<DVec3> = keypoints[..=EARS[1]].iter().flatten().copied().collect();
    let middle = face.iter().sum::<DVec3>() / face.len().max(1) as f64;
    let head = Limb { part: BodyPart::Head, ends_m: [middle; 2], radius_m: 0.1 };
    (!face.is_empty()).then_some(head).into_iter().chain(bones(keypoints)).collect()
}

/// All bones but the head, of which all the joints are known.
fn bones(keypoints: &Keypoints) -> Vec<Limb> {
    let limb = |part, [a, b]: [DVec3; 2], radius_m| Limb { part, ends_m: [a, b], radius_m };
    let bone = |part, a, b, radius_m| both(keypoints, [a, b]).map(|ends_m| limb(part, ends_m, radius_m));
    let mut bones = vec![neck(keypoints).map(|neck| limb(BodyPart::Head, neck, 0.06))];
    // Shoulders and pelvis span the torso's width.
    bones.push(bone(BodyPart::Torso, SHOULDERS[0], SHOULDERS[1], 0.055));
    let pelvis = both(keypoints, HIPS).map(|[l, r]| [l.lerp(r, 0.25), r.lerp(l, 0.25)]);
    bones.push(pelvis.map(|pelvis| limb(BodyPart::Torso, pelvis, 0.12)));
    for (side, [upper_arm, forearm, thigh, shank]) in LIMBS.into_iter().enumerate() {
        bones.push(flank(keypoints, side).map(|flank| limb(BodyPart::Torso, flank, 0.11)));
        bones.push(bone(upper_arm, SHOULDERS[side], ELBOWS[side], 0.05));
        bones.push(bone(forearm, ELBOWS[side], WRISTS[side], 0.04));
        let hand = hand(keypoints[ELBOWS[side]], keypoints[WRISTS[side]]);
        bones.push(hand.map(|hand| limb(forearm, hand, 0.035)));
        bones.push(bone(thigh, HIPS[side], KNEES[side], 0.075));
        bones.push(bone(shank, KNEES[side], ANKLES[side], 0.055));
        bones.push(foot(keypoints, side).map(|foot| limb(shank, foot, 0.04)));
    }
    bones.into_iter().flatten().collect()
}

/// What the limbs of the left and of the right side are part of.
const LIMBS: [[BodyPart; 4]; 2] = [
    [BodyPart::LeftUpperArm, BodyPart::LeftForearm, BodyPart::LeftThigh, BodyPart::LeftShank],
    [BodyPart::RightUpperArm, BodyPart::RightForearm, BodyPart::RightThigh, BodyPart::RightShank],
];

fn both(keypoints: &Keypoints, joints: [usize; 2]) -> Option<[DVec3; 2]> {
    Some([keypoints[joints[0]]?, keypoints[joints[1]]?])
}

/// An ellipsoid about the middle of the ears, a little above it, facing the nose.
fn head(keypoints: &Keypoints, sag_m: f64) -> Option<Mesh> {
    let [left_ear, right_ear] = both(keypoints, EARS)?;
    let center = (left_ear + right_ear) / 2.0;
    let left = (left_ear - right_ear).try_normalize()?;
    let forward = (keypoints[NOSE]? - center).reject_from_normalized(left);
    let forward = forward.try_normalize()?;
    let up = forward.cross(left);
    let turn = DQuat::from_mat3(&DMat3::from_cols(forward, left, up));
    let skull = ellipsoid(DVec3::new(0.1, 0.08, 0.12), sag_m);
    Some(skull.transform(turn, center + 0.02 * up))
}

fn neck(keypoints: &Keypoints) -> Option<[DVec3; 2]> {
    let [left, right] = both(keypoints, SHOULDERS)?;
    let [left_ear, right_ear] = both(keypoints, EARS)?;
    let (low, high) = ((left + right) / 2.0, (left_ear + right_ear) / 2.0);
    // Up to the chin: further, the neck would bulge out of the head.
    Some([low, low.lerp(high, 0.7)])
}

/// One half of chest and belly, from below the shoulder to the hip; the halves overlap in the middle.
fn flank(keypoints: &Keypoints, side: usize) -> Option<[DVec3; 2]> {
    let shoulders = both(keypoints, SHOULDERS)?;
    let hips = both(keypoints, HIPS)?;
    let shoulder = shoulders[side].lerp(shoulders[1 - side], 0.25);
    let hip = hips[side].lerp(hips[1 - side], 0.25);
    // The round end would otherwise stand above the shoulders.
    let chest = shoulder.move_towards(hip, 0.07);
    Some([chest, hip])
}

/// The hand: straight on from the forearm, up to the fingertips.
fn hand(elbow: Option<DVec3>, wrist: Option<DVec3>) -> Option<[DVec3; 2]> {
    let (elbow, wrist) = (elbow?, wrist?);
    let onward = (wrist - elbow).try_normalize()?;
    Some([wrist, wrist + 0.13 * onward])
}

/// The foot: level, whatever the shin's slope, toward where the hips face; the sole is 8 cm below the ankle.
/// Without hips side by side (someone lying on a side) there is no such direction, and no foot.
fn foot(keypoints: &Keypoints, side: usize) -> Option<[DVec3; 2]> {
    let [left_hip, right_hip] = both(keypoints, HIPS)?;
    let ankle = keypoints[ANKLES[side]]?;
    let forward = (left_hip - right_hip).cross(DVec3::Z).try_normalize()?;
    let sole = ankle - 0.04 * DVec3::Z;
    Some([sole - 0.04 * forward, sole + 0.15 * forward])
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::objects::mesh::tests::{assert_closed, volume};

    const SAG: f64 = 0.002;
    /// Head, neck, shoulders, pelvis; on each side flank, upper arm, forearm, hand, thigh, shin, foot.
    const PARTS: usize = 4 + 2 * 7;

    /// Someone 1.75 m tall who stands on the origin, looks along x and lets the arms hang.
    pub(crate) fn standing() -> Keypoints {
        let mut keypoints = [Some(DVec3::new(0.1, 0.0, 1.6)); 17];
        let pairs = [
            (1, 0.08, 0.03, 1.63),
            (3, 0.0, 0.07, 1.61),
            (5, 0.0, 0.18, 1.43),
            (7, 0.0, 0.2, 1.13),
            (9, 0.05, 0.2, 0.87),
            (11, 0.0, 0.1, 0.92),
            (13, 0.0, 0.1, 0.5),
            (15, 0.0, 0.1, 0.09),
        ];
        for (joint, x, y, z) in pairs {
            keypoints[joint] = Some(DVec3::new(x, y, z));
            keypoints[joint + 1] = Some(DVec3::new(x, -y, z));
        }
        keypoints
    }

    #[test]
    fn a_whole_body_has_all_its_parts_and_an_adults_size() {
        let parts = parts(&standing(), SAG);
        assert_eq!(parts.len(), PARTS);
        for part in &parts {
            assert_closed(part);
            assert!(volume(part) > 0.0);
        }
        let mesh = body(&standing(), SAG);
        assert_closed(&mesh);
        let (low, high) = mesh.bounds().unwrap();
        assert!((low.z - 0.01).abs() < 0.002, "soles at {}", low.z);
        assert!((1.72..1.78).contains(&high.z), "crown at {}", high.z);
        assert!((0.24..0.26).contains(&high.y) && (low.y + high.y).abs() < 1e-9, "{low} {high}");
        assert!((0.18..0.2).contains(&high.x), "toes point along x: {}", high.x);
    }

    #[test]
    fn a_missing_joint_leaves_its_parts_out_and_moves_no_other() {
        let whole = parts(&standing(), SAG);
        // nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles
        let lost = [1, 0, 0, 2, 2, 5, 5, 3, 3, 2, 2, 6, 6, 2, 2, 2, 2];
        for joint in 0..17 {
            let mut keypoints = standing();
            keypoints[joint] = None;
            let kept = parts(&keypoints, SAG);
            let name = crate::objects::keypoints::JOINTS[joint];
            assert_eq!(kept.len(), PARTS - lost[joint], "without {name}");
            assert!(kept.iter().all(|part| whole.contains(part)), "{name} moves a part");
        }
        assert_eq!(body(&[None; 17], SAG), Mesh::default());
        // Joints on one spot have no direction to build on, and must not make NaN.
        let pile = body(&[Some(DVec3::ONE); 17], SAG);
        assert!(pile.vertices.iter().all(|v| v.is_finite()) && !pile.triangles.is_empty());
    }

    #[test]
    fn all_parts_of_a_body_have_limbs() {
        let all = limbs(&standing());
        for part in &BodyPart::ALL[..10] {
            assert!(all.iter().any(|limb| limb.part == *part), "{}", part.name());
        }
        assert!(all.iter().all(|limb| limb.part != BodyPart::Body));
        assert_eq!(all.len(), PARTS, "a limb for each surface");
        let nearest = |x, y, z| {
            let place = DVec3::new(x, y, z);
            all.iter().min_by(|a, b| a.away_m(place).total_cmp(&b.away_m(place))).unwrap().part
        };
        assert_eq!(nearest(0.0, 0.0, 1.75), BodyPart::Head);
        assert_eq!(nearest(0.1, 0.0, 1.2), BodyPart::Torso);
        assert_eq!(nearest(0.0, 0.25, 1.2), BodyPart::LeftUpperArm);
        assert_eq!(nearest(0.08, -0.2, 0.75), BodyPart::RightForearm);
        assert_eq!(nearest(0.07, 0.1, 0.7), BodyPart::LeftThigh);
        assert_eq!(nearest(0.15, -0.1, 0.05), BodyPart::RightShank);
        let lost = [None; 17];
        assert!(limbs(&lost).is_empty());
        let mut nose = lost;
        nose[0] = Some(DVec3::ONE);
        assert_eq!(limbs(&nose), [Limb { part: BodyPart::Head, ends_m: [DVec3::ONE; 2], radius_m: 0.1 }]);
    }
}
