//! Warns of regions that the grid cuts off where no wall, floor or ceiling does.

use super::World;
use super::place::WALL_M;
use super::warnings::largest;
use crate::input::{RegionSpec, Study};
use perirobot_march::voxel::{BitGrid, Grid};
use perirobot_scene::objects::Role;
use perirobot_scene::truth::{Region, RegionShape, Truth};

/// A larger share of the places where a region leaves the grid is behind a surface if that side of the cell is closed.
const CLOSED: f64 = 0.9;

/// How much of each of some regions the grid cuts off, where, and what to do if that matters; in the snapshot where it is
/// most. What is below a floor, above a ceiling or behind a wall does not count.
pub fn cut_warnings(study: &Study, worlds: &[World], regions: &[usize]) -> Vec<String> {
    // By world, so that the voxels of each moment are put together once for all regions.
    let sides: Vec<Vec<Vec<&str>>> = worlds.iter().map(|world| open_sides(world, regions)).collect();
    let warnings = regions.iter().enumerate().map(|(number, &region)| {
        let sides: Vec<&[&str]> = sides.iter().map(|of_world| &of_world[number][..]).collect();
        cut_warning(study, worlds, region, &sides)
    });
    warnings.flatten().collect()
}

/// The warning of one region, of which these sides are open in each world.
fn cut_warning(study: &Study, worlds: &[World], region: usize, sides: &[&[&str]]) -> Option<String> {
    let open_share = |(world, sides): (&World, &&[&str])| {
        if sides.is_empty() { 0.0 } else { world.regions[region].cut_share }
    };
    let cut: Vec<f64> = worlds.iter().zip(sides).map(open_share).collect();
    let (at, when) = largest(&cut);
    let (name, spec) = &study.regions[region];
    let smaller = match spec {
        RegionSpec::RegionShape(RegionShape::HumanBox { .. }) => "take a smaller margin_m",
        RegionSpec::Separation { .. } => "take what is said of it as a bound",
        _ => "make the region smaller there",
    };
    let bounds = if study.bounds_m.is_some() { "widen bounds_m of [grid]" } else { "set bounds_m of [grid]" };
    let percent = 100.0 * cut[at];
    (percent > 0.0).then(|| {
        let sides = sides[at].join(", ");
        format!(
            "region {name:?}: {percent:.1} % of it lies outside the grid ({sides}) and is not counted{when}: if nobody \
             can be there, leave it as it is; else {bounds}, or {smaller}"
        )
    })
}

/// The sides of the grid by axis and end, those first that are cut off most often: floor and ceiling.
const SIDES: [(usize, usize, &str); 6] = [
    (2, 0, "below"),
    (2, 1, "above"),
    (0, 0, "towards -x"),
    (0, 1, "towards +x"),
    (1, 0, "towards -y"),
    (1, 1, "towards +y"),
];

/// Of each of some regions the sides on which it leaves the grid and no wall, floor or ceiling closes the cell.
fn open_sides(world: &World, regions: &[usize]) -> Vec<Vec<&'static str>> {
    let regions = || regions.iter().map(|&region| &world.regions[region]);
    if regions().all(|region| region.cut_share == 0.0) {
        return regions().map(|_| Vec::new()).collect();
    }
    let fixed = fixtures(&world.truth());
    regions().map(|region| open_sides_of(region, &world.grid, &fixed)).collect()
}

/// The voxels of what closes a cell. People and robots stand on floors, and share voxels with them.
fn fixtures(truth: &Truth) -> BitGrid {
    let mut fixed = BitGrid::new(truth.grid.window());
    let fixtures = truth.objects.iter().filter(|object| object.role == Role::Environment);
    fixtures.for_each(|object| fixed.add(&object.voxels));
    fixed.keep(&truth.occupied);
    fixed
}

fn open_sides_of(region: &Region, grid: &Grid, fixed: &BitGrid) -> Vec<&'static str> {
    let depth = (WALL_M / grid.voxel_size_m).ceil() as i32;
    let bounds = region.voxels.bounds();
    let is_open = |axis: usize, end: usize| {
        let (last, inwards) = if end == 0 { (0, 1) } else { (grid.size[axis] as i32 - 1, -1) };
        let mut layer = bounds;
        (layer.min[axis], layer.size[axis]) = (last, 1);
        let (mut leaves, mut closed) = (0u32, 0u32);
        region.voxels.each_in(&layer.intersection(&bounds), |voxel| {
            let is_closed = (0..depth).any(|step| {
                let mut behind = voxel;
                behind[axis] += inwards * step;
                fixed.get(behind)
            });
            leaves += 1;
            closed += u32::from(is_closed);
        });
        leaves == 0 || f64::from(closed) < CLOSED * f64::from(leaves)
    };
    let is_cut = |(axis, end, _): &&(usize, usize, &str)| region.cut_at[*axis][*end] && is_open(*axis, *end);
    SIDES.iter().filter(is_cut).map(|(.., name)| *name).collect()
}
