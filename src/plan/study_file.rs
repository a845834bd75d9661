//! A file of the study on the disk, its own or that of a scene: read once, watched for changes by others and written whole.
//! The study's own is locked against a second planner.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::source::hex;
use perirobot_sweep::results::files::write_whole;
use sha2::{Digest, Sha256};

/// A file that is edited.
#[derive(Debug)]
pub struct StudyFile {
    path: PathBuf,
    /// As it was last read or written here.
    known: String,
    /// Held as long as the study is open.
    _lock: Option<File>,
}

impl StudyFile {
    /// Reads a study's file. Unless it is only to be read, it is locked.
    ///
    /// # Errors
    /// When it cannot be read or is not UTF-8; `Error::Busy` if another planner has it open.
    pub fn open(path: &Path, read_only: bool) -> Result<StudyFile> {
        let known = read(path)?;
        let lock = if read_only { None } else { lock(path)? };
        Ok(StudyFile { path: path.into(), known, _lock: lock })
    }

    /// Reads a file that goes with a study's and is not locked.
    ///
    /// # Errors
    /// When it cannot be read or is not UTF-8.
    pub fn open_unlocked(path: &Path) -> Result<StudyFile> {
        Ok(StudyFile { path: path.into(), known: read(path)?, _lock: None })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its name, without its folder.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into()
    }

    /// Its text as it was last read or written here.
    pub fn text(&self) -> &str {
        &self.known
    }

    /// Whether another program has changed it, or it is gone.
    pub fn is_changed_on_disk(&self) -> bool {
        fs::read(&self.path).map_or(true, |now| now != self.known.as_bytes())
    }

    /// Writes a text, unless it is what is on the disk.
    ///
    /// # Errors
    /// When the file cannot be written; then it is as it was.
    pub fn write_if_changed(&mut self, text: &str) -> Result<()> {
        if self.known == text && !self.is_changed_on_disk() {
            return Ok(());
        }
        // A link stays one: the file that it leads to is written.
        let target = fs::canonicalize(&self.path).unwrap_or_else(|_| self.path.clone());
        let permissions = fs::metadata(&target).map(|found| found.permissions());
        write_whole(&target, text.as_bytes())?;
        if let Ok(permissions) = permissions {
            // The file is written in any case.
            let _ = fs::set_permissions(&target, permissions);
        }
        self.known = text.into();
        Ok(())
    }

    /// Reads what is on the disk now.
    ///
    /// # Errors
    /// As [`StudyFile::open`].
    pub fn read(&self) -> Result<String> {
        read(&self.path)
    }

    /// Takes a text that was read as the one that is known to be on the disk.
    pub fn set_known(&mut self, text: String) {
        self.known = text;
    }
}

fn read(path: &Path) -> Result<String> {
    let bytes = fs::read(path).map_err(|e| Error::io(path, "cannot be read", e))?;
    String::from_utf8(bytes).map_err(|_| {
        Error::from(Issue::says("is not UTF-8 text").with_advice("save it as UTF-8").with_place(path))
    })
}

/// Locks a study against other planners; `None` if the file system of temporary files has no locks. The lock is on a file of
/// its own, since editors write a study as a new file under the same name.
fn lock(path: &Path) -> Result<Option<File>> {
    let whole = fs::canonicalize(path).map_err(|e| Error::io(path, "cannot be read", e))?;
    let name: String = hex(&Sha256::digest(whole.as_os_str().as_encoded_bytes()));
    let beside = std::env::temp_dir().join(format!("perirobot-plan-{}.lock", &name[..32]));
    let file = match File::options().create(true).append(true).open(&beside) {
        Ok(file) => file,
        Err(e) => {
            log::warn!("{} cannot be locked ({e}): open it in one planner only", path.display());
            return Ok(None);
        }
    };
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => {
            let what = "is open in another planner";
            let cure = "close that one, or open the study to be read only";
            Err(Error::Busy(Issue::says(what).with_advice(cure).with_place(path)))
        }
        Err(TryLockError::Error(e)) => {
            log::warn!("{} cannot be locked ({e}): open it in one planner only", path.display());
            Ok(None)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_written_if_it_differs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("study.toml");
        fs::write(&path, "a = 1\n").unwrap();
        let mut file = StudyFile::open(&path, false).unwrap();
        assert_eq!((file.text(), file.is_changed_on_disk()), ("a = 1\n", false));
        file.write_if_changed("a = 2\n").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "a = 2\n");
        fs::write(&path, "a = 3\n").unwrap();
        assert!(file.is_changed_on_disk());
        file.write_if_changed("a = 2\n").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "a = 2\n", "what was read is written again");
        let written = fs::metadata(&path).unwrap().modified().unwrap();
        file.write_if_changed("a = 2\n").unwrap();
        assert_eq!(fs::metadata(&path).unwrap().modified().unwrap(), written, "it is so already");
        fs::write(&path, "a = 5\n").unwrap();
        let text = file.read().unwrap();
        file.set_known(text);
        assert_eq!((file.text(), file.is_changed_on_disk()), ("a = 5\n", false));
        fs::remove_file(&path).unwrap();
        assert!(file.is_changed_on_disk(), "it is gone");
    }

    #[test]
    fn one_planner_has_it_open() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("study.toml");
        fs::write(&path, "a = 1\n").unwrap();
        let mut first = StudyFile::open(&path, false).unwrap();
        let refused = || matches!(StudyFile::open(&path, false), Err(Error::Busy(_)));
        assert!(refused());
        first.write_if_changed("a = 2\n").unwrap();
        assert!(refused(), "after it was saved, too");
        fs::rename(&path, folder.path().join("study.toml~")).unwrap();
        fs::copy(folder.path().join("study.toml~"), &path).unwrap();
        assert!(refused(), "after another program wrote it as a new file, too");
        StudyFile::open(&path, true).unwrap();
        drop(first);
        StudyFile::open(&path, false).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let [real, link] = ["real.toml", "link.toml"].map(|name| folder.path().join(name));
        fs::write(&real, "a = 1\n").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        StudyFile::open(&link, false).unwrap().write_if_changed("a = 2\n").unwrap();
        assert_eq!(fs::read_to_string(&real).unwrap(), "a = 2\n");
        assert!(link.symlink_metadata().unwrap().is_symlink());
    }
}
