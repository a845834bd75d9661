//! What stands so near before a sensor that it is not measured: rays that end there are blind.

use perirobot_march::voxel::{Grid, Window};

use super::World;
use crate::input::Study;
use crate::sensor::lens::Lens;
use crate::sensor::range::Along;
use crate::sensor::{Sensor, Setting};

/// The part of each region in which a body is too near to a sensor to be detected by it.
#[derive(Clone, Debug, PartialEq)]
pub struct NearBlindness {
    /// The nearest distance that the sensor measures, in metres.
    pub near_m: f64,
    /// What it is measured along.
    pub along: Along,
    /// For each region, its voxels that are in the field of view and nearer, and all of them.
    pub regions: Vec<[u64; 2]>,
    /// The columns of voxels of which one is in the field of view and nearer, and all columns of the grid: seen from above,
    /// the blind ring and the floor.
    pub floor: [u64; 2],
}

/// The lens of a sensor at a candidate in a world, if it has one.
pub fn lens_of(sensor: &Sensor, setting: &Setting) -> Option<Lens> {
    match setting {
        Setting::Pose(pose) => Lens::new(&*sensor.kind, pose),
        _ => None,
    }
}

/// What is too near to a sensor at a candidate. Walls in between do not count.
pub fn near_blindness(
    study: &Study,
    world: &World,
    [sensor, candidate]: [usize; 2],
) -> Option<NearBlindness> {
    let lens = lens_of(&study.sensors[sensor], &world.settings[sensor][candidate])?;
    let (near_m, along) = lens.near_m();
    let grid = &world.grid;
    let own = Grid::voxel_of(grid.position_q16(lens.position_m));
    let reach = (lens.near_reach_m() / grid.voxel_size_m).ceil() as i32 + 1;
    let around = Window::from_corners(own, own).grown(reach);
    let regions = world.regions.iter().map(|region| {
        let mut blind = 0;
        region.voxels.each_in(&around.intersection(&region.voxels.window()), |voxel| {
            let middle_m = grid.corner_m(voxel) + grid.voxel_size_m / 2.0;
            blind += u64::from(lens.is_too_near(middle_m));
        });
        [blind, region.voxels.count()]
    });
    let columns = around.intersection(&grid.window());
    let ([x, y, z], [x_end, y_end, z_end]) = (columns.min, columns.end());
    let is_blind = |voxel| lens.is_too_near(grid.corner_m(voxel) + grid.voxel_size_m / 2.0);
    let blind = (x..x_end)
        .flat_map(|x| (y..y_end).map(move |y| [x, y]))
        .filter(|[x, y]| (z..z_end).any(|z| is_blind([*x, *y, z])))
        .count();
    let floor = [blind as u64, u64::from(grid.size[0]) * u64::from(grid.size[1])];
    Some(NearBlindness { near_m, along, regions: regions.collect(), floor })
}

impl NearBlindness {
    /// The distance, with what it is measured along.
    pub fn describe_distance(&self) -> String {
        let along = if self.along == Along::Axis { " (depth)" } else { "" };
        format!("nearer than {} m{along}", self.near_m)
    }

    /// The regions that are blind in part, with their shares; `None` if no voxel of a region is.
    pub fn describe_regions(&self, study: &Study) -> Option<String> {
        let shares = study.regions.iter().zip(&self.regions).filter(|(_, [blind, _])| *blind > 0);
        let shares = shares.map(|((name, _), share)| format!("{} % of region {name:?}", percent(*share)));
        let shares: Vec<String> = shares.collect();
        (!shares.is_empty()).then(|| shares.join(", "))
    }

    /// The share of the floor above which something is blind, whatever its height; `None` if nothing in the grid is.
    pub fn describe_floor(&self) -> Option<String> {
        (self.floor[0] > 0).then(|| format!("{} % of the floor (seen from above)", percent(self.floor)))
    }

    /// The largest share of a region.
    pub fn largest_share(&self) -> f64 {
        let share = |[blind, all]: &[u64; 2]| *blind as f64 / (*all).max(1) as f64;
        self.regions.iter().map(share).fold(0.0, f64::max)
    }
}

/// A share above 0 in percent.
fn percent([some, all]: [u64; 2]) -> String {
    match 100.0 * some as f64 / all as f64 {
        little if little < 0.01 => "under 0.01".into(),
        percent => format!("{percent:.2}"),
    }
}

#[cfg(test)]
mod tests;
