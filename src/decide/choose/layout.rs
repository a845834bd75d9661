//! Which voxels of a study the bits of the solver are: those of one region in each scene, snapshot and repeat.

use perirobot_cover::layout::{BitLayout, FALSE, FELT, MISSED, MomentBits, PLANES, PartBits};
use perirobot_march::backend::Planes;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_scene::truth::region::window_of;
use perirobot_study::sensor::Kind;
use perirobot_study::study::Study;
use perirobot_study::world::World;
use perirobot_sweep::sweep::SensorSays;

/// The bits of a region in all worlds of a study.
pub(super) fn layout_of(study: &Study, worlds: &[World], region: usize) -> (BitLayout, Vec<RegionPlaces>) {
    let (moments, places): (Vec<MomentBits>, Vec<RegionPlaces>) =
        worlds.iter().map(|world| describe(world, region)).unzip();
    (BitLayout::new(&moments, study.repeats, study.min_hits.into()), places)
}

/// Where the voxels of a world's region are in planes over the bounding box of the world's regions.
#[derive(Debug)]
pub(super) struct RegionPlaces {
    window: Window,
    /// Of truly occupied and of truly free voxels: words of a plane, and the voxels in them.
    masks: [Vec<(usize, u32)>; 2],
    /// Of each part the bits of a plane.
    parts: Vec<Vec<usize>>,
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

impl RegionPlaces {
    /// The six planes of what a sensor says as words of one moment; none of a plane without a bit.
    pub(super) fn pick(&self, said: &[SensorSays]) -> [Vec<u64>; PLANES] {
        let mut all = Planes::blank(self.window);
        let mut felt = BitGrid::new(self.window);
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
        let [truly, falsely] = &self.masks;
        let of_people = |plane: &[u32]| {
            let part = |bits: &Vec<usize>| {
                let set = bits.iter().map(|&bit| (plane[bit >> 5] >> (bit & 31) & 1, 1));
                pack_bits(set)
            };
            self.parts.iter().flat_map(part).collect::<Vec<u64>>()
        };
        let of_mask = |plane: &[u32], masks: &[(usize, u32)]| {
            pack_bits(masks.iter().map(|&(word, mask)| (extract(plane[word], mask), mask.count_ones())))
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
        pack_bits(
            masks[0].iter().map(|&(word, mask)| (extract(plane.words()[word], mask), mask.count_ones())),
        )
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
fn pack_bits(groups: impl Iterator<Item = (u32, u32)>) -> Vec<u64> {
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
        let words = pack_bits(groups.into_iter());
        assert_eq!(words.len(), expected.len().div_ceil(64));
        let found = (0..words.len() * 64).map(|bit| words[bit / 64] >> (bit % 64) & 1 == 1);
        let padding = vec![false; words.len() * 64 - expected.len()];
        assert_eq!(found.collect::<Vec<_>>(), [expected, padding].concat());
    }
}
