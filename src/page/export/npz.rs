//! A view for numpy: arrays over the grid in one `.npz`.
//!
//! | array | type, shape | what |
//! |---|---|---|
//! | `labels` | int8 (x, y, z) | 1 occupied, 0 free, −1 unknown: the fused labels |
//! | `hits` | bool (x, y, z) | voxels of true returns, independent of the measured distance |
//! | `truth`, `human`, `robot` | bool (x, y, z) | truly occupied; voxels of a person; of the robot |
//! | `verdict` | uint8 (x, y, z) | an index of `verdict_names`: tp, fp, fn, tn, uo, uf |
//! | `regions` | bool (x, y, z, region) | the voxels of each region; `region_names` in the same order |
//! | `origin_m` | float64 (3) | lower corner of voxel `[0, 0, 0]` in the world; its centre is half a voxel further |
//! | `voxel_size_m` | float64 () | edge of a voxel |
//! | `scene`, `combination`, `poses`, `representation` | text () | the choice, as in the columns of results.csv |
//! | `snapshot`, `repeat` | float64 () | the moment and the repeat |
//!
//! Voxel `[i, j, k]` is the i-th along x, the j-th along y, the k-th along z. In memory x is the fastest
//! (Fortran order), as everywhere here.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::DeflateEncoder;
use rawzip::time::UtcDateTime;
use rawzip::{CompressionMethod, ZipArchiveWriter};

use super::title;
use perirobot_decide::view::{Verdict, View};
use perirobot_march::voxel::BitGrid;
use perirobot_march::{Error, Result};

/// The first date of the ZIP format, so that equal views have equal bytes.
const FIRST_DAY: UtcDateTime = match UtcDateTime::from_components(1980, 1, 1, 0, 0, 0, 0) {
    Some(day) => day,
    None => unreachable!(),
};

/// The bytes of the archive.
pub(crate) fn bytes(view: &View) -> Result<Vec<u8>> {
    write(view).map_err(|e| Error::device(format!("cannot pack the arrays: {e}")))
}

fn write(view: &View) -> Result<Vec<u8>, rawzip::Error> {
    let mut archive = Archive(ZipArchiveWriter::new(Vec::new()));
    let (world, truth) = (view.world, &view.truth);
    let (grid, labels) = (&truth.grid, &view.labels);
    let shape = grid.size.map(|n| n as usize);
    archive.array("labels", "|i1", &shape, |out| out.write_all(&view.label_bytes()))?;
    let planes: [(&str, &BitGrid); 4] = [
        ("hits", &labels.hits),
        ("truth", &truth.occupied),
        ("human", &truth.human),
        ("robot", &truth.robot),
    ];
    for (name, plane) in planes {
        archive.array(name, "|b1", &shape, |out| {
            write_voxels(out, grid.size, &|voxel| plane.get(voxel).into())
        })?;
    }
    let verdict = |voxel| view.verdict(voxel) as u8;
    archive.array("verdict", "|u1", &shape, |out| write_voxels(out, grid.size, &verdict))?;
    archive.texts("verdict_names", &Verdict::ALL.map(Verdict::name), false)?;
    let names: Vec<&str> = world.regions.iter().map(|region| region.name.as_str()).collect();
    archive.texts("region_names", &names, false)?;
    archive.array("regions", "|b1", &[&shape[..], &[names.len()]].concat(), |out| {
        let mut all = world.regions.iter();
        all.try_for_each(|region| write_voxels(out, grid.size, &|voxel| region.voxels.get(voxel).into()))
    })?;
    archive.numbers("origin_m", &grid.corner_m([0; 3]).to_array(), false)?;
    archive.numbers("voxel_size_m", &[grid.voxel_size_m], true)?;
    let [poses, _, representation, _] = title(view);
    let combination = &view.study.combinations[view.choice.combination].name;
    let texts = [
        ("scene", &world.name),
        ("combination", combination),
        ("poses", &poses),
        ("representation", &representation),
    ];
    for (name, text) in texts {
        archive.texts(name, &[text], true)?;
    }
    for (name, number) in [("snapshot", world.snapshot), ("repeat", view.choice.repeat)] {
        archive.numbers(name, &[number as f64], true)?;
    }
    archive.0.finish()
}

/// An archive of arrays.
struct Archive(ZipArchiveWriter<Vec<u8>>);

impl Archive {
    /// An array; `write` writes its bytes, with the first index fastest.
    fn array(
        &mut self,
        name: &str,
        kind: &str,
        shape: &[usize],
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), rawzip::Error> {
        let name = format!("{name}.npy");
        let file = self.0.new_file(&name).compression_method(CompressionMethod::DEFLATE);
        let (mut entry, summed) = file.last_modified(FIRST_DAY).start()?;
        let mut out = summed.wrap(DeflateEncoder::new(&mut entry, Compression::default()));
        let comma = if shape.len() == 1 { "," } else { "" };
        let shape = shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let header = format!("{{'descr': '{kind}', 'fortran_order': True, 'shape': ({shape}{comma}), }}");
        // The array begins at a multiple of 64 bytes: 10 bytes, the header and a newline precede it.
        let length = (header.len() + 11).next_multiple_of(64) - 10;
        out.write_all(b"\x93NUMPY\x01\x00")?;
        out.write_all(&(length as u16).to_le_bytes())?;
        writeln!(out, "{header:<width$}", width = length - 1)?;
        write(&mut out)?;
        let (packed, sums) = out.finish()?;
        packed.finish()?;
        entry.finish(sums).map(drop)
    }

    /// A row of numbers, or a single one.
    fn numbers(&mut self, name: &str, numbers: &[f64], single: bool) -> Result<(), rawzip::Error> {
        let shape: &[usize] = if single { &[] } else { &[numbers.len()] };
        let write = |out: &mut dyn Write| numbers.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()));
        self.array(name, "<f8", shape, write)
    }

    /// A row of texts, or a single one.
    fn texts(&mut self, name: &str, texts: &[impl AsRef<str>], single: bool) -> Result<(), rawzip::Error> {
        let longest = texts.iter().map(|text| text.as_ref().chars().count()).max().unwrap_or(0).max(1);
        let shape: &[usize] = if single { &[] } else { &[texts.len()] };
        let padded = |text| str::chars(text).chain(std::iter::repeat('\0')).take(longest);
        let mut characters = texts.iter().map(AsRef::as_ref).flat_map(padded);
        let write = |out: &mut dyn Write| {
            characters.try_for_each(|character| out.write_all(&u32::from(character).to_le_bytes()))
        };
        self.array(name, &format!("<U{longest}"), shape, write)
    }
}

/// Writes a byte for each voxel, x fastest.
fn write_voxels(out: &mut dyn Write, size: [u32; 3], f: &dyn Fn([i32; 3]) -> u8) -> io::Result<()> {
    let [width, depth, height] = size.map(|n| n as i32);
    for z in 0..height {
        for y in 0..depth {
            let row: Vec<u8> = (0..width).map(|x| f([x, y, z])).collect();
            out.write_all(&row)?;
        }
    }
    Ok(())
}
