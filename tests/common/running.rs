//! Sweeps that run in the background, to be disturbed.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use super::program::{Folder, Outcome, text};

/// Makes the small study one of some seconds: 311 choices of poses, each twice, with noise, and planes of
/// which few fit the memory that [`Running::sweep`] gives it, so that batches are small.
pub(crate) fn long(folder: &Folder) {
    folder.edit("study.toml", "voxel_size_m = 0.1", "voxel_size_m = 0.05");
    folder.edit("study.toml", "seed = 7", "seed = 7\nrepeats = 2");
    folder.edit("study.toml", "count = 2", "count = 302");
    folder.edit("study.toml", "[16, 9]", "[160, 90]");
    folder.edit("study.toml", "range_m = [0.1, 5.0]", "range_m = [0.1, 5.0]\nnoise = { std_m = 0.1 }");
    folder.edit("study.toml", "near_ignore_m = 0.05", "near_ignore_m = 0.05\nnoise = { std_m = 0.02 }");
}

/// A run of the program.
pub(crate) struct Running(Child);

impl Running {
    /// Starts a sweep of the study in a folder into `out` there: one thread, small batches.
    pub(crate) fn sweep(folder: &Folder, more: &[&str]) -> Running {
        let (study, out) = (folder.path("study.toml"), folder.path("out"));
        let fixed = ["sweep", text(&study), "--out", text(&out), "--threads", "1", "--memory", "1MiB"];
        let backend: &[&str] = if more.contains(&"--backend") { &[] } else { &["--backend", "cpu"] };
        Running::start(&[&fixed, backend, more].concat())
    }

    /// Starts the program.
    pub(crate) fn start(arguments: &[&str]) -> Running {
        let mut command = Command::new(env!("CARGO_BIN_EXE_perirobot"));
        command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
        Running(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
    }

    /// Waits until a journal has rows beyond those it had; whether it came so far.
    pub(crate) fn until_rows(&mut self, journal: &Path, before: u64) -> bool {
        while size(journal) <= before.max(128) {
            if self.0.try_wait().unwrap().is_some() {
                return false;
            }
            sleep(Duration::from_millis(2));
        }
        true
    }

    /// Waits until it would hear SIGTERM.
    #[cfg(target_os = "linux")]
    pub(crate) fn until_it_catches_signals(&mut self) {
        let status = format!("/proc/{}/status", self.0.id());
        let caught = |text: String| {
            let mask = text.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
            u64::from_str_radix(mask.trim(), 16).ok()
        };
        while fs::read_to_string(&status).ok().and_then(caught).is_none_or(|mask| mask >> 14 & 1 == 0) {
            assert!(self.0.try_wait().unwrap().is_none(), "it has ended");
            sleep(Duration::from_millis(2));
        }
    }

    /// Sends a signal; whether it was still there to take it.
    pub(crate) fn signal(&mut self, name: &str) -> bool {
        let there = self.0.try_wait().unwrap().is_none();
        let (signal, process) = (format!("-{name}"), self.0.id().to_string());
        there && Command::new("kill").args([&signal, &process]).status().unwrap().success()
    }

    /// Waits for its end.
    pub(crate) fn end(self) -> Outcome {
        let output = self.0.wait_with_output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let code = output.status.code();
        Outcome { code, stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

/// The size of a file; nothing if there is none.
pub(crate) fn size(path: &Path) -> u64 {
    fs::metadata(path).map_or(0, |of| of.len())
}

/// Fails unless both folders have the same counts and tables, byte for byte.
#[track_caller]
pub(crate) fn same_bytes(one: &Path, other: &Path) {
    for name in ["results.csv", "scores.csv", "poses.csv", "counts.journal"] {
        let bytes = |folder: &Path| fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(bytes(one) == bytes(other), "{name} differs");
    }
}
