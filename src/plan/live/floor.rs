//! How many sensors watch each spot of the floor.

use std::sync::Arc;

use perirobot_decide::approach::walked_surfaces;
use perirobot_march::backend::Planes;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// Up to which height above the floor a spot is counted, in metres: that of a tall person.
pub const PERSON_M: f64 = 2.0;

/// In a [`FloorMap`], a spot above which nothing is counted.
pub const NOT_COUNTED: u8 = u8::MAX;

/// How many sensors watch each spot of the floor: 0, 1, or 2 for more. A spot is a column of voxels of all regions together,
/// up to [`PERSON_M`] above the floor, those left out in which something is; with `floor = "auto"` above each surface that
/// bodies walk on, and nothing elsewhere. It is watched by as many sensors as label the voxel in it that
/// the fewest label: with 1, no voxel is blind; with 2, none is if any one sensor dies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FloorMap {
    /// The lowest column, from the corner of the grid.
    pub min: [i32; 2],
    /// How many columns there are along x and y.
    pub size: [u32; 2],
    /// Column by column, x the fastest.
    pub sensors: Vec<u8>,
    /// From which floor up to which height it counts, in words.
    pub counted: Arc<str>,
}

/// What a scene's floor map is counted above.
#[derive(Clone, Debug)]
pub(super) enum CarryingFloor {
    /// The one height of the floor.
    Level,
    /// Every surface that bodies walk on at some moment.
    Walked(BitGrid),
    /// The height of the lowest floor, because the surfaces are unknown for this reason.
    LowestOnly(String),
}

impl CarryingFloor {
    /// Of the snapshots of a scene.
    pub(super) fn new(study: &Study, worlds: &[World]) -> CarryingFloor {
        match walked_surfaces(study, worlds, &[]) {
            Ok(None) => CarryingFloor::Level,
            Ok(Some(surfaces)) => CarryingFloor::Walked(surfaces),
            Err(error) => CarryingFloor::LowestOnly(error.issue().to_string()),
        }
    }

    fn counted(&self, world: &World) -> String {
        match self {
            CarryingFloor::Level => format!("From the floor to {PERSON_M} m:"),
            CarryingFloor::Walked(_) => format!("From each floor that bodies walk on to {PERSON_M} m:"),
            CarryingFloor::LowestOnly(why) => format!(
                "Only from z {:.2} m to {PERSON_M} m above it, because other floors are unknown ({why}):",
                world.floor.z_m
            ),
        }
    }
}

/// The voxels of a moment that a floor map counts.
#[derive(Clone, Debug)]
pub(super) struct CountedFloor {
    voxels: BitGrid,
    /// As in [`FloorMap`].
    counted: Arc<str>,
}

impl CountedFloor {
    pub(super) fn new(world: &World, floor: &CarryingFloor) -> CountedFloor {
        let mut voxels = world.region_voxels();
        voxels.remove(&world.truth().occupied);
        match floor {
            CarryingFloor::Walked(surfaces) => voxels.keep(&above(world, surfaces)),
            CarryingFloor::Level | CarryingFloor::LowestOnly(_) => CountedFloor::keep_low(world, &mut voxels),
        }
        CountedFloor { voxels, counted: floor.counted(world).into() }
    }

    /// Keeps those from the floor's height up to a person's.
    fn keep_low(world: &World, voxels: &mut BitGrid) {
        let (grid, window) = (&world.grid, voxels.window());
        let top = ((world.floor.z_m + PERSON_M - grid.corner_m([0; 3]).z) / grid.voxel_size_m).round() as i32;
        let high = Window {
            min: [window.min[0], window.min[1], top.max(window.min[2])],
            size: [
                window.size[0],
                window.size[1],
                (window.end()[2] - top).clamp(0, window.size[2] as i32) as u32,
            ],
        };
        voxels.remove(&BitGrid::full(high));
    }

    /// The map for what sensors say, each over the window of the regions.
    pub(super) fn map<'p>(&self, said: impl Iterator<Item = &'p Planes>) -> FloorMap {
        let window = self.voxels.window();
        let (mut once, mut twice) = (BitGrid::new(window), BitGrid::new(window));
        for planes in said {
            let words = planes.occupied.words().iter().zip(planes.free.words());
            let seen = once.words_mut().iter_mut().zip(twice.words_mut());
            for ((once, twice), (occupied, free)) in seen.zip(words) {
                let labelled = occupied | free;
                *twice |= *once & labelled;
                *once |= labelled;
            }
        }
        let [nx, ny, nz] = window.size.map(|n| n as usize);
        let row = self.voxels.words_per_row() as usize;
        // Of each column a bit: whether it is counted, has a voxel that none labels, has one that fewer than two label.
        let mut columns = [(); 3].map(|()| vec![0u32; row * ny]);
        let [some, blind, single] = &mut columns;
        for z in 0..nz {
            let layer = z * row * ny..(z + 1) * row * ny;
            let [counted, once, twice] =
                [&self.voxels, &once, &twice].map(|plane| &plane.words()[layer.clone()]);
            let of_column = some.iter_mut().zip(blind.iter_mut()).zip(single.iter_mut());
            let voxels = counted.iter().zip(once).zip(twice);
            for (((some, blind), single), ((counted, once), twice)) in of_column.zip(voxels) {
                *some |= counted;
                *blind |= counted & !once;
                *single |= counted & !twice;
            }
        }
        let sensors = (0..ny).flat_map(|y| (0..nx).map(move |x| (y * row + x / 32, x % 32)));
        let sensors = sensors.map(|(word, bit)| {
            let [counted, blind, single] = [0, 1, 2].map(|which: usize| columns[which][word] >> bit & 1 == 1);
            match (counted, blind, single) {
                (false, ..) => NOT_COUNTED,
                (_, true, _) => 0,
                (.., true) => 1,
                _ => 2,
            }
        });
        let [x, y, _] = window.min;
        let counted = self.counted.clone();
        FloorMap { min: [x, y], size: [nx as u32, ny as u32], sensors: sensors.collect(), counted }
    }
}

/// The voxels up to a person's height above surfaces.
fn above(world: &World, surfaces: &BitGrid) -> BitGrid {
    let layers = (PERSON_M / world.grid.voxel_size_m).round() as i32;
    let mut above = BitGrid::new(surfaces.window());
    for [x, y, surface] in surfaces.voxels() {
        let column = (surface + 1..=surface + layers).map(|z| [x, y, z]);
        column.filter(|&voxel| surfaces.window().contains(voxel)).for_each(|voxel| above.set(voxel));
    }
    above
}
