//! The deepest place of one body from one entry, and the path that shows it.

use super::body::Body;
use super::flood::Flood;
use perirobot_march::voxel::{BitGrid, Distances, Grid};

/// What a body can do unnoticed from an entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ApproachFinding {
    /// How deep it comes; `None` where it is noticed at the entry already, or has no room there.
    pub deepest: Option<Deepest>,
    /// How far it is from the hazard, squared in whole voxels, at the nearest of those places of the entry at which it
    /// has room and is noticed; `None` where there is none.
    pub noticed: Option<u32>,
    /// The same of all places of the entry at which it has room, noticed or not: no sensor makes it farther.
    pub entry: Option<u32>,
    /// The places that it reaches.
    pub reached: BitGrid,
}

impl ApproachFinding {
    /// How near it has come when it is noticed, if ever: the lesser of how deep it comes unnoticed and of how far off
    /// it is where it is noticed at the entry, squared. `None` where it has no room there.
    pub fn nearest(&self) -> Option<u32> {
        lesser(self.deepest.as_ref().map(|deepest| deepest.squared), self.noticed)
    }
}

fn lesser(one: Option<u32>, other: Option<u32>) -> Option<u32> {
    one.into_iter().chain(other).min()
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

impl Deepest {
    /// The length of the path in metres.
    pub(super) fn length_m(&self, grid: &Grid) -> f64 {
        self.length as f64 / 1000.0 * grid.voxel_size_m
    }
}

/// Where the way can be closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Narrowest {
    /// Where the path crosses the narrowest front.
    pub place: [i32; 3],
    /// How many places the front has.
    pub front: u64,
}

/// Where a body may be, whatever its entry is.
#[derive(Clone, Copy, Debug)]
pub struct FreeRoom<'r> {
    /// Where nothing solid is in its way.
    pub free: &'r BitGrid,
    /// Those of them at which it is not noticed.
    pub open: &'r BitGrid,
    /// How far voxels are from the hazard.
    pub distances: &'r Distances,
}

/// How deep a body comes from those of some places that are open, through open ones, and how near the others are.
pub fn deepest(body: &Body, begin: &BitGrid, room: FreeRoom) -> ApproachFinding {
    let flood = Flood::from_places(begin, room.open, body.climbs);
    let (reached, noticed) = (flood.places().clone(), noticed_squared(body, begin, room));
    let entry = nearest_at_entry(body, begin, room.free, room.distances);
    let Some((squared, place)) = nearest(body, &flood, room.distances) else {
        return ApproachFinding { deepest: None, noticed, entry, reached };
    };
    let (length, path) = (flood.length(place), flood.path(place));
    let narrowest = narrowest(&flood, length, &path);
    ApproachFinding { deepest: Some(Deepest { squared, length, path, narrowest }), noticed, entry, reached }
}

/// [`ApproachFinding::nearest`] of a body, and how many places it reaches.
pub(super) fn nearest_of_all(body: &Body, begin: &BitGrid, room: FreeRoom) -> (Option<u32>, u64) {
    let flood = Flood::from_places(begin, room.open, body.climbs);
    let unnoticed = nearest(body, &flood, room.distances).map(|(squared, _)| squared);
    (lesser(unnoticed, noticed_squared(body, begin, room)), flood.places().count())
}

/// The least squared distance of a body at those places of an entry at which it has room and is noticed.
fn noticed_squared(body: &Body, begin: &BitGrid, room: FreeRoom) -> Option<u32> {
    let mut noticed = room.free.clone();
    noticed.remove(room.open);
    nearest_at_entry(body, begin, &noticed, room.distances)
}

/// The least squared distance of a body at those places of an entry that are among others.
pub(super) fn nearest_at_entry(
    body: &Body,
    begin: &BitGrid,
    among: &BitGrid,
    distances: &Distances,
) -> Option<u32> {
    let mut places = begin.clone();
    places.keep(among);
    let mut nearest = None;
    for place in places.voxels() {
        let bound = least(body, place, distances);
        if nearest.is_none_or(|nearest| bound < u64::from(nearest)) {
            nearest = lesser(nearest, squared_distance(body, place, distances));
        }
    }
    nearest
}

/// The squared distance of a body at a place.
pub(super) fn squared_distance(body: &Body, place: [i32; 3], distances: &Distances) -> Option<u32> {
    body.voxels(place).map(|voxel| distances.squared_distance(voxel)).min()
}

/// What that is not below: no voxel of a body is nearer than its middle less its radius.
pub(super) fn least(body: &Body, place: [i32; 3], distances: &Distances) -> u64 {
    let least = distances.squared_distance(body.middle(place)).isqrt().saturating_sub(body.radius());
    u64::from(least).pow(2)
}

/// The least squared distance of the body at a place that is reached, and that place.
fn nearest(body: &Body, flood: &Flood, distances: &Distances) -> Option<(u32, [i32; 3])> {
    let at = |place| squared_distance(body, place, distances);
    let middle = |place| distances.squared_distance(body.middle(place));
    let begin = flood.places().voxels().min_by_key(|&place| middle(place))?;
    let mut best = (at(begin)?, flood.length(begin), begin);
    for place in flood.places().voxels() {
        if least(body, place, distances) > u64::from(best.0) {
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
    let front_of = |place| flood.length(place) / flood.longest_step();
    let mut fronts = vec![0u64; (length / flood.longest_step()) as usize];
    for place in flood.places().voxels() {
        if let Some(front) = fronts.get_mut(front_of(place) as usize) {
            *front += 1;
        }
    }
    // Not the entry's own: it is as wide as it was drawn.
    let (number, &front) = fronts.iter().enumerate().skip(1).min_by_key(|(_, front)| **front)?;
    let place = *path.iter().find(|&&place| front_of(place) == number as u64)?;
    Some(Narrowest { place, front })
}
