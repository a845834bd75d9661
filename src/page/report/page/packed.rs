//! Numbers and bytes as text that a page can hold: gzip, then base64, which browsers undo by themselves.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, write::GzEncoder};

/// Bytes, compressed and spelt in letters.
pub(super) fn pack(bytes: &[u8]) -> String {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    let written = gzip.write_all(bytes).and_then(|()| gzip.finish());
    STANDARD.encode(written.expect("memory takes all that is written"))
}

/// Numbers that a script finds by where they begin.
#[derive(Debug, Default)]
pub(super) struct NumberTable(Vec<u8>);

impl NumberTable {
    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.0.len() / 4
    }

    /// Adds one; what has no value is NaN.
    pub(super) fn push(&mut self, value: Option<f64>) {
        self.0.extend((value.unwrap_or(f64::NAN) as f32).to_le_bytes());
    }

    /// The least of those from a place on; infinite where none has a value.
    pub(super) fn least_from(&self, begin: usize) -> f64 {
        let numbers =
            self.0[4 * begin..].chunks_exact(4).map(|one| f32::from_le_bytes(one.try_into().unwrap()));
        f64::from(numbers.fold(f32::INFINITY, f32::min))
    }

    /// All of them as text: little-endian floats of 32 bits.
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
