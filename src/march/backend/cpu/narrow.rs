//! Crossings of rays as numbers of 32 bits, of which a processor compares twice as many at once as of 64.
//!
//! # Theory
//! A crossing is one number, distance · 4 + axis (`leap`), which for those within any grid fits in 32 bits. Crossing n of
//! an axis comes after n periods and by n + 1 periods at the latest. Let 2ᶜ be the least power that is not below n + 1: where 2ᶜ
//! periods are more than [`LATEST`], n of them are at least half of it, 8192 voxels, since n is at least 2ᶜ⁻¹. Such a
//! crossing is outside of any grid, and said never to happen ([`NONE`]).
//!
//! # Practice
//! For packets against single voxels, the blockers of `intersect` and the voxels of `carve_voxels`, and against windows
//! (`through`).

use fearless_simd::Simd;

use super::packet::{Lanes, Packet, RAYS};

/// No crossing is later, in 1/65536 voxels: four times that, and an axis, is the largest number of 32 bits.
const LATEST: u32 = (1 << 30) - 1;

/// No crossing at all.
pub(super) const NONE: u32 = u32::MAX;

/// The first crossing of axis `r`, from its distance.
#[inline(always)]
fn first(first_q16: u32, r: usize) -> u32 {
    4 * first_q16.min(LATEST) + r as u32
}

/// The rays of a packet.
#[derive(Clone)]
pub(super) struct NarrowPacket {
    first: [Lanes<u32>; 3],
    /// Distance alone, in 1/65536 voxels.
    period_q16: [Lanes<u32>; 3],
    step: [Lanes<i32>; 3],
}

impl NarrowPacket {
    /// No rays yet.
    pub(super) fn new() -> Self {
        NarrowPacket { first: [[NONE; RAYS]; 3], period_q16: [[0; RAYS]; 3], step: [[0; RAYS]; 3] }
    }

    /// Takes the rays of a packet.
    #[inline(always)]
    pub(super) fn start<S: Simd>(&mut self, _: S, packet: &Packet) {
        self.period_q16 = packet.period_q16;
        for r in 0..3 {
            for lane in 0..RAYS {
                self.first[r][lane] = first(packet.first_q16[r][lane], r);
                let dir_q16 = packet.dir_q16[r][lane];
                self.step[r][lane] = i32::from(dir_q16 > 0) - i32::from(dir_q16 < 0);
            }
        }
    }

    /// The crossings by which the rays of `N` lanes from one on enter and leave a voxel: [`NONE`] enters if one leads away from
    /// it, 0 if it begins there.
    #[inline(always)]
    pub(super) fn spans<const N: usize>(&self, begin: usize, voxel: &Slabs) -> [[u32; N]; 2] {
        let [mut enters, mut leaves] = [[0; N], [NONE; N]];
        for (r, slab) in voxel.0.iter().enumerate() {
            let first = &self.first[r][begin..][..N];
            let Some(slab) = slab else {
                (0..N).for_each(|lane| leaves[lane] = leaves[lane].min(first[lane]));
                continue;
            };
            let (period_q16, step) = (&self.period_q16[r][begin..][..N], &self.step[r][begin..][..N]);
            for lane in 0..N {
                let [own_enters, own_leaves] = slab.crossings(first[lane], period_q16[lane], step[lane]);
                enters[lane] = enters[lane].max(own_enters);
                leaves[lane] = leaves[lane].min(own_leaves);
            }
        }
        [enters, leaves]
    }

    /// The crossings by which rays enter a layer of voxels across an axis, so many voxels away from where they begin, if they
    /// lead there: [`NONE`] for others.
    #[inline(always)]
    pub(super) fn enters<S: Simd>(&self, _: S, axis: usize, away: i32) -> Lanes<u32> {
        let slab = Slab::new(away);
        let (first, period_q16, step) = (&self.first[axis], &self.period_q16[axis], &self.step[axis]);
        std::array::from_fn(|lane| slab.crossings(first[lane], period_q16[lane], step[lane])[0])
    }

    /// The crossings by which all rays enter and leave a box: [`NONE`] enters if a ray leads away from it, 0 if it begins there,
    /// and [`NONE`] leaves if that is outside of any grid.
    #[inline(always)]
    pub(super) fn box_spans<S: Simd>(&self, _: S, slabs: &BoxSlabs) -> [Lanes<u32>; 2] {
        let [mut enters, mut leaves] = [[0; RAYS], [NONE; RAYS]];
        for (r, slabs) in slabs.0.iter().enumerate() {
            let (first, period_q16, step) = (&self.first[r], &self.period_q16[r], &self.step[r]);
            match slabs {
                Sides::Around { low, high } => {
                    for lane in 0..RAYS {
                        let [_, down] = low.crossings(first[lane], period_q16[lane], step[lane]);
                        let [_, up] = high.crossings(first[lane], period_q16[lane], step[lane]);
                        leaves[lane] = leaves[lane].min(if step[lane] < 0 { down } else { up });
                    }
                }
                Sides::Beside { near, far } => {
                    for lane in 0..RAYS {
                        let [own_enters, _] = near.crossings(first[lane], period_q16[lane], step[lane]);
                        let [_, own_leaves] = far.crossings(first[lane], period_q16[lane], step[lane]);
                        enters[lane] = enters[lane].max(own_enters);
                        leaves[lane] = leaves[lane].min(own_leaves);
                    }
                }
            }
        }
        [enters, leaves]
    }

    /// Whether one of the rays visits a voxel, were nothing in its way.
    pub(super) fn visits(&self, lane: usize, voxel: &Slabs) -> bool {
        let [[enters], [leaves]] = self.spans(lane, voxel);
        is_visited(enters, leaves)
    }
}

/// Whether a voxel that is entered and left by these crossings is visited. Both are the same where a ray leaves at
/// once what it begins in, and nowhere else.
#[inline(always)]
pub(super) fn is_visited(enters: u32, leaves: u32) -> bool {
    (enters <= leaves) & (enters < NONE)
}

/// The layers in which a voxel lies, across each axis, but for those in which rays begin.
pub(super) struct Slabs([Option<Slab>; 3]);

impl Slabs {
    /// Those of the voxel so many voxels away.
    #[inline(always)]
    pub(super) fn new(away: [i32; 3]) -> Slabs {
        Slabs(away.map(|away| (away != 0).then(|| Slab::new(away))))
    }
}

/// The layers in which the outermost voxels of a box lie, across each axis.
pub(super) struct BoxSlabs([Sides; 3]);

/// Those across one axis.
enum Sides {
    /// Rays begin between them, or in one of them.
    Around { low: Slab, high: Slab },
    /// Rays begin outside.
    Beside { near: Slab, far: Slab },
}

impl BoxSlabs {
    /// Those of the box from its lowest to its highest voxel, both counted from where rays begin.
    #[inline(always)]
    pub(super) fn new(low: [i32; 3], high: [i32; 3]) -> BoxSlabs {
        BoxSlabs(std::array::from_fn(|r| {
            let [low_slab, high_slab] = [low[r], high[r]].map(Slab::new);
            match (low[r] > 0, high[r] < 0) {
                (true, _) => Sides::Beside { near: low_slab, far: high_slab },
                (_, true) => Sides::Beside { near: high_slab, far: low_slab },
                _ => Sides::Around { low: low_slab, high: high_slab },
            }
        }))
    }
}

/// A layer of voxels across an axis, as rays see it that begin beside it; they leave also the layer in which they begin.
#[derive(Clone, Copy)]
struct Slab {
    /// The step of rays that come to it.
    towards: i32,
    /// What periods are multiplied with: all up to the layer, in numbers.
    made: u32,
    /// The longest periods of rays that enter it, and that leave it, before all ends.
    longest: [u32; 2],
}

impl Slab {
    /// The layer so many voxels away.
    #[inline(always)]
    fn new(away: i32) -> Slab {
        let n = away.unsigned_abs();
        // The first crossing, however long a period is, enters the next layer and leaves a ray's own.
        let longest = |n: u32| if n == 0 { u32::MAX } else { LATEST >> log2_up(n + 1) };
        let longest = [longest(n.saturating_sub(1)), longest(n)];
        Slab { towards: away.signum(), made: n.wrapping_sub(1).wrapping_mul(4), longest }
    }

    /// The crossings by which a ray enters and leaves the layer, as `RayAxis::slab` has them.
    #[inline(always)]
    fn crossings(&self, first: u32, period_q16: u32, step: i32) -> [u32; 2] {
        let enters = first.wrapping_add(self.made.wrapping_mul(period_q16));
        let leaves = enters.wrapping_add(period_q16.wrapping_mul(4));
        let comes = (step == self.towards) & (period_q16 <= self.longest[0]);
        [if comes { enters } else { NONE }, if period_q16 <= self.longest[1] { leaves } else { NONE }]
    }
}

/// The exponent of the least power of two that is not below a number.
#[inline(always)]
fn log2_up(n: u32) -> u32 {
    u32::BITS - (n - 1).leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::leap::RayAxis;
    use crate::march::{NEVER, start_axis};

    /// The same in 64 bits.
    fn wide(away: i32, r: usize, [first_q16, period_q16]: [u32; 2], step: i32) -> [u64; 2] {
        RayAxis::new(r, step, first_q16, period_q16).slab(away, away)
    }

    #[test]
    fn numbers_are_those_of_64_bits() {
        let mut late = 0;
        for d in (0..=65_539i32).step_by(97).chain([1, 2, 3, 4, 5, 65_535, 65_536, 65_537]) {
            for dir_q16 in [-d, d] {
                for origin_q16 in [0, 1, 0x5_8000, 0x6_ffff] {
                    let [first_q16, period_q16] = start_axis(origin_q16, dir_q16);
                    for away in [-1772, -1000, -65, -2, -1, 1, 2, 3, 64, 999, 1771] {
                        for r in 0..3 {
                            let own = first(first_q16, r);
                            let narrow = Slab::new(away).crossings(own, period_q16, dir_q16.signum());
                            let exact = wide(away, r, [first_q16, period_q16], dir_q16.signum());
                            for (narrow, exact) in narrow.into_iter().zip(exact) {
                                let is_far = exact >= 4 * (8192 << 16);
                                late += usize::from(is_far);
                                assert!(
                                    u64::from(narrow) == exact || is_far && narrow >= 4 * (8192 << 16),
                                    "{dir_q16} {origin_q16} {away}: {narrow} for {exact}"
                                );
                            }
                        }
                    }
                }
            }
        }
        assert!(late > 1000);
        assert_eq!(first(NEVER, 2), NONE - 1);
    }
}
