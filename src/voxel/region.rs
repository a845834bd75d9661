//! Regions of interest: sets of voxels, those whose centre lies inside, decided in integers.

use super::BitGrid;
use super::grid::{MAX_VOXELS_PER_AXIS, ONE_Q16, Window, length_q16, point_q16};
use super::voxelize::Truth;
use crate::scene::Role;
use crate::{Error, Result};
use glam::DVec3;

/// What a region is, in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Centres strictly within a radius.
    Sphere {
        /// Middle of the sphere, in the world.
        center_m: DVec3,
        /// Radius.
        radius_m: f64,
    },
    /// Centres in a half-open box.
    Box {
        /// Lowest corner, included.
        min_m: DVec3,
        /// Highest corner, excluded.
        max_m: DVec3,
    },
    /// The bounding box of a human's voxels, grown on each side.
    HumanBox {
        /// Name of the object, or `None` for all humans of the scene together.
        object: Option<String>,
        /// How far it grows below, on each axis.
        margin_min_m: DVec3,
        /// How far it grows above, on each axis.
        margin_max_m: DVec3,
    },
}

/// A region of a scene, in voxels.
#[derive(Clone, Debug)]
pub struct Region {
    /// Its name in the study.
    pub name: String,
    /// Its voxels, over the smallest window that holds them.
    pub cells: BitGrid,
    /// The share of the shape's voxels that lie outside the grid, 0 to 1.
    pub cut_share: f64,
}

/// A row of voxels along x whose centres are inside a shape, wherever the grid is: y, z, first x, one past the last.
type Row = [i64; 4];

/// The voxels of a shape in a scene. Ignored insides belong to no region; a region left without voxels is an error.
pub fn region(name: &str, shape: &Shape, truth: &Truth) -> Result<Region> {
    let mut cells = BitGrid::new(truth.grid.window());
    let mut total = 0u64;
    each_row(name, shape, truth, &mut |[y, z, from, to]: Row| {
        total += (to - from).max(0) as u64;
        let cut = |x: i64| x.clamp(-1, MAX_VOXELS_PER_AXIS as i64 + 1) as i32;
        cells.set_run(cut(from), cut(to), cut(y), cut(z));
    })?;
    let inside = cells.count();
    if inside == 0 {
        let why = if total == 0 { "holds no voxel's centre" } else { "lies outside the grid" };
        return Err(Error::input(format!("region {name:?}"), format!("{why}; make it larger or move it")));
    }
    cells.remove(&truth.ignored);
    if cells.is_empty() {
        let what = "all its voxels are inside a body whose interior is ignored; if that body is the room itself, \
                    give it interior = \"free\"";
        return Err(Error::input(format!("region {name:?}"), what));
    }
    Ok(Region {
        name: name.into(),
        cells: cells.over(cells.bounds()),
        cut_share: (total - inside) as f64 / total as f64,
    })
}

/// Calls `emit` with every row of a shape.
fn each_row(name: &str, shape: &Shape, truth: &Truth, emit: &mut dyn FnMut(Row)) -> Result<()> {
    let grid = &truth.grid;
    match shape {
        Shape::Sphere { center_m, radius_m } => {
            let radius = length_q16(*radius_m, grid.voxel_size_m);
            if radius > 2047 * ONE_Q16 {
                let what =
                    format!("radius_m = {radius_m}: at most 2047 voxels ({} m)", 2047.0 * grid.voxel_size_m);
                return Err(Error::input(format!("region {name:?}"), what));
            }
            sphere_rows(grid.position_q16(*center_m), radius, emit);
            Ok(())
        }
        Shape::Box { min_m, max_m } => {
            box_rows(name, grid.position_q16(*min_m), grid.position_q16(*max_m), emit)
        }
        Shape::HumanBox { object, margin_min_m, margin_max_m } => {
            let bounds = human_bounds(name, object.as_deref(), truth)?;
            let margin = |m: &DVec3| point_q16(*m, grid.voxel_size_m);
            let (below, above) = (margin(margin_min_m), margin(margin_max_m));
            let low = std::array::from_fn(|r| bounds.min[r] as i64 * ONE_Q16 - below[r]);
            let high = std::array::from_fn(|r| bounds.end()[r] as i64 * ONE_Q16 + above[r]);
            box_rows(name, low, high, emit)
        }
    }
}

fn human_bounds(name: &str, object: Option<&str>, truth: &Truth) -> Result<Window> {
    let place = format!("region {name:?}");
    let bounds = match object {
        None => truth.human.bounds(),
        Some(wanted) => {
            let humans = || truth.objects.iter().filter(|o| o.role == Role::Human);
            let found = humans().find(|o| o.name == wanted).ok_or_else(|| {
                let known: Vec<_> = humans().map(|o| o.name.as_str()).collect();
                Error::input(
                    &place,
                    format!("human_box.object = {wanted:?}: the scene's humans are {known:?}"),
                )
            })?;
            found.cells.bounds()
        }
    };
    if bounds.is_empty() {
        return Err(Error::input(place, "human_box: no voxel of a human lies in the grid"));
    }
    Ok(bounds)
}

/// Rows of a sphere: centre distance² < radius².
fn sphere_rows(center: [i64; 3], radius: i64, emit: &mut dyn FnMut(Row)) {
    // Voxels whose centre may be within `reach` of `at` on one axis, both ends included.
    let span = |at: i64, reach: i64| {
        let first = -(-(at - reach - ONE_Q16 / 2)).div_euclid(ONE_Q16);
        (first, (at + reach - ONE_Q16 / 2).div_euclid(ONE_Q16))
    };
    let offset = |cell: i64, at: i64| (cell * ONE_Q16 + ONE_Q16 / 2 - at) as i128;
    let (z_first, z_last) = span(center[2], radius);
    let (y_first, y_last) = span(center[1], radius);
    for z in z_first..=z_last {
        for y in y_first..=y_last {
            let left = (radius as i128).pow(2) - offset(y, center[1]).pow(2) - offset(z, center[2]).pow(2);
            if left > 0 {
                // The largest whole x offset with x² < left.
                let reach = (left - 1).isqrt() as i64;
                let (first, last) = span(center[0], reach);
                emit([y, z, first, last + 1]);
            }
        }
    }
}

/// Rows of a half-open box.
fn box_rows(name: &str, low: [i64; 3], high: [i64; 3], emit: &mut dyn FnMut(Row)) -> Result<()> {
    // The first voxel whose centre is at or above a bound.
    let from = |bound: i64| -(-(bound - ONE_Q16 / 2)).div_euclid(ONE_Q16);
    let (first, end) = (low.map(from), high.map(from));
    if (0..3).any(|r| end[r] - first[r] > 4 * MAX_VOXELS_PER_AXIS as i64) {
        let what = format!("is over {} voxels long; is it in millimetres?", 4 * MAX_VOXELS_PER_AXIS);
        return Err(Error::input(format!("region {name:?}"), what));
    }
    for z in first[2]..end[2] {
        (first[1]..end[1]).for_each(|y| emit([y, z, first[0], end[0]]));
    }
    Ok(())
}

/// The window that holds all regions.
pub fn window_of(regions: &[Region]) -> Window {
    regions
        .iter()
        .map(|region| region.cells.window())
        .fold(Window::between([0; 3], [-1; 3]), |all, one| all.union(&one))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::Grid;

    /// An empty scene of 0.05 m voxels over the paper's cell.
    fn empty_cell() -> Truth {
        let grid = Grid { voxel_size_m: 0.05, origin: [-60, -40, 0], size: [121, 81, 61] };
        let blank = BitGrid::new(grid.window());
        Truth {
            grid,
            occupied: blank.clone(),
            blockers: blank.clone(),
            ignored: blank.clone(),
            human: blank.clone(),
            robot: blank,
            objects: Vec::new(),
        }
    }

    #[test]
    fn the_papers_regions_have_the_papers_sizes() {
        let truth = empty_cell();
        let robot = Shape::Sphere { center_m: DVec3::new(0.0, 0.0, 1.0), radius_m: 1.5 };
        let robot = region("robot", &robot, &truth).unwrap();
        assert_eq!(robot.cells.count(), 104_732);
        assert!(robot.cut_share > 0.0, "the floor cuts the sphere");
        let human = Shape::Box { min_m: DVec3::new(-0.25, -1.45, 0.0), max_m: DVec3::new(0.9, 0.0, 1.95) };
        let human = region("human", &human, &truth).unwrap();
        assert_eq!((human.cells.count(), human.cut_share), (26_013, 0.0));
    }

    #[test]
    fn a_small_sphere_is_counted_by_hand() {
        let truth = empty_cell();
        // Around a voxel's centre: strictly within 1 voxel there is only the voxel itself; just over 1, seven.
        let at = |radius_m| {
            let shape = Shape::Sphere { center_m: DVec3::new(0.025, 0.025, 1.025), radius_m };
            region("ball", &shape, &truth).map(|r| (r.cells.count(), r.cells.window().min))
        };
        assert_eq!(at(0.05).unwrap(), (1, [60, 40, 20]));
        assert_eq!(at(0.0501).unwrap(), (7, [59, 39, 19]));
    }

    #[test]
    fn a_human_box_grows_by_its_margins() {
        let mut truth = empty_cell();
        truth.human.set([60, 40, 10]);
        truth.human.set([62, 40, 30]);
        let margin = DVec3::new(0.3, 0.1, 0.0);
        let shape = Shape::HumanBox { object: None, margin_min_m: margin, margin_max_m: DVec3::ZERO };
        let human = region("human", &shape, &truth).unwrap();
        assert_eq!(human.cells.window(), Window::between([54, 38, 10], [62, 40, 30]));
        assert_eq!(human.cells.count(), 9 * 3 * 21);
    }

    #[test]
    fn regions_that_cannot_be_are_refused() {
        let mut truth = empty_cell();
        let far = Shape::Sphere { center_m: DVec3::new(50.0, 0.0, 0.0), radius_m: 1.0 };
        assert!(region("far", &far, &truth).unwrap_err().to_string().contains("outside the grid"));
        let tiny = Shape::Sphere { center_m: DVec3::ZERO, radius_m: 0.001 };
        assert!(region("tiny", &tiny, &truth).unwrap_err().to_string().contains("no voxel"));
        let big = Shape::Sphere { center_m: DVec3::ZERO, radius_m: 1500.0 };
        assert!(region("big", &big, &truth).unwrap_err().to_string().contains("radius_m = 1500"));
        let nobody = Shape::HumanBox { object: None, margin_min_m: DVec3::ZERO, margin_max_m: DVec3::ZERO };
        assert!(region("human", &nobody, &truth).is_err());
        let unit = Shape::Box { min_m: DVec3::ZERO, max_m: DVec3::ONE };
        let mut everything = truth.occupied.clone();
        (0..61).for_each(|z| (0..81).for_each(|y| everything.set_run(0, 121, y, z)));
        truth.ignored = everything;
        assert!(region("unit", &unit, &truth).unwrap_err().to_string().contains("interior"));
    }
}
