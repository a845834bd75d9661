//! Evidence from the host, into slots. A plane mostly says something of a small part of the window, as of a person: only its
//! rows travel, and the device clears the rest itself.

use super::{Gpu, no_scene};
use crate::Result;
use crate::backend::{Planes, Slot};
use crate::voxel::{BitGrid, Window};

/// Words that may be on their way at once.
const WORDS_AT_ONCE: usize = 16 << 20;

/// Bytes that cost as much as a piece of their own.
const WORTH_A_PIECE: u32 = 8 << 10;

/// Rows of planes, and where each piece of them belongs.
#[derive(Default)]
struct Rows<'a> {
    words: Vec<u32>,
    /// Whose rows they are, and where those begin: a zone is the same from wherever it is watched.
    planes: Vec<(&'a BitGrid, usize)>,
    pieces: Vec<Piece<'a>>,
}

/// Words that follow each other on both sides: the first byte here and there, and how many bytes.
struct Piece<'a> {
    from: u64,
    arena: &'a wgpu::Buffer,
    to: u64,
    bytes: u64,
}

impl Gpu {
    pub(super) fn upload_all(&mut self, evidence: &[(Slot, Planes)]) -> Result<()> {
        let Gpu { queue, loaded, room, .. } = self;
        let loaded = loaded.as_mut().ok_or_else(no_scene)?;
        let device = &queue.device;
        let mut left = evidence;
        while !left.is_empty() {
            let mut encoder = device.encoder();
            let mut rows = Rows::default();
            while let Some(((slot, planes), others)) = left.split_first()
                && rows.words.len() < WORDS_AT_ONCE
            {
                let (offset, bytes) = (loaded.offset(*slot)?, loaded.sizes.plane_bytes());
                encoder.clear_buffer(&loaded.ended, 2 * offset, Some(2 * bytes));
                encoder.clear_buffer(&loaded.free, offset, Some(bytes));
                rows.add(&planes.occupied, loaded.window, &loaded.ended, 2 * offset);
                rows.add(&planes.free, loaded.window, &loaded.free, offset);
                rows.add(&planes.hits, loaded.window, &loaded.ended, 2 * offset + bytes);
                left = others;
            }
            let uploaded = room.uploaded.filled(device, &rows.words);
            for Piece { from, arena, to, bytes } in rows.pieces {
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

impl<'a> Rows<'a> {
    /// Adds a plane that begins at a byte of an arena, over a window.
    fn add(&mut self, plane: &'a BitGrid, window: Window, arena: &'a wgpu::Buffer, begin: u64) {
        let shared = plane.window().intersection(&window);
        if shared.is_empty() || plane.is_empty() {
            return;
        }
        let row_words = window.size[0].div_ceil(32);
        // Layers that are nearly whole go whole, since then they follow each other.
        let left_out = (window.size[1] - shared.size[1]) * row_words * 4;
        let part = if left_out < WORTH_A_PIECE { window } else { shared };
        let ys = part.min[1]..part.end()[1];
        let zs = shared.min[2]..shared.end()[2];
        let layer_words = row_words as usize * ys.len();
        let known = self.planes.iter().find(|(known, _)| *known == plane);
        let from = known.map_or(self.words.len(), |&(_, from)| from);
        if known.is_none() {
            self.planes.push((plane, from));
            self.words.resize(from + layer_words * zs.len(), 0);
            for (layer, z) in self.words[from..].chunks_exact_mut(layer_words).zip(zs.clone()) {
                plane.add_to_rows(layer, window, ys.clone(), z);
            }
        }
        let (pieces, layers) = if part == window { (1, zs.len()) } else { (zs.len(), 1) };
        let bytes = (layers * layer_words * 4) as u64;
        let first_row =
            (zs.start - window.min[2]) as u64 * u64::from(window.size[1]) + (ys.start - window.min[1]) as u64;
        let to = begin + first_row * u64::from(row_words) * 4;
        let stride = u64::from(window.size[1] * row_words) * 4;
        self.pieces.extend((0..pieces as u64).map(|piece| Piece {
            from: from as u64 * 4 + piece * bytes,
            arena,
            to: to + piece * stride,
            bytes,
        }));
    }
}
