//! What the rays of a table watch of a scene from any pose, without noise: for whoever asks what a sensor would notice, not
//! what it says.
//!
//! # Theory
//! A voxel is watched if some ray enters it from its shortest range to its longest, up to its first blocker and with it. Beyond the shortest range these are the
//! voxels of the backend's evidence, if a ray that ends in nothing certifies what it passed. Before it there are none. Only
//! where some rays may enter a voxel before it and others beyond it do single rays decide (`nearest_range`).

use super::first_hit::Layer;
use super::nearest_range::{NearestRange, Runs, Side};
use super::plan::RelevantVoxels;
use super::scratch::Scratch;
use super::simd::SimdLevel;
use super::table::{Blockers, RayTable, TableCaster};
use crate::backend::{GridPose, Noise, Rays};
use crate::march::Gates;
use crate::voxel::{BitGrid, Window};

/// A table of rays, made ready.
pub struct SightRays {
    table: RayTable,
    /// The farthest that the shortest range of a ray is.
    farthest_q16: u32,
    runs: Runs,
}

/// What stops rays, made ready, and where it is asked what they watch.
pub struct SightScene {
    blockers: Layer,
    within: Window,
}

impl SightRays {
    /// The rays of a table, whatever their noise.
    pub fn new(rays: &Rays) -> SightRays {
        let gates = Gates { no_return_is_free: true, backdrop: false, ..rays.gates };
        let table = RayTable::new(&Rays { gates, noise: Noise::default(), ..rays.clone() });
        let slant = rays.most_slant();
        let farthest_q16 = slant.ray_range_q16(gates.range_min_q16).max(gates.near_ignore_q16);
        SightRays { runs: Runs::new(rays), table, farthest_q16 }
    }
}

impl SightScene {
    /// A scene with these blockers over the whole grid; it is asked what is watched of a part of it.
    pub fn new(blockers: &BitGrid, within: Window) -> SightScene {
        let within = within.intersection(&blockers.window());
        SightScene { blockers: Layer::new(blockers.clone()), within }
    }

    /// The voxels that rays watch.
    pub fn watched(&self, rays: &SightRays, from: &GridPose) -> BitGrid {
        let from = from.caster();
        let SightRays { table, farthest_q16, runs } = rays;
        let nearest = NearestRange::new(&table.rays, &from);
        let own = from.origin_q16.map(|at| at >> 16);
        let near = Window::from_corners(own, own).grown((farthest_q16 >> 16) as i32 + 2);
        let near = near.intersection(&self.within);
        let (mut wanted, mut doubtful) = (BitGrid::full(self.within), BitGrid::new(near));
        BitGrid::full(near).each_in(&near, |voxel| match nearest.side(voxel) {
            Side::Before => wanted.unset(voxel),
            Side::Both => doubtful.set(voxel),
            Side::Beyond => {}
        });
        let mut watched = self.passed(table, &from, wanted);
        doubtful.keep(&watched.to_window(near));
        watched.remove(&doubtful);
        watched.add(&nearest.watched(&self.blockers.blockers, doubtful, *runs));
        watched
    }

    /// The voxels of some that rays pass within their longest range, and those of the first blockers. A ray whose first blocker is
    /// nearer than its shortest range passes nothing.
    fn passed(&self, table: &RayTable, from: &GridPose, wanted: BitGrid) -> BitGrid {
        let SimdLevel { level, wide, .. } = SimdLevel::most();
        let blockers = Blockers { still: None, moving: &self.blockers, sometimes: None };
        let wanted = &RelevantVoxels::from_voxels(wanted);
        let caster =
            TableCaster { level, wide, table, blockers, shades: None, wanted, carving: None, plane_words: 0 };
        let planes = caster.sense(from, &mut Scratch::new(&caster), None, None);
        let mut passed = planes.free;
        passed.add(&planes.occupied);
        passed.keep(&wanted.voxels);
        passed
    }
}

impl std::fmt::Debug for SightRays {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SightRays").field("gates", &self.table.gates).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for SightScene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SightScene").field("within", &self.within).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::test_camera::camera_of;
    use super::*;
    use crate::march;

    /// The same, each ray followed step by step.
    fn followed(rays: &Rays, from: &GridPose, blockers: &BitGrid, within: Window) -> BitGrid {
        let mut watched = BitGrid::new(within);
        for (ray, &dir_q15) in rays.dirs_q15.iter().enumerate() {
            let gates = rays.gates_of(ray);
            let entered = march::crossings(from.launch(dir_q15));
            let inside = |to: &march::Crossing| {
                to.t_q16 <= gates.range_max_q16 && blockers.window().contains(to.voxel)
            };
            for to in entered.take_while(inside).filter(|to| to.t_q16 >= gates.near_ignore_q16) {
                if to.t_q16 >= gates.range_min_q16 {
                    watched.set(to.voxel);
                }
                if blockers.get(to.voxel) {
                    break;
                }
            }
        }
        watched
    }

    /// A camera with many pixels a voxel among scattered blockers, some of them before its shortest range, some on it.
    #[test]
    fn a_dense_camera_watches_what_its_rays_enter() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let window = Window { min: [0; 3], size: [60, 50, 40] };
        let (mut near, mut all) = (0, 0);
        for turn in 0..24u32 {
            let mut blockers = BitGrid::new(window);
            for _ in 0..60 {
                blockers.set(window.size.map(|n| (random.next_u32() % n) as i32));
            }
            let mut below = |n: u32| (random.next_u32() % n) as i32;
            // Without a shortest range, on the edge of voxels.
            let (along_axis, on_edge) = (turn % 2 == 0, turn % 5 == 0);
            let gates = Gates {
                range_min_q16: if on_edge { 0 } else { ((4 + below(8)) << 16) as u32 + below(65_536) as u32 },
                range_max_q16: 40 << 16,
                shade_ranges_q16: crate::march::FULL_RANGE,
                along_axis,
                near_ignore_q16: if turn % 3 == 0 { 6 << 16 } else { 0 },
                no_return_is_free: false,
                backdrop: false,
            };
            let rays = Rays { gates, ..camera_of([200, 150], [110.0 + f64::from(below(60)); 2]) };
            let origin_q16 = [below(60 << 16), below(50 << 16), below(40 << 16)];
            let origin_q16 = if on_edge { origin_q16.map(|x| x & !0xffff) } else { origin_q16 };
            let turned =
                glam::DMat3::from_euler(glam::EulerRot::ZYX, f64::from(below(7)), f64::from(below(7)), 0.3);
            let axis_q15 =
                std::array::from_fn(|r| turned.row(r).to_array().map(|x| (x * 32_768.0).round() as i32));
            let from = GridPose { origin_q16, axis_q15, truly: None, draws: 0 };
            let within = if turn % 4 == 0 { window } else { Window { min: [5, 0, 3], size: [50, 45, 30] } };
            let watched = SightScene::new(&blockers, within).watched(&SightRays::new(&rays), &from);
            assert_eq!(watched, followed(&rays, &from, &blockers, within), "turn {turn}");
            let own = origin_q16.map(|x| x >> 16);
            near += watched.to_window(Window::from_corners(own, own).grown(14)).count();
            all += watched.count();
        }
        assert!(near > 5_000 && all > 50_000, "{near} of {all}");
    }
}
