//! The evidence of candidates in one region: rows of bits, in memory if they fit.

use super::super::layout::{RegionPlaces, layout_in, may_have_bits};
use super::super::planes::{SAID_OF, SaidPlanes};
use perirobot_cover::layout::{BitLayout, PLANES, SPACE_OF, WantedCounts};
use perirobot_march::voxel::Window;
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// The evidence of a candidate in a region in one repeat of a world: words of six planes; empty for a plane without a
/// bit or that is not needed.
pub(super) type CandidateWords = [Vec<u64>; PLANES];

/// The rows of a region.
pub(super) struct RegionRows {
    pub(super) layout: BitLayout,
    /// For each world the places of its voxels in the planes.
    pub(super) places: Vec<RegionPlaces>,
    /// The planes of each sensor that the question needs and that may have a bit.
    pub(super) needed: Vec<[bool; PLANES]>,
    /// The bits of all moments in memory, empty for a plane without a bit; all empty once they do not fit.
    pub(super) rows: Vec<[Box<[u64]>; PLANES]>,
    /// The planes of each row that have a bit.
    pub(super) has: Vec<[bool; PLANES]>,
    /// Bytes of all planes, in memory or not.
    pub(super) bytes: u64,
}

impl RegionRows {
    /// Empty rows for some candidates.
    pub(super) fn new(
        study: &Study,
        (worlds, windows): (&[World], &[Window]),
        (region, wanted): (usize, WantedCounts),
        representations: &[usize],
        items: usize,
    ) -> RegionRows {
        let (layout, places) = layout_in(study, worlds, windows, region);
        let needed = study.sensors.iter().zip(representations).map(|(sensor, &way)| {
            let may = may_have_bits(&*sensor.kind, way);
            std::array::from_fn(|plane| wanted.needs(plane) && may[plane])
        });
        RegionRows {
            layout,
            places,
            needed: needed.collect(),
            rows: vec![Default::default(); items],
            has: vec![[false; PLANES]; items],
            bytes: 0,
        }
    }

    /// The evidence of a sensor in the region in a world.
    pub(super) fn pick(&self, sensor: usize, world: usize, said: &SaidPlanes) -> CandidateWords {
        std::array::from_fn(|plane| match self.needed[sensor][plane] {
            true => self.places[world].pick(plane, &said[SAID_OF[plane]]),
            false => Vec::new(),
        })
    }

    /// Stores the evidence of a candidate at some moments. Beyond `most_bytes` it is only counted.
    pub(super) fn put(
        &mut self,
        item: usize,
        moments: impl Iterator<Item = usize> + Clone,
        words: &CandidateWords,
        most_bytes: u64,
    ) {
        let filled = words.iter().enumerate().filter(|(_, words)| !words.is_empty());
        for (plane, words) in filled {
            let length = self.layout.words[SPACE_OF[plane]];
            let is_new = !std::mem::replace(&mut self.has[item][plane], true);
            self.bytes += u64::from(is_new) * 8 * length as u64;
            let Some(row) = self.rows.get_mut(item).map(|row| &mut row[plane]) else { continue };
            if is_new && self.bytes <= most_bytes {
                *row = vec![0; length].into();
            }
            if row.is_empty() {
                continue;
            }
            for moment in moments.clone() {
                row[self.layout.moments[moment].words[SPACE_OF[plane]].clone()].copy_from_slice(words);
            }
        }
    }

    /// The most bytes that a row of a sensor may still take.
    pub(super) fn bytes_to_come(&self, sensor: usize, item: usize) -> u64 {
        let more = (0..PLANES).filter(|&plane| self.needed[sensor][plane] && !self.has[item][plane]);
        more.map(|plane| 8 * self.layout.words[SPACE_OF[plane]] as u64).sum()
    }
}
