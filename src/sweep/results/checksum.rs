//! The checksum of journals.

use sha2::{Digest, Sha256};

/// Bytes of a checksum.
pub const CHECK_BYTES: usize = 8;

/// The first bytes of a SHA-256: a random error passes with probability 2⁻⁶⁴.
pub fn checksum(parts: [&[u8]; 2]) -> [u8; CHECK_BYTES] {
    let mut hash = Sha256::new();
    parts.iter().for_each(|part| hash.update(part));
    let hash = hash.finalize();
    std::array::from_fn(|i| hash[i])
}
