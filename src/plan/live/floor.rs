//! How many sensors watch each spot of the floor.

use perirobot_march::backend::Planes;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_study::world::World;

/// Up to which height above the floor a spot is counted, in metres: that of a tall person.
pub const PERSON_M: f64 = 2.0;

/// In a [`FloorMap`], a spot above which nothing is counted.
pub const NOT_COUNTED: u8 = u8::MAX;

/// How many sensors watch each spot of the floor: 0, 1, or 2 for more. A spot is a column of voxels of all regions together,
/// up to [`PERSON_M`], those left out in which something is. It is watched by as many sensors as label the voxel in it that
/// the fewest label: with 1, no voxel is blind; with 2, none is if any one sensor dies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FloorMap {
    /// The lowest column, from the corner of the grid.
    pub min: [i32; 2],
    /// How many columns there are along x and y.
    pub size: [u32; 2],
    /// Column by column, x the fastest.
    pub sensors: Vec<u8>,
}

/// The voxels of a moment that a floor map counts.
#[derive(Clone, Debug)]
pub(super) struct CountedFloor(BitGrid);

impl CountedFloor {
    pub(super) fn new(world: &World) -> CountedFloor {
        let mut voxels = world.region_voxels();
        voxels.remove(&world.truth().occupied);
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
        CountedFloor(voxels)
    }

    /// The map for what sensors say, each over the window of the regions.
    pub(super) fn map<'p>(&self, said: impl Iterator<Item = &'p Planes>) -> FloorMap {
        let window = self.0.window();
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
        let row = self.0.words_per_row() as usize;
        // Of each column a bit: whether it is counted, has a voxel that none labels, has one that fewer than two label.
        let mut columns = [(); 3].map(|()| vec![0u32; row * ny]);
        let [some, blind, single] = &mut columns;
        for z in 0..nz {
            let layer = z * row * ny..(z + 1) * row * ny;
            let [counted, once, twice] = [&self.0, &once, &twice].map(|plane| &plane.words()[layer.clone()]);
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
        FloorMap { min: [x, y], size: [nx as u32, ny as u32], sensors: sensors.collect() }
    }
}
