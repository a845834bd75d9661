//! Which voxels a sensor watches: those in which a body would be noticed if it were there.
//!
//! | sensor | watches |
//! |---|---|
//! | one that casts and is scored by its points | each voxel that a ray enters from its shortest to its longest range, up to its first blocker and with it, but within `near_ignore_m`; not the voxel that the sensor is in |
//! | the same with `reflectance_ranges_m` | of those the ones within its range for people of the default reflectance |
//! | one that casts and is a switch by a field | of those the ones whose return would be read in the field |
//! | one that feels without a table of rays | the voxels in which it feels ([`Kind::feels`]): a pad's first layer, a gate's box, what a radar senses |
//! | a switch that the environment trips | nothing: it is always on, so nobody changes what it says |
//! | a switch by the joints of people, as `rgb` is | nothing: a body has no joints |
//! | one that notices nobody who comes, as `known_robot` and `recorded` | nothing |
//!
//! A kind that watches anything else says so in [`Kind::watches`].
//!
//! It follows that a person who has a voxel in a watched one is hit or felt, and one who has none is not:
//!
//! * A ray ends in the first voxel of a body that it enters, so a body that has more watched voxels need not
//!   have more hits, but it has one.
//! * What is nearer to the sensor than its shortest range hides what is behind: a body that reaches there
//!   may blind the rays that come to its watched voxels.
//! * A ray ends in nothing before it has come to the longest range; whether that certifies that it passed free
//!   space does not matter for what it would have hit.
//! * A return that is lost in a repeat is lost whatever it comes from. Noise moves where a return is read, not
//!   where it comes from; rays are those of the true mount.
//! * A body that comes moves, fast enough for every radar.
//! * A zone camera would notice a person whose joints it finds; which these are, a body does not say.
//!
//! The reasons of `src/decide/view/why.rs` say more of what is not watched: whoever stands in a voxel that is
//! monitored and not watched has something before them, or too near to the lens, or a return is lost.

use std::borrow::Cow;

use rayon::prelude::*;

use super::look::{self, RayDirection};
use super::{Extent, Kind, Station};
use crate::input::PERSON_REFLECTANCE;
use perirobot_march::backend::cpu::{SightRays, SightScene};
use perirobot_march::backend::{GridPose, Rays};
use perirobot_march::march::{self, Gates};
use perirobot_march::voxel::BitGrid;
use perirobot_march::voxel::grid::length_q16;

/// What makes rays quick that are followed from many poses: their table and what blocks them, made ready.
#[derive(Clone, Copy, Debug)]
pub struct ReadySight<'a> {
    /// The rays of the sensor.
    pub rays: &'a SightRays,
    /// The blockers of its station.
    pub scene: &'a SightScene,
}

/// The voxels that a sensor watches in a representation, over the grid or a part of it. They are the same with `sight`
/// and without.
pub fn watched_voxels(
    kind: &dyn Kind,
    representation: usize,
    at: &Station,
    sight: Option<ReadySight>,
) -> BitGrid {
    if is_always_on(kind, representation, at) {
        return BitGrid::nowhere();
    }
    if let Some(voxels) = kind.watches(representation, at) {
        return voxels;
    }
    match (kind.feels(at), at.rays) {
        (Extent::Only(voxels), _) => voxels,
        (_, Some(rays)) => match sight.filter(|_| rays.noise.lost_below == 0 && !rays.gates.has_shades()) {
            Some(ReadySight { rays, scene }) => scene.watched(rays, &at.placement(kind)),
            None => {
                let rays = rays_that_notice(kind, rays, at);
                ray_watch(&rays, &at.placement(kind), &at.truth.blockers, None)
            }
        },
        (_, None) => BitGrid::nowhere(),
    }
}

/// The rays of a sensor as far as they notice a body that comes, which is as dark as people are by default.
pub(super) fn rays_that_notice<'a>(kind: &dyn Kind, rays: &'a Rays, at: &Station) -> Cow<'a, Rays> {
    let reach_m = kind.range().map_or(f64::INFINITY, |range| range.reflectance.range_m(PERSON_REFLECTANCE));
    let reach_q16 = length_q16(reach_m.min(1e6), at.truth.grid.voxel_size_m);
    if reach_q16 >= i64::from(rays.gates.range_max_q16) {
        return Cow::Borrowed(rays);
    }
    let gates = Gates { range_max_q16: reach_q16.max(0) as u32, ..rays.gates };
    Cow::Owned(Rays { gates, ..rays.clone() })
}

/// Whether a sensor is, in a representation, a switch that the environment alone trips.
pub fn is_always_on(kind: &dyn Kind, representation: usize, at: &Station) -> bool {
    kind.feels_presence(representation) && !kind.stuck_by(at).is_empty()
}

/// The voxels that rays watch, each followed step by step; only those whose return would be read in a field, if one is given.
pub(super) fn ray_watch(
    rays: &Rays,
    from: &GridPose,
    blockers: &BitGrid,
    field: Option<&BitGrid>,
) -> BitGrid {
    let window = blockers.window();
    let follow = |plane: &mut BitGrid, ray: u32| {
        let drawn = march::draw(from.draws, ray);
        if march::is_lost(drawn, rays.noise.lost_below) {
            return;
        }
        let (way, gates) =
            (RayDirection::new(from, rays.dirs_q15[ray as usize]), rays.gates_of(ray as usize));
        let entered = march::crossings(march::start(from.caster().origin_q16, way.truly_q16));
        for to in entered.take_while(|to| to.t_q16 <= gates.range_max_q16 && window.contains(to.voxel)) {
            if to.t_q16 < gates.near_ignore_q16 {
                continue;
            }
            let is_read = |field: &BitGrid| field.get(look::read(rays, from, way, drawn, &to, window.size));
            if to.t_q16 >= gates.range_min_q16 && field.is_none_or(is_read) {
                plane.set(to.voxel);
            }
            if blockers.get(to.voxel) {
                break;
            }
        }
    };
    // A plane for each thread.
    let count = rays.dirs_q15.len() as u32;
    let share = count.div_ceil(rayon::current_num_threads() as u32).max(1);
    let parts = (0..count.div_ceil(share)).into_par_iter().map(|part| {
        let mut plane = BitGrid::new(window);
        (part * share..(part * share + share).min(count)).for_each(|ray| follow(&mut plane, ray));
        plane
    });
    let all = parts.reduce_with(|mut all, part| {
        all.add(&part);
        all
    });
    all.unwrap_or_else(BitGrid::nowhere)
}
