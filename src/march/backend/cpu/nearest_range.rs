//! Which voxels rays enter before their shortest range, and which beyond it.
//!
//! # Theory
//! A ray enters a voxel through a face that is turned to the sensor. The distances of these faces bound where any ray enters
//! it; depths along the sensor's axis do the same where ranges are depths. Integer rays deviate a little from ideal ones
//! (`deviation`). What the bounds leave open single rays decide, in integers: one ray that enters a voxel beyond its shortest
//! range, with nothing before it, is enough.
//!
//! # Practice
//! Of the rays of a camera some hundred to thousand enter such a voxel, so a few of them decide most voxels. Then the others are
//! followed that pass near a voxel that is still open; neighbours in an image are looked at together.

use super::open_voxels::OpenVoxels;
use crate::backend::{GridPose, Rays};
use crate::march::{self, LEAST_AXIAL_Q15, Slant, deviation, leap};
use crate::voxel::BitGrid;

/// Where rays enter a voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// Before their shortest range.
    Before,
    /// Beyond it.
    Beyond,
    /// Some perhaps before it, and others beyond it.
    Both,
}

/// The shortest range of the rays of a table from a pose.
pub(super) struct NearestRange<'a> {
    rays: &'a Rays,
    from: &'a GridPose,
    /// Where the sensor is, in voxels, and its axis.
    origin: [f64; 3],
    axis: [f64; 3],
    /// In voxels; the first along the axis if ranges are depths, the other along the ray.
    range_min: f64,
    near_ignore: f64,
    /// Whether some rays are so slanted that their depth is not what their range is measured in.
    is_slanted: bool,
}

/// Of so many rays one is followed first; then of fewer one is asked, and the others last.
const FOLLOWED_FIRST: usize = 61;
const ASKED_FIRST: usize = 7;

/// How far from where a ray comes to its shortest range the voxels are that it enters next, unless it is too slanted.
const AROUND: i32 = 3;

/// How far the shortest range may bend out of a box of its places at the corners of a voxel, if it is so far, in voxels.
const BEND: f64 = 0.25;
const LEAST_STRAIGHT: f64 = 3.0;

/// The most rays that are looked at together.
const LONGEST_RUN: usize = 16;

/// The most voxels along a ray for a voxel of depth with which that holds.
const MOST_SLANT: f64 = 1.5;

/// What a ray may deviate by: far beyond what is known of it, in 64-bit floats.
fn deviation(distance: f64) -> f64 {
    0.01 + 2.0 * deviation::PER_VOXEL * distance
}

impl<'a> NearestRange<'a> {
    /// That of rays from a caster.
    pub(super) fn new(rays: &'a Rays, from: &'a GridPose) -> NearestRange<'a> {
        let voxels = |q16: u32| f64::from(q16) / 65_536.0;
        NearestRange {
            rays,
            from,
            origin: from.origin_q16.map(|x| f64::from(x) / 65_536.0),
            axis: from.axis_q15.map(|row| f64::from(row[2]) / 32_768.0),
            range_min: voxels(rays.gates.range_min_q16),
            near_ignore: voxels(rays.gates.near_ignore_q16),
            is_slanted: rays.gates.along_axis && rays.dirs_q15.iter().any(|dir| dir[2] < LEAST_AXIAL_Q15),
        }
    }

    /// Where rays enter a voxel.
    pub(super) fn side(&self, voxel: [i32; 3]) -> Side {
        let low: [f64; 3] = std::array::from_fn(|r| f64::from(voxel[r]) - self.origin[r]);
        let least: f64 = low.iter().map(|low| low.max(-low - 1.0).max(0.0).powi(2)).sum::<f64>().sqrt();
        let (mut depths, mut most, mut deepest) = (f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY);
        for corner in 0..8u32 {
            let is_high = |r: usize| corner >> r & 1 == 1;
            let at: [f64; 3] = std::array::from_fn(|r| low[r] + f64::from(u8::from(is_high(r))));
            let depth: f64 = (0..3).map(|r| at[r] * self.axis[r]).sum();
            depths = depths.min(depth);
            // On a face that is turned to the sensor, or that the sensor is on.
            if (0..3).any(|r| if is_high(r) { low[r] + 1.0 <= 0.0 } else { low[r] >= 0.0 }) {
                most = most.max(at.iter().map(|x| x * x).sum::<f64>().sqrt());
                deepest = deepest.max(depth);
            }
        }
        let by = deviation(least + 2.0);
        let (nearest, farthest) = if self.rays.gates.along_axis { (depths, deepest) } else { (least, most) };
        let is_depth_known = !self.is_slanted;
        let beyond = least >= self.near_ignore + by && nearest >= self.range_min + by;
        let before = most < self.near_ignore - by || farthest < self.range_min - by;
        match (beyond && is_depth_known, before && is_depth_known) {
            (true, _) => Side::Beyond,
            (_, true) => Side::Before,
            _ => Side::Both,
        }
    }

    /// Those of some voxels, all of them near the shortest range, that rays watch; `runs` of the rays are known ([`Runs`]).
    pub(super) fn watched(&self, blockers: &BitGrid, open: BitGrid, runs: Runs) -> BitGrid {
        let mut decided = Decided { blockers, watched: BitGrid::new(open.window()), open };
        let count = self.rays.dirs_q15.len();
        (0..count).step_by(FOLLOWED_FIRST).for_each(|ray| self.follow(ray, &mut decided));
        let open = OpenVoxels::new(self.each_towards(&decided.open), 0.0);
        (0..count).step_by(ASKED_FIRST).for_each(|ray| self.ask(ray, &open, &mut decided));
        let Runs { length, spread } = runs;
        let open = OpenVoxels::new(self.each_towards(&decided.open), spread);
        for first in (0..count).step_by(length) {
            if self.place(first).is_none_or(|place| open.about(place, spread).next().is_some()) {
                (first..(first + length).min(count)).for_each(|ray| self.ask(ray, &open, &mut decided));
            }
        }
        decided.watched
    }

    /// Follows a ray if it enters an open voxel beyond its shortest range, or is too slanted to tell.
    fn ask(&self, ray: usize, open: &OpenVoxels, decided: &mut Decided) {
        let enters = |place: [f64; 3]| {
            let mut about = open.about(place, 0.0).filter(|&voxel| decided.open.get(voxel)).peekable();
            about.peek().is_some() && {
                let (begin, gates) = (self.from.launch(self.rays.dirs_q15[ray]), self.rays.gates_of(ray));
                let range_q16 = gates.range_min_q16.max(gates.near_ignore_q16)..=gates.range_max_q16;
                about.any(|voxel| {
                    leap::entry_q16(&begin, voxel).is_some_and(|t_q16| range_q16.contains(&t_q16))
                })
            }
        };
        if self.place(ray).is_none_or(enters) {
            self.follow(ray, decided);
        }
    }

    /// Where a ray comes to its shortest range, from the sensor in voxels; `None` if it is too slanted to tell where it goes next.
    fn place(&self, ray: usize) -> Option<[f64; 3]> {
        let dir_q15 = self.rays.dirs_q15[ray];
        let t = shortest(self.rays, dir_q15).filter(|_| !self.is_slanted)? / 65_536.0;
        Some(self.from.axis_q15.map(|axis| f64::from(march::direction_q16(axis, dir_q15)) * t))
    }

    /// Each of some voxels with its [`NearestRange::towards`].
    fn each_towards(&self, voxels: &BitGrid) -> Vec<([i32; 3], [[f64; 3]; 2])> {
        voxels.voxels().map(|voxel| (voxel, self.towards(voxel))).collect()
    }

    /// A box that holds where rays come to their shortest range that enter a voxel beyond it, from the sensor in voxels.
    fn towards(&self, voxel: [i32; 3]) -> [[f64; 3]; 2] {
        let from = |corner: i32| {
            std::array::from_fn::<f64, 3, _>(|r| f64::from(voxel[r] + (corner >> r & 1)) - self.origin[r])
        };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for at in (0..8).map(from) {
            let distance = at.iter().map(|x| x * x).sum::<f64>().sqrt();
            let depth: f64 = (0..3).map(|r| at[r] * self.axis[r]).sum();
            let measured = if self.rays.gates.along_axis { depth } else { distance };
            let shortest = (self.range_min / measured).max(self.near_ignore / distance);
            if distance * shortest < LEAST_STRAIGHT || measured * MOST_SLANT < distance {
                // Too near, or too slanted: all that a ray may come to next.
                let around = f64::from(AROUND);
                return [from(0).map(|x| x - around), from(7).map(|x| x + around)];
            }
            for r in 0..3 {
                (low[r], high[r]) = (low[r].min(at[r] * shortest), high[r].max(at[r] * shortest));
            }
        }
        [low.map(|x| x - BEND), high.map(|x| x + BEND)]
    }

    /// Marks the open voxels that a ray watches about its shortest range.
    fn follow(&self, ray: usize, Decided { blockers, open, watched }: &mut Decided) {
        let gates = self.rays.gates_of(ray);
        let Slant { period_q16, .. } = self.rays.gates.slant(self.rays.dirs_q15[ray][2]);
        // No voxel is left open that all rays enter so far beyond it.
        let until_q16 = gates.range_min_q16.max(gates.near_ignore_q16) + AROUND as u32 * period_q16;
        let until_q16 =
            if self.is_slanted { gates.range_max_q16 } else { until_q16.min(gates.range_max_q16) };
        let entered = march::crossings(self.from.launch(self.rays.dirs_q15[ray]));
        let inside = |to: &march::Crossing| to.t_q16 <= until_q16 && blockers.window().contains(to.voxel);
        for to in entered.take_while(inside).filter(|to| to.t_q16 >= gates.near_ignore_q16) {
            if to.t_q16 >= gates.range_min_q16 && open.get(to.voxel) {
                watched.set(to.voxel);
                open.unset(to.voxel);
            }
            if blockers.get(to.voxel) {
                break;
            }
        }
    }
}

/// The distance at which a ray comes to its shortest range, in voxels; `None` if it is too slanted.
fn shortest(rays: &Rays, dir_q15: [i32; 3]) -> Option<f64> {
    let slant = if rays.gates.along_axis { 32_768.0 / f64::from(dir_q15[2].max(1)) } else { 1.0 };
    let voxels = |q16: u32| f64::from(q16) / 65_536.0;
    let t = (voxels(rays.gates.range_min_q16) * slant).max(voxels(rays.gates.near_ignore_q16));
    (slant <= MOST_SLANT).then_some(t)
}

/// How many rays after each other come to their shortest ranges how near to the first of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Runs {
    length: usize,
    spread: f64,
}

impl Runs {
    /// Those of a table: pixels of one row of an image.
    pub(super) fn new(rays: &Rays) -> Runs {
        let place = |dir_q15: &[i32; 3]| {
            shortest(rays, *dir_q15).map(|t| dir_q15.map(|x| f64::from(x) / 32_768.0 * t))
        };
        let apart = |dirs: &[[i32; 3]]| {
            let first = place(&dirs[0]);
            let distance = |[a, b]: [[f64; 3]; 2]| (0..3).map(|r| (a[r] - b[r]).powi(2)).sum::<f64>().sqrt();
            let each =
                dirs.iter().map(|dir| first.zip(place(dir)).map_or(f64::INFINITY, |(a, b)| distance([a, b])));
            each.fold(0.0, f64::max)
        };
        let is_even = |length: &usize| {
            rays.image.is_none_or(|image| (image.size_px[0] as usize).is_multiple_of(*length))
        };
        let spread = |length: usize| rays.dirs_q15.chunks(length).map(apart).fold(0.0, f64::max) + 0.01;
        let runs =
            (2..=LONGEST_RUN).rev().filter(is_even).map(|length| Runs { length, spread: spread(length) });
        runs.into_iter().find(|run| run.spread < 1.0).unwrap_or(Runs { length: 1, spread: 0.01 })
    }
}

/// What is known of voxels near the shortest range.
struct Decided<'a> {
    blockers: &'a BitGrid,
    open: BitGrid,
    watched: BitGrid,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::Noise;
    use crate::march::{FULL_RANGE, Gates};

    /// Rays to all sides from a place, and where they truly enter voxels.
    #[test]
    fn voxels_are_on_the_side_where_rays_enter_them() {
        let mut dirs_q15 = Vec::new();
        for i in 0..20_000 {
            let (u, v) = ((f64::from(i) + 0.5) / 20_000.0, f64::from(i) * 2.399_963);
            let z: f64 = 1.0 - 0.9 * u;
            let r = (1.0 - z * z).sqrt();
            dirs_q15.push([r * v.cos(), r * v.sin(), z].map(|x| (x * 32_768.0).round() as i32));
        }
        let far = (6 << 16) + 12_345;
        let cases =
            [(false, 0, far), (true, 0, far), (true, 5 << 16, far), (false, 9 << 16, far), (false, 0, 0)];
        for (along_axis, near_ignore_q16, range_min_q16) in cases {
            let gates = Gates {
                range_min_q16,
                range_max_q16: 100 << 16,
                shade_ranges_q16: FULL_RANGE,
                along_axis,
                near_ignore_q16,
                no_return_is_free: true,
                backdrop: false,
            };
            let rays =
                Rays { gates, noise: Noise::default(), image: None, dirs_q15: dirs_q15.clone().into() };
            let axis_q15 = [[32_768, 0, 0], [0, 32_768, 0], [0, 0, 32_768]];
            let from =
                GridPose { origin_q16: [900_001, 950_123, 1_000_777], axis_q15, truly: None, draws: 0 };
            let range = NearestRange::new(&rays, &from);
            let mut met = [0; 3];
            for ray in 0..rays.dirs_q15.len() {
                let gates = rays.gates_of(ray);
                let nearest_q16 = gates.range_min_q16.max(gates.near_ignore_q16);
                for to in march::crossings(from.launch(rays.dirs_q15[ray])).take(40) {
                    let side = range.side(to.voxel);
                    let is_beyond = to.t_q16 >= nearest_q16;
                    assert!(
                        side != if is_beyond { Side::Before } else { Side::Beyond },
                        "{to:?} of ray {ray}"
                    );
                    met[side as usize] += 1;
                }
            }
            assert!(range_min_q16 == 0 || met.into_iter().min() > Some(20_000), "{met:?}");
        }
    }
}
