//! Where a study comes from: a file, or keys in memory.

use std::path::{Path, PathBuf};

use perirobot_march::{Error, Result};
use perirobot_scene::source::Sources;
use perirobot_study::input::{IN_MEMORY, Overrides, Study};
use pyo3::FromPyObject;

/// The name under which a study that was made in memory is told in messages.
const STUDY: &str = "(study)";

/// A file of a study, and what is brought in beside it.
pub(crate) struct FileOrigin {
    path: PathBuf,
    overrides: Overrides,
    packages: Vec<(String, PathBuf)>,
    allow_outside: bool,
    /// Whether the user's `xacro` may be run.
    xacro: bool,
    /// The interpreter that may convert STEP files.
    step_python: Option<PathBuf>,
    /// Files that are in memory only, by their paths.
    pub(crate) files: Vec<(PathBuf, Vec<u8>)>,
}

/// A file in memory.
#[derive(FromPyObject)]
pub(crate) enum MemoryFile {
    /// Its keys, as JSON.
    Keys(String),
    /// Whatever it is.
    Bytes(Vec<u8>),
}

impl FileOrigin {
    /// A file on the disk.
    pub(crate) fn file(
        path: PathBuf,
        overrides: Overrides,
        packages: Vec<(String, PathBuf)>,
        allow_outside: bool,
        xacro: bool,
        step_python: Option<PathBuf>,
    ) -> FileOrigin {
        FileOrigin { path, overrides, packages, allow_outside, xacro, step_python, files: Vec::new() }
    }

    /// Keys as JSON, beside files in memory that are named from a folder.
    pub(crate) fn memory(keys: &str, folder: &Path, files: Vec<(PathBuf, MemoryFile)>) -> Result<FileOrigin> {
        let mut origin =
            FileOrigin::file(folder.join(STUDY), Overrides::default(), Vec::new(), false, false, None);
        origin.files.push((origin.path.clone(), text("keys", keys)?));
        for (name, file) in files {
            let bytes = match file {
                MemoryFile::Keys(keys) => text(&name.display().to_string(), &keys)?,
                MemoryFile::Bytes(bytes) => bytes,
            };
            origin.files.push((folder.join(name), bytes));
        }
        Ok(origin)
    }

    /// Reads and checks the study.
    pub(crate) fn read(&self) -> Result<Study> {
        let named = self.packages.iter().map(|(name, folder)| (name.as_str(), folder.as_path()));
        let beside = Sources::from_main(&self.path);
        let sources = named.clone().fold(beside, |all, (name, folder)| all.with_package(name, folder));
        let sources =
            self.files.iter().fold(sources, |all, (path, bytes)| all.with_file(path, bytes.clone()));
        let sources = if self.allow_outside { sources.allow_outside() } else { sources };
        let sources = if self.xacro { sources.allow_xacro() } else { sources };
        let sources = match &self.step_python {
            Some(python) => sources.allow_step(python),
            None => sources,
        };
        let mut study = Study::read(&self.path, &self.overrides, sources)?;
        study.scenes.iter_mut().for_each(|scene| scene.use_packages(named.clone()));
        Ok(study)
    }
}

/// Keys from JSON.
pub(crate) fn table(json: &str) -> Result<toml::Table> {
    read("keys", json)
}

/// Keys of something from JSON.
fn read(of: &str, json: &str) -> Result<toml::Table> {
    serde_json::from_str(json).map_err(|e| {
        // The place in the JSON, which the user has never seen, is left out.
        let what = e.to_string();
        let what = what.split(" at line ").next().unwrap_or(&what);
        Error::input(of, format!("cannot be the keys of a file: {what}"))
    })
}

/// Keys from JSON as a file has them.
fn text(of: &str, json: &str) -> Result<Vec<u8>> {
    let text = toml::to_string(&read(of, json)?).map_err(|e| Error::input(of, e.to_string()))?;
    Ok(format!("{IN_MEMORY}{text}").into_bytes())
}
