//! The voxels of people, of which part of the body each is, and who is detected.

use std::collections::BTreeMap;

use super::{BitGrid, Window};
use crate::metrics::{BodyPart, Detection, PartTally};

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
    /// How many people there are, those without a voxel at the end left out.
    pub(crate) fn count(&self) -> usize {
        self.voxels.iter().map(|of| of.person as usize + 1).max().unwrap_or(0)
    }

    /// The same, but for voxels outside a window.
    pub fn crop(&self, window: Window) -> People {
        let voxels = self.voxels.iter().filter(|of| window.contains(of.voxel)).copied().collect();
        People { voxels, ..*self }
    }

    /// Who is detected in a region, voxel by voxel: which are hit, and which of them a presence sensor feels.
    pub fn detection(
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
        Detection::from_parts(self.min_hits.into(), parts.into_iter().map(tally), &felt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_threshold_what_is_hit_in_them() {
        let window = Window::from_corners([0; 3], [9, 0, 0]);
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
        assert_eq!(people.crop(Window::from_corners([2, 0, 0], [3, 0, 0])).voxels, voxels[2..4]);
    }
}
