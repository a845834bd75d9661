//! Reads a whole file into memory, if it is one. What the bytes mean is the loaders' affair.

use std::path::Path;

use crate::{Error, Result};

/// The bytes of a regular file. Pipes and devices are refused, since reading one may never end.
pub(super) fn read(path: &Path) -> Result<Vec<u8>> {
    let metadata = std::fs::metadata(path).map_err(|source| Error::io(path, "cannot be read", source))?;
    if !metadata.is_file() {
        return Err(Error::input(path.display(), "is not a regular file"));
    }
    let bytes = std::fs::read(path).map_err(|source| Error::io(path, "cannot be read", source))?;
    tracing::info!("read {}: {} bytes", path.display(), bytes.len());
    Ok(bytes)
}
