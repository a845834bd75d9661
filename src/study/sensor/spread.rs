//! Between which poses of a group others are possible: a lattice or a box stands for a stretch of wall, and
//! for all ways to turn a sensor there.

use std::ops::Range;

use perirobot_scene::pose::Pose;

/// The ways to move a pose: along x, y and z in metres, pan and tilt in degrees.
pub const WAYS: usize = 5;

/// The ways among them that are angles.
pub const TURNS: Range<usize> = 3..WAYS;

/// A position or an angle that is this little outside of a stretch is at its end: steps are added up in
/// floating point.
const NEARLY: f64 = 1e-9;

/// A group of poses between which others are possible.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseSpread {
    /// Which of the sensor's candidates they are.
    pub candidates: Range<usize>,
    /// How far they reach in each way.
    stretches: [Stretch; WAYS],
    /// How they are turned from where their group faces; the first follows the last, again and again.
    turns_deg: Vec<[f64; 2]>,
}

/// How far poses reach in one way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    from: f64,
    to: f64,
    /// How far they are from each other; 0 where none is possible between them.
    step: f64,
}

impl PoseSpread {
    /// Of poses with such steps between them, 0 where there are none. They begin with this number.
    pub fn new(first: usize, poses: &[&Pose], turns_deg: Vec<[f64; 2]>, steps: [f64; WAYS]) -> PoseSpread {
        let stretches = std::array::from_fn(|way| {
            let value = |number: usize| match way.checked_sub(TURNS.start) {
                Some(turn) => turns_deg[number % turns_deg.len()][turn],
                None => poses[number].position_m[way],
            };
            let ends = (0..poses.len())
                .map(value)
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
            Stretch { from: ends[0], to: ends[1], step: steps[way] }
        });
        PoseSpread { candidates: first..first + poses.len(), stretches, turns_deg }
    }

    /// How far poses are from each other in each way; 0 where none is possible between them.
    pub fn steps(&self) -> [f64; WAYS] {
        self.stretches.map(|stretch| stretch.step)
    }

    /// The pose of a candidate, moved so far in each way. `None` where no pose of the group goes so far.
    pub fn move_pose(&self, candidate: usize, pose: &Pose, by: [f64; WAYS]) -> Option<Pose> {
        let turn = self.turns_deg[(candidate - self.candidates.start) % self.turns_deg.len()];
        let [x, y, z] = pose.position_m.to_array();
        let was = [x, y, z, turn[0], turn[1]];
        let mut now = was;
        for way in (0..WAYS).filter(|&way| by[way] != 0.0) {
            let Stretch { from, to, .. } = self.stretches[way];
            now[way] += by[way];
            if !(from - NEARLY..=to + NEARLY).contains(&now[way]) {
                return None;
            }
            now[way] = now[way].clamp(from, to);
        }
        let [pan_rad, tilt_rad] = [3, 4].map(|way| (now[way] - was[way]).to_radians());
        let position_m = glam::DVec3::new(now[0], now[1], now[2]);
        Some(pose.moved_to(position_m, pan_rad, tilt_rad))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn poses_move_as_far_as_their_group_reaches() {
        let at = |x: f64, pan: f64, tilt: f64| {
            Pose::facing(DVec3::new(x, -1.0, 2.0), DVec3::Y, pan.to_radians(), tilt.to_radians())
        };
        let turns = vec![[0.0, 0.0], [20.0, -20.0]];
        let poses: Vec<Pose> =
            [0.0, 0.1, 0.2].iter().flat_map(|&x| turns.iter().map(move |t| at(x, t[0], t[1]))).collect();
        let spread =
            PoseSpread::new(7, &poses.iter().collect::<Vec<_>>(), turns.clone(), [0.1, 0.0, 0.0, 20.0, 20.0]);
        assert_eq!(spread.candidates, 7..13);
        let moved = |number: usize, by| spread.move_pose(7 + number, &poses[number], by);
        let close = |a: Pose, b: Pose| {
            (a.position_m - b.position_m).length() < 1e-12
                && (a.rotation.dot(b.rotation).abs() - 1.0).abs() < 1e-12
        };
        // Position and angles as if the study had listed them.
        assert!(close(moved(2, [0.05, 0.0, 0.0, 10.0, -5.0]).unwrap(), at(0.15, 10.0, -5.0)));
        assert!(close(moved(3, [-0.05, 0.0, 0.0, -10.0, 5.0]).unwrap(), at(0.05, 10.0, -15.0)));
        // What is not turned keeps its rotation bit for bit.
        assert_eq!(moved(3, [0.05, 0.0, 0.0, 0.0, 0.0]).unwrap().rotation, poses[3].rotation);
        // 0.1 + 0.1 is the end, and not beyond.
        assert_eq!(moved(2, [0.1 + 1e-15, 0.0, 0.0, 0.0, 0.0]).unwrap().position_m.x, 0.2);
        for beyond in [[0.11, 0.0, 0.0, 0.0, 0.0], [0.0, 0.01, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0, 0.0]] {
            assert_eq!(moved(2, beyond), None, "{beyond:?}");
        }
    }
}
