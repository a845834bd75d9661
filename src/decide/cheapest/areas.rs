//! The floor that a set must watch so that little is left on which a body is unnoticed, as bits that the search counts.
//!
//! # Theory
//! If `n` sensors notice a body together, one of them watches at least an `n`-th of the voxels that this takes. A set
//! leaves no more unnoticed places than are allowed only if its members cover all others in this sense. What is watched
//! differs between the snapshots of a scene, and a body is noticed if it is in all of them, so the first one also is a bound.

use rayon::prelude::*;

use super::ways::SceneWays;
use perirobot_cover::CandidateEvidence;
use perirobot_cover::cheapest::Coverage;
use perirobot_cover::layout::{BitLayout, MomentBits, PLANES};
use perirobot_march::voxel::BitGrid;

/// The places of bodies that candidates can cover.
pub(super) struct Areas {
    /// A bit for each place; a moment for each pair of scene and body.
    covered: CandidateEvidence,
    /// Scene, body and number of places of each moment.
    moments: Vec<([usize; 2], u64)>,
}

/// An area that must be small.
pub(super) struct LargestArea {
    /// Scene and body.
    pub(super) of: [usize; 2],
    /// The number of places that may be left.
    pub(super) most: u64,
    /// The number of sensors that may be dead.
    pub(super) dead: usize,
}

impl Areas {
    /// The areas of all scenes, for sets of at most this many members.
    pub(super) fn new(ways: &[SceneWays], items: &[[usize; 2]], at_most: usize) -> Areas {
        let (mut described, mut moments) = (Vec::new(), Vec::new());
        let mut first = 0;
        for (scene, ways) in ways.iter().enumerate() {
            for (body, free) in ways.free_floor() {
                let words = packed_length(free);
                moments.push(([scene, body], free.count()));
                described.push(MomentBits {
                    words: [0..words, 0..0, 0..0],
                    voxels: [free.count(), 0],
                    roles: [vec![0; words], vec![0; words]],
                    parts: Vec::new(),
                    people: 0,
                });
                first += words;
            }
        }
        let row = |item: usize| -> [Box<[u64]>; PLANES] {
            let mut covered = Vec::with_capacity(first);
            for ways in ways {
                let planes = ways.may_notice(item, at_most);
                ways.free_floor().for_each(|(body, _)| covered.extend(packed(&planes[body])));
            }
            let mut row: [Box<[u64]>; PLANES] = Default::default();
            row[perirobot_cover::layout::HIT] = covered.into();
            row
        };
        let rows = (0..items.len()).into_par_iter().map(row).collect();
        let layout = BitLayout::new(&described, 1, 1);
        Areas { covered: CandidateEvidence::from_memory(layout, items.to_vec(), rows, 0), moments }
    }

    /// What a set must cover to keep an area small.
    pub(super) fn coverage(&self, largest: &LargestArea) -> Option<Coverage<'_>> {
        let moment = self.moments.iter().position(|(of, _)| *of == largest.of)?;
        let least = self.moments[moment].1.saturating_sub(largest.most);
        Some(Coverage { evidence: &self.covered, moment, least, dead: largest.dead })
    }
}

fn packed_length(plane: &BitGrid) -> usize {
    plane.words().len().div_ceil(2)
}

/// The words of a plane, packed in pairs.
fn packed(plane: &BitGrid) -> impl Iterator<Item = u64> {
    let word = |pair: &[u32]| u64::from(pair[0]) | u64::from(pair.get(1).copied().unwrap_or(0)) << 32;
    plane.words().chunks(2).map(word)
}
