//! The bits of the solver: the voxels of one region in each scene, snapshot and repeat of a study.

use perirobot_cover::layout::{BitLayout, FALSE, FELT, MISSED, MomentBits, PLANES, PartBits, SPACE_OF};
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_study::input::Study;
use perirobot_study::sensor::Kind;
use perirobot_study::world::World;

/// The bits of a region in all worlds of a study.
pub(super) fn layout_of(study: &Study, worlds: &[World], region: usize) -> BitLayout {
    let windows: Vec<Window> = worlds.iter().map(|world| world.regions[region].voxels.window()).collect();
    layout_in(study, worlds, &windows, region).0
}

/// The same, with the places of the region's voxels in planes over a window of each world.
pub(super) fn layout_in(
    study: &Study,
    worlds: &[World],
    windows: &[Window],
    region: usize,
) -> (BitLayout, Vec<RegionPlaces>) {
    let described = worlds.iter().zip(windows).map(|(world, &window)| describe(world, window, region));
    let (moments, places): (Vec<MomentBits>, Vec<RegionPlaces>) = described.unzip();
    (BitLayout::new(&moments, study.repeats, study.min_hits.into()), places)
}

/// The places of a world's region in planes over a window of the world.
#[derive(Debug)]
pub(super) struct RegionPlaces {
    /// Of truly occupied and of truly free voxels: words of a plane, and the voxels in them.
    masks: [Vec<(usize, u32)>; 2],
    /// The bits of each part in a plane.
    parts: Vec<Vec<usize>>,
}

/// The planes of a sensor, of six, that may have a bit: without noise or volumes all its labels are correct, and few
/// sensors feel people.
pub(super) fn may_have_bits(kind: &dyn Kind, representation: usize) -> [bool; PLANES] {
    let may_be_wrong = kind.is_noisy() || kind.adds(representation);
    std::array::from_fn(|plane| match plane {
        MISSED | FALSE => may_be_wrong,
        FELT => kind.feels_presence(representation),
        _ => true,
    })
}

impl RegionPlaces {
    /// One of the six planes as words of one moment, from the plane of [`SAID_OF`]; empty if it has no bit.
    ///
    /// [`SAID_OF`]: super::planes::SAID_OF
    pub(super) fn pick(&self, plane: usize, said: &BitGrid) -> Vec<u64> {
        let plane_words = said.words();
        let words = match SPACE_OF[plane] {
            space @ (0 | 1) => {
                let masks = self.masks[space].iter();
                pack_bits(masks.map(|&(word, mask)| (extract(plane_words[word], mask), mask.count_ones())))
            }
            _ => {
                let part = |bits: &Vec<usize>| {
                    pack_bits(bits.iter().map(|&bit| (plane_words[bit >> 5] >> (bit & 31) & 1, 1)))
                };
                self.parts.iter().flat_map(part).collect()
            }
        };
        if words.iter().all(|&word| word == 0) { Vec::new() } else { words }
    }
}

fn describe(world: &World, window: Window, region: usize) -> (MomentBits, RegionPlaces) {
    let truth = world.truth();
    let [region, occupied, human, robot] =
        [&*world.regions[region].voxels, &*truth.occupied, &truth.human, &truth.robot]
            .map(|plane| plane.to_window(window));
    let mut masks = [Vec::new(), Vec::new()];
    for (word, (&inside, &filled)) in region.words().iter().zip(occupied.words()).enumerate() {
        for (masks, mask) in masks.iter_mut().zip([inside & filled, inside & !filled]) {
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
    let roles = [&human, &robot].map(role);
    let mut body: Vec<_> = world.people.voxels.iter().filter(|of| region.get(of.voxel)).collect();
    body.sort_by_key(|of| (of.person, of.part, occupied.bit_index(of.voxel)));
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
        bits.push(of_part.iter().filter_map(|of| occupied.bit_index(of.voxel)).collect());
    }
    let words = [voxels[0].div_ceil(64) as usize, voxels[1].div_ceil(64) as usize, end];
    let people = parts.iter().map(|part| part.person + 1).max().unwrap_or(0);
    let moment = MomentBits { words: words.map(|words| 0..words), voxels, roles, parts, people };
    (moment, RegionPlaces { masks, parts: bits })
}

/// Gathers the bits of a word at the places of a mask (`pext`).
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

/// Packs groups of bits, lowest first, with their lengths, into words of 64.
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
