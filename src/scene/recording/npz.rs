//! Reads labels from an archive of numpy arrays, such as `perirobot export` writes.
//!
//! | array | shape | what |
//! |---|---|---|
//! | `labels` | (x, y, z), whole numbers | 1 occupied, 0 free, −1 (255 of unsigned bytes) unknown |
//! | `origin_m` | (3) | lower corner of voxel `[0, 0, 0]`, in metres |
//! | `voxel_size_m` | () | edge of a voxel in metres |
//! | `hits` | (x, y, z), optional | voxels that returns came from |
//!
//! `rawzip` lists the archive's directory as it is written: encrypted entries, other packings and entries of the same
//! name are seen before they are unpacked, and size and checksum are compared while they are. `zip` keeps one entry a
//! name and brings paths and encryption that no array needs; `npyz` reads archives through `zip`.

use std::io::Read;

use flate2::bufread::DeflateDecoder;
use glam::DVec3;
use rawzip::{CompressionMethod, ZipArchive, ZipFileHeaderRecord, ZipSliceArchive};

use super::labels::{Each, LabelArray};
use super::npy::Array;
use super::voxels::VoxelMap;
use crate::source::MemoryLimit;
use perirobot_march::error::Issue;

/// Most bytes that deflate packs into one.
const MOST_UNPACKED: u64 = 1032;

/// Parses an archive.
pub(super) fn parse(bytes: &[u8]) -> Result<VoxelMap, Issue> {
    let no_archive = |_| {
        Issue::damaged("is not an archive of arrays, or a truncated one")
            .with_advice("write it with numpy.savez")
    };
    let archive = ZipArchive::from_slice(bytes).map_err(no_archive)?;
    let entries: Vec<_> = archive.entries().collect::<Result<_, _>>().map_err(no_archive)?;
    let mut limit = MemoryLimit::new(bytes.len() as u64);
    let mut array = |name: &str| {
        // Of several that have the name numpy takes the last.
        let entry =
            entries.iter().rfind(|entry| entry.file_path().as_ref() == format!("{name}.npy").as_bytes());
        let array = entry.map(|entry| unpack(&archive, entry, &mut limit).and_then(Array::parse)).transpose();
        array.map_err(|e| e.with_place(name))
    };
    let wanted = |found: Option<Array>, name: &str| {
        found.ok_or_else(|| {
            Issue::missing(name).with_advice(
                "labels (x, y, z), origin_m (3) and voxel_size_m are read, as numpy.savez writes them",
            )
        })
    };
    let labels = wanted(array("labels")?, "labels")?;
    let origin_m = wanted(array("origin_m")?, "origin_m")?;
    let voxel_size_m = wanted(array("voxel_size_m")?, "voxel_size_m")?;
    let hits = array("hits")?;

    let shape = labels.three().map_err(|e| e.with_place("labels"))?;
    // Three planes of a bit a voxel, with rows along x filled up to 32.
    let [x, y, z] = shape.map(|n| n.min(1 << 20) as u64);
    limit.spend(3 * x.next_multiple_of(32) * y * z / 8)?;
    if hits.as_ref().is_some_and(|hits| hits.shape != labels.shape) {
        return Err(Issue::damaged("is not as large as labels").with_place("hits"));
    }
    // What is not as many numbers as it should be is no length.
    let origin_m = match origin_m.numbers()[..] {
        [x, y, z] => DVec3::new(x, y, z),
        _ => DVec3::NAN,
    };
    let voxel_size_m = match voxel_size_m.numbers()[..] {
        [size] => size,
        _ => f64::NAN,
    };
    let each_hit = hits.as_ref().map(|hits| |see: &mut dyn FnMut([i32; 3], f64)| hits.each(see));
    let hits = each_hit.as_ref().map(|each| each as &Each);
    let each: &Each = &|see| labels.each(see);
    LabelArray { shape, each, are_bytes: labels.is_of_bytes(), hits, origin_m, voxel_size_m }.map()
}

/// The bytes of a file in an archive, if they are as many as the archive declares.
fn unpack(
    archive: &ZipSliceArchive<&[u8]>,
    entry: &ZipFileHeaderRecord,
    limit: &mut MemoryLimit,
) -> Result<Vec<u8>, Issue> {
    if entry.flags().is_encrypted() {
        return Err(Issue::unsupported("is encrypted"));
    }
    let damaged = || Issue::damaged("is damaged in the archive").with_advice("write it again");
    let packed = archive.get_entry(entry.wayfinder()).map_err(|_| damaged())?;
    let plain: Box<dyn Read> = match entry.compression_method() {
        CompressionMethod::STORE => Box::new(packed.data()),
        CompressionMethod::DEFLATE => Box::new(DeflateDecoder::new(packed.data())),
        other => {
            let method = Issue::unsupported(format!("is packed by the method {other}"));
            return Err(method.with_advice("what numpy.savez and numpy.savez_compressed write is read"));
        }
    };
    let length = entry.uncompressed_size_hint();
    limit.spend(length)?;
    // Room for no more than the entry can hold, whatever it declares.
    let most = MOST_UNPACKED.saturating_mul(packed.data().len() as u64);
    let mut bytes = Vec::with_capacity(length.min(most) as usize);
    let read = packed.verifying_reader(plain).take(length + 1).read_to_end(&mut bytes);
    read.ok().filter(|count| *count as u64 <= length).ok_or_else(damaged)?;
    Ok(bytes)
}
