//! Warns of regions that the grid cuts off where no wall, floor or ceiling does.

use super::World;
use super::place::WALL_M;
use super::warnings::largest;
use crate::scene::Role;
use crate::study::{RegionSpec, Study};
use crate::truth::{Region, RegionShape};
use crate::voxel::BitGrid;

/// A larger share of the places where a region leaves the grid is behind a surface if that side of the cell is closed.
const CLOSED: f64 = 0.9;

/// How much of a region the grid cuts off, where, and what to do if that matters; in the snapshot where it is
/// most. What is below a floor, above a ceiling or behind a wall does not count.
pub fn cut_warning(study: &Study, worlds: &[World], region: usize) -> Option<String> {
    let open_share = |world: &World| {
        let region = &world.regions[region];
        let is_open = region.cut_share > 0.0 && !open_sides(world, region).is_empty();
        if is_open { region.cut_share } else { 0.0 }
    };
    let cut: Vec<f64> = worlds.iter().map(open_share).collect();
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
        let sides = open_sides(&worlds[at], &worlds[at].regions[region]).join(", ");
        format!(
            "region {name:?}: {percent:.1} % of it lies outside the grid ({sides}) and is not counted{when}: no loss \
             if the cell ends there; if not, {bounds}, or {smaller}"
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

/// The sides on which a region leaves the grid and no wall, floor or ceiling closes the cell.
fn open_sides(world: &World, region: &Region) -> Vec<&'static str> {
    let truth = world.truth();
    // People and robots stand on floors, and share voxels with them.
    let mut fixed = BitGrid::new(truth.grid.window());
    let fixtures = truth.objects.iter().filter(|object| object.role == Role::Environment);
    fixtures.for_each(|object| fixed.add(&object.voxels));
    fixed.keep(&truth.occupied);
    let depth = (WALL_M / world.grid.voxel_size_m).ceil() as i32;
    let bounds = region.voxels.bounds();
    let is_open = |axis: usize, end: usize| {
        let (last, inwards) = if end == 0 { (0, 1) } else { (world.grid.size[axis] as i32 - 1, -1) };
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
