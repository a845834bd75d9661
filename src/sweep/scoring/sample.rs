//! A few poses of a study, cast before its sweep: the ends of their rays, and the estimated time of all.

use std::collections::HashSet;
use std::time::Instant;

use super::compare::spread;
use super::{BatchSize, Ledger, Row, run_choices};
use crate::results::{PoseChoice, layout_of};
use perirobot_march::Result;
use perirobot_march::backend::{Backend, GridPose, Rays};
use perirobot_march::march::{BLIND, End, LEFT, NEVER, RETURN, crossings};
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::Study;
use perirobot_study::world::{World, ray_tables_of};

/// Sampled moments of a study, evenly spaced.
const MOMENTS: usize = 4;
/// Sampled sensors of a study, evenly spaced.
pub const SENSORS: usize = 1000;
/// Timed combinations, evenly spaced.
const COMBINATIONS: usize = 1000;
/// Sampled rays of a pose, evenly spaced.
const RAYS: usize = 20_000;
/// Least duration of a reliable measurement, in seconds.
const LONG_ENOUGH_S: f64 = 0.5;
/// Rows of choices that share their poses.
const ROWS: usize = 8;
/// Least difference in seconds between choices that share their poses and choices that do not.
const IN_A_ROW_S: f64 = 1.5;

/// The ends of a sensor's rays, at some of its poses.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EndCounts {
    /// Cast poses, in each moment.
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

impl EndCounts {
    /// All sampled rays.
    pub fn rays(&self) -> u64 {
        self.returns + self.too_near + self.too_far + self.left
    }
}

/// The ends of each sensor's rays, at this many of its poses, evenly spaced; empty for a sensor without rays, and for
/// one that is not among the [`SENSORS`] sampled ones.
///
/// # Errors
/// If the backend fails.
pub fn ends(
    study: &Study,
    worlds: &[World],
    poses: usize,
    backend: &mut dyn Backend,
) -> Result<Vec<EndCounts>> {
    let mut all = vec![EndCounts::default(); study.sensors.len()];
    let looked_at = spread(SENSORS, study.sensors.len());
    let tables = ray_tables_of(study, |sensor| looked_at.binary_search(&sensor).is_ok());
    backend.tables(&tables.iter().flatten().cloned().collect::<Vec<_>>())?;
    for moment in spread(MOMENTS, worlds.len()) {
        let world = &worlds[moment];
        backend.load(&world.scene(window_of(&world.regions)))?;
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

fn add(all: &mut EndCounts, rays: &Rays, placement: &GridPose, ends: &[End]) {
    all.poses += 1;
    let step = rays.dirs_q15.len().div_ceil(RAYS).max(1);
    for (dir_q15, end) in rays.dirs_q15.iter().zip(ends).step_by(step) {
        match end.kind {
            RETURN => all.returns += 1,
            BLIND => all.too_near += 1,
            LEFT => all.left += 1,
            _ if next_after_q16(placement, *dir_q15, end)
                > rays.gates.ray_gates(dir_q15[2]).range_max_q16 =>
            {
                all.too_far += 1
            }
            _ => all.left += 1,
        }
    }
}

/// The distance at which a ray would have crossed the next boundary: it is within the range only if the ray left the
/// grid.
fn next_after_q16(placement: &GridPose, dir_q15: [i32; 3], end: &End) -> u32 {
    let mut after = crossings(placement.launch(dir_q15)).skip(end.crossings as usize);
    after.next().map_or(NEVER, |crossing| crossing.t_q16)
}

/// The backend that recounts a device's counts, and its share of choices.
pub struct Checker<'a> {
    /// The backend.
    pub backend: &'a mut dyn Backend,
    /// One choice in this many.
    pub every: u64,
}

/// Estimates the duration of a sweep, in seconds, from the time of some choices of poses: a time per cast pose, one per
/// fused and counted choice, and the time of a checker. Without the preparation of scenes.
///
/// # Errors
/// If a backend fails.
pub fn seconds(
    study: &Study,
    worlds: &[World],
    backend: &mut dyn Backend,
    checker: Option<Checker>,
) -> Result<f64> {
    let layout = layout_of(study);
    let all = layout.pose_choices();
    let timed = spread(COMBINATIONS, study.combinations.len());
    let sizes = timed.into_iter().map(|c| (c, study.combinations[c].choices())).collect::<Vec<_>>();
    let most_asks: usize = sizes.iter().map(|(_, choices)| choices).sum();
    let some = |which: &dyn Fn(usize) -> Vec<usize>| -> Vec<PoseChoice> {
        let sizes = sizes.iter().copied();
        let pose_choices = |(combination, choices)| {
            which(choices).into_iter().map(move |choice| PoseChoice { combination, choice })
        };
        sizes.flat_map(pose_choices).collect()
    };
    let here = &worlds[..1];
    // The first choice takes longer, since it includes the preparation of the scene.
    let mut apart = some(&|choices| spread(1, choices));
    let first = apart[..1].to_vec();
    let warm_s = took_s(study, here, &first, backend)?;
    let ready_s = took_s(study, here, &first, backend)?.min(warm_s);
    let (mut most, mut apart_s) = (1, took_s(study, here, &apart, backend)?);
    while apart_s < LONG_ENOUGH_S && apart.len() < most_asks {
        most *= 4;
        apart = some(&|choices| spread(most, choices));
        apart_s = took_s(study, here, &apart, backend)?;
    }
    // Consecutive choices share most of their poses: their time shows the cost of a choice without its poses, which
    // matters for millions of choices.
    let (mut in_a_row, mut in_a_row_s) = (apart.clone(), apart_s);
    let shares_poses = study.combinations.iter().any(|combination| combination.members.len() > 1);
    while shares_poses && apart.len() < most_asks {
        in_a_row = some(&|choices| rows_of(most, choices));
        in_a_row_s = took_s(study, here, &in_a_row, backend)?;
        if in_a_row_s >= apart_s + IN_A_ROW_S || in_a_row.len() >= most_asks {
            break;
        }
        most *= 4;
    }
    let extra = |pose_choices: &[PoseChoice]| {
        [poses(study, pose_choices) - poses(study, &first), pose_choices.len() - first.len()]
            .map(|count| count as f64)
    };
    let each = solve_two([extra(&apart), extra(&in_a_row)], [apart_s - ready_s, in_a_row_s - ready_s]);
    let members = study.combinations.iter().flat_map(|combination| &combination.members);
    let every =
        members.flat_map(|member| member.candidates.iter().map(|&candidate| (member.sensor, candidate)));
    let rest = [every.collect::<HashSet<_>>().len() - poses(study, &first), all - first.len()];
    let moment_s = ready_s + each[0] * rest[0] as f64 + each[1] * rest[1] as f64;
    // First hits on static objects are cast once for all moments of a scene.
    let again = match worlds {
        [one, two, ..] if one.scene == two.scene => {
            (took_s(study, &worlds[..2], &apart, backend)? / apart_s - 1.0).clamp(0.0, 1.0)
        }
        _ => 1.0,
    };
    let scenes = worlds.chunk_by(|a, b| a.scene == b.scene).count() as f64;
    let moments = scenes + again * (worlds.len() as f64 - scenes);
    let checks_s = match checker {
        Some(Checker { backend, every }) => {
            let some = some(&|choices| spread(4, choices));
            let each_s = took_s(study, here, &some, backend)? / (some.len() * study.repeats as usize) as f64;
            each_s * (layout.blocks() * all) as f64 / every as f64
        }
        None => 0.0,
    };
    Ok(moment_s * moments + checks_s)
}

/// About this many choices, in runs with evenly spaced starts, since the first poses may not be typical.
fn rows_of(most: usize, choices: usize) -> Vec<usize> {
    let each = most.div_ceil(ROWS);
    let rows = spread(ROWS, choices).into_iter().map(|first| first..(first + each).min(choices));
    let mut all: Vec<usize> = rows.flatten().collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The time of some choices in these worlds.
fn took_s(
    study: &Study,
    worlds: &[World],
    pose_choices: &[PoseChoice],
    backend: &mut dyn Backend,
) -> Result<f64> {
    let begin = Instant::now();
    run_choices(study, worlds, pose_choices, BatchSize::FULL, backend, &mut Forgetful)?;
    Ok(begin.elapsed().as_secs_f64())
}

/// The time of each of two kinds of work, never negative, from two measurements of mixtures of both. If both mixtures
/// are the same, all time counts as the first kind's.
fn solve_two([a, b]: [[f64; 2]; 2], took_s: [f64; 2]) -> [f64; 2] {
    let area = a[0] * b[1] - b[0] * a[1];
    let alone = |kind: usize| {
        let each = (took_s[0] + took_s[1]).max(0.0) / (a[kind] + b[kind]).max(1.0);
        if kind == 0 { [each, 0.0] } else { [0.0, each] }
    };
    if area.abs() <= 1e-9 * (a[0] * b[1]).max(1.0) {
        return alone(0);
    }
    let each = [(took_s[0] * b[1] - took_s[1] * a[1]) / area, (took_s[1] * a[0] - took_s[0] * b[0]) / area];
    match each {
        [pose, _] if pose < 0.0 => alone(1),
        [_, choice] if choice < 0.0 => alone(0),
        each => each,
    }
}

/// The number of different poses of some choices, sensor by sensor.
fn poses(study: &Study, pose_choices: &[PoseChoice]) -> usize {
    let poses_of = |pose_choice: &PoseChoice| {
        let combination = &study.combinations[pose_choice.combination];
        let sensors = combination.members.iter().map(|member| member.sensor);
        sensors.zip(combination.choice(pose_choice.choice)).collect::<Vec<_>>()
    };
    pose_choices.iter().flat_map(poses_of).collect::<HashSet<_>>().len()
}

/// Wants all rows and stores none.
struct Forgetful;

impl Ledger for Forgetful {
    fn wants(&self, _: &World, _: usize, _: &PoseChoice) -> bool {
        true
    }

    fn take(&mut self, _: &[Row]) -> Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
