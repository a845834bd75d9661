//! Several sensors' evidence becomes one label a voxel, a word of 32 voxels at a time: the twin of
//! `shaders/fuse.wgsl`. Which readings belong together is the sweep's business.

use super::{Fusion, LOG_ODDS, Planes, Reading, Slot};
use crate::voxel::{BitGrid, Window};

/// The planes of a job over a window; the result's `free` holds no voxel of its `occupied`.
pub(super) fn fuse<'a>(
    window: Window,
    fusion: Fusion,
    job: &[Reading],
    planes: impl Fn(Slot) -> Option<&'a Planes>,
) -> Planes {
    let mut fused = Planes { occupied: BitGrid::new(window), free: BitGrid::new(window) };
    let readings: Vec<_> = job
        .iter()
        .map(|reading| (reading, [Some(reading.slot), reading.volume].map(|slot| planes(slot?))))
        .collect();
    let mut sums = Sums::default();
    for word in 0..fused.occupied.words().len() {
        sums.begin();
        let (mut any_occupied, mut any_free) = (0, 0);
        for (reading, parts) in &readings {
            let join = |plane: fn(&Planes) -> &BitGrid| {
                parts.iter().flatten().fold(0, |all, planes| all | plane(planes).words()[word])
            };
            let occupied = join(|planes| &planes.occupied);
            let free = join(|planes| &planes.free) & !occupied;
            any_occupied |= occupied;
            any_free |= free;
            if fusion == Fusion::Octomap && occupied | free != 0 {
                sums.add(occupied, reading.hit);
                sums.add(free, reading.miss);
                sums.next();
            }
        }
        let [occupied, free] = match fusion {
            Fusion::OccupiedWins => [any_occupied, any_free & !any_occupied],
            Fusion::Octomap => sums.signs(),
        };
        fused.occupied.words_mut()[word] = occupied;
        fused.free.words_mut()[word] = free;
    }
    fused
}

/// The log-odds of 32 voxels: which voxels have which sum. There are few different sums, so this beats 32 numbers.
#[derive(Default)]
struct Sums {
    now: Vec<(i32, u32)>,
    next: Vec<(i32, u32)>,
}

impl Sums {
    /// No voxel has evidence.
    fn begin(&mut self) {
        self.now.clear();
        self.now.push((0, u32::MAX));
        self.next.clear();
    }

    /// Some voxels hear the same from one sensor.
    fn add(&mut self, voxels: u32, said: i32) {
        for (sum, holders) in &mut self.now {
            let heard = *holders & voxels;
            if heard != 0 {
                *holders &= !voxels;
                self.next.push(((*sum + said).clamp(*LOG_ODDS.start(), *LOG_ODDS.end()), heard));
            }
        }
    }

    /// The sensor has spoken.
    fn next(&mut self) {
        self.now.retain(|(_, holders)| *holders != 0);
        self.now.append(&mut self.next);
    }

    /// Voxels above zero and below it. A sum of zero is no label, with evidence or without.
    fn signs(&self) -> [u32; 2] {
        let holders = |is: fn(i32) -> bool| {
            self.now.iter().filter(|(sum, _)| is(*sum)).fold(0, |all, (_, voxels)| all | voxels)
        };
        [holders(|sum| sum > 0), holders(|sum| sum < 0)]
    }
}
