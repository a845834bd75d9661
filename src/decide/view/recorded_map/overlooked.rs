//! Why a recorded map does not label an occupied voxel occupied.
//!
//! # Theory
//! A map has no rays, so there are fewer reasons than in [`crate::view::why`]. An occupied voxel without the label occupied
//! has the first that applies:
//!
//! | reason | condition |
//! |---|---|
//! | `beside` | labelled free, with an occupied label among its 26 neighbours; or without a label, with a free neighbour labelled occupied: the object is in the map, a voxel off |
//! | `said_free` | labelled free |
//! | `hidden` | something is in front of it, seen from each position of a sensor |
//! | `not_measured` | none of these: in sight without a point, or no position is known |
//!
//! * The ray from the place to the voxel's centre marches as all rays do, its direction a unit vector in Q16. Something is
//!   in front of the voxel if this ray first enters another voxel that stops rays. It may be the voxel's own object: its
//!   far side, or its inside.
//! * Of several positions, the object in front of the first is named.
//! * A ray marches 2047 voxels; farther voxels are `not_measured`.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::RecordedMap;
use crate::view::View;
use perirobot_march::backend::cpu::BlockerSearch;
use perirobot_march::march::{self, FULL_RANGE, Gates, leap};
use perirobot_march::voxel::{BitGrid, Grid};
use perirobot_scene::recording::cloud::enters;

/// Why an occupied voxel is not labelled occupied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Oversight {
    /// The map has an occupied voxel next to it.
    Beside,
    /// The map labels it free.
    SaidFree,
    /// An object was in front of it.
    Hidden,
    /// It was not measured.
    NotMeasured,
}

impl Oversight {
    /// All reasons, in their order.
    pub const ALL: [Oversight; 4] =
        [Oversight::Beside, Oversight::SaidFree, Oversight::Hidden, Oversight::NotMeasured];

    /// The name in tables.
    pub fn name(self) -> &'static str {
        ["beside", "said_free", "hidden", "not_measured"][self as usize]
    }
}

/// Voxels that a map misses for the same reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overlooked {
    /// The reason.
    pub reason: Oversight,
    /// The hiding object, by its index in [`perirobot_scene::truth::Truth::objects`].
    pub object: Option<usize>,
    /// The voxels.
    pub voxels: BitGrid,
}

impl Overlooked {
    /// The number of its voxels in the intersection of some planes.
    pub fn count(&self, of: &[&BitGrid]) -> u64 {
        let mut voxels = self.voxels.clone();
        of.iter().for_each(|plane| voxels.keep(plane));
        voxels.count()
    }
}

/// Lines of sight: they end in the first blocker at any distance.
const SIGHT: Gates = Gates {
    range_min_q16: 0,
    range_max_q16: march::MAX_RANGE_VOXELS << 16,
    shade_ranges_q16: FULL_RANGE,
    along_axis: false,
    near_ignore_q16: 0,
    no_return_is_free: false,
    backdrop: false,
};

impl RecordedMap {
    /// The voxels that the map misses in all regions, reason by reason, in their order. The view is the map's own.
    pub fn find_overlooked(&self, view: &View) -> Vec<Overlooked> {
        let (truth, labels) = (&*view.truth, &view.labels);
        let mut overlooked = self.world.region_voxels();
        overlooked.keep(&truth.occupied);
        overlooked.remove(&labels.occupied);
        let search = view.search.get_or_init(|| BlockerSearch::new(&truth.blockers));
        let why = |&voxel: &[i32; 3]| {
            let is_free = labels.free.get(voxel);
            let tells =
                |near: &[i32; 3]| labels.occupied.get(*near) && (is_free || !truth.occupied.get(*near));
            if neighbours(voxel).any(|near| tells(&near)) {
                return (Oversight::Beside, None);
            }
            if is_free {
                return (Oversight::SaidFree, None);
            }
            let before: Option<Vec<_>> = self
                .places_m
                .iter()
                .map(|&place| blocking_voxel(place, voxel, &truth.grid, search))
                .collect();
            match before.as_deref() {
                Some([first, ..]) => {
                    let stands = |object: usize| {
                        truth.objects[object].stops_rays && truth.objects[object].voxels.get(*first)
                    };
                    (Oversight::Hidden, (0..truth.objects.len()).find(|&object| stands(object)))
                }
                _ => (Oversight::NotMeasured, None),
            }
        };
        let voxels: Vec<_> = overlooked.voxels().collect();
        let reasons: Vec<_> = voxels.par_iter().map(why).collect();
        let mut planes = BTreeMap::new();
        for (voxel, reason) in voxels.into_iter().zip(reasons) {
            planes.entry(reason).or_insert_with(|| BitGrid::new(overlooked.window())).set(voxel);
        }
        let some = |((reason, object), voxels): (_, BitGrid)| Overlooked { reason, object, voxels };
        planes.into_iter().map(some).collect()
    }
}

/// The 26 voxels around a voxel.
fn neighbours([x, y, z]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    let all = (-1..=1).flat_map(move |k| (-1..=1).flat_map(move |j| (-1..=1).map(move |i| [i, j, k])));
    all.filter(|step| *step != [0; 3]).map(move |[i, j, k]| [x + i, y + j, z + k])
}

/// The first voxel on the line of sight from a place in the world to a voxel of the grid; `None` if it is in sight.
fn blocking_voxel(place_m: DVec3, voxel: [i32; 3], grid: &Grid, search: &BlockerSearch) -> Option<[i32; 3]> {
    let middle_m = grid.corner_m(voxel) + grid.voxel_size_m / 2.0;
    let begin_q16 = enters(place_m, middle_m, grid)?;
    if Grid::voxel_of(begin_q16) == voxel {
        return None;
    }
    let way: [i64; 3] = std::array::from_fn(|r| (i64::from(voxel[r]) << 16) + 0x8000 - begin_q16[r]);
    let way = DVec3::from_array(way.map(|x| x as f64));
    let direction_q16 = (way / way.length()).to_array().map(|v| (v * 65536.0).round() as i32);
    let begin = march::start(begin_q16.map(|x| x as i32), direction_q16);
    leap::entry_q16(&begin, voxel)?;
    let hit = search.first(&search.rays_from(begin_q16.map(|x| x as i32)), direction_q16, &SIGHT)?;
    // All rays from one voxel to another cross the same number of boundaries.
    let crossings = |to: [i32; 3]| (0..3).map(|r| to[r].abs_diff(begin.voxel[r])).sum::<u32>();
    (crossings(hit.voxel) < crossings(voxel)).then_some(hit.voxel)
}

#[cfg(test)]
mod tests;
