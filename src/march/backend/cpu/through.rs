//! When the rays of a packet are in a window of voxels: all of them at once.
//!
//! # Theory
//! A ray enters a box when it has entered on every axis, and leaves it when it leaves on any; both are crossings, whose number
//! is known in closed form. A ray that comes into a window of the grid leaves it before 32 bits end (`narrow`).
//!
//! # Practice
//! For packets whose rays are marked one by one (`carve_rays`): most of a LIDAR's rays miss the window, or have left it
//! before anything happens.

use fearless_simd::{Level, Simd, dispatch};

use super::first_hit;
use super::narrow::{BoxSlabs, NONE, NarrowPacket};
use super::packet::{Lanes, Packet, RAYS};
use crate::voxel::Window;

/// The rays of a packet and a window.
pub(super) struct Through {
    rays: NarrowPacket,
    enters: Lanes<u32>,
    leaves: Lanes<u32>,
}

impl Through {
    /// No rays yet.
    pub(super) fn new() -> Self {
        Through { rays: NarrowPacket::new(), enters: [NONE; RAYS], leaves: [0; RAYS] }
    }

    /// Takes the rays of a packet through a window of the grid.
    pub(super) fn start(&mut self, level: Level, packet: &Packet, window: &Window) {
        dispatch!(level, simd => start(simd, self, packet, window));
    }

    /// The crossings by which a ray enters and leaves the window; `None` if it never comes there within any range. The first
    /// is 0 where the ray begins inside, and also where it enters by a crossing of x at distance 0.
    #[inline]
    pub(super) fn span(&self, lane: usize) -> Option<[u32; 2]> {
        let (enters, leaves) = (self.enters[lane], self.leaves[lane]);
        (enters <= leaves.min(first_hit::LAST)).then_some([enters, leaves])
    }

    /// The rays that come into the window.
    pub(super) fn lanes(&self) -> impl Iterator<Item = usize> {
        (0..RAYS).filter(|&lane| self.span(lane).is_some())
    }
}

#[inline(always)]
fn start<S: Simd>(simd: S, through: &mut Through, packet: &Packet, window: &Window) {
    through.rays.start(simd, packet);
    let (min, end) = (window.min, window.end());
    let low = std::array::from_fn(|r| min[r] - packet.voxel[r]);
    let high = std::array::from_fn(|r| end[r] - 1 - packet.voxel[r]);
    [through.enters, through.leaves] = through.rays.box_spans(simd, &BoxSlabs::new(low, high));
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::simd::SimdLevel;
    use super::*;
    use crate::backend::GridPose;
    use crate::march::leap;

    /// Against the same in 64 bits, ray by ray.
    #[test]
    fn rays_enter_and_leave_windows_as_single_rays_do() {
        let mut random = ChaCha8Rng::seed_from_u64(19);
        let levels = SimdLevel::all();
        let mut below = |n: u32| (random.next_u32() % n) as i32;
        let (mut begins_inside, mut comes, mut misses) = (0, 0, 0);
        let mut packet = Packet::new();
        for turn in 0..400 {
            let size = if turn % 2 == 0 { 1023 } else { 12 };
            let mut within = |n: u32| [0; 3].map(|_: i32| below(n));
            let (voxel, one, other) = (within(size), within(size), within(size));
            let low = std::array::from_fn(|r| one[r].min(other[r]));
            let high = std::array::from_fn(|r| one[r].max(other[r]));
            let window = Window::from_corners(low, high);
            // Some along the axes and diagonals, some nearly so.
            let dirs: [Lanes<i32>; 3] = std::array::from_fn(|_| {
                std::array::from_fn(|lane| match lane % 4 {
                    0 => below(3) - 1,
                    1 => 16_384 * (below(5) - 2),
                    _ => below(65_537) - 32_768,
                })
            });
            let axis_q15 = [[32_768, 0, 0], [0, 32_768, 0], [0, 0, 32_768]];
            let origin_q16 = voxel.map(|x| (x << 16) + [0, 0x8000, below(65_536)][turn % 3]);
            let pose = GridPose { origin_q16, axis_q15, draws: 0, truly: None };
            let level = levels[turn / 6 % levels.len()].level;
            packet.start(level, &pose, &dirs);
            let mut through = Through::new();
            through.start(level, &packet, &window);
            let away = |voxel: [i32; 3]| std::array::from_fn(|r| voxel[r] - packet.voxel[r]);
            for lane in 0..RAYS {
                let expected = leap::span(|r| packet.axis(lane, r), away(low), away(high));
                // What is entered behind every range is not entered.
                let expected = expected.filter(|[enters, _]| *enters <= first_hit::LAST.into());
                let found = through.span(lane);
                assert_eq!(found.map(|[enters, _]| u64::from(enters)), expected.map(|[enters, _]| enters));
                match (found, expected) {
                    (Some([_, leaves]), Some([_, exact])) if exact < 4 * (8192 << 16) => {
                        assert_eq!(u64::from(leaves), exact, "lane {lane} of turn {turn}");
                    }
                    (Some([_, leaves]), _) => {
                        assert!(leaves >= 4 * (8192 << 16), "lane {lane} of turn {turn}")
                    }
                    (None, _) => {}
                }
                begins_inside += usize::from(found.is_some_and(|[enters, _]| enters == 0));
                comes += usize::from(found.is_some_and(|[enters, _]| enters > 0));
                misses += usize::from(found.is_none());
            }
        }
        assert!(begins_inside > 500 && comes > 1000 && misses > 5000, "{begins_inside}, {comes}, {misses}");
    }
}
