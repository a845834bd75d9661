//! Voxels of numpy arrays as maps in memory, which scenes name like files.

use numpy::ndarray::ArrayView3;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::octomap::{KEYS, write};

/// The voxels that are set, as an OctoMap whose voxel `key` is the array's first; `None` where none is set.
pub(crate) fn map(voxels: ArrayView3<bool>, voxel_size_m: f64, key: [i32; 3]) -> Result<Option<Vec<u8>>> {
    let size: [u32; 3] = std::array::from_fn(|axis| u32::try_from(voxels.shape()[axis]).unwrap_or(u32::MAX));
    let is_held = |axis: usize| {
        let end = i64::from(key[axis]) + i64::from(size[axis]);
        KEYS.contains(&key[axis]) && end <= i64::from(KEYS.end)
    };
    if !(0..3).all(is_held) {
        let what = format!(
            "of {size:?} voxels from voxel {key:?} on reaches beyond voxels {} to {}",
            KEYS.start,
            KEYS.end - 1
        );
        return Err(Error::from(Issue::too_large(what).with_place("cell")));
    }
    // A map is made voxel by voxel of the box that it is given, and outside of the box of those that are set nothing is.
    let Some([low, high]) = corners(voxels) else { return Ok(None) };
    let begin: [i32; 3] = std::array::from_fn(|axis| key[axis] + low[axis] as i32);
    let size: [u32; 3] = std::array::from_fn(|axis| (high[axis] + 1 - low[axis]) as u32);
    let is_set = |[x, y, z]: [i32; 3]| {
        let at = [x - key[0], y - key[1], z - key[2]].map(|n| n as usize);
        voxels[at].then_some(true)
    };
    Ok(Some(write(voxel_size_m, begin, size, &is_set)))
}

/// The least and the greatest indices of voxels that are set; `None` where none is.
fn corners(voxels: ArrayView3<bool>) -> Option<[[usize; 3]; 2]> {
    let mut found: Option<[[usize; 3]; 2]> = None;
    for (x, slice) in voxels.outer_iter().enumerate() {
        for (y, row) in slice.outer_iter().enumerate() {
            let Some(first) = row.iter().position(|&set| set) else { continue };
            let last = row.iter().rposition(|&set| set).unwrap_or(first);
            let [low, high] = found.get_or_insert([[x, y, first], [x, y, last]]);
            for (axis, (least, most)) in [(x, x), (y, y), (first, last)].into_iter().enumerate() {
                low[axis] = low[axis].min(least);
                high[axis] = high[axis].max(most);
            }
        }
    }
    found
}
