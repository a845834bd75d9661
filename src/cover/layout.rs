//! Which bits stand for which voxels: those of one region in each scene, snapshot and repeat, one row of bits
//! for all of them together. Truly occupied voxels, truly free ones and those of people have rows of their
//! own.

use std::ops::Range;

use perirobot_march::metrics::{BodyPart, Confusion, Detection, PartTally, RoleCounts, Score};
use perirobot_march::voxel::{Joined, Ones};

/// What is kept of a sensor at a candidate: six rows of bits.
pub const PLANES: usize = 6;
/// Truly occupied voxels that it calls occupied.
pub const HIT: usize = 0;
/// Truly occupied voxels that it calls free.
pub const MISSED: usize = 1;
/// Truly free voxels that it calls occupied.
pub const FALSE: usize = 2;
/// Truly free voxels that it calls free.
pub const CLEAR: usize = 3;
/// People's voxels that it hits.
pub const SEEN: usize = 4;
/// People's voxels that it feels as a presence sensor.
pub const FELT: usize = 5;

/// The rows of bits: of truly occupied voxels, of truly free ones, and of people's.
pub const SPACES: usize = 3;

/// Which row of bits each of the six is.
pub const SPACE_OF: [usize; PLANES] = [0, 0, 1, 1, 2, 2];

/// The bits of all moments.
#[derive(Debug)]
pub struct BitLayout {
    /// Repeat by repeat, and in each scene by scene and snapshot by snapshot.
    pub moments: Vec<MomentBits>,
    /// Words of each row of bits.
    pub words: [usize; SPACES],
    /// How many voxels of a part must be hit.
    min_hits: u64,
}

/// One repeat of a world.
#[derive(Clone, Debug)]
pub struct MomentBits {
    /// Its words in each row of bits.
    pub words: [Range<usize>; SPACES],
    /// Voxels of the region that are truly occupied, and truly free.
    pub voxels: [u64; 2],
    /// Of the truly occupied ones those of people and of the robot: words of the first row of bits.
    pub roles: [Vec<u64>; 2],
    /// The parts of people's bodies.
    pub parts: Vec<PartBits>,
    /// How many people are numbered.
    pub people: usize,
}

/// A part of a person's body in the region.
#[derive(Clone, Debug)]
pub struct PartBits {
    /// Whose it is.
    pub person: usize,
    /// Which part.
    pub part: BodyPart,
    /// Its voxels in the region.
    pub voxels: u64,
    /// Its words of the third row of bits.
    pub words: Range<usize>,
}

/// What is counted of a union.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WantedCounts {
    /// The labels of all voxels.
    pub labels: bool,
    /// Besides, those of people's and the robot's voxels.
    pub roles: bool,
    /// Who is detected.
    pub people: bool,
}

impl WantedCounts {
    /// Everything.
    pub const ALL: WantedCounts = WantedCounts { labels: true, roles: true, people: true };

    /// What some scores are made of.
    pub fn from_scores(scores: impl Iterator<Item = Score>) -> WantedCounts {
        let mut wanted = WantedCounts { labels: false, roles: false, people: false };
        for score in scores {
            match score {
                Score::F1 | Score::Kappa => wanted.labels = true,
                _ => wanted.people = true,
            }
        }
        wanted
    }

    /// Whether one of the six planes is counted.
    pub fn needs(&self, plane: usize) -> bool {
        match plane {
            SEEN | FELT => self.people,
            _ => self.labels,
        }
    }
}

/// Truly occupied and truly free voxels, and of parts of people whose they are and how many voxels they have.
#[cfg(test)]
pub(crate) type MadeUp = ([u64; 2], Vec<(usize, u64)>);

impl BitLayout {
    /// The bits of each moment of one repeat, in all repeats; a part must be hit in `min_hits` voxels.
    pub fn new(described: &[MomentBits], repeats: u32, min_hits: u64) -> BitLayout {
        let (mut words, mut moments) = ([0; SPACES], Vec::new());
        for _ in 0..repeats {
            for moment in described {
                let first = words;
                let shifted: [Range<usize>; SPACES] = std::array::from_fn(|space| {
                    words[space] += moment.words[space].len();
                    first[space]..words[space]
                });
                let mut moment = moment.clone();
                for part in &mut moment.parts {
                    part.words = part.words.start + first[2]..part.words.end + first[2];
                }
                moments.push(MomentBits { words: shifted, ..moment });
            }
        }
        BitLayout { moments, words, min_hits }
    }

    /// Moments with so many voxels, made up.
    #[cfg(test)]
    pub(crate) fn made_up(moments: &[MadeUp], min_hits: u64) -> BitLayout {
        let mut words = [0; SPACES];
        let one = |(voxels, people): &MadeUp| {
            let mut first = words[2];
            let part = |(number, &(person, voxels)): (usize, &(usize, u64))| {
                let end = first + voxels.div_ceil(64) as usize;
                let part = PartBits { person, part: BodyPart::ALL[number], voxels, words: first..end };
                first = end;
                part
            };
            let parts: Vec<PartBits> = people.iter().enumerate().map(part).collect();
            let before = words;
            words = [
                words[0] + voxels[0].div_ceil(64) as usize,
                words[1] + voxels[1].div_ceil(64) as usize,
                parts.last().map_or(words[2], |part| part.words.end),
            ];
            let roles = [0; 2].map(|_| vec![0; words[0] - before[0]]);
            let people = parts.iter().map(|part| part.person + 1).max().unwrap_or(0);
            let words = std::array::from_fn(|space| before[space]..words[space]);
            MomentBits { words, voxels: *voxels, roles, parts, people }
        };
        let moments = moments.iter().map(one).collect();
        BitLayout { moments, words, min_hits }
    }

    /// How many words each of the six planes has in one moment of a world.
    pub fn words_of(&self, world: usize) -> [usize; PLANES] {
        SPACE_OF.map(|space| self.moments[world].words[space].len())
    }

    /// What a union of rows is worth at one moment. A union does not determine the overlap, which stays empty.
    pub fn counts(
        &self,
        ones: Ones,
        moment: &MomentBits,
        planes: &[Joined; PLANES],
        wanted: WantedCounts,
    ) -> Confusion {
        let [truly, falsely, _] = &moment.words;
        let mut counts = Confusion::default();
        if wanted.labels {
            let (hit, missed) = (planes[HIT].part(truly), planes[MISSED].part(truly));
            let (wrong, clear) = (planes[FALSE].part(falsely), planes[CLEAR].part(falsely));
            counts.tp = ones.count_joined(hit);
            counts.fn_ = ones.joined_beyond(missed, hit);
            counts.uo = moment.voxels[0] - counts.tp - counts.fn_;
            counts.fp = ones.count_joined(wrong);
            counts.tn = ones.joined_beyond(clear, wrong);
            counts.uf = moment.voxels[1] - counts.fp - counts.tn;
            if wanted.roles {
                let of_role = |role: &Vec<u64>| {
                    let [tp, fn_, uo] = ones.shared_out(role, hit, missed);
                    RoleCounts { tp, fn_, uo }
                };
                [counts.human, counts.robot] = moment.roles.each_ref().map(of_role);
            }
        }
        if wanted.people {
            let mut sensed = vec![0; moment.people];
            let tally = |part: &PartBits| {
                sensed[part.person] += ones.count_joined(planes[FELT].part(&part.words));
                let hit = ones.count_joined(planes[SEEN].part(&part.words));
                PartTally { person: part.person, part: part.part, voxels: part.voxels, hit }
            };
            let parts: Vec<PartTally> = moment.parts.iter().map(tally).collect();
            counts.detection = Detection::from_parts(self.min_hits, parts, &sensed);
        }
        if wanted.people && !wanted.roles {
            // Scores of people need their number of voxels; without labels all of them count as unknown.
            counts.human.uo = moment.parts.iter().map(|part| part.voxels).sum();
        }
        counts
    }

    /// The parts of people's bodies, moment by moment.
    pub fn parts(&self) -> impl Iterator<Item = &PartBits> {
        self.moments.iter().flat_map(|moment| &moment.parts)
    }

    /// How many voxels of a part must be hit for it to be detected.
    pub fn min_hits(&self) -> u64 {
        self.min_hits
    }
}
