//! Every backend on the same poses, every integer compared: counts, both bit planes over the whole grid, and how
//! each ray ended. The oracle is right by definition; the first difference is explained.

use std::time::{Duration, Instant};

use super::World;
use crate::backend::oracle::Oracle;
use crate::backend::{Backend, Cell, Evidence, Fusion, Placement, Rays, Reading, Slot};
use crate::march::{self, End};
use crate::metrics::Confusion;
use crate::sensor::Sensor;
use crate::study::Study;
use crate::voxel::BitGrid;
use crate::{Error, Result};

/// Which poses are compared.
#[derive(Clone, Debug)]
pub enum Selection {
    /// This many of each scene and sensor, spread evenly over the study's order.
    Spread(usize),
    /// The pose of this name.
    Named(String),
    /// All of them.
    All,
}

/// What one backend did on one scene and sensor.
#[derive(Clone, Debug)]
pub struct Line {
    /// The scene's name.
    pub scene: String,
    /// The sensor's name.
    pub sensor: String,
    /// The backend's name.
    pub backend: &'static str,
    /// Poses compared.
    pub poses: usize,
    /// Rays cast.
    pub rays: u64,
    /// Voxels of the grid.
    pub voxels: u64,
    /// Counts, plane bits and ray ends that differ from the oracle's.
    pub differences: u64,
    /// Time to score the poses: cast, carve and count.
    pub time: Duration,
}

/// The outcome of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// One line for each scene, sensor and backend.
    pub lines: Vec<Line>,
    /// The first difference in study order, explained.
    pub first_difference: Option<String>,
}

/// The poses of a sensor that a selection names, as indices.
pub fn select(selection: &Selection, sensor: &Sensor) -> Vec<usize> {
    let count = sensor.candidates.len();
    match selection {
        Selection::All => (0..count).collect(),
        Selection::Spread(wanted) => {
            let wanted = (*wanted).min(count);
            (0..wanted).map(|i| i * count / wanted).collect()
        }
        Selection::Named(name) => {
            // As in poses.csv, or with its sensor as in results.csv.
            let own = name.strip_prefix(&format!("{}:", sensor.name)).unwrap_or(name);
            (0..count).filter(|&i| sensor.candidates[i].name == own).collect()
        }
    }
}

/// Runs the oracle and each backend on one scene and sensor, and adds to the report.
pub fn compare(
    study: &Study,
    world: &World,
    sensor: &Sensor,
    selection: &Selection,
    backends: &mut [Box<dyn Backend>],
    report: &mut Report,
) -> Result<()> {
    let cell = world.cell(world.truth.grid.window());
    let rays = sensor.rays(study.voxel_size_m, study.backdrop);
    let poses = select(selection, sensor);
    if poses.is_empty() {
        return Ok(());
    }
    let placements: Vec<Placement> =
        poses.iter().map(|&p| sensor.placement(&sensor.candidates[p].pose, &world.truth.grid)).collect();
    let mut oracle = Oracle::default();
    let (counts, time) = timed(&mut oracle, &cell, &rays, &placements)?;
    let line = Line {
        scene: world.name.clone(),
        sensor: sensor.name.clone(),
        backend: oracle.name(),
        poses: poses.len(),
        rays: (poses.len() * rays.dirs_q15.len()) as u64,
        voxels: world.truth.grid.window().volume(),
        differences: 0,
        time,
    };
    report.lines.push(line.clone());
    for backend in backends {
        let (found, time) = timed(backend.as_mut(), &cell, &rays, &placements)?;
        if found.len() != placements.len() {
            let what = format!("answered for {} of {} poses", found.len(), placements.len());
            return Err(Error::Device(format!("backend {}: {what}", backend.name())));
        }
        let mut differences = 0;
        for (i, placement) in placements.iter().enumerate() {
            let expected = (&oracle.read(0, placement)?, &counts[i]);
            let got = (&backend.read(0, placement)?, &found[i]);
            let here = count_differences(expected, got);
            if here > 0 && report.first_difference.is_none() {
                let place = format!(
                    "scene {}, pose {}:{}, {} against the oracle",
                    world.name,
                    sensor.name,
                    sensor.candidates[poses[i]].name,
                    backend.name()
                );
                let why = explain(&cell, &rays, placement, expected, got)?;
                report.first_difference = Some(format!("{place}: {why}"));
            }
            differences += here;
        }
        report.lines.push(Line { backend: backend.name(), differences, time, ..line.clone() });
    }
    Ok(())
}

/// Loads and scores; the time is that of scoring.
fn timed(
    backend: &mut dyn Backend,
    cell: &Cell,
    rays: &Rays,
    placements: &[Placement],
) -> Result<(Vec<Vec<Confusion>>, Duration)> {
    backend.tables(std::slice::from_ref(rays))?;
    backend.load(cell)?;
    let begin = Instant::now();
    let mut counts = Vec::new();
    for batch in placements.chunks(backend.slots()) {
        let shots: Vec<(Slot, Placement)> = (0..).zip(batch.iter().copied()).collect();
        backend.sense(0, &shots)?;
        let alone = |&(slot, _): &(Slot, _)| vec![Reading { slot, volume: None, hit: 1, miss: -1 }];
        let jobs: Vec<_> = shots.iter().map(alone).collect();
        counts.extend(backend.score(Fusion::OccupiedWins, &jobs)?);
    }
    Ok((counts, begin.elapsed()))
}

/// The evidence and the counts of one pose.
type Said<'a> = (&'a Evidence, &'a Vec<Confusion>);

/// Counts, plane bits and ends that differ; what one side lacks differs too.
fn count_differences((expected, counts): Said, (got, found): Said) -> u64 {
    let bits = |a: &BitGrid, b: &BitGrid| {
        let (mut only_a, mut only_b) = (a.clone(), b.clone());
        only_a.remove(b);
        only_b.remove(a);
        only_a.count() + only_b.count()
    };
    let flat = |all: &[Confusion]| -> Vec<u64> { all.iter().flat_map(Confusion::counts).collect() };
    bits(&expected.planes.occupied, &got.planes.occupied)
        + bits(&expected.planes.free, &got.planes.free)
        + unequal(&expected.ends, &got.ends)
        + unequal(&flat(counts), &flat(found))
}

/// How many places of two lists differ, those included that only the longer one has.
fn unequal<T: PartialEq>(a: &[T], b: &[T]) -> u64 {
    (a.iter().zip(b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len())) as u64
}

/// Names the ray and the voxel of the first difference of a pose.
fn explain(
    cell: &Cell,
    rays: &Rays,
    placement: &Placement,
    (expected, counts): Said,
    (got, found): Said,
) -> Result<String> {
    let differs = |(_, (a, b)): &(usize, (&End, &End))| a != b;
    if let Some((ray, (a, b))) = expected.ends.iter().zip(&got.ends).enumerate().find(differs) {
        let dir = rays.dirs_q15[ray];
        let told = |end: &End| {
            let kind = match end.kind {
                march::RETURN => "a return",
                march::BLIND => "blind",
                march::LEFT => "a return outside",
                march::NOTHING => "nothing",
                _ => "no known end",
            };
            format!(
                "{kind} in voxel {:?} after {} crossings",
                cell_after(placement, dir, end.crossings),
                end.crossings
            )
        };
        return Ok(format!("ray {ray} (direction {dir:?}) ended as {}, expected {}", told(b), told(a)));
    }
    if expected.ends.len() != got.ends.len() {
        return Ok(format!("{} rays ended, expected {}", got.ends.len(), expected.ends.len()));
    }
    if expected.ends.len() != got.ends.len() {
        return Ok(format!("{} rays ended, expected {}", got.ends.len(), expected.ends.len()));
    }
    for (plane, a, b) in [
        ("occupied", &expected.planes.occupied, &got.planes.occupied),
        ("free", &expected.planes.free, &got.planes.free),
    ] {
        let (mut only_a, mut only_b) = (a.clone(), b.clone());
        only_a.remove(b);
        only_b.remove(a);
        let lost = only_a.cells().next().map(|v| (v, "is missing from"));
        if let Some((voxel, what)) = lost.or(only_b.cells().next().map(|v| (v, "should not be in"))) {
            let ray = marking_ray(cell, rays, placement, |e| {
                if plane == "free" { e.planes.free.get(voxel) } else { e.planes.occupied.get(voxel) }
            })?;
            let ray = ray.map_or("the oracle's rays do not mark it".into(), |r| {
                format!("ray {r} is the first that marks it")
            });
            return Ok(format!("voxel {voxel:?} {what} the {plane} plane; {ray}"));
        }
    }
    let unequal = counts.iter().zip(found).position(|(a, b)| a != b);
    let region = unequal.unwrap_or(counts.len().min(found.len()));
    let told = |all: &[Confusion]| all.get(region).map(Confusion::counts).unwrap_or_default();
    Ok(format!(
        "all rays and planes agree, the counts of region {region} (from 0) do not: {:?}, expected {:?} (tp fp fn tn uo uf, \
         then tp fn uo of the human and of the robot)",
        told(found),
        told(counts)
    ))
}

/// The cell of a ray after this many crossings.
fn cell_after(placement: &Placement, dir_q15: [i32; 3], crossings: u32) -> [i32; 3] {
    let dir_q16 = placement.axis_q15.map(|axis| march::direction_q16(axis, dir_q15));
    let mut ray = march::start(placement.origin_q16, dir_q16);
    for _ in 0..crossings {
        let axis = march::next_axis(ray.next_q16);
        if ray.next_q16[axis] > march::MAX_RANGE_VOXELS << 16 {
            break;
        }
        march::cross(&mut ray, axis);
    }
    ray.cell
}

/// The first ray with which the oracle's evidence has a mark. Marks only grow with the rays, so halving finds it.
fn marking_ray(
    cell: &Cell,
    rays: &Rays,
    placement: &Placement,
    marked: impl Fn(&Evidence) -> bool,
) -> Result<Option<usize>> {
    let mut oracle = Oracle::default();
    let mut marked_by = |first: usize| -> Result<bool> {
        oracle.tables(&[Rays { dirs_q15: rays.dirs_q15[..first].to_vec(), ..rays.clone() }])?;
        oracle.load(cell)?;
        Ok(marked(&oracle.read(0, placement)?))
    };
    let (mut without, mut with) = (0, rays.dirs_q15.len());
    if !marked_by(with)? {
        return Ok(None);
    }
    while with - without > 1 {
        let middle = (without + with) / 2;
        if marked_by(middle)? { with = middle } else { without = middle }
    }
    Ok(Some(without))
}

#[cfg(test)]
mod tests;
