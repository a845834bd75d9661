//! Expands xacros by the user's own program of that name, if the user allows it: such a file may run whatever it says.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::PoisonError;

use super::folder::{TemporaryFolder, output_end};
use super::{MOST_BYTES_OF_TEXT, Sources, sha256, utf8};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

/// What a xacro was expanded to, by its path, its arguments and the folders of packages.
pub(super) type Expanded = BTreeMap<(PathBuf, Vec<String>, Vec<(String, PathBuf)>), String>;

/// A module of Python that says where packages are.
const AMENT_INDEX: &str = include_str!("ament_index.py");

impl Sources {
    /// And xacros, which the program `xacro` on the path expands.
    #[must_use]
    pub fn allow_xacro(self) -> Sources {
        Sources { xacro: true, ..self }
    }

    /// What a xacro becomes with these arguments, `$(find NAME)` being the folder of a package; none if it may not be
    /// expanded. It is expanded once. Files of the packages are named by `package://NAME/`.
    ///
    /// # Errors
    /// When the program is not there or fails, or writes too much or no text. When it wrote something else at an earlier
    /// time.
    pub(crate) fn expand(
        &self,
        path: &Path,
        args: &BTreeMap<String, String>,
        packages: impl Iterator<Item = (String, PathBuf)>,
    ) -> Result<Option<String>> {
        if !self.xacro {
            return Ok(None);
        }
        let args: Vec<String> = args.iter().map(|(name, value)| format!("{name}:={value}")).collect();
        // The program runs elsewhere, and what is not there is its to tell.
        let whole = |folder: PathBuf| folder.canonicalize().unwrap_or(folder);
        let packages: Vec<(String, PathBuf)> = packages.map(|(name, folder)| (name, whole(folder))).collect();
        let key = (path.to_path_buf(), args, packages);
        let known = self.record.lock().unwrap_or_else(PoisonError::into_inner).expanded.get(&key).cloned();
        if known.is_some() {
            return Ok(known);
        }
        let text = name_by_package(utf8(path, run(path, &key.1, &key.2)?)?, &key.2);
        log::info!("expanded {}: {} bytes", path.display(), text.len());
        let mut record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        // What it includes is not listed, but what comes out is.
        let name = [&[self.name(path)], &key.1[..], &["(expanded)".into()]].concat().join(" ");
        record.by_name.insert(name, sha256([text.as_bytes()]));
        record.expanded.insert(key, text.clone());
        Ok(Some(text))
    }
}

/// The text with the files of packages named so that it is the same on every machine.
fn name_by_package(text: String, packages: &[(String, PathBuf)]) -> String {
    packages.iter().fold(text, |text, (name, folder)| {
        let (folder, package) = (folder.display(), format!("package://{name}/"));
        let text = text.replace(&format!("file://{folder}/"), &package);
        ['"', '\''].into_iter().fold(text, |text, quote| {
            text.replace(&format!("{quote}{folder}/"), &format!("{quote}{package}"))
        })
    })
}

/// A folder with [`AMENT_INDEX`] where Python looks for it.
fn ament_index() -> std::io::Result<TemporaryFolder> {
    let index = TemporaryFolder::new()?;
    let module = index.path().join("ament_index_python");
    std::fs::create_dir(&module)?;
    std::fs::write(module.join("__init__.py"), "")?;
    std::fs::write(module.join("packages.py"), AMENT_INDEX)?;
    Ok(index)
}

/// What the program writes.
fn run(path: &Path, args: &[String], packages: &[(String, PathBuf)]) -> Result<Vec<u8>> {
    let failed = |what: String| Error::from(Issue::says(what).with_place("xacro").with_place(path));
    // A name that begins with a hyphen would be taken for an option.
    let place = path.canonicalize().map_err(|e| Error::io(path, "cannot be read", e))?;
    let mut command = Command::new("xacro");
    command.arg(place).args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let index = ament_index().map_err(|e| failed(format!("no temporary folder can be made: {e}")))?;
    let before = std::env::var_os("PYTHONPATH").unwrap_or_default();
    let modules =
        std::env::join_paths([index.path().to_path_buf()].into_iter().chain(std::env::split_paths(&before)))
            .map_err(|e| failed(format!("PYTHONPATH cannot be set: {e}")))?;
    let packages: Vec<String> =
        packages.iter().map(|(name, folder)| format!("{name}={}", folder.display())).collect();
    command.env("PYTHONPATH", modules).env("PERIROBOT_PACKAGES", packages.join("\n"));
    let mut child = command.spawn().map_err(|e| match e.kind() {
        ErrorKind::NotFound => failed("the program is not on the path".into())
            .with_advice("ROS has it (source its setup file first), and so has `pip install xacro`"),
        _ => failed(format!("the program cannot be run: {e}")),
    })?;
    let (out, said) = (child.stdout.take(), child.stderr.take());
    // Both are read at once, so that neither waits for the other.
    let (out, said) = std::thread::scope(|scope| {
        let said = scope.spawn(|| read(said, u64::MAX));
        let out = read(out, MOST_BYTES_OF_TEXT + 1);
        if out.as_ref().map_or(true, |out| out.len() as u64 > MOST_BYTES_OF_TEXT) {
            // It ended by itself, or it ends now.
            let _ = child.kill();
        }
        (out, said.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    let (status, out) =
        (child.wait(), out.map_err(|e| failed(format!("what it writes cannot be read: {e}")))?);
    if out.len() as u64 > MOST_BYTES_OF_TEXT {
        let what = format!("writes more than {} MiB", MOST_BYTES_OF_TEXT >> 20);
        return Err(Issue::too_large(what).with_place("xacro").with_place(path).into());
    }
    match status {
        Ok(status) if status.success() => Ok(out),
        _ => {
            let said = output_end(&said.unwrap_or_default());
            Err(failed(format!("the program failed and says: {said}")))
        }
    }
}

fn read(from: Option<impl Read>, most: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.map_or(Ok(0), |from| from.take(most).read_to_end(&mut bytes))?;
    Ok(bytes)
}
