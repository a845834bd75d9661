//! A few poses of a study, cast before it is swept: how their rays end, and how long all of them would take. What to do
//! about it is for the front.

use std::collections::HashSet;
use std::time::Instant;

use super::compare::spread;
use super::{Ask, Batch, Ledger, Row, World, layout_of, run_asks, tables};
use crate::Result;
use crate::backend::{Backend, Placement, Rays};
use crate::march::{BLIND, End, LEFT, RETURN, direction_q16, next_axis, start};
use crate::study::Study;
use crate::voxel::region::window_of;

/// Moments of a study that are looked at, spread evenly.
const MOMENTS: usize = 4;
/// Rays of a pose that are looked at, spread evenly.
const RAYS: usize = 20_000;
/// Seconds that a measurement takes before it is believed.
const LONG_ENOUGH_S: f64 = 0.5;

/// How the rays of a sensor ended, at some of its poses.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ends {
    /// Poses that were cast, each moment for itself.
    pub poses: u64,
    /// Rays that hit something within their range.
    pub returns: u64,
    /// Rays that hit something nearer than the sensor measures.
    pub too_near: u64,
    /// Rays that hit nothing before the end of their range.
    pub too_far: u64,
    /// Rays that left the grid before that.
    pub left: u64,
}

impl Ends {
    /// All rays that were looked at.
    pub fn rays(&self) -> u64 {
        self.returns + self.too_near + self.too_far + self.left
    }
}

/// How the rays of each sensor end, at so many of its poses, spread evenly; no rays of a sensor that casts none.
///
/// # Errors
/// When the backend fails.
pub fn ends(study: &Study, worlds: &[World], poses: usize, backend: &mut dyn Backend) -> Result<Vec<Ends>> {
    let tables = tables(study);
    let mut all = vec![Ends::default(); study.sensors.len()];
    backend.tables(&tables.iter().flatten().cloned().collect::<Vec<_>>())?;
    for moment in spread(MOMENTS, worlds.len()) {
        let world = &worlds[moment];
        backend.load(&world.cell(window_of(&world.regions)))?;
        let casting = (0..tables.len()).filter_map(|sensor| Some((sensor, tables[sensor].as_ref()?)));
        for (number, (sensor, rays)) in casting.enumerate() {
            for candidate in spread(poses, study.sensors[sensor].candidates.len()) {
                let placement = world.placement(study, sensor, candidate, 0);
                let evidence = backend.read(number, &placement)?;
                add(&mut all[sensor], rays, &placement, &evidence.ends);
            }
        }
    }
    Ok(all)
}

fn add(all: &mut Ends, rays: &Rays, placement: &Placement, ends: &[End]) {
    all.poses += 1;
    let step = rays.dirs_q15.len().div_ceil(RAYS).max(1);
    for (dir_q15, end) in rays.dirs_q15.iter().zip(ends).step_by(step) {
        match end.kind {
            RETURN => all.returns += 1,
            BLIND => all.too_near += 1,
            LEFT => all.left += 1,
            _ if next_after_q16(placement, *dir_q15, end) > rays.gates.range_max_q16 => all.too_far += 1,
            _ => all.left += 1,
        }
    }
}

/// Where a ray would have crossed the next boundary: within its range only if that led out of the grid.
fn next_after_q16(placement: &Placement, dir_q15: [i32; 3], end: &End) -> u32 {
    let dir_q16 = std::array::from_fn(|r| direction_q16(placement.axis_q15[r], dir_q15));
    let mut march = start(placement.origin_q16, dir_q16);
    for _ in 0..end.crossings {
        let axis = next_axis(march.next_q16);
        march.next_q16[axis] = march.next_q16[axis].saturating_add(march.period_q16[axis]);
    }
    march.next_q16[next_axis(march.next_q16)]
}

/// How long a sweep would take by what some choices of poses took in the first moment, in seconds: so much for each pose
/// that is cast, and so much for each choice that is fused and counted. It is rather too much: what stands still from one
/// moment to the next, a sweep casts once. Scenes are ready by then.
///
/// # Errors
/// When the backend fails.
pub fn seconds(study: &Study, worlds: &[World], backend: &mut dyn Backend) -> Result<f64> {
    let all = layout_of(study).asks();
    let some = |which: &dyn Fn(usize) -> Vec<usize>| -> Vec<Ask> {
        let sizes = study.combinations.iter().map(|c| c.choices()).enumerate();
        let of_one = |(combination, choices)| {
            which(choices).into_iter().map(move |choice| Ask { combination, choice })
        };
        sizes.flat_map(of_one).collect()
    };
    let mut measure = |asks: &[Ask]| -> Result<f64> {
        let begin = Instant::now();
        run_asks(study, &worlds[..1], asks, Batch::FULL, backend, &mut Forgetful)?;
        Ok(begin.elapsed().as_secs_f64())
    };
    // What is made ready for the first choice is made ready once.
    let first = some(&|choices| spread(1, choices));
    measure(&first)?;
    let ready_s = measure(&first)?;
    let (mut most, mut asks, mut took_s) = (1, first.clone(), ready_s);
    while took_s < LONG_ENOUGH_S && asks.len() < all {
        most *= 4;
        asks = some(&|choices| spread(most, choices));
        took_s = measure(&asks)?;
    }
    // As many choices in a row share more of their poses, so that the two costs can be told apart.
    let in_a_row = some(&|choices| (0..most.min(choices)).collect());
    let poses = |asks: &[Ask]| poses(study, asks) as f64;
    let fewer = poses(&asks) - poses(&in_a_row);
    let each_pose_s = match fewer > 0.0 {
        true => (took_s - measure(&in_a_row)?).max(0.0) / fewer,
        false => (took_s - ready_s).max(0.0) / (poses(&asks) - poses(&first)).max(1.0),
    };
    let of_poses_s = each_pose_s * (poses(&asks) - poses(&first));
    let more = (asks.len() - first.len()).max(1) as f64;
    let each_choice_s = (took_s - ready_s - of_poses_s).max(0.0) / more;
    let members = study.combinations.iter().flat_map(|combination| &combination.members);
    let every =
        members.flat_map(|member| member.candidates.iter().map(|&candidate| (member.sensor, candidate)));
    let rest = every.collect::<HashSet<_>>().len() as f64 - poses(&first);
    let choices = all.saturating_sub(first.len()) as f64;
    Ok(worlds.len() as f64 * (ready_s + each_pose_s * rest + each_choice_s * choices))
}

/// How many different poses some choices have, each sensor for itself.
fn poses(study: &Study, asks: &[Ask]) -> usize {
    let of = |ask: &Ask| {
        let combination = &study.combinations[ask.combination];
        let sensors = combination.members.iter().map(|member| member.sensor);
        sensors.zip(combination.choice(ask.choice)).collect::<Vec<_>>()
    };
    asks.iter().flat_map(of).collect::<HashSet<_>>().len()
}

/// Wants everything and keeps nothing.
struct Forgetful;

impl Ledger for Forgetful {
    fn wants(&self, _: &World, _: usize, _: &Ask) -> bool {
        true
    }

    fn take(&mut self, _: &[Row]) -> Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
