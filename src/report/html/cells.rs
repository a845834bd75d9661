//! The cell in voxels for the page's 3D view: what is there at some moments, and what the sensors of the best choices say of
//! the regions. Which of it is drawn is the script's business.

use std::collections::BTreeSet;

use serde::Serialize;

use super::packed::put_runs;
use super::ranking::Ranking;
use crate::Result;
use crate::backend::Backend;
use crate::report::{Results, Score, snapshots};
use crate::study::Study;
use crate::sweep::World;
use crate::view::{Choice, View};
use crate::voxel::BitGrid;

/// Most bytes of voxels before they are compressed; less than half of that after.
const MOST_BYTES: usize = 24 << 20;

/// A part of the bytes.
type Part = [usize; 2];

/// The scene at a moment. Voxels follow with x fastest, then y, then z.
#[derive(Debug, Serialize)]
struct Moment {
    moment: usize,
    /// World key of the first voxel.
    origin: [i32; 3],
    size: [u32; 3],
    /// Classes: 0 free, 1 environment, 2 robot, 3 human, 4 of no region.
    truth: Part,
    /// For each region, 1 where a voxel belongs to it.
    regions: Vec<Part>,
}

/// What is said of a choice at a moment.
#[derive(Debug, Serialize)]
struct Labels {
    series: usize,
    choice: usize,
    moment: usize,
    /// Classes of the voxels that are in any region, in their order: 0 unknown, 1 free, 2 occupied.
    labels: Part,
}

/// Everything, and where in the bytes it is.
#[derive(Debug, Default, Serialize)]
pub(super) struct Cells {
    moments: Vec<Moment>,
    labels: Vec<Labels>,
    #[serde(skip)]
    pub(super) bytes: Vec<u8>,
}

/// A choice of poses to look at, at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Sight {
    series: usize,
    choice: usize,
    moment: usize,
}

/// Looks at the best choices of each region and representation, as many as are wanted and fit, in each scene's first
/// moment and in the one where the choice is worst. Says how many of how many are done after each.
///
/// # Errors
/// Those of the backend.
pub(super) fn look(
    (study, worlds): (&Study, &[World]),
    (results, rankings): (&Results, &[Ranking]),
    most: usize,
    backend: &mut dyn Backend,
    said: &mut dyn FnMut(usize, usize),
) -> Result<Cells> {
    let mut cells = Cells::default();
    results.scenes.iter().for_each(|scene| cells.put_moment(worlds, scene.moments.start));
    let sights = sights(results, rankings, most);
    for (done, sight) in sights.iter().enumerate() {
        if cells.bytes.len() > MOST_BYTES {
            break;
        }
        cells.put_moment(worlds, sight.moment);
        let series = rankings[sight.series].series;
        let (combination, representation) = (series.combination, series.representation);
        let choice = Choice { combination, choice: sight.choice, representation, repeat: 0 };
        let world = &worlds[sight.moment];
        let view = View::new(study, world, choice, backend)?;
        let (occupied, free) = (&view.labels.occupied, &view.labels.free);
        let of = |voxel| if occupied.get(voxel) { 2 } else { u8::from(free.get(voxel)) };
        let begin = cells.bytes.len();
        put_runs(anywhere(world).cells().map(of), &mut cells.bytes);
        let Sight { series, choice, moment } = *sight;
        cells.labels.push(Labels { series, choice, moment, labels: [begin, cells.bytes.len()] });
        said(done + 1, sights.len());
    }
    Ok(cells)
}

/// What is worth looking at, the best first.
fn sights(results: &Results, rankings: &[Ranking], most: usize) -> Vec<Sight> {
    let (mut known, mut sights) = (BTreeSet::new(), Vec::new());
    for rank in 0..most {
        for (series, ranking) in rankings.iter().enumerate() {
            for (region, best) in ranking.by_region.iter().enumerate() {
                let Some(&(choice, _)) = best.get(rank) else { continue };
                let key = ranking.series.key(choice, region);
                for scene in &results.scenes {
                    let worst = snapshots::worst_snapshot(results, scene, key, Score::F1);
                    let moments =
                        [Some(scene.moments.start), worst.map(|snapshot| scene.moments.start + snapshot)];
                    let all = moments.into_iter().flatten().map(|moment| Sight { series, choice, moment });
                    sights.extend(all.filter(|&sight| known.insert(sight)));
                }
            }
        }
    }
    sights
}

/// The voxels of all regions.
fn anywhere(world: &World) -> BitGrid {
    let mut all = BitGrid::new(world.truth.grid.window());
    world.regions.iter().for_each(|region| all.add(&region.cells));
    all
}

impl Cells {
    /// Adds the scene at a moment, once.
    fn put_moment(&mut self, worlds: &[World], moment: usize) {
        if self.moments.iter().any(|known| known.moment == moment) {
            return;
        }
        let (truth, grid) = (&worlds[moment].truth, worlds[moment].truth.grid);
        let voxels = || BitGrid::full(grid.window());
        let role = |voxel| match () {
            _ if truth.ignored.get(voxel) => 4,
            _ if !truth.occupied.get(voxel) => 0,
            _ if truth.human.get(voxel) => 3,
            _ if truth.robot.get(voxel) => 2,
            _ => 1,
        };
        let truth = self.put(voxels().cells().map(role));
        let regions = &worlds[moment].regions;
        let regions =
            regions.iter().map(|r| self.put(voxels().cells().map(|voxel| r.cells.get(voxel).into())));
        let regions = regions.collect();
        self.moments.push(Moment { moment, origin: grid.origin, size: grid.size, truth, regions });
    }

    fn put(&mut self, classes: impl Iterator<Item = u8>) -> Part {
        let begin = self.bytes.len();
        put_runs(classes, &mut self.bytes);
        [begin, self.bytes.len()]
    }
}
