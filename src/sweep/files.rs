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

/// The files of a sweep.
pub const RESULT_FILES: [&str; 4] = ["poses.csv", "results.csv", "scores.csv", "manifest.json"];

/// An output folder that is known to take files. Folders that this run made go again if nothing was put into them.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Folders that were not there before, innermost first.
    made: Vec<PathBuf>,
}

impl OutputFolder {
    /// Makes the folder where needed and proves that the files of a sweep can be written in it.
    pub fn open(path: &Path) -> Result<Self> {
        if path.as_os_str().is_empty() {
            return Err(Error::Input("--out is empty: name a folder for the results".into()));
        }
        let missing = path.ancestors().filter(|p| !p.as_os_str().is_empty()).take_while(|p| !p.exists());
        let folder = OutputFolder { path: path.into(), made: missing.map(Path::to_path_buf).collect() };
        fs::create_dir_all(path)
            .map_err(|e| Error::io(path, "cannot be made a folder for results (--out)", e))?;
        let probe = path.join(format!(".{}.probe", std::process::id()));
        fs::write(&probe, b"")
            .and_then(|()| fs::remove_file(&probe))
            .map_err(|e| Error::io(path, "cannot be written to (--out)", e))?;
        for file in RESULT_FILES.map(|name| path.join(name)) {
            if file.is_dir() {
                return Err(Error::input(
                    file.display(),
                    "is a folder, and --out needs a file there: move it away",
                ));
            }
        }
        Ok(folder)
    }

    /// Writes a file of the folder whole.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        write_whole(&self.path.join(name), bytes)
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        for folder in &self.made {
            // Only succeeds while the folder is empty, which is when it should go.
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names in a folder, sorted.
    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        write_whole(&path, b"a long first version").unwrap();
        write_whole(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["table.csv"]);
    }

    #[test]
    fn a_failed_write_leaves_nothing_and_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        // A folder in the file's place: the part is written, the renaming fails.
        let path = folder.path().join("table.csv");
        fs::create_dir(&path).unwrap();
        fs::write(path.join("kept"), b"").unwrap();
        let error = write_whole(&path, b"new").unwrap_err().to_string();
        assert!(error.contains("table.csv") && error.contains("cannot be written"), "{error}");
        assert_eq!(names(folder.path()), ["table.csv"]);
        assert_eq!(names(&path), ["kept"]);
        assert!(write_whole(&folder.path().join("no/such/table.csv"), b"new").is_err());
    }

    #[test]
    fn folders_that_stay_empty_go_again() {
        let outer = tempfile::tempdir().unwrap();
        drop(OutputFolder::open(&outer.path().join("a/b/c")).unwrap());
        assert_eq!(names(outer.path()), [""; 0]);
        // One that was there stays, and so does one that holds a result.
        drop(OutputFolder::open(outer.path()).unwrap());
        let folder = OutputFolder::open(&outer.path().join("a/b")).unwrap();
        folder.write("poses.csv", b"pose").unwrap();
        drop(folder);
        assert_eq!(names(&outer.path().join("a/b")), ["poses.csv"]);
    }

    #[test]
    fn folders_that_cannot_take_results_are_refused() {
        let outer = tempfile::tempdir().unwrap();
        let file = outer.path().join("file");
        fs::write(&file, b"").unwrap();
        let occupied = outer.path().join("occupied");
        fs::create_dir_all(occupied.join("results.csv")).unwrap();
        // Longer than any file system takes, below a folder that would have to be made.
        let long = outer.path().join("new").join("x".repeat(5000));
        for path in [Path::new(""), &file, &file.join("below"), &occupied, &long] {
            let error = OutputFolder::open(path).unwrap_err().to_string();
            assert!(error.contains("--out"), "{error}");
        }
        assert_eq!(names(outer.path()), ["file", "occupied"]);
    }
}
