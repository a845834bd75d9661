//! A view for numpy: arrays over the grid in one `.npz`.
//!
//! | array | type, shape | what |
//! |---|---|---|
//! | `labels` | int8 (x, y, z) | 1 occupied, 0 free, −1 unknown: what the sensors say together |
//! | `hits` | bool (x, y, z) | voxels that returns truly come from, whatever distance they are read at |
//! | `truth`, `human`, `robot` | bool (x, y, z) | truly occupied; voxels of a person; of the robot |
//! | `verdict` | uint8 (x, y, z) | an index of `verdict_names`: tp, fp, fn, tn, uo, uf |
//! | `regions` | bool (x, y, z, region) | the voxels of each region; `region_names` in the same order |
//! | `origin_m` | float64 (3) | lower corner of voxel `[0, 0, 0]` in the world; its centre is half a voxel further |
//! | `voxel_size_m` | float64 () | edge of a voxel |
//! | `scene`, `combination`, `poses`, `representation` | text () | what is looked at, as in the columns of results.csv |
//! | `snapshot`, `repeat` | float64 () | at which moment, in which repeat |
//!
//! Voxel `[i, j, k]` is the i-th along x, the j-th along y, the k-th along z. In memory x is the fastest
//! (Fortran order), as everywhere here.

use std::io::{self, Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::title;
use crate::view::{Verdict, View};
use crate::voxel::BitGrid;
use crate::{Error, Result};

/// The bytes of the archive.
pub(crate) fn bytes(view: &View) -> Result<Vec<u8>> {
    write(view).map_err(|e| Error::device(format!("cannot pack the arrays: {e}")))
}

fn write(view: &View) -> io::Result<Vec<u8>> {
    let mut archive = Archive(ZipWriter::new(Cursor::new(Vec::new())));
    let (world, truth) = (view.world, &view.truth);
    let (grid, labels) = (&truth.grid, &view.labels);
    let shape = grid.size.map(|n| n as usize);
    archive.begin("labels", "|i1", &shape)?;
    archive.0.write_all(&view.label_bytes())?;
    let planes: [(&str, &BitGrid); 4] = [
        ("hits", &labels.hits),
        ("truth", &truth.occupied),
        ("human", &truth.human),
        ("robot", &truth.robot),
    ];
    for (name, plane) in planes {
        archive.voxels(name, "|b1", shape, |voxel| plane.get(voxel).into())?;
    }
    archive.voxels("verdict", "|u1", shape, |voxel| view.verdict(voxel) as u8)?;
    archive.texts("verdict_names", &Verdict::ALL.map(Verdict::name), false)?;
    let names: Vec<&str> = world.regions.iter().map(|region| region.name.as_str()).collect();
    archive.texts("region_names", &names, false)?;
    archive.begin("regions", "|b1", &[&shape[..], &[names.len()]].concat())?;
    for region in &world.regions {
        archive.fill(shape, |voxel| region.voxels.get(voxel).into())?;
    }
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
    Ok(archive.0.finish()?.into_inner())
}

/// An archive of arrays.
struct Archive(ZipWriter<Cursor<Vec<u8>>>);

impl Archive {
    /// Begins an array; its bytes follow, the first index the fastest.
    fn begin(&mut self, name: &str, kind: &str, shape: &[usize]) -> io::Result<()> {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        self.0.start_file(format!("{name}.npy"), options.large_file(true))?;
        let comma = if shape.len() == 1 { "," } else { "" };
        let shape = shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let header = format!("{{'descr': '{kind}', 'fortran_order': True, 'shape': ({shape}{comma}), }}");
        // The array begins at a multiple of 64 bytes: 10 of them, the header, and a newline are before it.
        let length = (header.len() + 11).next_multiple_of(64) - 10;
        self.0.write_all(b"\x93NUMPY\x01\x00")?;
        self.0.write_all(&(length as u16).to_le_bytes())?;
        writeln!(self.0, "{header:<width$}", width = length - 1)
    }

    /// An array with a byte for each voxel.
    fn voxels(
        &mut self,
        name: &str,
        kind: &str,
        shape: [usize; 3],
        f: impl Fn([i32; 3]) -> u8,
    ) -> io::Result<()> {
        self.begin(name, kind, &shape)?;
        self.fill(shape, f)
    }

    fn fill(&mut self, [width, depth, height]: [usize; 3], f: impl Fn([i32; 3]) -> u8) -> io::Result<()> {
        for z in 0..height as i32 {
            for y in 0..depth as i32 {
                let row: Vec<u8> = (0..width as i32).map(|x| f([x, y, z])).collect();
                self.0.write_all(&row)?;
            }
        }
        Ok(())
    }

    /// A row of numbers, or a single one.
    fn numbers(&mut self, name: &str, numbers: &[f64], single: bool) -> io::Result<()> {
        let shape = if single { vec![] } else { vec![numbers.len()] };
        self.begin(name, "<f8", &shape)?;
        numbers.iter().try_for_each(|x| self.0.write_all(&x.to_le_bytes()))
    }

    /// A row of texts, or a single one.
    fn texts(&mut self, name: &str, texts: &[impl AsRef<str>], single: bool) -> io::Result<()> {
        let longest = texts.iter().map(|text| text.as_ref().chars().count()).max().unwrap_or(0).max(1);
        let shape = if single { vec![] } else { vec![texts.len()] };
        self.begin(name, &format!("<U{longest}"), &shape)?;
        for text in texts {
            let padded = text.as_ref().chars().chain(std::iter::repeat('\0')).take(longest);
            padded.into_iter().try_for_each(|c| self.0.write_all(&u32::from(c).to_le_bytes()))?;
        }
        Ok(())
    }
}
