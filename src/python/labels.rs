//! Labels of whole grids as numpy arrays, of many choices of poses at once, and the truth beside them.

use numpy::npyffi::NPY_ORDER;
use numpy::{Element, PyArray1, PyArray3, PyArrayMethods};
use perirobot_decide::view::{Choice, View, Viewer};
use perirobot_march::Result;
use perirobot_march::backend::Backend;
use perirobot_march::progress::Progress;
use perirobot_march::voxel::BitGrid;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::watch::Listener;

/// A choice of poses in one world: the world's number, and those of combination, choice, representation and repeat.
pub(crate) type ViewNumbers = (usize, [usize; 4]);

/// The numbers of a scene and a snapshot, and their grid.
pub(crate) type WorldGrid = (usize, usize, [f64; 3], [u32; 3]);

/// How many voxels a grid has along each axis, and of each the label and whether a return comes from it, x the fastest.
type Labels = ([u32; 3], Vec<u8>, Vec<bool>);

/// Most choices that are cast together: between them Python may stop it.
const AT_ONCE: usize = 16;

/// The labels of choices of poses in worlds, which are given by numbers; those of the same world follow each other.
pub(crate) fn all(
    study: &Study,
    worlds: &[World],
    views: &[ViewNumbers],
    backend: &mut dyn Backend,
    listener: &Listener,
) -> Result<Vec<Labels>> {
    let mut all = Vec::with_capacity(views.len());
    each(study, worlds, views, backend, listener, |seen| {
        let of_view =
            |view: &View| (view.world.grid.size, view.label_bytes(), bytes(view.world, &view.labels.hits));
        all.par_extend(seen.par_iter().map(of_view));
        Ok(())
    })?;
    Ok(all)
}

/// Makes views of choices some at a time, and hands them over in their order.
fn each<'a>(
    study: &'a Study,
    worlds: &'a [World],
    views: &[ViewNumbers],
    backend: &mut dyn Backend,
    listener: &Listener,
    mut take: impl FnMut(&[View<'a>]) -> Result<()>,
) -> Result<()> {
    let mut viewer = Viewer::new(study, backend)?;
    let of_worlds = views.chunk_by(|(one, _), (next, _)| one == next);
    for of_one in of_worlds.flat_map(|of_one| of_one.chunks(AT_ONCE)) {
        listener.check_stop()?;
        let choice = |&(_, [combination, choice, representation, repeat]): &ViewNumbers| Choice {
            combination,
            choice,
            representation,
            repeat,
        };
        let choices: Vec<Choice> = of_one.iter().map(choice).collect();
        take(&viewer.view_grid(&worlds[of_one[0].0], &choices)?)?;
        listener.advance(of_one.len() as u64);
    }
    Ok(())
}

/// Writes labels of choices into rows of bytes, and whether a return comes from each voxel if rows are given for that.
/// Returns for each how many voxels are free, occupied and unknown. All worlds have as many voxels as a row has bytes.
pub(crate) fn write(
    (study, worlds): (&Study, &[World]),
    views: &[ViewNumbers],
    (labels, mut hits): (&mut [u8], Option<&mut [bool]>),
    backend: &mut dyn Backend,
    listener: &Listener,
) -> Result<Vec<[u64; 3]>> {
    let voxels = labels.len() / views.len().max(1);
    let (mut counts, mut done) = (Vec::with_capacity(views.len()), 0);
    each(study, worlds, views, backend, listener, |seen| {
        let rows = done * voxels..(done + seen.len()) * voxels;
        labels[rows.clone()]
            .par_chunks_exact_mut(voxels)
            .zip(seen)
            .for_each(|(row, view)| view.write_labels(row));
        if let Some(hits) = &mut hits {
            let of_view = |(row, view): (&mut [bool], &View)| set_bytes(view.world, &view.labels.hits, row);
            hits[rows].par_chunks_exact_mut(voxels).zip(seen).for_each(of_view);
        }
        counts.extend(seen.iter().map(|view| {
            let [free, occupied] = [&view.labels.free, &view.labels.occupied].map(BitGrid::count);
            [free, occupied, voxels as u64 - free - occupied]
        }));
        done += seen.len();
        Ok(())
    })?;
    Ok(counts)
}

/// The scene and snapshot of a world, and its grid: its corner in metres, and how many voxels it has.
pub(crate) fn grid(world: &World) -> WorldGrid {
    (world.scene, world.snapshot, world.grid.corner_m([0; 3]).to_array(), world.grid.size)
}

/// What is truly there in a world: the voxels that are occupied, those of people, of the robot, and of each region.
pub(crate) fn truth(world: &World) -> Vec<Vec<bool>> {
    let truth = world.truth();
    let regions = world.regions.iter().map(|region| &*region.voxels);
    let planes = [&*truth.occupied, &truth.human, &truth.robot].into_iter().chain(regions);
    planes.map(|plane| bytes(world, plane)).collect()
}

/// A byte for each voxel of a world's grid, x the fastest.
fn bytes(world: &World, plane: &BitGrid) -> Vec<bool> {
    let mut bytes = vec![false; world.grid.size.iter().map(|&n| n as usize).product()];
    set_bytes(world, plane, &mut bytes);
    bytes
}

/// Writes whether each voxel of a world's grid is set, x the fastest.
fn set_bytes(world: &World, plane: &BitGrid, bytes: &mut [bool]) {
    let [nx, ny, _] = world.grid.size.map(|n| n as usize);
    bytes.fill(false);
    for [x, y, z] in plane.to_window(world.grid.window()).voxels() {
        bytes[x as usize + nx * (y as usize + ny * z as usize)] = true;
    }
}

/// A value for each voxel as an array of the grid's shape: labels as uint8, 1 occupied, 0 free, 255 unknown; planes of the
/// truth as bool. The bytes are handed over, not copied.
pub(crate) fn array<'py, T: Element>(
    py: Python<'py>,
    size: [u32; 3],
    labels: Vec<T>,
) -> PyResult<Bound<'py, PyArray3<T>>> {
    PyArray1::from_vec(py, labels).reshape_with_order(size.map(|n| n as usize), NPY_ORDER::NPY_FORTRANORDER)
}
