//! Why one sensor has no label for a voxel.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::sight::{Look, Sight};
use super::{Cause, Reason};
use crate::view::{SensorView, View};
use perirobot_march::backend::cpu::{BlockerSearch, RaysFrom};
use perirobot_march::backend::{Rays, Shades};
use perirobot_march::march::{self, leap};
use perirobot_march::voxel::BitGrid;
use perirobot_scene::truth::{ObjectVoxels, Truth};
use perirobot_study::input::Study;
use perirobot_study::sensor::look::RayDirection;
use perirobot_study::sensor::{Extent, Kind, Sensor};

/// Finds why one sensor has no label for a voxel.
pub(super) struct Witness<'a> {
    truth: &'a Truth,
    member: &'a SensorView,
    kind: &'a dyn Kind,
    means: Means<'a>,
}

enum Means<'a> {
    /// A sensor with rays, with the search for their ends.
    Rays { sight: Sight<'a>, rays: &'a Rays, search: &'a BlockerSearch, from: RaysFrom },
    /// A sensor that labels a volume, with the reason for its unlabelled voxels, and what is known outside the volume.
    Volume { voxels: BitGrid, otherwise: Reason, beyond: Option<(Sight<'a>, &'a Fan, RaysFrom)> },
}

/// The rays by which a switch senses its field, and the search for what stops them.
#[derive(Debug)]
pub(in crate::view) struct Fan {
    rays: Rays,
    search: BlockerSearch,
}

/// The fans of the sensors of a study that have one, by their numbers.
fn fans(study: &Study, truth: &Truth) -> BTreeMap<usize, Fan> {
    let fan = |(number, sensor): (usize, &Sensor)| {
        let rays = sensor.kind.fan(truth.grid.voxel_size_m)?;
        Some((number, Fan { rays, search: BlockerSearch::new(sensor.kind.blockers(truth)) }))
    };
    study.sensors.iter().enumerate().filter_map(fan).collect()
}

impl<'a> Witness<'a> {
    pub(super) fn new(view: &'a View, member: &'a SensorView) -> Self {
        let (truth, kind) = (&view.truth, &view.study.sensors[member.sensor].kind);
        let means = match &view.tables[member.sensor] {
            Some(rays) if member.casts => {
                let sight = Sight::new(rays, &member.placement, kind.field_of_view());
                let search = view.search.get_or_init(|| BlockerSearch::new(&truth.blockers));
                let from = search.rays_from(member.placement.caster().origin_q16);
                Means::Rays { sight, rays, search, from }
            }
            _ => {
                let station = view.world.station(
                    view.study,
                    truth,
                    [member.sensor, member.candidate, view.choice.repeat],
                );
                let mut voxels = BitGrid::new(truth.grid.window());
                if let Extent::Only(volume) | Extent::RaysAnd(volume) = kind.reach(&station) {
                    voxels.add(&volume);
                }
                if let Some(volume) = kind.wherever_it_stands(truth) {
                    voxels.add(&volume);
                }
                let says_nothing = member.says.occupied.is_empty() && member.says.free.is_empty();
                let otherwise = match says_nothing {
                    true if kind.is_muted(&station) => Reason::Muted,
                    true => Reason::Silent,
                    false => Reason::Misread,
                };
                let fan = view.fans.get_or_init(|| fans(view.study, truth)).get(&member.sensor);
                let beyond = fan.map(|fan| {
                    let sight = Sight::new(&fan.rays, &member.placement, kind.field_of_view());
                    (sight, fan, fan.search.rays_from(member.placement.caster().origin_q16))
                });
                Means::Volume { voxels, otherwise, beyond }
            }
        };
        Witness { truth, member, means, kind: &**kind }
    }

    pub(super) fn cause(&self, voxel: [i32; 3]) -> Cause {
        let because = |reason| Cause { reason, object: None };
        if self.member.says.occupied.get(voxel) || self.member.says.free.get(voxel) {
            return because(Reason::Cancelled);
        }
        match &self.means {
            Means::Volume { voxels, otherwise, .. } if voxels.get(voxel) => because(*otherwise),
            Means::Volume { beyond: None, .. } => because(Reason::OutOfView),
            Means::Volume { beyond: Some((sight, fan, from)), .. } => match crossing(sight, &fan.rays, voxel)
            {
                Err(reason) => because(reason),
                Ok((ray, begin, entered_q16)) => {
                    let hit = self.first((ray, &fan.rays), &fan.search, from);
                    self.fan_reason(hit, &begin, &fan.rays.gates, (voxel, entered_q16))
                }
            },
            Means::Rays { sight, rays, search, from } => match crossing(sight, rays, voxel) {
                Err(reason) => because(reason),
                Ok((ray, begin, entered_q16)) => {
                    let hit = self.first((ray, rays), search, from);
                    self.end_reason((ray, hit), &begin, rays, (voxel, entered_q16))
                }
            },
        }
    }

    /// Where a ray truly ends.
    fn first(
        &self,
        (ray, rays): (u32, &Rays),
        search: &BlockerSearch,
        from: &RaysFrom,
    ) -> Option<march::Crossing> {
        let way = RayDirection::new(&self.member.placement, rays.dirs_q15[ray as usize]);
        search.first(from, way.truly_q16, &rays.gates_of(ray as usize))
    }

    /// Why a voxel is outside the field of a switch, although one of its rays crosses it within its range.
    fn fan_reason(
        &self,
        hit: Option<march::Crossing>,
        begin: &march::March,
        gates: &march::Gates,
        (voxel, entered_q16): ([i32; 3], u32),
    ) -> Cause {
        let because = |reason| Cause { reason, object: None };
        match hit {
            _ if entered_q16 < gates.range_min_q16.max(gates.near_ignore_q16) => because(Reason::OutOfRange),
            Some(hit) if crossings(begin, voxel) >= crossings(begin, hit.voxel) => {
                Cause { reason: Reason::Hidden, object: self.object_that_stops(hit.voxel) }
            }
            _ => because(Reason::BetweenRays),
        }
    }

    fn object_that_stops(&self, voxel: [i32; 3]) -> Option<usize> {
        let stands = |object: &Arc<ObjectVoxels>| self.kind.is_stopped_by(object) && object.voxels.get(voxel);
        self.truth.objects.iter().position(stands)
    }

    /// Why a voxel stays unknown although a believed ray crosses it within its range; the true ray ended at an object
    /// or nothing.
    fn end_reason(
        &self,
        (ray, hit): (u32, Option<march::Crossing>),
        begin: &march::March,
        rays: &Rays,
        (voxel, entered_q16): ([i32; 3], u32),
    ) -> Cause {
        let because = |reason| Cause { reason, object: None };
        let from = &self.member.placement;
        let Some(hit) = hit else { return because(Reason::NoReturn) };
        let gates = rays.gates_of(ray as usize);
        let is_too_dark = |shades: &Shades| shades.is_too_weak(hit.voxel, hit.t_q16, &gates);
        let reason = if hit.t_q16 < gates.range_min_q16 {
            Reason::Blind
        } else if self.truth.shades.as_deref().is_some_and(is_too_dark) {
            Reason::TooDark
        } else if march::is_lost(march::draw(from.draws, ray), rays.noise.lost_below) {
            return because(Reason::NoReturn);
        } else {
            // For shifted mounts, distances are compared.
            let is_before = match from.truly {
                None => crossings(begin, voxel) > crossings(begin, hit.voxel),
                Some(_) => entered_q16 > hit.t_q16,
            };
            if !is_before {
                return because(Reason::Misread);
            }
            Reason::Hidden
        };
        Cause { reason, object: self.object_that_stops(hit.voxel) }
    }
}

/// The ray nearest to a voxel's centre, if it crosses it within its range, where it begins, and at which distance it enters the
/// voxel; otherwise why it does not.
fn crossing(sight: &Sight, rays: &Rays, voxel: [i32; 3]) -> Result<(u32, march::March, u32), Reason> {
    let Look { in_view, ray, squared_q32 } = sight.look(voxel);
    let begin = ray.map(|ray| (ray, sight.start(ray)));
    let crosses = begin.and_then(|(ray, begin)| Some((ray, begin, leap::entry_q16(&begin, voxel)?)));
    // If no ray crosses the voxel, the ray nearest to it.
    let gates = ray.map_or(rays.gates, |ray| rays.gates_of(ray as usize));
    let range_q16 = gates.range_max_q16;
    match crosses {
        None if !in_view => Err(Reason::OutOfView),
        None if squared_q32 > i128::from(range_q16).pow(2) => Err(Reason::OutOfRange),
        None => Err(Reason::BetweenRays),
        Some((_, _, entered_q16)) if entered_q16 > range_q16 => Err(Reason::OutOfRange),
        Some(found) => Ok(found),
    }
}

/// How many boundaries every ray from its first voxel to another crosses.
fn crossings(begin: &march::March, to: [i32; 3]) -> u32 {
    (0..3).map(|r| to[r].abs_diff(begin.voxel[r])).sum()
}
