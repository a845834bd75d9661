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

use crate::watch::Listener;

/// How many voxels a grid has along each axis, and of each the label and whether a return comes from it, x the fastest.
type Labels = ([u32; 3], Vec<u8>, Vec<bool>);

/// Most choices that are cast together: between them Python may stop it.
const AT_ONCE: usize = 16;

/// The labels of choices of poses in worlds, which are given by numbers; those of the same world follow each other.
pub(crate) fn all(
    study: &Study,
    worlds: &[World],
    views: &[(usize, [usize; 4])],
    backend: &mut dyn Backend,
    listener: &Listener,
) -> Result<Vec<Labels>> {
    let mut viewer = Viewer::new(study, backend)?;
    let mut all = Vec::with_capacity(views.len());
    let of_worlds = views.chunk_by(|(one, _), (next, _)| one == next);
    for of_one in of_worlds.flat_map(|of_one| of_one.chunks(AT_ONCE)) {
        listener.check_stop()?;
        let choice = |&(_, [combination, choice, representation, repeat]): &(usize, [usize; 4])| Choice {
            combination,
            choice,
            representation,
            repeat,
        };
        let choices: Vec<Choice> = of_one.iter().map(choice).collect();
        let world = &worlds[of_one[0].0];
        let seen = viewer.view_grid(world, &choices)?;
        let hits = |view: &View| bytes(world, &view.labels.hits);
        all.extend(seen.iter().map(|view| (world.grid.size, view.label_bytes(), hits(view))));
        listener.advance(of_one.len() as u64);
    }
    Ok(all)
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
    let [nx, ny, nz] = world.grid.size.map(|n| n as usize);
    let mut bytes = vec![false; nx * ny * nz];
    for [x, y, z] in plane.to_window(world.grid.window()).voxels() {
        bytes[x as usize + nx * (y as usize + ny * z as usize)] = true;
    }
    bytes
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
