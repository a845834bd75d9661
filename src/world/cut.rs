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
        if region.cut_share > 0.0 && is_open(world, region) { region.cut_share } else { 0.0 }
    };
    let cut: Vec<f64> = worlds.iter().map(open_share).collect();
    let (at, when) = largest(&cut);
    let (name, spec) = &study.regions[region];
    let sides = sides(worlds[at].regions[region].cut_at);
    let smaller = match spec {
        RegionSpec::RegionShape(RegionShape::HumanBox { .. }) => "take a smaller margin_m",
        RegionSpec::Separation { .. } => "take what is said of it as a bound",
        _ => "make the region smaller there",
    };
    let bounds = if study.bounds_m.is_some() { "widen bounds_m of [grid]" } else { "set bounds_m of [grid]" };
    let percent = 100.0 * cut[at];
    (percent > 0.0).then(|| {
        format!(
            "region {name:?}: {percent:.1} % of it lies outside the grid ({sides}) and is not counted{when}: no loss \
             if the cell ends there; if not, {bounds}, or {smaller}"
        )
    })
}

/// Whether a region leaves the grid on a side that no wall, floor or ceiling closes.
fn is_open(world: &World, region: &Region) -> bool {
    let truth = world.truth();
    // People and robots stand on floors, and share voxels with them.
    let mut fixed = BitGrid::new(truth.grid.window());
    let fixtures = truth.objects.iter().filter(|object| object.role == Role::Environment);
    fixtures.for_each(|object| fixed.add(&object.voxels));
    fixed.keep(&truth.occupied);
    let depth = (WALL_M / world.grid.voxel_size_m).ceil() as i32;
    let bounds = region.voxels.bounds();
    (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]).filter(|&(axis, end)| region.cut_at[axis][end]).any(
        |(axis, end)| {
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
        },
    )
}

/// The sides of the grid in words, from whether something goes beyond the low and the high end of each axis.
fn sides(beyond: [[bool; 2]; 3]) -> String {
    let names = [["towards -x", "towards +x"], ["towards -y", "towards +y"], ["below", "above"]];
    // Floors and ceilings are what is cut off most often.
    let order = [2, 0, 1].into_iter().flat_map(|axis| [0, 1].map(|end| (axis, end)));
    let cut: Vec<&str> =
        order.filter(|&(axis, end)| beyond[axis][end]).map(|(axis, end)| names[axis][end]).collect();
    cut.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_are_named_with_floor_and_ceiling_first() {
        assert_eq!(sides([[true, false], [false; 2], [true, false]]), "below, towards -x");
        assert_eq!(
            sides([[false, true], [true, true], [false, true]]),
            "above, towards +x, towards -y, towards +y"
        );
        assert_eq!(sides([[false; 2]; 3]), "");
    }
}
