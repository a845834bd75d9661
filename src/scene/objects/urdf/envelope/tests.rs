use std::collections::HashSet;
use std::path::Path;

use rand::{RngExt, SeedableRng};

use super::*;
use crate::objects::urdf::{JointValues, parse};

/// Two arms in a plane, 0.6 m and 0.4 m long; the second carries a slide that goes up, and that a hand.
const ARM: &str = "<robot name='arm'>\
    <link name='base'/><link name='upper'/><link name='lower'/><link name='lift'/><link name='hand'/>\
    <joint name='shoulder' type='revolute'><parent link='base'/><child link='upper'/><origin xyz='0 0 0.2'/>\
      <axis xyz='0 0 1'/><limit lower='-1' upper='2' effort='1' velocity='1'/></joint>\
    <joint name='elbow' type='revolute'><parent link='upper'/><child link='lower'/><origin xyz='0.6 0 0' rpy='0.3 0 0'/>\
      <axis xyz='0 1 1'/><limit lower='-0.5' upper='2.5' effort='1' velocity='1'/></joint>\
    <joint name='slide' type='prismatic'><parent link='lower'/><child link='lift'/><origin xyz='0.4 0 0'/>\
      <axis xyz='0 0 1'/><limit lower='-0.1' upper='0.2' effort='1' velocity='1'/></joint>\
    <joint name='flange' type='fixed'><parent link='lift'/><child link='hand'/><origin xyz='0.1 0 0'/></joint></robot>";

fn arm() -> RobotModel {
    parse(Path::new("arm.urdf"), ARM).unwrap()
}

/// A triangle of a few millimetres at a place.
fn dot(at: DVec3) -> Mesh {
    Mesh { vertices: vec![at, at + DVec3::X * 0.003, at + DVec3::Y * 0.003], triangles: vec![[0, 1, 2]] }
}

/// A thin plate on the upper arm, a dot at the hand.
fn meshes() -> Vec<Mesh> {
    let plate = Mesh {
        vertices: [[0.1, -0.05, 0.0], [0.5, -0.05, 0.0], [0.5, 0.05, 0.1]].map(DVec3::from).to_vec(),
        triangles: vec![[0, 1, 2]],
    };
    let none = Mesh::default;
    vec![none(), plate, none(), none(), dot(DVec3::ZERO)]
}

/// Points by cells, to find those near a place.
struct Near {
    cells: HashSet<[i64; 3]>,
    size_m: f64,
}

impl Near {
    fn new(size_m: f64) -> Near {
        Near { cells: HashSet::new(), size_m }
    }

    fn cell(&self, at: DVec3) -> [i64; 3] {
        at.to_array().map(|v| (v / self.size_m).floor() as i64)
    }

    fn add(&mut self, at: DVec3) {
        let cell = self.cell(at);
        self.cells.insert(cell);
    }

    /// Whether a point is in the cell of a place or next to it.
    fn has(&self, at: DVec3) -> bool {
        let [x, y, z] = self.cell(at);
        let mut around = (0..27).map(|n| [x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1]);
        around.any(|cell| self.cells.contains(&cell))
    }
}

/// Where all vertices are for some joint values.
fn vertices(model: &RobotModel, meshes: &[Mesh], [shoulder, elbow, slide]: [f64; 3]) -> Vec<DVec3> {
    let angles = [("shoulder", shoulder), ("elbow", elbow)];
    let values = JointValues {
        angles_deg: angles.iter().map(|(name, angle)| (name.to_string(), angle.to_degrees())).collect(),
        travels_m: [("slide".to_string(), slide)].into(),
    };
    let placed = model.pose(&values).unwrap();
    let moved = meshes.iter().zip(placed).map(|(mesh, root_from_link)| mesh.place(&root_from_link).vertices);
    moved.flatten().collect()
}

#[test]
fn whatever_the_joints_do_the_robot_stays_within_its_envelope() {
    let (model, meshes) = (arm(), meshes());
    for limits in [AxisLimits::default(), narrow()] {
        let envelope = model.envelope(&meshes, &limits, (0.0, &[]), 0.02).unwrap();
        assert!(envelope.error_m() < 0.08, "{}", envelope.error_m());
        let mut near = Near::new(envelope.error_m());
        envelope.for_each(&mut |at| near.add(at));
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let [shoulder, elbow, slide] = ranges(&limits);
        for _ in 0..2000 {
            let values = [shoulder, elbow, slide].map(|[low, high]| random.random_range(low..=high));
            for at in vertices(&model, &meshes, values) {
                assert!(near.has(at), "{values:?}: {at}");
            }
        }
    }
}

#[test]
fn an_envelope_is_hardly_larger_than_what_joint_values_reach() {
    let (model, meshes) = (arm(), meshes());
    for limits in [AxisLimits::default(), narrow()] {
        let envelope = model.envelope(&meshes, &limits, (0.0, &[]), 0.01).unwrap();
        let [shoulder, elbow, slide] = ranges(&limits);
        let at =
            |[low, high]: [f64; 2], part: u32, of: u32| low + (high - low) * f64::from(part) / f64::from(of);
        let mut near = Near::new(0.08);
        for (s, e, l) in (0..=120).flat_map(|s| (0..=120).flat_map(move |e| (0..=8).map(move |l| (s, e, l))))
        {
            let values = [at(shoulder, s, 120), at(elbow, e, 120), at(slide, l, 8)];
            let all = vertices(&model, &meshes, values);
            // Along the plate of the upper arm, too.
            (0..=10).for_each(|part| near.add(all[0].lerp(all[1], f64::from(part) / 10.0)));
            (0..=10).for_each(|part| near.add(all[1].lerp(all[2], f64::from(part) / 10.0)));
            (0..=10).for_each(|part| near.add(all[0].lerp(all[2], f64::from(part) / 10.0)));
            all.into_iter().for_each(|at| near.add(at));
        }
        let (mut all, mut outside) = (0, 0);
        envelope.for_each(&mut |at| {
            all += 1;
            outside += usize::from(!near.has(at));
        });
        assert!(all > 10_000 && outside == 0, "{outside} of {all} points are reached by no joint values");
    }
}

fn narrow() -> AxisLimits {
    AxisLimits {
        limits_deg: [("shoulder".to_string(), [0.0, 60.0]), ("elbow".to_string(), [10.0, 40.0])].into(),
        limits_m: [("slide".to_string(), [0.0, 0.05])].into(),
    }
}

fn ranges(limits: &AxisLimits) -> [[f64; 2]; 3] {
    let turn =
        |name: &str, own| limits.limits_deg.get(name).map_or(own, |limits| limits.map(f64::to_radians));
    [
        turn("shoulder", [-1.0, 2.0]),
        turn("elbow", [-0.5, 2.5]),
        limits.limits_m.get("slide").copied().unwrap_or([-0.1, 0.2]),
    ]
}

#[test]
fn a_tool_reaches_beyond_the_last_link_and_nowhere_else() {
    let (model, meshes) = (arm(), meshes());
    let farthest = |tool_m: f64| {
        let envelope = model.envelope(&meshes, &AxisLimits::default(), (tool_m, &[]), 0.01).unwrap();
        let mut farthest: f64 = 0.0;
        envelope.for_each(&mut |at| farthest = farthest.max(at.truncate().length()));
        (farthest, envelope.error_m())
    };
    let ((bare, error_m), (tool, _)) = (farthest(0.0), farthest(0.3));
    assert!((tool - bare - 0.3).abs() < 2.0 * error_m, "{bare}, {tool}");
}

#[test]
fn limits_that_are_wrong_are_named() {
    let wrong = |limits_deg: &[(&str, [f64; 2])], limits_m: &[(&str, [f64; 2])]| {
        let map =
            |all: &[(&str, [f64; 2])]| all.iter().map(|(name, limits)| (name.to_string(), *limits)).collect();
        let limits = AxisLimits { limits_deg: map(limits_deg), limits_m: map(limits_m) };
        arm().envelope(&meshes(), &limits, (0.0, &[]), 0.02).unwrap_err().to_string()
    };
    for (found, expected) in [
        (
            wrong(&[("wrist", [0.0, 1.0])], &[]),
            "limits_deg.wrist = [0.0, 1.0]: arm.urdf has no such joint; there are shoulder",
        ),
        (wrong(&[("slide", [0.0, 1.0])], &[]), "slides: write its metres under limits_m"),
        (wrong(&[], &[("elbow", [0.0, 1.0])]), "turns: write its degrees under limits_deg"),
        (wrong(&[("flange", [0.0, 1.0])], &[]), "is a fixed joint: leave it out"),
        (wrong(&[("elbow", [30.0, -10.0])], &[]), "must be [lowest, highest]"),
        (
            wrong(&[("elbow", [-40.0, 10.0])], &[]),
            "must be within [-28.6479, 143.2394], its limits in arm.urdf",
        ),
        (wrong(&[("elbow", [f64::NAN, 10.0])], &[]), "must be [lowest, highest]"),
    ] {
        assert!(found.contains(expected), "{found}");
    }
}
