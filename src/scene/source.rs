//! Reads all files that a study names: only regular ones, only from the folders that it may read, none above
//! a size, and records the hash of each.

mod folder;
mod formats;
mod limit;
mod step;
mod table;
mod text;
mod xacro;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::{File, Metadata};
use std::io::{ErrorKind, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use sha2::{Digest, Sha256};

use crate::spelling::nearest;
pub use formats::{accepted_formats, ending, is_other_format};
pub(crate) use limit::MemoryLimit;
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::{Error, Result};
pub(crate) use step::{Layered, is_step};
pub use table::{decimal_commas, refuse_other_separators, refuse_width, table_issue};
pub(crate) use text::{lines, strip_mark};

/// Most bytes of files that people write: studies, scenes, robots, joints of a person. Some parsers need many
/// times as much.
const MOST_BYTES_OF_TEXT: u64 = 64 << 20;
/// Most bytes of files that programs write: meshes, maps, tables of poses and rays.
const MOST_BYTES_OF_DATA: u64 = 1 << 30;

/// Where the files of one study (or of one scene that is read alone) may lie, and which of them were read.
/// Clones share the list.
#[derive(Clone, Debug)]
pub struct Sources {
    /// The file named on the command line.
    main: PathBuf,
    /// Folders that may be read from besides the main file's, by the names of their packages.
    packages: Vec<(String, PathBuf)>,
    outside: bool,
    /// Whether xacros may be expanded, which may run what they say.
    xacro: bool,
    /// The Python that may convert STEP files.
    step_python: Option<PathBuf>,
    /// Files that are in memory only, by the paths under which they are named.
    given: BTreeMap<PathBuf, Arc<[u8]>>,
    record: Arc<Mutex<Record>>,
    /// Whether a file could not be read for a reason that may go away, such as a failing disk.
    failed: Arc<AtomicBool>,
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ReadFile {
    /// As the study names it, from the folder of the main file and with forward slashes; `package://name/…`
    /// for files in a package's folder. It is the same on two machines, unless the study names an absolute
    /// path.
    pub path: PathBuf,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// Hashes of what was read.
#[derive(Debug, Default)]
struct Record {
    by_name: BTreeMap<String, String>,
    /// By the place on the disk, since a file may have several names.
    by_place: HashMap<PathBuf, String>,
    expanded: xacro::Expanded,
    converted: step::Converted,
    remarks: Vec<String>,
}

impl Sources {
    /// The file itself and what lies in its folder or below.
    pub fn from_main(main: &Path) -> Sources {
        let (given, record, failed) = Default::default();
        let (packages, step_python) = (Vec::new(), None);
        let (outside, xacro) = (false, false);
        Sources { main: main.into(), packages, outside, xacro, step_python, given, record, failed }
    }

    /// And a file that is in memory only, whatever is on the disk under its path.
    #[must_use]
    pub fn with_file(mut self, path: &Path, bytes: Vec<u8>) -> Sources {
        self.given.insert(path.into(), bytes.into());
        self
    }

    /// And what lies in the folder of a package, or below.
    #[must_use]
    pub fn with_package(mut self, name: &str, folder: &Path) -> Sources {
        self.packages.push((name.into(), folder.into()));
        self
    }

    /// And all other files.
    #[must_use]
    pub fn allow_outside(self) -> Sources {
        Sources { outside: true, ..self }
    }

    /// A file that people write, of at most 64 MiB.
    ///
    /// # Errors
    /// When the file cannot be read, is not a regular one, lies outside, is too large, or is not UTF-8. When
    /// its bytes are others than at an earlier read.
    pub fn text(&self, path: &Path) -> Result<String> {
        utf8(path, self.read(path, MOST_BYTES_OF_TEXT)?)
    }

    /// XML that a program writes, of at most 64 MiB: in UTF-8 or UTF-16, whatever its declaration says.
    ///
    /// # Errors
    /// As [`Sources::text`], and when it is in neither.
    pub fn xml(&self, path: &Path) -> Result<String> {
        let bytes = self.read(path, MOST_BYTES_OF_TEXT)?;
        text::utf8_or_utf16(bytes).map_err(|issue| issue.with_place(path).into())
    }

    /// A table that a program writes, of at most 1 GiB.
    ///
    /// # Errors
    /// As [`Sources::text`].
    pub fn table(&self, path: &Path) -> Result<String> {
        utf8(path, self.read(path, MOST_BYTES_OF_DATA)?)
    }

    /// A mesh, a map, or a part of one, of at most 1 GiB.
    ///
    /// # Errors
    /// As [`Sources::text`], but for what the bytes are.
    pub(crate) fn bytes(&self, path: &Path) -> Result<Vec<u8>> {
        self.read(path, MOST_BYTES_OF_DATA)
    }

    /// The bytes of a file that begins with text, without a byte-order mark.
    ///
    /// # Errors
    /// As [`Sources::bytes`], and when the text is in UTF-16 or UTF-32.
    pub(crate) fn bytes_of_text(&self, path: &Path) -> Result<Vec<u8>> {
        strip_mark(self.bytes(path)?).map_err(|issue| issue.with_place(path).into())
    }

    /// Keeps what a reader did with a file that its user may not expect, for a warning.
    pub(crate) fn remark(&self, path: &Path, what: impl std::fmt::Display) {
        let mut record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        record.remarks.push(format!("{}: {what}", path.display()));
    }

    /// The remarks since the last call, each once.
    pub fn take_remarks(&self) -> Vec<String> {
        let mut record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        let mut seen = HashSet::new();
        let remarks = std::mem::take(&mut record.remarks).into_iter();
        remarks.filter(|remark| seen.insert(remark.clone())).collect()
    }

    /// The files read so far, each once, sorted by path.
    pub fn read_files(&self) -> Vec<ReadFile> {
        let record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        let file =
            |(name, sha256): (&String, &String)| ReadFile { path: name.into(), sha256: sha256.clone() };
        record.by_name.iter().map(file).collect()
    }

    /// Whether this file, under any name, is one of them.
    pub fn has_read(&self, path: &Path) -> bool {
        let record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        path.canonicalize().is_ok_and(|place| record.by_place.contains_key(&place))
    }

    /// Turns an error about files into one of the disk if a file could not be read for a reason that may go
    /// away, since the input may then be right.
    pub fn classify(&self, problems: Vec<Error>) -> Vec<Error> {
        let of_storage = |issue| match issue {
            Error::Input(issue) => Error::Storage(issue),
            other => other,
        };
        match self.failed.load(Ordering::Relaxed) {
            true => problems.into_iter().map(of_storage).collect(),
            false => problems,
        }
    }

    fn read(&self, path: &Path, most_bytes: u64) -> Result<Vec<u8>> {
        let read = self.read_once(path, most_bytes);
        if matches!(read, Err(Error::Storage(_))) {
            self.failed.store(true, Ordering::Relaxed);
        }
        read
    }

    fn read_once(&self, path: &Path, most_bytes: u64) -> Result<Vec<u8>> {
        if let Some(given) = self.given.get(path) {
            self.note(path, path.into(), given)?;
            return Ok(given.to_vec());
        }
        let path = &*resolve_backslashes(path);
        let unreadable = |source| Error::io(path, "cannot be read", source);
        let place = path.canonicalize().map_err(|e| match path.read_link() {
            Ok(target) if e.kind() == ErrorKind::NotFound => {
                Error::input(path, format!("is a link to {}, which is not there", target.display()))
            }
            _ if Error::is_link_loop(&e) => Error::input(path, "is behind links that lead in a circle")
                .with_advice("put the file there, or mend the link"),
            _ if e.kind() == ErrorKind::NotFound => self.with_nearest(path, unreadable(e)),
            _ => unreadable(e),
        })?;
        self.refuse_outside(path, &place)?;
        // Opening a pipe would wait for its writer, so the kind of file is checked before it is opened, and
        // again afterwards.
        check(path, &place.metadata().map_err(unreadable)?, most_bytes)?;
        let file = File::open(&place).map_err(unreadable)?;
        let length = check(path, &file.metadata().map_err(unreadable)?, most_bytes)?;
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(length as usize + 1).map_err(|e| {
            Issue::too_large(format!("has {length} bytes, for which there is no memory: {e}"))
                .with_place(path)
        })?;
        // Reading one byte more than its length shows whether it has grown.
        file.take(length + 1).read_to_end(&mut bytes).map_err(unreadable)?;
        if bytes.len() as u64 != length {
            return Err(changed_file(path));
        }
        if bytes.starts_with(b"version https://git-lfs.github.com/spec/") {
            return Err(Error::input(path, "is a pointer of Git LFS, not the file itself")
                .with_advice("run `git lfs pull`"));
        }
        self.note(path, place, &bytes)?;
        log::info!("read {}: {} bytes", path.display(), bytes.len());
        Ok(bytes)
    }

    /// The error for a file that is not there, with the nearest name that is: of a folder on its path, or of
    /// a file beside it.
    fn with_nearest(&self, path: &Path, error: Error) -> Error {
        let slashed = PathBuf::from(path.to_string_lossy().replace('\\', "/"));
        let instead = || {
            let path = slashed.as_path();
            let upwards: Vec<&Path> = path.ancestors().filter(|part| !part.as_os_str().is_empty()).collect();
            let missing = *upwards.iter().rev().find(|part| !part.exists())?;
            let (name, folder) = (missing.file_name()?.to_str()?, folder_of(missing));
            self.refuse_outside(path, &folder.canonicalize().ok()?).ok()?;
            let wants_folder = missing != path;
            let entries = std::fs::read_dir(&folder).ok()?.flatten();
            let fits = entries.filter(|entry| entry.path().is_dir() == wants_folder);
            let mut names: Vec<String> =
                fits.filter_map(|entry| entry.file_name().into_string().ok()).collect();
            // Of names that are equally near, one of the same kind comes first.
            names.sort_by_key(|other| (split(other).1 != split(name).1, other.clone()));
            let namesake = names.iter().find(|other| other.to_lowercase() == name.to_lowercase());
            let stem = nearest(split(name).0, names.iter().map(|other| split(other).0));
            let near = names.iter().find(|other| Some(split(other).0) == stem);
            let what = match (namesake, near) {
                (Some(other), _) => format!("there is {other:?}: upper and lower case are told apart"),
                (None, Some(other)) => format!("there is {other:?}: is that meant?"),
                (None, None) => String::new(),
            };
            let missing = match wants_folder {
                true => format!("there is no folder {name:?} in {}", folder.display()),
                false => String::new(),
            };
            Some([missing, what].into_iter().filter(|said| !said.is_empty()).collect::<Vec<_>>().join("; "))
        };
        if path.to_string_lossy().contains(char::is_control) {
            return error.cure(
                "its name has a control character: between \" in TOML a backslash begins an escape, so write paths with /",
            );
        }
        match instead().filter(|said| !said.is_empty()) {
            Some(said) => error.cure(said),
            None => error,
        }
    }

    /// `place` is where the path leads when all links are followed, so that none leads out.
    fn refuse_outside(&self, path: &Path, place: &Path) -> Result<()> {
        let home = folder_of(&self.main);
        let mut trees = self.packages.iter().map(|(_, folder)| folder.as_path()).chain([home.as_path()]);
        let inside = |tree: &Path| tree.canonicalize().is_ok_and(|tree| place.starts_with(tree));
        if self.outside || path == self.main || trees.any(inside) {
            return Ok(());
        }
        let home = home.canonicalize().unwrap_or_else(|_| home.clone());
        let what = format!(
            "lies outside of {} and the folders below, where {} is",
            home.display(),
            self.main.display()
        );
        let cure = Words::from("put it there, name its folder with ")
            + Argument("package").with_value("NAME=DIR")
            + " if it is of a robot's package, or allow all files with "
            + Argument("allow outside");
        Err(Error::input(path, what).with_advice(cure))
    }

    fn note(&self, path: &Path, place: PathBuf, bytes: &[u8]) -> Result<()> {
        let sha256 = sha256([bytes]);
        let mut record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        let name = self.name(path);
        let before = [record.by_place.get(&place), record.by_name.get(&name)];
        if before.into_iter().flatten().any(|before| *before != sha256) {
            return Err(changed_file(path));
        }
        record.by_place.insert(place, sha256.clone());
        record.by_name.insert(name, sha256);
        Ok(())
    }

    /// The name of a file in the list of [`Sources::read_files`].
    pub fn name(&self, path: &Path) -> String {
        for (package, folder) in &self.packages {
            if let Ok(rest) = path.strip_prefix(folder) {
                return format!("package://{package}/{}", with_slashes(rest));
            }
        }
        let home = self.main.parent().unwrap_or(Path::new(""));
        with_slashes(path.strip_prefix(home).unwrap_or(path))
    }
}

/// The stem of a file's name and what follows its last dot.
fn split(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or((name, ""))
}

fn utf8(path: &Path, bytes: Vec<u8>) -> Result<String> {
    text::utf8(bytes).map_err(|issue| issue.with_place(path).into())
}

/// The path with the slashes of this system, if only that is there: programs of Windows write backslashes.
pub(crate) fn resolve_backslashes(path: &Path) -> Cow<'_, Path> {
    let other =
        path.to_str().filter(|text| text.contains('\\')).map(|text| PathBuf::from(text.replace('\\', "/")));
    match other {
        Some(other) if !path.exists() && other.exists() => Cow::Owned(other),
        _ => Cow::Borrowed(path),
    }
}

/// The length of a file that may be read.
fn check(path: &Path, metadata: &Metadata, most_bytes: u64) -> Result<u64> {
    if !metadata.is_file() {
        return Err(Error::input(path, "is not a regular file"));
    }
    match metadata.len() {
        length if length > most_bytes => {
            let most = most_bytes >> 20;
            Err(Issue::too_large(format!("has {length} bytes"))
                .with_advice(format!("at most {most} MiB are read"))
                .with_place(path)
                .into())
        }
        length => Ok(length),
    }
}

fn changed_file(path: &Path) -> Error {
    Error::from(
        Issue::says("changed while it was being read")
            .with_advice("run again when nothing writes to it")
            .with_place(path),
    )
}

fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.into(),
        _ => ".".into(),
    }
}

fn with_slashes(path: &Path) -> String {
    if path.is_absolute() {
        return path.display().to_string();
    }
    let parts = path.components().filter(|part| *part != Component::CurDir);
    parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Hash of parts after each other.
pub fn sha256<const N: usize>(parts: [&[u8]; N]) -> String {
    let mut hash = Sha256::new();
    parts.iter().for_each(|part| hash.update(part));
    hex(&hash.finalize())
}

/// The bytes of 32-bit numbers in little-endian order, as they are in the memory of most machines.
pub fn little_endian<T: bytemuck::NoUninit>(numbers: &[T]) -> Cow<'_, [u8]> {
    match cfg!(target_endian = "little") {
        true => bytemuck::cast_slice(numbers).into(),
        false => bytemuck::cast_slice(numbers).iter().flat_map(|n: &u32| n.to_le_bytes()).collect(),
    }
}

/// Bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests;
