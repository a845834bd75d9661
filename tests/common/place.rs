//! A folder with what ships, where commands of the documents are run.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Ends of the names of files.
const FILES: [&str; 17] = [
    "toml", "png", "csv", "bt", "html", "npz", "glb", "stl", "urdf", "parquet", "json", "jsonl", "sh",
    "yaml", "ply", "pcd", "ppm",
];

/// The quick study with a quarter of its rays and twice its voxels: what is shown here is that commands work.
const THINNER: [(&str, &str); 3] = [
    ("voxel_size_m = 0.05", "voxel_size_m = 0.1"),
    ("resolution_px = [640, 360]", "resolution_px = [160, 90]"),
    ("resolution_deg = [0.4, 1.5]", "resolution_deg = [1.6, 3]"),
];

/// A file of the project.
pub(crate) fn root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Its text.
pub(crate) fn read(document: &str) -> String {
    fs::read_to_string(root(document)).unwrap_or_else(|e| panic!("{document}: {e}"))
}

/// Every Markdown file of the project, by its path.
pub(crate) fn pages() -> Vec<String> {
    fn below(folder: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() && !["target", ".git", "node_modules"].contains(&name.as_str()) {
                below(&path, found);
            } else if name.ends_with(".md") {
                let page = path.strip_prefix(root("")).unwrap();
                found.push(page.to_string_lossy().into_owned());
            }
        }
    }
    let mut found = Vec::new();
    for folder in ["benches", "scenes", "src", "tests"] {
        below(&root(folder), &mut found);
    }
    found.extend(["README.md", "CHANGELOG.md"].map(String::from));
    assert!(found.len() > 25, "{found:?}");
    found
}

/// A folder with what ships and a study of one's own, `my.toml`, where commands are run.
pub(crate) struct Place(tempfile::TempDir);

impl Place {
    pub(crate) fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        copy(&root("scenes"), &place.path("scenes"));
        let quick = THINNER.iter().fold(read("scenes/quick.toml"), |text, (from, to)| {
            assert!(text.contains(from), "scenes/quick.toml has no {from}");
            text.replace(from, to)
        });
        fs::write(place.path("scenes/quick.toml"), quick).unwrap();
        copy(&root("scenes/tiny"), &place.path("tiny"));
        // As many poses as the examples have shards.
        let mine = read("scenes/tiny.toml").replace("count = 4", "count = 100");
        fs::write(place.path("my.toml"), mine).unwrap();
        for folder in [".local/share/bash-completion/completions", ".zfunc", ".config/fish/completions"] {
            fs::create_dir_all(place.path("home").join(folder)).unwrap();
        }
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs a program here, with `perirobot` on its path; what it prints. It must succeed, and warn of
    /// nothing in the tutorial.
    #[track_caller]
    pub(crate) fn run(&self, program: &Path, arguments: &[&str], what: &str) -> String {
        let built = Path::new(env!("CARGO_BIN_EXE_perirobot")).parent().unwrap();
        let paths = std::env::var_os("PATH").unwrap_or_default();
        let path: OsString = [built.as_os_str(), ":".as_ref(), &paths].into_iter().collect();
        let mut command = Command::new(program);
        command.args(arguments).current_dir(self.0.path()).env("PATH", path).env("HOME", self.path("home"));
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        let arguments = arguments.join(" ");
        assert!(output.status.success(), "{what} ends with {}:\n{arguments}\n{said}", output.status);
        let is_quiet = !arguments.contains("scenes/tutorial/study.toml") || !said.contains("warning: ");
        assert!(is_quiet, "{what} warns:\n{arguments}\n{said}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs commands here, and looks for the files that they name; what they print.
    #[track_caller]
    pub(crate) fn shell(&self, commands: &str, what: &str) -> String {
        let printed = self.run(Path::new("sh"), &["-eu", "-c", commands], what);
        self.has_files(commands, what);
        printed
    }

    /// Panics unless each file that a text names is there; of one without a folder, anywhere.
    #[track_caller]
    pub(crate) fn has_files(&self, text: &str, what: &str) {
        let mut all = BTreeSet::new();
        names_below(self.0.path(), &mut all);
        let words = text.split(|c: char| c.is_whitespace() || "\"'(),;=#`".contains(c));
        for word in words {
            let word = word.trim_end_matches(['.', ':']);
            let is_file =
                word.rsplit_once('.').is_some_and(|(stem, end)| !stem.is_empty() && FILES.contains(&end));
            if !is_file || word.contains(['*', '…', '<', '{', ':']) {
                continue;
            }
            let path = match word.strip_prefix("~/") {
                Some(below) => self.path("home").join(below),
                None => self.path(word),
            };
            assert!(
                path.exists() || all.contains(word),
                "{what} names {word}, which is not there afterwards"
            );
        }
    }
}

/// A folder and all below it, but for pictures: those that commands draw must be drawn.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else if path.extension().is_none_or(|extension| extension != "png") {
            fs::copy(&path, &target).unwrap();
        }
    }
}

fn names_below(folder: &Path, names: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        names.insert(path.file_name().unwrap().to_string_lossy().into_owned());
        if path.is_dir() {
            names_below(&path, names);
        }
    }
}
