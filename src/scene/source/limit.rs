//! Bounds the memory that reading one file may take, for all readers alike: 256 MiB, since a small file may stand for
//! much, and 64 bytes for each byte of the file. A reader pays for what it is about to make before it makes it.

use perirobot_march::error::Issue;

/// Bytes that any file may take, however small it is.
const FLOOR_BYTES: u64 = 256 << 20;
/// Bytes that a file may take for each of its own; a plain export needs about 4.
const BYTES_PER_BYTE: u64 = 64;

/// Memory that a file may still take.
pub(crate) struct MemoryLimit {
    left: u64,
    most: u64,
}

impl MemoryLimit {
    /// That of a file of a length in bytes.
    pub(crate) fn new(length: u64) -> MemoryLimit {
        let most = FLOOR_BYTES.saturating_add(BYTES_PER_BYTE.saturating_mul(length));
        MemoryLimit { left: most, most }
    }

    /// Pays for bytes that are about to be taken.
    ///
    /// # Errors
    /// When less is left.
    pub(crate) fn spend(&mut self, bytes: u64) -> Result<(), Issue> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| {
            let most = self.most >> 20;
            Issue::too_large(format!(
                "unfolds to far more than its size: over the {most} MiB that it may take"
            ))
            .with_advice("split the file, or place fewer copies")
        })?;
        Ok(())
    }

    /// Pays for a number of things of a size.
    ///
    /// # Errors
    /// When less is left.
    pub(crate) fn spend_on<T>(&mut self, count: usize) -> Result<(), Issue> {
        self.spend((count as u64).saturating_mul(size_of::<T>() as u64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_takes_a_floor_and_a_share_of_its_length() {
        let mut limit = MemoryLimit::new(1 << 20);
        limit.spend(256 << 20).unwrap();
        limit.spend_on::<u64>(8 << 20).unwrap();
        let refused = limit.spend(1).unwrap_err().to_string();
        assert!(refused.contains("over the 320 MiB that it may take: split the file"), "{refused}");
        assert!(MemoryLimit::new(u64::MAX).spend_on::<u64>(usize::MAX).is_ok());
    }
}
