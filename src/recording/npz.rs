//! Reads labels from an archive of numpy arrays, such as `perirobot export` writes.
//!
//! | array | shape | what |
//! |---|---|---|
//! | `labels` | (x, y, z), whole numbers | 1 occupied, 0 free, −1 (255 of unsigned bytes) unknown |
//! | `origin_m` | (3) | lower corner of voxel `[0, 0, 0]`, in metres |
//! | `voxel_size_m` | () | edge of a voxel in metres |
//! | `hits` | (x, y, z), optional | voxels that returns came from |

use std::io::{Cursor, Read};

use glam::DVec3;
use zip::ZipArchive;

use super::npy::Array;
use super::voxels::{Known, VoxelMap};
use crate::backend::Planes;
use crate::error::Issue;
use crate::voxel::{BitGrid, Window};

/// Most bytes of one array, unpacked.
const MOST_BYTES: u64 = 1 << 30;

/// Most voxels, with rows along x filled up to 32.
const MOST_VOXELS: usize = 1 << 33;

/// Parses an archive.
pub(super) fn parse(bytes: &[u8]) -> Result<VoxelMap, Issue> {
    let mut archive = ZipArchive::new(Cursor::new(bytes))
        .map_err(|e| Issue::damaged(format!("is no archive of arrays: {e}")))?;
    let mut array = |name: &str| -> Result<Option<Array>, Issue> {
        let Some(number) = archive.index_for_name(&format!("{name}.npy")) else { return Ok(None) };
        let packed = archive.by_index(number).map_err(|e| Issue::damaged(e.to_string()).at(name))?;
        let mut bytes = Vec::new();
        let read = packed.take(MOST_BYTES + 1).read_to_end(&mut bytes);
        read.map_err(|e| Issue::damaged(e.to_string()).at(name))?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(Issue::too_large(format!("has more than {MOST_BYTES} bytes")).at(name));
        }
        Array::parse(bytes).map(Some).map_err(|e| e.at(name))
    };
    let wanted = |found: Option<Array>, name: &str| {
        found.ok_or_else(|| {
            Issue::missing(name).wanted(
                "labels (x, y, z), origin_m (3) and voxel_size_m are read, as numpy.savez writes them",
            )
        })
    };
    let labels = wanted(array("labels")?, "labels")?;
    let origin_m = wanted(array("origin_m")?, "origin_m")?;
    let voxel_size_m = wanted(array("voxel_size_m")?, "voxel_size_m")?;
    let hits = array("hits")?;

    let shape = labels.three().map_err(|e| e.at("labels"))?;
    let [x, y, z] = shape.map(|n| n.min(1 << 21));
    if shape.iter().any(|n| *n > 1 << 20) || x.next_multiple_of(32) * y * z > MOST_VOXELS {
        return Err(Issue::too_large(format!("has the shape {shape:?}"))
            .wanted("cut the map to the cell")
            .at("labels"));
    }
    let window = Window { min: [0; 3], size: [x, y, z].map(|n| n as u32) };
    if hits.as_ref().is_some_and(|hits| hits.shape != labels.shape) {
        return Err(Issue::damaged("is not as large as labels").at("hits"));
    }
    let [mut occupied, mut free, mut hit] = [(); 3].map(|()| BitGrid::new(window));
    let mut odd = None;
    labels.each(|voxel, label| match label {
        1.0 => occupied.set(voxel),
        0.0 => free.set(voxel),
        -1.0 => {}
        255.0 if labels.is_of_bytes() => {}
        other => odd = odd.or(Some((voxel, other))),
    });
    if let Some((voxel, label)) = odd {
        return Err(Issue::value(
            format!("{voxel:?}"),
            label,
            "must be 1 (occupied), 0 (free) or -1 (unknown)",
        )
        .at("labels"));
    }
    if let Some(hits) = &hits {
        hits.each(|voxel, is_hit| {
            if is_hit != 0.0 {
                hit.set(voxel);
            }
        });
    }
    if occupied.is_empty() && free.is_empty() {
        return Err(Issue::says("has no voxel that is occupied or free").at("labels"));
    }
    let corner_m = match origin_m.numbers()[..] {
        [x, y, z] if [x, y, z].iter().all(|v| v.abs() < 1e6) => DVec3::new(x, y, z),
        _ => return Err(Issue::says("must be three lengths in metres").at("origin_m")),
    };
    let voxel_size_m = match voxel_size_m.numbers()[..] {
        [size] if size.is_finite() && size > 0.0 => size,
        _ => return Err(Issue::says("must be one positive length in metres").at("voxel_size_m")),
    };
    let planes = Planes { occupied, free, hits: hit };
    Ok(VoxelMap { voxel_size_m, corner_m, known: Known::Planes { planes, knows_hits: hits.is_some() } })
}
