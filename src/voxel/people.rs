//! Which voxels are a person's, and of which part of the body: the nearest of the person's limbs decides.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{BitGrid, Grid, Truth, Window};
use crate::metrics::{BodyPart, Detection, PartTally};
use crate::scene::Role;
use crate::scene::mannequin::{Limb, limbs};

/// A truly occupied voxel of a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyVoxel {
    /// Where it is, from the grid's corner.
    pub voxel: [i32; 3],
    /// Whose it is: people are counted from 0 in the order of the scene's objects.
    pub person: u32,
    /// Which part.
    pub part: BodyPart,
}

/// The people of a scene at one moment, and when they are detected.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct People {
    /// How many voxels of a part must be hit for it to be detected.
    pub min_hits: u32,
    /// Their truly occupied voxels, each once, in no order that matters.
    pub voxels: Vec<BodyVoxel>,
}

impl People {
    /// The people of a scene. A voxel of several is the first one's.
    pub(crate) fn of(truth: &Truth, min_hits: u32) -> People {
        let mut left = BitGrid::clone(&truth.occupied);
        let humans = truth.objects.iter().filter(|object| object.role == Role::Human);
        let mut voxels = Vec::new();
        for (human, person) in humans.zip(0..) {
            let limbs = human.keypoints.as_ref().map_or_else(Vec::new, limbs);
            let mut own = human.voxels.clone();
            own.keep(&left);
            left.remove(&own);
            let of_person =
                |voxel| BodyVoxel { voxel, person, part: part_at(middle_m(&truth.grid, voxel), &limbs) };
            voxels.extend(own.voxels().map(of_person));
        }
        People { min_hits, voxels }
    }

    /// How many people there are, those without a voxel at the end left out.
    pub(crate) fn count(&self) -> usize {
        self.voxels.iter().map(|of| of.person as usize + 1).max().unwrap_or(0)
    }

    /// The same, but for voxels outside a window.
    pub fn within(&self, window: Window) -> People {
        let voxels = self.voxels.iter().filter(|of| window.contains(of.voxel)).copied().collect();
        People { voxels, ..*self }
    }

    /// Who is detected in a region, voxel by voxel: which are hit, and which of them a presence sensor feels.
    pub(crate) fn detection(
        &self,
        region: &BitGrid,
        hit: impl Fn([i32; 3]) -> bool,
        sensed: impl Fn([i32; 3]) -> bool,
    ) -> Detection {
        let mut parts = BTreeMap::<(u32, BodyPart), [u64; 2]>::new();
        let mut felt = vec![0; self.count()];
        for of in self.voxels.iter().filter(|of| region.get(of.voxel)) {
            let [voxels, hits] = parts.entry((of.person, of.part)).or_default();
            *voxels += 1;
            *hits += u64::from(hit(of.voxel));
            felt[of.person as usize] += u64::from(sensed(of.voxel));
        }
        let tally = |((person, part), [voxels, hit]): ((u32, BodyPart), [u64; 2])| PartTally {
            person: person as usize,
            part,
            voxels,
            hit,
        };
        Detection::of(self.min_hits.into(), parts.into_iter().map(tally), &felt)
    }
}

/// The part of the nearest limb, the first of several.
fn part_at(place_m: DVec3, limbs: &[Limb]) -> BodyPart {
    let away = limbs.iter().map(|limb| (limb.away_m(place_m), limb.part));
    let nearest = away.reduce(|nearest, other| if other.0 < nearest.0 { other } else { nearest });
    nearest.map_or(BodyPart::Body, |(_, part)| part)
}

/// The centre of a voxel in the world.
fn middle_m(grid: &Grid, voxel: [i32; 3]) -> DVec3 {
    grid.corner_m(voxel) + DVec3::splat(grid.voxel_size_m / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limb along y, one of x, and a ball.
    const LIMBS: [Limb; 3] = [
        Limb { part: BodyPart::Torso, ends_m: [DVec3::ZERO, DVec3::Y], radius_m: 0.3 },
        Limb { part: BodyPart::LeftForearm, ends_m: [DVec3::ZERO, DVec3::X], radius_m: 0.1 },
        Limb { part: BodyPart::Head, ends_m: [DVec3::new(0.0, 2.0, 0.0); 2], radius_m: 0.2 },
    ];

    #[track_caller]
    fn check(x: f64, y: f64, expected: BodyPart) {
        assert_eq!(part_at(DVec3::new(x, y, 0.0), &LIMBS), expected, "at ({x}, {y})");
    }

    #[test]
    fn the_nearest_flesh_decides_the_first_limb_of_several() {
        check(0.0, 0.5, BodyPart::Torso);
        check(1.5, 0.0, BodyPart::LeftForearm);
        check(0.0, 3.0, BodyPart::Head);
        // As far from both bones: the thicker one's flesh is nearer.
        check(0.5, 0.5, BodyPart::Torso);
        // 0.7 from the torso's flesh, 0.7 from the forearm's.
        check(1.0, 0.8, BodyPart::Torso);
        check(1.0, 0.79, BodyPart::LeftForearm);
        assert_eq!(part_at(DVec3::ZERO, &[]), BodyPart::Body, "without a bone");
    }

    #[test]
    fn regions_threshold_what_is_hit_in_them() {
        let window = Window::between([0; 3], [9, 0, 0]);
        let voxel = |x, person, part| BodyVoxel { voxel: [x, 0, 0], person, part };
        let voxels = [
            voxel(0, 0, BodyPart::Head),
            voxel(1, 0, BodyPart::Head),
            voxel(2, 0, BodyPart::Torso),
            voxel(3, 1, BodyPart::Body),
            voxel(4, 1, BodyPart::Body),
        ];
        let people = People { min_hits: 2, voxels: voxels.to_vec() };
        let row = |from: i32, to: i32| {
            let mut region = BitGrid::new(window);
            (from..to).for_each(|x| region.set([x, 0, 0]));
            region
        };
        let counts = |region: &BitGrid, hit: i32, felt: i32| {
            people.detection(region, |[x, ..]| x < hit, |[x, ..]| x == felt).counts()
        };
        assert_eq!(counts(&row(0, 10), 2, 9), [2, 2, 1, 2, 1]);
        assert_eq!(counts(&row(0, 10), 1, 9), [1, 2, 0, 2, 0]);
        assert_eq!(counts(&row(0, 10), 0, 3), [0, 2, 1, 2, 0], "one voxel felt");
        // Half of a head is none, and where no part is, nobody is.
        assert_eq!(counts(&row(1, 4), 10, 3), [3, 0, 0, 0, 0]);
        assert_eq!(people.within(Window::between([2, 0, 0], [3, 0, 0])).voxels, voxels[2..4]);
    }
}
