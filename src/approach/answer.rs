//! The deepest place of one body from one entry, and the path that shows it.

use super::body::Body;
use super::flood::{Flood, LONGEST_STEP};
use crate::voxel::{BitGrid, Distances};

/// What a body can do unnoticed from an entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// How deep it comes; `None` where it is noticed at the entry already, or has no room there.
    pub deepest: Option<Deepest>,
    /// The places that it reaches.
    pub reached: BitGrid,
}

/// The deepest place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deepest {
    /// How far the body is from the hazard there: squared, in whole voxels, between centres.
    pub squared: u32,
    /// The length of the path in thousandths of a voxel.
    pub length: u64,
    /// The places on the way, from the entry on.
    pub path: Vec<[i32; 3]>,
    /// Where the way is the narrowest; `None` where the entry is as deep as it gets.
    pub narrowest: Option<Narrowest>,
}

/// Where the way can be closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Narrowest {
    /// Where the path crosses the narrowest front.
    pub place: [i32; 3],
    /// How many places the front has.
    pub front: u64,
}

/// How deep a body comes from those of some places that are open, through open ones; `distances` are those to
/// the hazard.
pub fn deepest(body: &Body, begin: &BitGrid, open: &BitGrid, distances: &Distances) -> Found {
    let flood = Flood::from(begin, open);
    let reached = flood.reached().clone();
    let Some((squared, place)) = nearest(body, &flood, distances) else {
        return Found { deepest: None, reached };
    };
    let (length, path) = (flood.length(place), flood.path(place));
    let narrowest = narrowest(&flood, length, &path);
    Found { deepest: Some(Deepest { squared, length, path, narrowest }), reached }
}

/// How near a body comes from those of some places that are open, through open ones: the squared distance, `None`
/// where it does not come in. With it how many places it reaches.
pub(super) fn nearest_of_all(
    body: &Body,
    begin: &BitGrid,
    open: &BitGrid,
    distances: &Distances,
) -> (Option<u32>, u64) {
    let flood = Flood::from(begin, open);
    (nearest(body, &flood, distances).map(|(squared, _)| squared), flood.reached().count())
}

/// The least squared distance of the body at a place that is reached, and that place.
fn nearest(body: &Body, flood: &Flood, distances: &Distances) -> Option<(u32, [i32; 3])> {
    let at = |place| body.voxels(place).map(|voxel| distances.squared(voxel)).min();
    let middle = |place| distances.squared(body.middle(place));
    let begin = flood.reached().voxels().min_by_key(|&place| middle(place))?;
    let mut best = (at(begin)?, flood.length(begin), begin);
    for place in flood.reached().voxels() {
        // No voxel of the body is nearer than its middle less its radius.
        let least = middle(place).isqrt().saturating_sub(body.radius());
        if u64::from(least).pow(2) > u64::from(best.0) {
            continue;
        }
        let Some(squared) = at(place) else { continue };
        let rank = |(squared, length, [x, y, z]): (u32, u64, [i32; 3])| (squared, length, [z, y, x]);
        let this = (squared, flood.length(place), place);
        if rank(this) < rank(best) {
            best = this;
        }
    }
    Some((best.0, best.2))
}

/// The narrowest front between the entry and a place, and where the path to it crosses that.
fn narrowest(flood: &Flood, length: u64, path: &[[i32; 3]]) -> Option<Narrowest> {
    let front_of = |place| flood.length(place) / LONGEST_STEP;
    let mut fronts = vec![0u64; (length / LONGEST_STEP) as usize];
    for place in flood.reached().voxels() {
        if let Some(front) = fronts.get_mut(front_of(place) as usize) {
            *front += 1;
        }
    }
    // Not the entry's own: it is as wide as it was drawn.
    let (number, &front) = fronts.iter().enumerate().skip(1).min_by_key(|(_, front)| **front)?;
    let place = *path.iter().find(|&&place| front_of(place) == number as u64)?;
    Some(Narrowest { place, front })
}
