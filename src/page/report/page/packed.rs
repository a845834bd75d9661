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

/// Adds classes, as runs of equal ones, to some bytes: LEB128 numbers, each the length of a run times how
/// many kinds of classes there are, plus its class.
pub(super) fn put_runs(classes: impl Iterator<Item = usize>, kinds: usize, bytes: &mut Vec<u8>) {
    let mut run: Option<(usize, u64)> = None;
    let mut put = |(class, length): (usize, u64)| {
        let mut rest = length * kinds as u64 + class as u64;
        while rest >= 0x80 {
            bytes.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        bytes.push(rest as u8);
    };
    for class in classes {
        debug_assert!(class < kinds, "{class} of {kinds}");
        run = match run {
            Some((same, length)) if same == class => Some((same, length + 1)),
            other => {
                other.into_iter().for_each(&mut put);
                Some((class, 1))
            }
        };
    }
    run.into_iter().for_each(put);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_worked_by_hand() {
        let mut bytes = vec![9];
        // Three of class 1: 3·8 + 1. Twenty of class 5: 165 = 37 + 128. One of class 0.
        let classes = [vec![1; 3], vec![5; 20], vec![0]].concat();
        put_runs(classes.into_iter(), 8, &mut bytes);
        assert_eq!(bytes, [9, 25, 165, 1, 8]);
        put_runs(std::iter::empty(), 8, &mut bytes);
        assert_eq!(bytes.len(), 5, "nothing of nothing");
        // Two of class 2 of 3: 3·2 + 2.
        put_runs([2, 2].into_iter(), 3, &mut bytes);
        assert_eq!(bytes[5..], [8]);
    }

    #[test]
    fn what_is_packed_can_be_unpacked() {
        let text = pack(b"abc");
        let gzip = STANDARD.decode(text).unwrap();
        let mut back = String::new();
        std::io::Read::read_to_string(&mut flate2::read::GzDecoder::new(&gzip[..]), &mut back).unwrap();
        assert_eq!(back, "abc");
    }
}
