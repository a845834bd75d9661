//! Keypoints in random cells against a plain march in u64, which shares nothing with the sensors' but the
//! rules.

use super::*;
use crate::sensor::keypoints::{Detected, KeypointCamera, detect};
use crate::sensor::kinds::rgbd::{KeypointShape, Rgbd};
use crate::sensor::look::Return;
use crate::sensor::noise::Deviation;
use crate::sensor::range::{Along, Range, ReflectanceRanges};
use crate::sensor::{Camera, RayScale};
use perirobot_march::backend::Noise;
use perirobot_march::march::NOISE_STEPS;
use perirobot_scene::objects::keypoints::JOINTS;

pub(super) struct DetectionRandom(pub(super) u64);

impl DetectionRandom {
    /// SplitMix64.
    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(super) fn number_below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    pub(super) fn number_between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn point(&mut self, from: [f64; 3], to: [f64; 3]) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|r| self.number_between(from[r], to[r])))
    }
}

const SIZE: [u32; 3] = [34, 20, 17];
pub(super) const VOXEL_M: f64 = 0.1;

/// Two or three people of loose voxels around their joints, clutter, and a fence that stops nothing.
pub(super) fn random_cell(random: &mut DetectionRandom) -> Truth {
    let mut truth = empty(SIZE, VOXEL_M);
    let anywhere = |random: &mut DetectionRandom| SIZE.map(|n| random.number_below(n.into()) as i32);
    for _ in 0..2 + random.number_below(2) {
        let middle = random.point([0.8, 0.3, 0.3], [3.2, 1.7, 1.4]);
        let mut keypoints = [None; 17];
        let mut voxels = Vec::new();
        for keypoint in &mut keypoints {
            let joint = middle + random.point([-0.3; 3], [0.3; 3]);
            let joint_voxel = Grid::voxel_of(truth.grid.position_q16(joint));
            for _ in 0..6 {
                voxels.push(joint_voxel.map(|c| c + random.number_below(3) as i32 - 1));
            }
            *keypoint = (random.number_below(6) > 0).then_some(joint);
        }
        put(&mut truth, Role::Human, &voxels, Some(keypoints));
    }
    let clutter: Vec<_> = (0..random.number_below(150)).map(|_| anywhere(random)).collect();
    put(&mut truth, Role::Environment, &clutter, None);
    let fence: Vec<_> = (0..random.number_below(150)).map(|_| anywhere(random)).collect();
    put(&mut truth, Role::Environment, &fence, None);
    let fence = truth.objects.last().unwrap().voxels.clone();
    Arc::make_mut(&mut truth.blockers).remove(&fence);
    truth
}

pub(super) fn camera(random: &mut DetectionRandom) -> Rgbd {
    let near = [0.0, 0.0, 0.5][random.number_below(3) as usize];
    let range = Range {
        reflectance: ReflectanceRanges::NONE,
        range_m: [near, random.number_between(0.8, 4.0)],
        along: Along::Ray,
        near_ignore_m: [0.0, 0.3][random.number_below(2) as usize],
        no_return_is_free: false,
        noise: [
            Deviation::NONE,
            Deviation { std_m: 0.05, ..Deviation::NONE },
            Deviation { std_m: 0.3, per_m: 0.05, per_m2: 0.02 },
        ][random.number_below(3) as usize],
        calibration: None,
        dropout: [0.0, 0.0, 0.1][random.number_below(3) as usize],
    };
    let fov_rad = [random.number_between(0.3, 2.5), random.number_between(0.3, 2.5)];
    let resolution_px = [1 + random.number_below(5) as u32, 1 + random.number_below(5) as u32];
    let keypoint_tolerance_m = [0.0, 0.05, 0.15, 9.0][random.number_below(4) as usize];
    Rgbd {
        camera: Camera { fov_rad, resolution_px },
        range,
        shapes: vec![KeypointShape::Box],
        keypoint_tolerance_m,
    }
}

/// What the rules say, from the words of `SEMANTICS.md`.
fn expected(
    truth: &Truth,
    sensor: &Rgbd,
    pose: &Pose,
    truly: &Pose,
    draws: u32,
    noise: &Noise,
) -> Vec<Detected> {
    let people: Vec<_> = truth.objects.iter().filter(|object| object.role == Role::Human).collect();
    let pixels = u64::from(sensor.camera.resolution_px[0] * sensor.camera.resolution_px[1]);
    let one = |(number, human): (usize, &&Arc<ObjectVoxels>)| -> Detected {
        std::array::from_fn(|k| {
            let joint_m = human.keypoints.unwrap()[k]?;
            let ray = pixels + 17 * number as u64 + k as u64;
            let drawn = pcg(u64::from(draws) ^ ray);
            if pcg(drawn) < u64::from(noise.lost_below) {
                return None;
            }
            let noise = |t: u64| match noise.unit_q12.get((drawn >> 20) as usize) {
                None => 0,
                Some(&unit) => (i64::from(unit) * i64::from(noise.std_q16[(t >> 16) as usize]) + 2048) >> 12,
            };
            let (way, end) =
                (image_ray(sensor, truly, truth, joint_m)?, |way| follow(truth, sensor, truly, way, &noise));
            let (t, hit, mut read) = end(way)?;
            if truly != pose {
                read = believed_voxel(truth, pose, truly, way, (t as i64 + noise(t)).max(0) as u64);
            }
            let squared: i128 = way.iter().map(|&w| i128::from(w).pow(2)).sum();
            let mut distance = (squared as f64).sqrt() as i128;
            while distance.pow(2) > squared {
                distance -= 1;
            }
            while (distance + 1).pow(2) <= squared {
                distance += 1;
            }
            let near = (i128::from(t) - distance).abs() <= i128::from(q16(sensor.keypoint_tolerance_m));
            (near && human.voxels.get(hit)).then_some(Return { hit, distance_q16: t as u32, read })
        })
    };
    people.iter().enumerate().map(one).collect()
}

fn q16(metres: f64) -> i64 {
    (metres / VOXEL_M * 65_536.0).round() as i64
}

/// The way to a joint in 1/65536 voxels, if it is in front and in the image: by angles, where the camera
/// projects.
fn image_ray(sensor: &Rgbd, pose: &Pose, truth: &Truth, joint_m: DVec3) -> Option<[i64; 3]> {
    assert_eq!(truth.grid.origin, [0; 3]);
    let way: [i64; 3] = std::array::from_fn(|r| q16(joint_m[r]) - q16(pose.position_m[r]));
    let seen = pose.rotation.inverse() * DVec3::from_array(way.map(|w| w as f64));
    let [right, down] = [(-seen.y).atan2(seen.x), (-seen.z).atan2(seen.x)];
    let inside = |angle: f64, fov: f64| -fov / 2.0 <= angle && angle < fov / 2.0;
    let [across, along] = sensor.camera.fov_rad;
    (seen.x > 0.0 && inside(right, across) && inside(down, along)).then_some(way)
}

/// The voxel where a camera takes something to be that its true ray has met: the ray as it sees it, from
/// where it is believed to be, after all crossings up to a distance, in the grid.
fn believed_voxel(truth: &Truth, pose: &Pose, truly: &Pose, way: [i64; 3], until: u64) -> [i32; 3] {
    let way = DVec3::from_array(way.map(|w| w as f64));
    let seen = truly.optical().transpose() * way;
    let dir = (pose.optical() * seen / way.length()).to_array().map(|d| (d * 65_536.0).round() as i64);
    let mut voxel: [i32; 3] = std::array::from_fn(|r| (q16(pose.position_m[r]) >> 16) as i32);
    let mut made = [0; 3];
    loop {
        let (t, r) = (0..3).map(|r| (crossing(pose, dir, r, made[r]), r)).min().unwrap();
        let mut next = voxel;
        next[r] += dir[r].signum() as i32;
        if t > until || !truth.grid.window().contains(next) {
            return voxel;
        }
        made[r] += 1;
        voxel = next;
    }
}

/// When a ray makes crossing `n` of an axis.
fn crossing(pose: &Pose, dir: [i64; 3], r: usize, n: u64) -> u64 {
    if dir[r] == 0 {
        return u64::MAX;
    }
    let frac = (q16(pose.position_m[r]) & 0xffff) as u64;
    let f = if dir[r] < 0 { frac } else { (1 << 16) - frac };
    let period = (1u64 << 32) / dir[r].unsigned_abs();
    ((f * period) >> 16) + n * period
}

/// Distance, blocker and voxel read of a ray, one crossing after the other.
fn follow(
    truth: &Truth,
    sensor: &Rgbd,
    pose: &Pose,
    way: [i64; 3],
    noise: &dyn Fn(u64) -> i64,
) -> Option<(u64, [i32; 3], [i32; 3])> {
    let length = way.iter().map(|&w| (w as f64).powi(2)).sum::<f64>().sqrt();
    let dir: [i64; 3] = way.map(|w| (w as f64 / length * 65_536.0).round() as i64);
    let [near, far] = sensor.range.range_m.map(|m| q16(m) as u64);
    let ignore = q16(sensor.range.near_ignore_m) as u64;
    let mut voxel: [i32; 3] = std::array::from_fn(|r| (q16(pose.position_m[r]) >> 16) as i32);
    let mut made = [0; 3];
    let mut path = vec![(0, voxel)];
    let mut found = None;
    loop {
        let (t, r) = (0..3).map(|r| (crossing(pose, dir, r, made[r]), r)).min().unwrap();
        if let Some((_, _, until)) = found
            && t > until
        {
            break;
        }
        made[r] += 1;
        voxel[r] += dir[r].signum() as i32;
        if !truth.grid.window().contains(voxel) {
            break;
        }
        path.push((t, voxel));
        if found.is_none() && t > far {
            return None;
        }
        if found.is_none() && t >= ignore && truth.blockers.get(voxel) {
            if t < near {
                return None;
            }
            if noise(t) == 0 {
                return Some((t, voxel, voxel));
            }
            found = Some((t, voxel, (t as i64 + noise(t)).max(0) as u64));
        }
    }
    let (t, hit, until) = found?;
    // The first voxel is entered before anything.
    let read = path.iter().enumerate().rfind(|&(i, &(entered, _))| i == 0 || entered <= until)?;
    Some((t, hit, read.1.1))
}

#[test]
fn the_same_joints_as_a_plain_march() {
    let mut random = DetectionRandom(2023);
    let (mut joints, mut seen, mut moved) = (0, 0, 0);
    for case in 0..400 {
        let truth = random_cell(&mut random);
        let sensor = camera(&mut random);
        let rays = sensor.rays(&RayScale::new(VOXEL_M, case % 2 == 0)).unwrap();
        assert!([0, NOISE_STEPS as usize].contains(&rays.noise.unit_q12.len()));
        let target = truth.objects[0].keypoints.unwrap().into_iter().flatten().next().unwrap_or(DVec3::ONE);
        let position = random.point([0.05; 3], [3.35, 1.95, 1.65]);
        let [pan, tilt] = [random.number_between(-0.6, 0.6), random.number_between(-0.6, 0.6)];
        let pose = Pose::facing(position, target - position, pan, tilt);
        let draws = random.bits() as u32;
        let truly = (case % 3 == 0).then(|| {
            let position_m = (position + random.point([-0.2; 3], [0.2; 3]))
                .clamp(DVec3::splat(0.05), DVec3::new(3.35, 1.95, 1.65));
            Pose::facing(position_m, target - position, pan + random.number_between(-0.1, 0.1), tilt)
        });
        let at = Station { rays: Some(&rays), truly, draws, ..station(&truth, Setting::Pose(pose)) };
        let from = at.placement(&sensor);
        let eye = KeypointCamera {
            camera: &sensor.camera,
            rays: &rays,
            placement: &from,
            tolerance_m: sensor.keypoint_tolerance_m,
        };
        let found = detect(&eye, &at);
        let plain = expected(&truth, &sensor, &pose, &truly.unwrap_or(pose), draws, &rays.noise);
        assert_eq!(found, plain, "case {case}");
        joints += found.len() * JOINTS.len();
        let detected: Vec<_> = found.iter().flatten().flatten().collect();
        seen += detected.len();
        moved += detected.iter().filter(|found| !truth.human.get(found.read)).count();
    }
    assert!(seen * 20 > joints && seen < joints, "{seen} of {joints}: too few or too many to tell");
    assert!(moved * 20 > seen, "{moved} of {seen} read elsewhere");
}
