//! Labels, evidence and truth as OctoMap's binary trees for octovis, ROS and MoveIt. `objects::octomap` writes
//! the format.

use perirobot_decide::view::{SensorView, View};
use perirobot_march::backend::Planes;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::octomap::{KEYS, write};

/// The numbers of occupied and free voxels of a map.
pub type VoxelTotals = (u64, u64);

/// The fused labels; unknown voxels are left out.
pub(crate) fn labels(view: &View) -> Result<(Vec<u8>, VoxelTotals)> {
    map(view, &|voxel| label(&view.labels, voxel))
}

/// The evidence of one sensor.
pub(crate) fn evidence(view: &View, member: &SensorView) -> Result<(Vec<u8>, VoxelTotals)> {
    map(view, &|voxel| label(&member.says, voxel))
}

/// The truth; insides of bodies outside all regions are left out.
pub(crate) fn truth(view: &View) -> Result<(Vec<u8>, VoxelTotals)> {
    let truth = &view.truth;
    map(view, &|voxel| (!truth.ignored.get(voxel)).then(|| truth.occupied.get(voxel)))
}

fn label(planes: &Planes, voxel: [i32; 3]) -> Option<bool> {
    match (planes.occupied.get(voxel), planes.free.get(voxel)) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    }
}

/// A map of the grid from the state of each voxel.
fn map(view: &View, state: &dyn Fn([i32; 3]) -> Option<bool>) -> Result<(Vec<u8>, VoxelTotals)> {
    let grid = &view.world.grid;
    if (0..3).any(|r| {
        !KEYS.contains(&grid.origin[r]) || !KEYS.contains(&(grid.origin[r] + grid.size[r] as i32 - 1))
    }) {
        let farthest_m = f64::from(KEYS.end) * grid.voxel_size_m;
        let what = format!(
            "reaches more than {farthest_m:.0} m from the origin, the limit of an OctoMap: move the cell closer to it"
        );
        return Err(Error::input(format!("scene {:?}", view.world.name), what));
    }
    let held = std::cell::Cell::new((0, 0));
    let counted = |key: [i32; 3]| {
        let state = state(std::array::from_fn(|r| key[r] - grid.origin[r]));
        let (occupied, free) = held.get();
        held.set((occupied + u64::from(state == Some(true)), free + u64::from(state == Some(false))));
        state
    };
    let bytes = write(grid.voxel_size_m, grid.origin, grid.size, &counted);
    Ok((bytes, held.get()))
}
