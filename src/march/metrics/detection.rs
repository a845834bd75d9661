//! Whether people and their body parts are detected: thresholds on how many of their voxels are hit.
//! Who loads a scene says which voxel belongs to which part.

/// A part of a body, left and right of the person's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs)] // the names say it
pub enum BodyPart {
    /// With the neck.
    Head,
    Torso,
    LeftUpperArm,
    RightUpperArm,
    /// With the hand.
    LeftForearm,
    RightForearm,
    LeftThigh,
    RightThigh,
    /// With the foot.
    LeftShank,
    RightShank,
    /// All of a person of whom no bone is known.
    Body,
}

/// How many kinds of parts there are.
pub const BODY_PARTS: usize = 11;

impl BodyPart {
    /// All of them, in the order in which they are named.
    pub const ALL: [BodyPart; BODY_PARTS] = [
        BodyPart::Head,
        BodyPart::Torso,
        BodyPart::LeftUpperArm,
        BodyPart::RightUpperArm,
        BodyPart::LeftForearm,
        BodyPart::RightForearm,
        BodyPart::LeftThigh,
        BodyPart::RightThigh,
        BodyPart::LeftShank,
        BodyPart::RightShank,
        BodyPart::Body,
    ];

    /// As in tables.
    pub fn name(self) -> &'static str {
        [
            "head",
            "torso",
            "left_upper_arm",
            "right_upper_arm",
            "left_forearm",
            "right_forearm",
            "left_thigh",
            "right_thigh",
            "left_shank",
            "right_shank",
            "body",
        ][self as usize]
    }
}

/// What one part of one person has in a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartTally {
    /// Which person, counted from 0 in the order of the scene.
    pub person: usize,
    /// Which part.
    pub part: BodyPart,
    /// Its voxels in the region.
    pub voxels: u64,
    /// Those of them that are hit.
    pub hit: u64,
}

/// Who is detected in a region, or in several rows of results together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Detection {
    /// People's voxels that are hit.
    pub hit_human: u64,
    /// People of whom a part can be detected there.
    pub people: u64,
    /// Those that are detected.
    pub people_detected: u64,
    /// Parts with enough voxels there to be detected.
    pub parts: u64,
    /// Those that are detected.
    pub parts_detected: u64,
    /// For each of [`BodyPart::ALL`], in how many rows it is missed of some person.
    pub missed: [u64; BODY_PARTS],
}

impl Detection {
    /// Applies the threshold of `min_hits` voxels to all parts that have voxels in a region, those of a
    /// person together. `sensed` says of each person how many voxels there presence sensors feel.
    pub fn from_parts(
        min_hits: u64,
        parts: impl IntoIterator<Item = PartTally>,
        sensed: &[u64],
    ) -> Detection {
        let mut found = Detection::default();
        let mut people = vec![[false; 2]; sensed.len()];
        for PartTally { person, part, voxels, hit } in parts {
            found.hit_human += hit;
            if voxels < min_hits {
                continue;
            }
            let detected = hit >= min_hits;
            found.parts += 1;
            found.parts_detected += u64::from(detected);
            if !detected {
                found.missed[part as usize] = 1;
            }
            people[person][0] = true;
            people[person][1] |= detected;
        }
        for ([counts, by_part], &sensed) in people.into_iter().zip(sensed) {
            found.people += u64::from(counts);
            found.people_detected += u64::from(counts && (by_part || sensed > 0));
        }
        found
    }

    /// The counters: `hit_human`, `people`, `people_detected`, `parts`, `parts_detected`.
    pub fn counts(&self) -> [u64; DETECTION_COUNTERS] {
        [self.hit_human, self.people, self.people_detected, self.parts, self.parts_detected]
    }

    /// One row, from its counters and a bit for each part that is missed.
    pub fn from_counts(counts: [u64; DETECTION_COUNTERS], missed_bits: u32) -> Detection {
        let [hit_human, people, people_detected, parts, parts_detected] = counts;
        let missed = std::array::from_fn(|part| u64::from(missed_bits >> part & 1));
        Detection { hit_human, people, people_detected, parts, parts_detected, missed }
    }

    /// Counter by counter.
    pub(crate) fn plus(&self, other: &Detection) -> Detection {
        Detection {
            hit_human: self.hit_human + other.hit_human,
            people: self.people + other.people,
            people_detected: self.people_detected + other.people_detected,
            parts: self.parts + other.parts,
            parts_detected: self.parts_detected + other.parts_detected,
            missed: std::array::from_fn(|part| self.missed[part] + other.missed[part]),
        }
    }

    /// The parts that are missed of some person, a bit each.
    pub fn missed_bits(&self) -> u32 {
        self.missed.iter().zip(0..).fold(0, |bits, (&rows, part)| bits | u32::from(rows > 0) << part)
    }

    /// The names of the parts that are missed, joined by `+`.
    pub fn missed_names(&self) -> String {
        let missed = BodyPart::ALL.iter().filter(|&&part| self.missed[part as usize] > 0);
        missed.map(|part| part.name()).collect::<Vec<_>>().join("+")
    }

    /// The part that is missed in most rows, the first of several, and in how many; `None` if none is missed.
    pub fn worst_part(&self) -> Option<(BodyPart, u64)> {
        let missed = BodyPart::ALL.into_iter().map(|part| (part, self.missed[part as usize]));
        missed.rev().max_by_key(|&(_, rows)| rows).filter(|&(_, rows)| rows > 0)
    }
}

/// How many counters a [`Detection`] has besides the parts that are missed.
pub const DETECTION_COUNTERS: usize = 5;

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(person: usize, part: BodyPart, voxels: u64, hit: u64) -> PartTally {
        PartTally { person, part, voxels, hit }
    }

    #[test]
    fn parts_need_enough_hits_and_people_one_part_or_a_presence_sensor() {
        let parts = [
            tally(0, BodyPart::Head, 10, 3),
            tally(0, BodyPart::Torso, 40, 2),
            // Too few voxels to be detected ever: it counts nowhere, but its hits do.
            tally(0, BodyPart::LeftForearm, 2, 2),
            tally(1, BodyPart::Body, 100, 2),
            tally(2, BodyPart::Head, 2, 2),
        ];
        let found = Detection::from_parts(3, parts, &[0, 0, 0]);
        assert_eq!(found.counts(), [11, 2, 1, 3, 1]);
        assert_eq!(found.missed_names(), "torso+body");
        assert_eq!(Detection::from_counts(found.counts(), found.missed_bits()), found);
        // One voxel that a pad feels is enough for a person, not for a part; a person without a part there is
        // none.
        assert_eq!(Detection::from_parts(3, parts, &[0, 1, 5]).counts(), [11, 2, 2, 3, 1]);
        assert_eq!(Detection::from_parts(2, parts, &[0, 0, 0]).counts(), [11, 3, 3, 5, 5]);
    }

    #[test]
    fn the_worst_part_is_missed_in_most_rows_the_first_of_several() {
        let one = |bits| Detection::from_counts([0; DETECTION_COUNTERS], bits);
        assert_eq!(one(0).worst_part(), None);
        let sum = [0b110, 0b100, 0b1010].into_iter().map(one).reduce(|a, b| a.plus(&b)).unwrap();
        assert_eq!(sum.worst_part(), Some((BodyPart::Torso, 2)), "torso and left upper arm are missed twice");
        assert_eq!(one(1 << 10).worst_part(), Some((BodyPart::Body, 1)));
    }

    #[test]
    fn parts_are_numbered_in_their_order() {
        let numbers = BodyPart::ALL.map(|part| part as usize);
        assert_eq!(numbers.to_vec(), (0..BODY_PARTS).collect::<Vec<_>>());
    }
}
