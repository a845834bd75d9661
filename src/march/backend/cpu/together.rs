//! One pose on several threads: its packets of rays and the boxes of voxels are shared out among them.
//!
//! # Theory
//! What a packet tells, and what is free of a box, depends on no other packet or box. Planes are joined bit by bit, so it makes
//! no difference who found what.

use rayon::prelude::*;

use super::asked::AskedPlaces;
use super::packet::Lanes;
use super::plan;
use super::projection::Projection;
use super::pyramid::Pyramid;
use super::scratch::Scratch;
use super::table::TableCaster;
use crate::backend::{Carving, GridPose, Planes};
use crate::voxel::BitGrid;

/// Tables of fewer rays are cast as quickly by one thread.
pub(super) const LEAST_RAYS: usize = 4096;

/// Boxes that one thread decides at a time.
const BOXES_AT_ONCE: usize = 512;

/// A tile of a camera by its number, and how many voxels its pixels free.
type FreedTile = (usize, Lanes<u32>);

impl TableCaster<'_> {
    /// Senses from a placement of which nothing is kept, in so many parts: what [`TableCaster::sense`] does.
    pub(super) fn sense_together(&self, placement: &GridPose, parts: usize) -> Planes {
        let window = self.wanted.voxels.window();
        let carving = self.carving.unwrap_or_else(|| plan::carving(&self.table.packets, window));
        match (carving, self.table.packets.image()) {
            (Carving::ByVoxel, Some(image)) => {
                self.carve_by_voxel_together(&Projection::new(placement, image), placement, parts)
            }
            _ => {
                let part = |part: usize| {
                    let mut planes = Planes::blank(window);
                    let packets = (part..self.table.packets.count()).step_by(parts);
                    let mut scratch = Scratch::without_image(self);
                    self.carve_by_ray(packets, &mut self.shoot(placement), &mut scratch, &mut planes);
                    planes
                };
                joined((0..parts).into_par_iter().map(part), window)
            }
        }
    }

    fn carve_by_voxel_together(&self, projection: &Projection, placement: &GridPose, parts: usize) -> Planes {
        let window = self.wanted.voxels.window();
        let (tiles, boxes) = self.seen_boxes(projection, &self.shoot(placement));
        let part = |part: usize| {
            let (mut planes, mut freed) = (Planes::blank(window), Vec::new());
            let (some, mut scratch) = ((part..tiles.len()).step_by(parts), Scratch::without_image(self));
            let shoot = &mut self.shoot(placement);
            let take = &mut |packet, own: &Lanes<u32>| freed.push((packet, *own));
            self.cast_tiles(some, &tiles, projection, shoot, &mut scratch, &mut planes, take);
            (planes, freed)
        };
        let cast: Vec<(Planes, Vec<FreedTile>)> = (0..parts).into_par_iter().map(part).collect();
        let mut planes = Planes::blank(window);
        let Some(image) = self.table.packets.image() else { return planes };
        let mut pyramid = Pyramid::new(image);
        pyramid.clear();
        for (own, freed) in cast {
            planes.add(&own);
            freed.iter().for_each(|(packet, freed)| pyramid.set_tile(*packet, freed));
        }
        pyramid.build(self.level);
        let decide = |(asked, mut free): (AskedPlaces, BitGrid), some: &[_]| {
            let mut asked = asked;
            self.decide_boxes(some, projection, placement, &pyramid, &mut asked, &mut free);
            (asked, free)
        };
        let begin = || (AskedPlaces::new(), BitGrid::new(window));
        let free = boxes.par_chunks(BOXES_AT_ONCE).fold(begin, decide).map(|(_, free)| free);
        planes.free.add(&free.reduce(BitGrid::nowhere, union));
        planes
    }
}

fn joined(parts: impl ParallelIterator<Item = Planes>, window: crate::voxel::Window) -> Planes {
    parts.reduce(
        || Planes::blank(window),
        |mut all, part| {
            all.add(&part);
            all
        },
    )
}

/// The voxels of either; one of them may be nowhere.
fn union(one: BitGrid, other: BitGrid) -> BitGrid {
    let (mut larger, smaller) =
        if one.window().volume() >= other.window().volume() { (one, other) } else { (other, one) };
    larger.add(&smaller);
    larger
}

#[cfg(test)]
mod tests {
    use crate::backend::cpu::Cpu;
    use crate::backend::self_test::{POSES, camera, placement, scene};
    use crate::backend::{Backend, Carving, GridFrame, GridPose, Noise, Planes, Rays, Shot};
    use crate::march::NOISE_STEPS;

    /// Poses that are cast one by one, in whatever way, with noise and with a mount that is off.
    #[test]
    fn several_threads_say_what_one_says() {
        let unit_q12 = (0..NOISE_STEPS as i32).map(|step| step * 8 - 4 * NOISE_STEPS as i32).collect();
        let noise = Noise { unit_q12, std_q16: vec![1 << 15; 512], lost_below: 0 };
        let lossy = Noise { lost_below: 1 << 29, ..noise.clone() };
        let (mut number, mut said) = (0, [0; 2]);
        for noise in [Noise::default(), noise, lossy] {
            for carving in [None, Some(Carving::ByVoxel), Some(Carving::ByRay)] {
                let rays = Rays { noise: noise.clone(), ..camera() };
                let open = |threads: usize| {
                    let cpu = Cpu::new(Some(threads)).unwrap();
                    let mut cpu = carving.into_iter().fold(cpu, Cpu::carving);
                    cpu.tables(std::slice::from_ref(&rays)).unwrap();
                    cpu.load(&scene()).unwrap();
                    cpu
                };
                let says = |cpu: &mut Cpu, at: GridPose| -> Planes {
                    cpu.sense(0, &[Shot::once(0, at)]).unwrap();
                    cpu.planes(&[0]).unwrap().remove(0)
                };
                let (mut one, mut three) = (open(1), open(3));
                for pose in (0..POSES).skip(number % 3).step_by(3) {
                    let at = placement(pose);
                    let GridPose { origin_q16: [x, y, z], axis_q15, .. } = at;
                    let off = GridFrame { origin_q16: [x + 9000, y, z - 4000], axis_q15 };
                    let at = GridPose { truly: (pose % 2 == 1).then_some(off), ..at };
                    let expected = says(&mut one, at);
                    said = [said[0] + expected.free.count(), said[1] + expected.hits.count()];
                    assert!(says(&mut three, at) == expected, "pose {pose}, {carving:?}");
                }
                number += 1;
            }
        }
        assert!(said[0] > 100_000 && said[1] > 1000, "{said:?}");
    }
}
