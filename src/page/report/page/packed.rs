//! Numbers and bytes as text in a page: gzip, then base64, which browsers decode.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, write::GzEncoder};

/// Bytes, compressed and encoded.
pub(super) fn pack(bytes: &[u8]) -> String {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    let written = gzip.write_all(bytes).and_then(|()| gzip.finish());
    STANDARD.encode(written.expect("memory takes all that is written"))
}

/// Numbers that a script finds by their index.
#[derive(Debug, Default)]
pub(super) struct NumberTable(Vec<u8>);

impl NumberTable {
    /// Their number.
    pub(super) fn len(&self) -> usize {
        self.0.len() / 4
    }

    /// Adds one; NaN if it has no value.
    pub(super) fn push(&mut self, value: Option<f64>) {
        self.0.extend((value.unwrap_or(f64::NAN) as f32).to_le_bytes());
    }

    /// The least from a place on; infinite if none has a value.
    pub(super) fn least_from(&self, begin: usize) -> f64 {
        let numbers =
            self.0[4 * begin..].chunks_exact(4).map(|one| f32::from_le_bytes(one.try_into().unwrap()));
        f64::from(numbers.fold(f32::INFINITY, f32::min))
    }

    /// All numbers as text: little-endian floats of 32 bits.
    pub(super) fn pack(&self) -> String {
        pack(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_can_be_unpacked() {
        let text = pack(b"abc");
        let gzip = STANDARD.decode(text).unwrap();
        let mut back = String::new();
        std::io::Read::read_to_string(&mut flate2::read::GzDecoder::new(&gzip[..]), &mut back).unwrap();
        assert_eq!(back, "abc");
    }
}
