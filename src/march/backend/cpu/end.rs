//! How rays end, from what they hit first: ranges, noise, and where each return is read.
//!
//! # Theory
//! A ray's place, a distance and an axis, says how many crossings of each axis it has made, in closed form
//! (`SEMANTICS.md`, "Rays"); so neither path nor voxel need be kept from the search.
//!
//! # Practice
//! Returns, which most rays are, go 64 at a time; rays that end otherwise or are lost, or may be read outside
//! the grid, one by one.

use fearless_simd::{Level, Simd, dispatch};

use super::first_hit::{self, FirstHit};
use super::limits::PacketLimits;
use super::packet::{Lanes, Packet, RAYS, RayPlaces, mask};
use crate::backend::{Noise, Planes, Shades};
use crate::march::{self, BLIND, End, Gates, LEFT, NOTHING, RETURN, leap};
use crate::voxel::BitGrid;

/// How the rays of a packet ended.
pub(super) struct PacketEnds {
    kinds: Lanes<u32>,
    crossings: Lanes<u32>,
    /// How many leading voxels each ray frees.
    pub(super) freed: Lanes<u32>,
    /// The bit of each return's endpoint in the window's plane; [`NO_BIT`] outside and for other rays.
    bits: Lanes<u32>,
    /// The same of the blocker that each return comes from.
    hits: Lanes<u32>,
    places: RayPlaces,
    drawn: Lanes<u32>,
    steps_q16: Lanes<i32>,
    /// Which rays' returns are lost, a bit each.
    lost: u64,
    made: [Lanes<u32>; 3],
}

/// No voxel of the window.
const NO_BIT: u32 = u32::MAX;

/// What decides how rays end.
pub(super) struct Rules<'a> {
    pub(super) gates: &'a Gates,
    pub(super) limits: &'a PacketLimits,
    pub(super) noise: &'a Noise,
    /// The hash of what precedes the ray.
    pub(super) draws: u32,
    /// How dark blockers are, if that matters to the table.
    pub(super) shades: Option<&'a Shades>,
    /// The grid.
    pub(super) size: [u32; 3],
    /// Whether crossings are wanted of rays that free nothing.
    pub(super) all: bool,
}

/// Rays that were sent.
pub(super) struct Sent<'a> {
    /// As they are believed to go.
    pub(super) believed: &'a Packet,
    /// As they were truly cast, if the mount is off.
    pub(super) truly: Option<&'a Packet>,
}

impl PacketEnds {
    pub(super) fn new() -> Self {
        PacketEnds {
            kinds: [NOTHING; RAYS],
            crossings: [0; RAYS],
            freed: [0; RAYS],
            bits: [NO_BIT; RAYS],
            hits: [NO_BIT; RAYS],
            places: RayPlaces { t_q16: [0; RAYS], axis: [0; RAYS] },
            drawn: [0; RAYS],
            steps_q16: [0; RAYS],
            lost: 0,
            made: [[0; RAYS]; 3],
        }
    }

    /// Ends the rays of a packet, whose numbers are `rays`; endpoints are wanted in the window of a plane.
    pub(super) fn end(
        &mut self,
        level: Level,
        sent: &Sent,
        rays: &Lanes<u32>,
        first_hits: &Lanes<FirstHit>,
        rules: &Rules,
        plane: &BitGrid,
    ) {
        let noise = rules.noise;
        self.lost = 0;
        if *noise != Noise::default() {
            dispatch!(level, simd => draw(simd, rules, rays, &mut self.drawn));
            if noise.lost_below > 0 {
                self.lost = dispatch!(level, simd => lost_returns(simd, &self.drawn, noise.lost_below));
            }
        }
        if let Some(shades) = rules.shades {
            self.lost |= too_weak(shades, sent.truly.unwrap_or(sent.believed), first_hits, rules);
        }
        if let Some(unit_q12) = noise.unit_q12.first_chunk() {
            dispatch!(level, simd => steps(simd, unit_q12, rules, &self.drawn, first_hits, &mut self.steps_q16));
        }
        dispatch!(level, simd => read(simd, first_hits, &self.steps_q16, &mut self.places));
        let unusual = match sent.truly {
            // Rays that hit elsewhere than they are believed to go.
            Some(_) => u64::MAX,
            None => {
                sent.believed.count_crossings(level, &self.places, &mut self.made);
                dispatch!(level, simd => returns(simd, self, sent.believed, first_hits, rules, plane))
            }
        };
        for lane in (0..RAYS).filter(|lane| unusual >> lane & 1 == 1) {
            self.end_alone(sent, lane, first_hits[lane], rules, plane);
        }
        self.hits = self.bits;
        if noise.unit_q12.is_empty() && sent.truly.is_none() {
            return;
        }
        // Returns are read elsewhere than at what they come from.
        let cast = sent.truly.unwrap_or(sent.believed);
        dispatch!(level, simd => read(simd, first_hits, &[0; RAYS], &mut self.places));
        cast.count_crossings(level, &self.places, &mut self.made);
        dispatch!(level, simd => hits(simd, self, cast, plane));
    }

    /// How a ray ended.
    pub(super) fn get(&self, lane: usize) -> End {
        End { kind: self.kinds[lane], crossings: self.crossings[lane] }
    }

    /// Marks where returns are read, and what they come from.
    pub(super) fn mark(&self, planes: &mut Planes) {
        for (bits, plane) in [(&self.bits, &mut planes.occupied), (&self.hits, &mut planes.hits)] {
            let words = plane.words_mut();
            for &bit in bits.iter().filter(|&&bit| bit != NO_BIT) {
                words[bit as usize >> 5] |= 1 << (bit & 31);
            }
        }
    }

    /// Ends a ray that is no return, or a return that may be read outside the grid or was not hit where it
    /// is believed to be.
    fn end_alone(&mut self, sent: &Sent, lane: usize, hit: FirstHit, rules: &Rules, plane: &BitGrid) {
        let begin = sent.believed.march(lane);
        let room = march::room(&begin, rules.size);
        let lost = self.lost >> lane & 1 == 1;
        let mut end = |kind, crossings| {
            (self.kinds[lane], self.crossings[lane]) = (kind, crossings);
            self.freed[lane] = march::freed(End { kind, crossings }, rules.gates.no_return_is_free);
            self.bits[lane] = NO_BIT;
        };
        let blind = hit < first_hit::LEFT && hit >> 2 < rules.limits.range_min_q16[lane];
        if hit >= first_hit::LEFT || lost && !blind {
            let left = hit == first_hit::LEFT && rules.gates.backdrop && !lost;
            let kind = if left { LEFT } else { NOTHING };
            let counts = rules.all || kind == LEFT || rules.gates.no_return_is_free;
            let crossings = || march::crossings_at(&begin, room, rules.limits.range_max_q16(lane));
            return end(kind, if counts { crossings() } else { 0 });
        }
        if blind {
            // Not where a return would be read, but where the blocker is.
            let made = match sent.truly {
                None => sent.believed.made_by(lane, first_hit::crossing(hit)),
                Some(_) => march::made_until(&begin, room, hit >> 2, 2),
            };
            return end(BLIND, made.iter().sum());
        }
        let made = march::made_until(&begin, room, self.places.t_q16[lane], 2);
        end(RETURN, made.iter().sum());
        let voxel = std::array::from_fn(|r| begin.voxel[r] + begin.step[r] * made[r] as i32);
        self.bits[lane] = plane.bit_index(voxel).map_or(NO_BIT, |bit| bit as u32);
    }
}

/// The numbers that rays draw.
#[inline(always)]
fn draw<S: Simd>(_: S, rules: &Rules, rays: &Lanes<u32>, drawn: &mut Lanes<u32>) {
    for lane in 0..RAYS {
        drawn[lane] = march::draw(rules.draws, rays[lane]);
    }
}

/// Which returns are lost, a bit each.
#[inline(always)]
fn lost_returns<S: Simd>(_: S, drawn: &Lanes<u32>, below: u32) -> u64 {
    let mut lost = [0u32; RAYS];
    for lane in 0..RAYS {
        lost[lane] = march::is_lost(drawn[lane], below) as u32;
    }
    mask(&lost)
}

/// Which rays hit what is too dark to return their light, a bit each.
fn too_weak(shades: &Shades, cast: &Packet, first_hits: &Lanes<FirstHit>, rules: &Rules) -> u64 {
    let is_too_weak = |lane: usize| {
        let hit = first_hits[lane];
        let shade = || {
            let (begin, made) = (cast.march(lane), cast.made_by(lane, first_hit::crossing(hit)));
            shades.of(std::array::from_fn(|r| begin.voxel[r] + begin.step[r] * made[r] as i32))
        };
        hit < first_hit::LEFT && rules.limits.is_too_weak(lane, hit >> 2, rules.gates, shade)
    };
    (0..RAYS).filter(|&lane| is_too_weak(lane)).fold(0, |all, lane| all | 1 << lane)
}

/// The errors in distance of returns, from the two tables of noise.
#[inline(always)]
fn steps<S: Simd>(
    _: S,
    unit_q12: &[i32; march::NOISE_STEPS as usize],
    rules: &Rules,
    drawn: &Lanes<u32>,
    first_hits: &Lanes<FirstHit>,
    steps_q16: &mut Lanes<i32>,
) {
    let (std_q16, limits) = (&rules.noise.std_q16, rules.limits);
    let last = std_q16.len() - 1;
    let (mut units, mut stds) = ([0; RAYS], [0; RAYS]);
    for lane in 0..RAYS {
        units[lane] = unit_q12[march::entry(drawn[lane]) as usize];
    }
    for lane in 0..RAYS {
        let hit = if first_hits[lane] < first_hit::LEFT { first_hits[lane] } else { 0 };
        let entry = leap::periods_in(hit >> 2, limits.slant_q16[lane], limits.axial_q16[lane]);
        stds[lane] = std_q16[(entry as usize).min(last)];
    }
    for lane in 0..RAYS {
        let std_q16 = march::std_along_q16(stds[lane], limits.slant_q16[lane]);
        steps_q16[lane] = march::step_q16(units[lane], std_q16);
    }
}

/// Where returns are read: at the crossing into the blocker, or with noise after all crossings up to there.
#[inline(always)]
fn read<S: Simd>(_: S, first_hits: &Lanes<FirstHit>, steps_q16: &Lanes<i32>, places: &mut RayPlaces) {
    for lane in 0..RAYS {
        let hit = if first_hits[lane] < first_hit::LEFT { first_hits[lane] } else { 0 };
        let silent = steps_q16[lane] == 0;
        places.t_q16[lane] = march::noisy_q16(hit >> 2, steps_q16[lane]);
        places.axis[lane] = if silent { hit & 3 } else { 2 };
    }
}

/// The bit of each ray's voxel in a plane after so many crossings; [`NO_BIT`] outside its window. Also says which rays are
/// outside a grid of a size then.
#[inline(always)]
fn locate<S: Simd>(
    _: S,
    packet: &Packet,
    made: &[Lanes<u32>; 3],
    plane: &BitGrid,
    size: [u32; 3],
) -> (Lanes<u32>, Lanes<u32>) {
    let window = plane.window();
    let row = plane.words_per_row() as i32 * 32;
    let strides = [1, row, row * window.size[1] as i32];
    let mut outside = [0u32; RAYS];
    let mut elsewhere = [0u32; RAYS];
    let mut bits = [0i32; RAYS];
    for r in 0..3 {
        let own = packet.voxel[r];
        for lane in 0..RAYS {
            let made = made[r][lane] as i32;
            let voxel = own + if packet.dir_q16[r][lane] < 0 { -made } else { made };
            outside[lane] |= (voxel as u32 >= size[r]) as u32;
            let within = voxel - window.min[r];
            elsewhere[lane] |= (within as u32 >= window.size[r]) as u32;
            bits[lane] = bits[lane].wrapping_add(within.wrapping_mul(strides[r]));
        }
    }
    (std::array::from_fn(|lane| if elsewhere[lane] != 0 { NO_BIT } else { bits[lane] as u32 }), outside)
}

/// Ends all rays as if they were returns read inside the grid, and says which are not.
#[inline(always)]
fn returns<S: Simd>(
    simd: S,
    ends: &mut PacketEnds,
    packet: &Packet,
    first_hits: &Lanes<FirstHit>,
    rules: &Rules,
    plane: &BitGrid,
) -> u64 {
    let mut outside;
    (ends.bits, outside) = locate(simd, packet, &ends.made, plane, rules.size);
    for lane in 0..RAYS {
        let crossings = ends.made[0][lane] + ends.made[1][lane] + ends.made[2][lane];
        ends.kinds[lane] = RETURN;
        (ends.crossings[lane], ends.freed[lane]) = (crossings, crossings);
        let none = first_hits[lane] >= first_hit::LEFT;
        let blind = first_hits[lane] >> 2 < rules.limits.range_min_q16[lane];
        outside[lane] |= (none | blind) as u32;
    }
    mask(&outside) | ends.lost
}

/// Finds the blockers that returns come from.
#[inline(always)]
fn hits<S: Simd>(simd: S, ends: &mut PacketEnds, cast: &Packet, plane: &BitGrid) {
    let (bits, _) = locate(simd, cast, &ends.made, plane, plane.window().size);
    for lane in 0..RAYS {
        ends.hits[lane] = if ends.kinds[lane] == RETURN { bits[lane] } else { NO_BIT };
    }
}
