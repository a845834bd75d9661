//! The evidence of a sensor at a moment, voxel by voxel, for any region.

use perirobot_cover::layout::PLANES;
use perirobot_march::backend::Planes;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_sweep::scoring::SensorSays;

/// The number of planes.
pub(super) const SAID: usize = 4;
/// Voxels labelled occupied.
pub(super) const OCCUPIED: usize = 0;
/// Voxels labelled free, and not occupied.
pub(super) const FREE: usize = 1;
/// Voxels of true returns.
pub(super) const HITS: usize = 2;
/// Those of them that a presence sensor feels.
pub(super) const FELT: usize = 3;

/// The source plane of each of the six planes of a region.
pub(super) const SAID_OF: [usize; PLANES] = [OCCUPIED, FREE, OCCUPIED, FREE, HITS, FELT];

/// The planes over a window.
pub(super) type SaidPlanes = [BitGrid; SAID];

/// Merges the evidence of some sensors in a window; occupied wins.
pub(super) fn join(window: Window, said: &[SensorSays]) -> SaidPlanes {
    let mut all = Planes::blank(window);
    let mut felt = BitGrid::new(window);
    for said in said {
        for part in &said.parts {
            all.add(part);
            if said.presence {
                felt.add(&part.hits);
            }
        }
    }
    all.free.remove(&all.occupied);
    [all.occupied, all.free, all.hits, felt]
}

/// The words of a plane, packed; empty for a plane without a bit. LZ4 packs the long runs of equal words in planes of
/// few surfaces, in a small share of the casting time.
pub(super) fn pack(plane: &BitGrid) -> Vec<u8> {
    if plane.is_empty() {
        return Vec::new();
    }
    let bytes: Vec<u8> = plane.words().iter().flat_map(|word| word.to_le_bytes()).collect();
    lz4_flex::block::compress(&bytes)
}

/// Unpacks a plane; `None` if it does not belong to this window.
pub(super) fn unpack(packed: &[u8], window: Window) -> Option<BitGrid> {
    let blank = BitGrid::new(window);
    if packed.is_empty() {
        return Some(blank);
    }
    let bytes = lz4_flex::block::decompress(packed, 4 * blank.words().len()).ok()?;
    let (words, rest) = bytes.as_chunks::<4>();
    let words = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    BitGrid::from_words(window, words).filter(|_| rest.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_planes_unpack_unchanged() {
        let window = Window { min: [-3, 0, 7], size: [70, 9, 5] };
        let mut plane = BitGrid::new(window);
        assert!(pack(&plane).is_empty());
        assert_eq!(unpack(&[], window), Some(plane.clone()));
        (0..60).for_each(|x| plane.set([x, (x * 7) % 9, 7 + x % 5]));
        plane.set_run(-3, 50, 4, 9);
        let packed = pack(&plane);
        assert!(packed.len() < 4 * plane.words().len());
        assert_eq!(unpack(&packed, window), Some(plane));
        assert_eq!(unpack(&packed, Window { size: [70, 9, 4], ..window }), None, "too much");
        assert_eq!(unpack(&packed, Window { size: [70, 9, 6], ..window }), None, "too little");
        assert_eq!(unpack(&packed[..packed.len() - 1], window), None);
    }
}
