//! Evidence from the host, into slots. A plane mostly says something of a small part of the window, as of a person: only its
//! rows travel, and the device clears the rest itself.

use std::ops::Range;

use rayon::prelude::*;

use super::{Gpu, no_scene};
use crate::Result;
use crate::backend::{Planes, Slot};
use crate::voxel::{BitGrid, Window};

/// Words that may be on their way at once.
const WORDS_AT_ONCE: usize = 16 << 20;

/// Pieces that may be on their way at once.
const PIECES_AT_ONCE: usize = 1 << 14;

/// So many planes are remembered, in case that one of them comes again.
const REMEMBERED: usize = 64;

/// Bytes that cost as much as a piece of their own.
const WORTH_A_PIECE: u32 = 8 << 10;

/// Rows of planes, and where each piece of them belongs.
#[derive(Default)]
struct UploadRows<'a> {
    /// Whose rows: a zone is the same from wherever it is watched, and travels once.
    planes: Vec<PlaneRows<'a>>,
    pieces: Vec<UploadPiece<'a>>,
    words: usize,
}

/// Some rows of some layers of a plane, and their first word among all that travel.
struct PlaneRows<'a> {
    plane: &'a BitGrid,
    ys: Range<i32>,
    zs: Range<i32>,
    from: usize,
}

/// Words that follow each other on both sides: the first byte here and there, and how many bytes.
struct UploadPiece<'a> {
    from: u64,
    arena: &'a wgpu::Buffer,
    to: u64,
    bytes: u64,
}

impl Gpu {
    /// Puts evidence into its slots.
    pub(super) fn upload_all(&mut self, evidence: &[(Slot, Planes)]) -> Result<()> {
        let Gpu { queue, loaded, room, .. } = self;
        let loaded = loaded.as_mut().ok_or_else(no_scene)?;
        let device = &queue.device;
        for &(slot, _) in evidence {
            loaded.offset(slot)?;
            loaded.held[slot as usize] = false;
        }
        let mut encoder = device.encoder();
        let mut placed = Vec::with_capacity(3 * evidence.len());
        for (slot, planes) in evidence {
            let (offset, bytes) = (loaded.clear_slot(&mut encoder, *slot)?, loaded.sizes.plane_bytes());
            placed.extend([
                (&planes.occupied, &loaded.ended, 2 * offset),
                (&planes.free, &loaded.free, offset),
                (&planes.hits, &loaded.ended, 2 * offset + bytes),
            ]);
        }
        device.submit(encoder);
        let mut left = placed.as_slice();
        while !left.is_empty() {
            let mut encoder = device.encoder();
            let mut rows = UploadRows::default();
            while let Some((&(plane, arena, begin), others)) = left.split_first()
                && rows.words < WORDS_AT_ONCE
                && rows.pieces.len() < PIECES_AT_ONCE
            {
                rows.add(plane, loaded.window, arena, begin);
                left = others;
            }
            rows.fill(&mut room.rows, loaded.window);
            let uploaded = room.uploaded.fill(device, &room.rows);
            for UploadPiece { from, arena, to, bytes } in rows.pieces {
                encoder.copy_buffer_to_buffer(&uploaded, from, arena, to, bytes);
            }
            device.submit(encoder);
            if !left.is_empty() {
                device.wait()?;
            }
        }
        device.check()?;
        evidence.iter().for_each(|&(slot, _)| loaded.held[slot as usize] = true);
        Ok(())
    }
}

impl<'a> UploadRows<'a> {
    /// Adds a plane that begins at a byte of an arena, over a window.
    fn add(&mut self, plane: &'a BitGrid, window: Window, arena: &'a wgpu::Buffer, begin: u64) {
        let shared = plane.window().intersection(&window);
        if shared.is_empty() || plane.is_empty() {
            return;
        }
        let row_words = window.size[0].div_ceil(32);
        // Layers that are nearly whole go whole, since then they follow each other.
        let left_out = (window.size[1] - shared.size[1]) * row_words * 4;
        let whole = left_out < WORTH_A_PIECE;
        let part = if whole { window } else { shared };
        let (ys, zs) = (part.min[1]..part.end()[1], shared.min[2]..shared.end()[2]);
        let layer_words = row_words as usize * ys.len();
        let [y, z] = [ys.start - window.min[1], zs.start - window.min[2]].map(|rows| rows as u64);
        let (pieces, layers) = if whole { (1, zs.len()) } else { (zs.len(), 1) };
        let from = self
            .planes
            .iter()
            .rev()
            .take(REMEMBERED)
            .find(|known| known.plane == plane)
            .map(|known| known.from);
        let from = from.unwrap_or_else(|| {
            self.planes.push(PlaneRows { plane, ys, zs: zs.clone(), from: self.words });
            self.words += layer_words * zs.len();
            self.words - layer_words * zs.len()
        });
        let bytes = (layers * layer_words * 4) as u64;
        let row_bytes = u64::from(row_words) * 4;
        self.pieces.extend((0..pieces as u64).map(|piece| UploadPiece {
            from: from as u64 * 4 + piece * bytes,
            arena,
            to: begin + ((z + piece) * u64::from(window.size[1]) + y) * row_bytes,
            bytes,
        }));
    }

    /// Writes the rows of all planes, as they lie in a window.
    fn fill(&self, words: &mut Vec<u32>, window: Window) {
        words.clear();
        words.resize(self.words, 0);
        let mut left = words.as_mut_slice();
        let mut parts = Vec::with_capacity(self.planes.len());
        for rows in &self.planes {
            let layer_words = window.size[0].div_ceil(32) as usize * rows.ys.len();
            let own;
            (own, left) = left.split_at_mut(layer_words * rows.zs.len());
            parts.extend(
                own.chunks_exact_mut(layer_words).zip(rows.zs.clone()).map(|(layer, z)| (rows, layer, z)),
            );
        }
        parts
            .into_par_iter()
            .for_each(|(rows, layer, z)| rows.plane.add_to_rows(layer, window, rows.ys.clone(), z));
    }
}
