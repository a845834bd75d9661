//! Files that appear whole or not at all: written beside their place under another name, then renamed.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::{Error, Result};

/// Writes a file whole: readers see the old bytes or the new ones, never a part.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let cannot = |e| Error::io(path, "cannot be written", e);
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let write = || -> std::io::Result<()> {
        let mut file = fs::File::create(&part)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&part, path)
    };
    write().map_err(|e| {
        // The part is ours alone; if it never came to be, there is nothing to remove.
        let _ = fs::remove_file(&part);
        cannot(e)
    })
}

/// An output folder that is known to take files; if nothing was put into it and this run made it, it goes again.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    made: bool,
}

impl OutputFolder {
    /// Makes the folder where needed and proves that a file can be written in it.
    pub fn open(path: &Path) -> Result<Self> {
        let made = !path.exists();
        fs::create_dir_all(path)
            .map_err(|e| Error::io(path, "cannot be made a folder for results (--out)", e))?;
        let folder = OutputFolder { path: path.into(), made };
        let probe = path.join(format!(".{}.probe", std::process::id()));
        fs::write(&probe, b"")
            .and_then(|()| fs::remove_file(&probe))
            .map_err(|e| Error::io(path, "cannot be written to (--out)", e))?;
        Ok(folder)
    }

    /// Writes a file of the folder whole.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        write_whole(&self.path.join(name), bytes)
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if self.made {
            // Only succeeds while the folder is empty, which is when it should go.
            let _ = fs::remove_dir(&self.path);
        }
    }
}
