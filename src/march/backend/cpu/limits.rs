//! Between which distances the rays of a packet return, and how slanted they are. Where ranges are distances, all rays
//! are alike; where they are depths, each ray has its own.

use super::first_hit::{self, FirstHit};
use super::packet::{Lanes, Packets};
use crate::march::{self, Gates};

/// The limits of a packet's rays.
pub(super) struct PacketLimits {
    /// Of each ray, its shortest range.
    pub(super) range_min_q16: Lanes<u32>,
    /// Of each ray, its longest range, as the last crossing within it.
    pub(super) last: Lanes<FirstHit>,
    /// Of each ray, its [`march::Slant`].
    pub(super) axial_q16: Lanes<u32>,
    pub(super) slant_q16: Lanes<u32>,
    /// The largest of the shortest ranges, and the smallest of the longest.
    pub(super) within_q16: [u32; 2],
    /// The largest of the longest.
    pub(super) farthest: FirstHit,
}

impl PacketLimits {
    /// The limits of each packet of a table; one for all packets where all rays are alike.
    pub(super) fn from_packets(packets: &Packets, gates: &Gates) -> Vec<PacketLimits> {
        let packet = |number: usize| {
            let [.., z_q15] = packets.dirs_q15(number);
            PacketLimits::new(gates, z_q15)
        };
        let count = if gates.along_axis { packets.count() } else { packets.count().min(1) };
        (0..count).map(packet).collect()
    }

    fn new(gates: &Gates, z_q15: &Lanes<i32>) -> PacketLimits {
        let axial_q16: Lanes<u32> = z_q15.map(|z_q15| march::axial_q16(z_q15, gates.along_axis));
        let slant_q16 = axial_q16.map(march::period_q16);
        let [range_min_q16, range_max_q16] = [gates.range_min_q16, gates.range_max_q16]
            .map(|depth_q16| slant_q16.map(|slant_q16| march::ray_range_q16(depth_q16, slant_q16)));
        let last = range_max_q16.map(first_hit::range);
        let largest = |lanes: &Lanes<u32>| lanes.iter().fold(0, |most, &lane| lane.max(most));
        let smallest = |lanes: &Lanes<u32>| lanes.iter().fold(u32::MAX, |least, &lane| lane.min(least));
        PacketLimits {
            within_q16: [largest(&range_min_q16), smallest(&range_max_q16)],
            farthest: largest(&last),
            range_min_q16,
            last,
            axial_q16,
            slant_q16,
        }
    }

    /// Whether a return at a distance from a blocker of a shade is too weak to be detected.
    pub(super) fn is_too_weak(
        &self,
        lane: usize,
        t_q16: u32,
        gates: &Gates,
        shade: impl FnOnce() -> usize,
    ) -> bool {
        let reach =
            |shade: usize| march::ray_range_q16(gates.shade_ranges_q16[shade - 1], self.slant_q16[lane]);
        // Most hits are near enough for every shade.
        let darkest = (1..=march::SHADES).map(reach).min().unwrap_or(0);
        t_q16 > darkest && matches!(shade(), shade @ 1.. if t_q16 > reach(shade))
    }

    /// The longest range of a ray.
    pub(super) fn range_max_q16(&self, lane: usize) -> u32 {
        self.last[lane] >> 2
    }
}
