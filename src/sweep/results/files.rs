//! Atomic files: written under another name next to their path, then renamed.

mod part;

use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use serde_json::error::Category;

use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::{Error, Result};
use perirobot_scene::source::Sources;

/// The counts of a sweep, in its folder.
pub const JOURNAL: &str = "counts.journal";

/// The manifest of a sweep, in its folder.
pub const MANIFEST: &str = "manifest.json";

/// The file with the evidence of a device's wrong counts.
pub const DISAGREEMENT: &str = "disagreement.json";

/// The journal with the rows of that device, set aside.
pub const DISAGREED: &str = "disagreement.journal";

pub use part::abandon;
use part::{PartialFile, tidy};

/// A file that replaces its path when complete: readers see the old bytes or the new ones, never a part. If it is
/// dropped before [`WholeFile::commit`], no file is left.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    part: PartialFile,
}

impl WholeFile {
    /// Creates the temporary file. It is not buffered: write large pieces.
    pub fn create(path: &Path) -> Result<Self> {
        let part = match path.is_dir() {
            true => Err(ErrorKind::IsADirectory.into()),
            false => PartialFile::create(path),
        };
        let part = part.map_err(|e| cannot_write(path, e))?;
        Ok(WholeFile { path: path.into(), part })
    }

    /// The same on a full disk: writes go to a device that is always full.
    #[cfg(all(test, target_os = "linux"))]
    pub(crate) fn on_full_disk(mut self) -> Self {
        self.part.file = fs::File::options().write(true).open("/dev/full").unwrap();
        self
    }

    /// Syncs the file to disk and renames it to its path.
    pub fn commit(self) -> Result<()> {
        let synced = self.part.file.sync_all();
        let renamed = synced.and_then(|()| fs::rename(&self.part.path, &self.path));
        renamed.and_then(|()| sync_folder_of(&self.path)).map_err(|e| cannot_write(&self.path, e))?;
        log::info!("wrote {}", self.path.display());
        Ok(())
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.part.file.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.part.file.flush()
    }
}

/// Syncs the name of a new file to disk.
pub fn sync_folder_of(path: &Path) -> std::io::Result<()> {
    match cfg!(unix) {
        true => fs::File::open(folder_of(path))?.sync_all(),
        false => Ok(()),
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The error of a failed write: an input error if the path is wrong, else a disk error.
pub fn cannot_write(path: &Path, source: std::io::Error) -> Error {
    match Error::may_pass(&source) {
        false => Error::io(path, "cannot be written", source),
        true => Error::storage(path, source),
    }
}

/// Removes the files among some paths.
///
/// # Errors
/// If one cannot be removed.
pub fn remove_files(paths: impl IntoIterator<Item = PathBuf>) -> Result<()> {
    let is_file = |path: &PathBuf| path.symlink_metadata().is_ok_and(|found| found.is_file());
    for path in paths.into_iter().filter(is_file) {
        std::fs::remove_file(&path).map_err(|e| Error::io(&path, "cannot be removed", e))?;
    }
    Ok(())
}

/// Writes a file atomically from memory.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes).map_err(|e| cannot_write(path, e))?;
    file.commit()
}

/// Most bytes of a manifest or a table of poses; real ones are smaller.
const MOST_BYTES: u64 = 1 << 30;

/// Opens a file of a sweep's folder for reading. Only a regular one: a pipe would wait for its writer.
pub(crate) fn open_regular(path: &Path, most_bytes: u64) -> Result<fs::File> {
    let unreadable = |e| Error::io(path, "cannot be read", e);
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(Error::input(path, "is not a regular file"));
    }
    if metadata.len() > most_bytes {
        let what = format!("has {} bytes: at most {} MiB are read", metadata.len(), most_bytes >> 20);
        return Err(Error::input(path, what));
    }
    fs::File::open(path).map_err(unreadable)
}

/// The issue of a damaged JSON file of the program.
pub fn json_issue(e: &serde_json::Error) -> Issue {
    match e.classify() {
        Category::Eof => Issue::damaged("is cut off"),
        _ => Issue::damaged(format!("is not as it was written: {e}")),
    }
}

/// The bytes of a manifest or a table of poses.
pub fn read_regular(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = open_regular(path, MOST_BYTES)?.take(MOST_BYTES).read_to_end(&mut bytes);
    read.map_err(|e| Error::io(path, "cannot be read", e))?;
    Ok(bytes)
}

/// Verdicts on requirements, in the folder of a judged sweep.
pub const REQUIREMENTS: &str = "requirements.csv";

/// The same as typed JSON, with the scores under each condition, in the folder of a judged sweep.
pub const JUDGE_JSON: &str = "judge.json";

/// Scores under each condition, in the folder of a judged sweep.
pub const CONDITIONS: &str = "conditions.csv";

/// Drawn mounts, in the folder of a judged sweep.
pub const DRAWS: &str = "draws.csv";

/// A controller's measurements with sets of sensors, in the folder of a judged sweep.
pub const SEPARATION: &str = "separation.csv";

/// Verdicts at each speed of the robot, in the folder of a judged sweep.
pub const SPEEDS: &str = "speeds.csv";

/// The tables that are written at the end of a sweep, and later.
pub const TABLES: [&str; 12] = [
    "results.csv",
    "results.parquet",
    "scores.csv",
    "scores.parquet",
    "reasons.csv",
    "reasons.parquet",
    REQUIREMENTS,
    CONDITIONS,
    DRAWS,
    SEPARATION,
    SPEEDS,
    JUDGE_JSON,
];

/// The files that exist from its start.
pub const BEGUN: [&str; 3] = [JOURNAL, MANIFEST, "poses.csv"];

/// A writable output folder. Folders created by this run are removed again if they stay empty.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Created folders, innermost first.
    made: Vec<PathBuf>,
}

impl OutputFolder {
    /// Creates the folder if needed and checks that the files of a sweep can be written in it.
    pub fn open(path: &Path) -> Result<Self> {
        if path.as_os_str().is_empty() {
            let empty = Words::from(Argument("out")) + " is empty";
            return Err(Issue::says(empty).with_advice("name a folder for the results").into());
        }
        let missing = path.ancestors().filter(|p| !p.as_os_str().is_empty()).take_while(|p| !p.exists());
        let folder = OutputFolder { path: path.into(), made: missing.map(Path::to_path_buf).collect() };
        let cannot = |be: &str| Words::from(format!("cannot be {be} (")) + Argument("out") + ")";
        fs::create_dir_all(path).map_err(|e| Error::io(path, cannot("made a folder for results"), e))?;
        PartialFile::create(&path.join("probe")).map_err(|e| Error::io(path, cannot("written to"), e))?;
        for file in BEGUN.iter().chain(&TABLES).map(|name| path.join(name)) {
            if file.is_dir() {
                let what = Words::from("is a folder, and ") + Argument("out") + " needs a file there";
                return Err(Error::input(file, what).with_advice("move it away"));
            }
        }
        Ok(folder)
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Removes temporary files of killed runs.
    pub(crate) fn tidy(&self) {
        tidy(&self.path, |name| BEGUN.contains(&name) || TABLES.contains(&name));
    }

    /// Removes the tables of an earlier sweep, unless it is the same sweep, since they would not belong to the
    /// manifest. Also removes the evidence of a device's wrong counts.
    pub(crate) fn clear(&self, is_same: bool) {
        let tables = TABLES.iter().filter(|_| !is_same);
        for name in tables.chain([&DISAGREEMENT, &DISAGREED]) {
            let _ = fs::remove_file(self.path.join(name));
        }
    }

    /// The first existing table.
    pub(crate) fn table(&self) -> Option<&'static str> {
        TABLES.into_iter().find(|name| self.path.join(name).exists())
    }

    /// Fails if a file of the sweep, or one of `more`, would overwrite a file of the study.
    pub fn spare(&self, sources: &Sources, more: &[&str]) -> Result<()> {
        let mut places = BEGUN.iter().chain(&TABLES).chain(more).map(|name| self.path.join(name));
        let Some(place) = places.find(|place| sources.has_read(place)) else { return Ok(()) };
        let what = Words::from("is a file of the study, but ") + Argument("out") + " would overwrite it";
        Err(Error::input(place, what).with_advice("name another folder"))
    }

    /// Writes a file of the folder atomically.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        write_whole(&self.path.join(name), bytes)
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        for folder in &self.made {
            // Fails unless the folder is empty, as intended.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// The shard folders below the folder of a sweep, in order of their numbers.
pub fn shards_below(out: &Path) -> Result<Vec<PathBuf>> {
    let number = |path: &Path| {
        let name = path.file_name()?.to_str()?.strip_prefix("shard-")?;
        let (number, of) = name.split_once("-of-")?;
        Some((of.parse::<u32>().ok()?, number.parse::<u32>().ok()?))
    };
    let entries = std::fs::read_dir(out).map_err(|e| Error::io(out, "cannot be read", e))?;
    let paths = entries.flatten().map(|entry| entry.path());
    let mut found: Vec<_> = paths.filter_map(|path| Some((number(&path)?, path))).collect();
    found.sort();
    if found.is_empty() {
        let cure = Words::from("name the sweep's ") + Argument("out") + ", or each shard's folder";
        return Err(Error::input(out, "has no shard folders (shard-0-of-4)").with_advice(cure));
    }
    Ok(found.into_iter().map(|(_, path)| path).collect())
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
    fn a_file_that_is_not_committed_never_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        write_whole(&path, b"old").unwrap();
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"new, and long").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()).len(), 2);
        drop(file);
        assert_eq!(names(folder.path()), ["table.csv"]);
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }

    #[test]
    fn a_failed_write_leaves_nothing_and_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        // A folder has the file's path: the temporary file is written, but the renaming fails.
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
    fn what_stands_in_the_way_is_not_written_through() {
        let folder = tempfile::tempdir().unwrap();
        let (victim, path) = (folder.path().join("victim"), folder.path().join("table.csv"));
        fs::write(&victim, b"precious").unwrap();
        // Names that were in use once, and another name of a table.
        let planted =
            ["", "."].map(|dot| folder.path().join(format!("{dot}table.csv.{}.part", std::process::id())));
        #[cfg(unix)]
        planted.iter().for_each(|planted| std::os::unix::fs::symlink(&victim, planted).unwrap());
        fs::write(&path, b"old").unwrap();
        let other = folder.path().join("other.csv");
        fs::hard_link(&path, &other).unwrap();
        let part = || WholeFile::create(&path).unwrap().part.path.clone();
        assert_ne!(part(), part());
        write_whole(&path, b"new").unwrap();
        OutputFolder::open(folder.path()).unwrap();
        let read = |path: &Path| fs::read_to_string(path).unwrap();
        assert_eq!([&victim, &other, &path].map(|path| read(path)), ["precious", "old", "new"]);
    }

    #[test]
    fn parts_that_nobody_writes_to_go() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let left = folder.path().join("table.csv.0123456789abcdef.part");
        let others = ["table.csv.mine.part", "other.csv.0123456789abcdef.part"];
        others.iter().for_each(|name| fs::write(folder.path().join(name), b"").unwrap());
        fs::write(&left, b"half").unwrap();
        let writing = fs::File::open(&left).unwrap();
        writing.lock().unwrap();
        let two = [WholeFile::create(&path).unwrap(), WholeFile::create(&path).unwrap()];
        assert!(left.exists() && two.iter().all(|file| file.part.path.exists()), "they are written to");
        drop(writing);
        two.into_iter().for_each(|file| file.commit().unwrap());
        write_whole(&path, b"new").unwrap();
        let mut expected = [&others[..], &["table.csv"]].concat();
        expected.sort();
        assert_eq!(names(folder.path()), expected);
    }

    #[test]
    fn folders_that_stay_empty_go_again() {
        let outer = tempfile::tempdir().unwrap();
        drop(OutputFolder::open(&outer.path().join("a/b/c")).unwrap());
        assert_eq!(names(outer.path()), [""; 0]);
        // An existing folder stays, and so does one with a result.
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
        // Longer than any file system allows, below a folder that would have to be created.
        let long = outer.path().join("new").join("x".repeat(5000));
        for path in [Path::new(""), &file, &file.join("below"), &occupied, &long] {
            let error = OutputFolder::open(path).unwrap_err().to_string();
            assert!(
                ["out is empty", "(out)", "and out needs"].iter().any(|part| error.contains(part)),
                "{error}"
            );
        }
        assert_eq!(names(outer.path()), ["file", "occupied"]);
    }
}
