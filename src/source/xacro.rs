//! Expands xacros by the user's own program of that name, if the user allows it: such a file may run whatever it says.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::PoisonError;

use super::{MOST_BYTES_OF_TEXT, Sources, sha256, utf8};
use crate::error::Issue;
use crate::{Error, Result};

/// Most of what the program says of a failure that is told.
const MOST_SAID: usize = 2000;

/// What a xacro was expanded to, by its path and its arguments.
pub(super) type Expanded = BTreeMap<(std::path::PathBuf, Vec<String>), String>;

impl Sources {
    /// And xacros, which the program `xacro` on the path expands.
    #[must_use]
    pub fn allow_xacro(self) -> Sources {
        Sources { xacro: true, ..self }
    }

    /// What a xacro becomes with these arguments; none if it may not be expanded. It is expanded once.
    ///
    /// # Errors
    /// When the program is not there or fails, or writes too much or no text. When it wrote something else at an earlier
    /// time.
    pub(crate) fn expanded(&self, path: &Path, args: &BTreeMap<String, String>) -> Result<Option<String>> {
        if !self.xacro {
            return Ok(None);
        }
        let args: Vec<String> = args.iter().map(|(name, value)| format!("{name}:={value}")).collect();
        let key = (path.to_path_buf(), args);
        let known = self.record.lock().unwrap_or_else(PoisonError::into_inner).expanded.get(&key).cloned();
        if known.is_some() {
            return Ok(known);
        }
        let text = utf8(path, run(path, &key.1)?)?;
        log::info!("expanded {}: {} bytes", path.display(), text.len());
        let mut record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        // What it includes is not listed, but what comes out is.
        let name = [&[self.name(path)], &key.1[..], &["(expanded)".into()]].concat().join(" ");
        record.by_name.insert(name, sha256([text.as_bytes()]));
        record.expanded.insert(key, text.clone());
        Ok(Some(text))
    }
}

/// What the program writes.
fn run(path: &Path, args: &[String]) -> Result<Vec<u8>> {
    let failed = |what: String| Error::from(Issue::says(what).at("xacro").at(path));
    // A name that begins with a hyphen would be taken for an option.
    let place = path.canonicalize().map_err(|e| Error::io(path, "cannot be read", e))?;
    let mut command = Command::new("xacro");
    command.arg(place).args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| match e.kind() {
        ErrorKind::NotFound => failed("the program is not on the path".into())
            .wanted("ROS has it (source its setup file first), and so has `pip install xacro`"),
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
        return Err(Issue::too_large(what).at("xacro").at(path).into());
    }
    match status {
        Ok(status) if status.success() => Ok(out),
        _ => {
            let said = String::from_utf8_lossy(&said.unwrap_or_default()).trim().to_string();
            let begin = said.char_indices().rev().take(MOST_SAID).last().map_or(0, |(at, _)| at);
            Err(failed(format!("the program failed and says: {}", &said[begin..])))
        }
    }
}

fn read(from: Option<impl Read>, most: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.map_or(Ok(0), |from| from.take(most).read_to_end(&mut bytes))?;
    Ok(bytes)
}
