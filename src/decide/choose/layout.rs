//! Which bits stand for which voxels: those of one region in each scene, snapshot and repeat, one row of bits
//! for all of them together. Truly occupied voxels, truly free ones and those of people have rows of their
//! own.

use std::ops::Range;

use perirobot_march::backend::Planes;
use perirobot_march::metrics::{BodyPart, Confusion, Detection, PartTally, RoleCounts, Score};
use perirobot_march::voxel::{BitGrid, Joined, Ones, Window};
use perirobot_scene::truth::region::window_of;
use perirobot_study::sensor::Kind;
use perirobot_study::study::Study;
use perirobot_study::world::World;
use perirobot_sweep::sweep::SensorSays;

/// What is kept of a sensor at a candidate: six rows of bits.
pub(super) const PLANES: usize = 6;
/// Truly occupied voxels that it calls occupied.
pub(super) const HIT: usize = 0;
/// Truly occupied voxels that it calls free.
pub(super) const MISSED: usize = 1;
/// Truly free voxels that it calls occupied.
pub(super) const FALSE: usize = 2;
/// Truly free voxels that it calls free.
pub(super) const CLEAR: usize = 3;
/// People's voxels that it hits.
pub(super) const SEEN: usize = 4;
/// People's voxels that it feels as a presence sensor.
pub(super) const FELT: usize = 5;

/// The rows of bits: of truly occupied voxels, of truly free ones, and of people's.
pub(super) const SPACES: usize = 3;

/// Which row of bits each of the six is.
pub(super) const SPACE_OF: [usize; PLANES] = [0, 0, 1, 1, 2, 2];

/// The bits of all moments.
#[derive(Debug)]
pub(super) struct BitLayout {
    /// Repeat by repeat, and in each scene by scene and snapshot by snapshot.
    pub(super) moments: Vec<MomentBits>,
    /// Words of each row of bits.
    pub(super) words: [usize; SPACES],
    /// How many voxels of a part must be hit.
    min_hits: u64,
    /// For each world where its voxels are in the planes of a backend.
    places: Vec<RegionPlaces>,
}

/// One repeat of a world.
#[derive(Clone, Debug)]
pub(super) struct MomentBits {
    /// Its words in each row of bits.
    pub(super) words: [Range<usize>; SPACES],
    /// Voxels of the region that are truly occupied, and truly free.
    pub(super) voxels: [u64; 2],
    /// Of the truly occupied ones those of people and of the robot: words of the first row of bits.
    roles: [Vec<u64>; 2],
    /// The parts of people's bodies.
    pub(super) parts: Vec<PartBits>,
    /// How many people are numbered.
    pub(super) people: usize,
}

/// A part of a person's body in the region.
#[derive(Clone, Debug)]
pub(super) struct PartBits {
    /// Whose it is.
    pub(super) person: usize,
    part: BodyPart,
    /// Its voxels in the region.
    pub(super) voxels: u64,
    /// Its words of the third row of bits.
    pub(super) words: Range<usize>,
}

/// Where the voxels of a world's region are in planes over the bounding box of the world's regions.
#[derive(Debug)]
struct RegionPlaces {
    window: Window,
    /// Of truly occupied and of truly free voxels: words of a plane, and the voxels in them.
    masks: [Vec<(usize, u32)>; 2],
    /// Of each part the bits of a plane.
    parts: Vec<Vec<usize>>,
}

/// What is counted of a union.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wanted {
    /// The labels of all voxels.
    pub(super) labels: bool,
    /// Besides, those of people's and the robot's voxels.
    pub(super) roles: bool,
    /// Who is detected.
    pub(super) people: bool,
}

impl Wanted {
    /// Everything.
    pub(super) const ALL: Wanted = Wanted { labels: true, roles: true, people: true };

    /// What some scores are made of.
    pub(super) fn of(scores: impl Iterator<Item = Score>) -> Wanted {
        let mut wanted = Wanted { labels: false, roles: false, people: false };
        for score in scores {
            match score {
                Score::F1 | Score::Kappa => wanted.labels = true,
                _ => wanted.people = true,
            }
        }
        wanted
    }

    /// Whether one of the six planes is counted.
    pub(super) fn needs(&self, plane: usize) -> bool {
        match plane {
            SEEN | FELT => self.people,
            _ => self.labels,
        }
    }
}

/// Truly occupied and truly free voxels, and of parts of people whose they are and how many voxels they have.
#[cfg(test)]
pub(super) type MadeUp = ([u64; 2], Vec<(usize, u64)>);

impl BitLayout {
    /// The bits of a region in all worlds of a study.
    pub(super) fn new(study: &Study, worlds: &[World], region: usize) -> BitLayout {
        let (mut words, mut moments, mut places) = ([0; SPACES], Vec::new(), Vec::new());
        let described: Vec<(MomentBits, RegionPlaces)> =
            worlds.iter().map(|world| describe(world, region)).collect();
        for _ in 0..study.repeats {
            for (moment, _) in &described {
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
        places.extend(described.into_iter().map(|(_, places)| places));
        BitLayout { moments, words, min_hits: study.min_hits.into(), places }
    }

    /// Moments with so many voxels, made up.
    #[cfg(test)]
    pub(super) fn made_up(moments: &[MadeUp], min_hits: u64) -> BitLayout {
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
        BitLayout { moments, words, min_hits, places: Vec::new() }
    }

    /// How many words each of the six planes has in one moment of a world.
    pub(super) fn words_of(&self, world: usize) -> [usize; PLANES] {
        SPACE_OF.map(|space| self.moments[world].words[space].len())
    }

    /// Which of the six planes of a sensor may have a bit: without noise or volumes it is right about all that it
    /// says, and few sensors feel anybody.
    pub(super) fn may_have_bits(kind: &dyn Kind, representation: usize) -> [bool; PLANES] {
        let may_be_wrong = kind.is_noisy() || kind.adds(representation);
        std::array::from_fn(|plane| match plane {
            MISSED | FALSE => may_be_wrong,
            FELT => kind.feels_presence(representation),
            _ => true,
        })
    }

    /// The six planes of what a sensor says in a world, as words of one moment; none of a plane without a bit.
    pub(super) fn pick(&self, world: usize, said: &[SensorSays]) -> [Vec<u64>; PLANES] {
        let places = &self.places[world];
        let mut all = Planes::blank(places.window);
        let mut felt = BitGrid::new(places.window);
        for said in said {
            for part in &said.parts {
                all.occupied.add(&part.occupied);
                all.free.add(&part.free);
                all.hits.add(&part.hits);
                if said.presence {
                    felt.add(&part.hits);
                }
            }
        }
        all.free.remove(&all.occupied);
        let [occupied, free, hits, felt] = [&all.occupied, &all.free, &all.hits, &felt].map(BitGrid::words);
        let [truly, falsely] = &places.masks;
        let of_people = |plane: &[u32]| {
            let part = |bits: &Vec<usize>| {
                let set = bits.iter().map(|&bit| (plane[bit >> 5] >> (bit & 31) & 1, 1));
                packed(set)
            };
            places.parts.iter().flat_map(part).collect::<Vec<u64>>()
        };
        let of_mask = |plane: &[u32], masks: &[(usize, u32)]| {
            packed(masks.iter().map(|&(word, mask)| (extract(plane[word], mask), mask.count_ones())))
        };
        [
            of_mask(occupied, truly),
            of_mask(free, truly),
            of_mask(occupied, falsely),
            of_mask(free, falsely),
            of_people(hits),
            of_people(felt),
        ]
        .map(|words| if words.iter().all(|&word| word == 0) { Vec::new() } else { words })
    }

    /// What a union of rows is worth at one moment.
    pub(super) fn counts(
        &self,
        ones: Ones,
        moment: &MomentBits,
        planes: &[Joined; PLANES],
        wanted: Wanted,
    ) -> Confusion {
        let [truly, falsely, _] = &moment.words;
        let mut counts = Confusion::default();
        if wanted.labels {
            let (hit, missed) = (planes[HIT].part(truly), planes[MISSED].part(truly));
            let (wrong, clear) = (planes[FALSE].part(falsely), planes[CLEAR].part(falsely));
            counts.tp = ones.of_joined(hit);
            counts.fn_ = ones.joined_beyond(missed, hit);
            counts.uo = moment.voxels[0] - counts.tp - counts.fn_;
            counts.fp = ones.of_joined(wrong);
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
                sensed[part.person] += ones.of_joined(planes[FELT].part(&part.words));
                let hit = ones.of_joined(planes[SEEN].part(&part.words));
                PartTally { person: part.person, part: part.part, voxels: part.voxels, hit }
            };
            let parts: Vec<PartTally> = moment.parts.iter().map(tally).collect();
            counts.detection = Detection::of(self.min_hits, parts, &sensed);
        }
        if wanted.people && !wanted.roles {
            // Scores of people need their number of voxels; without labels all of them count as unknown.
            counts.human.uo = moment.parts.iter().map(|part| part.voxels).sum();
        }
        counts
    }

    /// The parts of people's bodies, moment by moment.
    pub(super) fn parts(&self) -> impl Iterator<Item = &PartBits> {
        self.moments.iter().flat_map(|moment| &moment.parts)
    }

    /// How many voxels of a part must be hit for it to be detected.
    pub(super) fn min_hits(&self) -> u64 {
        self.min_hits
    }
}

fn describe(world: &World, region: usize) -> (MomentBits, RegionPlaces) {
    let window = window_of(&world.regions);
    let scene = world.scene(window);
    let (region, truth) = (&scene.regions[region], &scene.truth);
    let mut masks = [Vec::new(), Vec::new()];
    for (word, (&inside, &occupied)) in region.words().iter().zip(truth.words()).enumerate() {
        for (masks, mask) in masks.iter_mut().zip([inside & occupied, inside & !occupied]) {
            if mask != 0 {
                masks.push((word, mask));
            }
        }
    }
    let voxels: [u64; 2] =
        [0, 1].map(|i: usize| masks[i].iter().map(|(_, mask)| u64::from(mask.count_ones())).sum());
    let role = |plane: &BitGrid| {
        packed(masks[0].iter().map(|&(word, mask)| (extract(plane.words()[word], mask), mask.count_ones())))
    };
    let roles = [&scene.human, &scene.robot].map(role);
    let mut body: Vec<_> = scene.people.voxels.iter().filter(|of| region.get(of.voxel)).collect();
    body.sort_by_key(|of| (of.person, of.part, truth.bit_index(of.voxel)));
    let (mut parts, mut bits, mut end) = (Vec::new(), Vec::new(), 0);
    for of_part in body.chunk_by(|a, b| (a.person, a.part) == (b.person, b.part)) {
        let first = end;
        end += of_part.len().div_ceil(64);
        parts.push(PartBits {
            person: of_part[0].person as usize,
            part: of_part[0].part,
            voxels: of_part.len() as u64,
            words: first..end,
        });
        bits.push(of_part.iter().filter_map(|of| truth.bit_index(of.voxel)).collect());
    }
    let words = [voxels[0].div_ceil(64) as usize, voxels[1].div_ceil(64) as usize, end];
    let people = parts.iter().map(|part| part.person + 1).max().unwrap_or(0);
    let moment = MomentBits { words: words.map(|words| 0..words), voxels, roles, parts, people };
    (moment, RegionPlaces { window, masks, parts: bits })
}

/// Bits of a word at the places of a mask, moved together.
fn extract(word: u32, mut mask: u32) -> u32 {
    if mask == u32::MAX {
        return word;
    }
    let (mut bits, mut count) = (0, 0);
    while mask != 0 {
        let low = mask.trailing_zeros();
        let run = (!(mask >> low)).trailing_zeros();
        let ones = ((1u64 << run) - 1) as u32;
        bits |= ((word >> low) & ones) << count;
        count += run;
        mask &= !(((u64::from(ones)) << low) as u32);
    }
    bits
}

/// Groups of bits, lowest first, with their lengths, one after the other in words of 64.
fn packed(groups: impl Iterator<Item = (u32, u32)>) -> Vec<u64> {
    let (mut words, mut word, mut filled) = (Vec::new(), 0u64, 0);
    for (bits, count) in groups {
        word |= u64::from(bits) << filled;
        filled += count;
        if filled >= 64 {
            words.push(word);
            filled -= 64;
            let left = count - filled;
            word = if filled == 0 { 0 } else { u64::from(bits) >> left };
        }
    }
    if filled > 0 {
        words.push(word);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_at_the_places_of_a_mask_are_moved_together() {
        let mut state = 3u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 32) as u32
        };
        let mut groups = Vec::new();
        let mut expected: Vec<bool> = Vec::new();
        for case in 0..1000 {
            let mask = match case % 4 {
                0 => u32::MAX,
                1 => random() & random() & random(),
                2 => 1 << (case % 32),
                _ => random(),
            };
            let word = random();
            groups.push((extract(word, mask), mask.count_ones()));
            expected.extend((0..32).filter(|bit| mask >> bit & 1 == 1).map(|bit| word >> bit & 1 == 1));
        }
        let words = packed(groups.into_iter());
        assert_eq!(words.len(), expected.len().div_ceil(64));
        let found = (0..words.len() * 64).map(|bit| words[bit / 64] >> (bit % 64) & 1 == 1);
        let padding = vec![false; words.len() * 64 - expected.len()];
        assert_eq!(found.collect::<Vec<_>>(), [expected, padding].concat());
    }
}
