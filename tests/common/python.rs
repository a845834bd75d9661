//! A Python with pandas, pyarrow and highspy, in an environment of its own below the target folder, made once.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use super::say;

const REQUIREMENTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/pandas/requirements.txt");

/// The interpreter. Where none can be made, `None` and a note; a failure where `PERIROBOT_REQUIRE_PYTHON=1`
/// promises one.
pub(crate) fn python() -> Option<PathBuf> {
    static ENVIRONMENT: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    match ENVIRONMENT.get_or_init(environment) {
        Ok(folder) => Some(interpreter(folder)),
        Err(why) => {
            let promised = std::env::var("PERIROBOT_REQUIRE_PYTHON").is_ok_and(|v| v == "1");
            assert!(!promised, "PERIROBOT_REQUIRE_PYTHON=1, but {why}");
            say(&format!("SKIPPED: {why}"));
            None
        }
    }
}

fn interpreter(environment: &Path) -> PathBuf {
    environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}

/// An environment with exactly the packages of the requirements; made beside its place, so that it is there
/// whole or not at all.
fn environment() -> Result<PathBuf, String> {
    let targets = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let ready = targets.join("python");
    let wanted = fs::read_to_string(REQUIREMENTS).unwrap();
    let made_of = |folder: &Path| fs::read_to_string(folder.join("requirements.txt")).unwrap_or_default();
    // The interpreter it was made with may be gone since.
    if made_of(&ready) == wanted && run(&interpreter(&ready), &["--version"]).is_ok() {
        return Ok(ready);
    }
    let new = targets.join(format!("python.{}", std::process::id()));
    let made = run(Path::new("python3"), &["-m", "venv", new.to_str().unwrap()]).and_then(|()| {
        let install = [
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--only-binary=:all:",
            "-r",
            REQUIREMENTS,
        ];
        run(&interpreter(&new), &install)
    });
    if let Err(why) = made {
        let _ = fs::remove_dir_all(&new);
        return Err(why);
    }
    fs::write(new.join("requirements.txt"), &wanted).unwrap();
    let _ = fs::remove_dir_all(&ready);
    if fs::rename(&new, &ready).is_err() && made_of(&ready) != wanted {
        return Err(format!("{} cannot be made", ready.display()));
    }
    Ok(ready)
}

/// Runs a program; what it complained of, if it failed.
pub(crate) fn run(program: &Path, arguments: &[&str]) -> Result<(), String> {
    let line = || format!("`{} {}`", program.display(), arguments.join(" "));
    let output =
        Command::new(program).args(arguments).output().map_err(|e| format!("{} failed: {e}", line()))?;
    if output.status.success() {
        return Ok(());
    }
    let said = [output.stdout, output.stderr].concat();
    Err(format!("{} failed: {}", line(), String::from_utf8_lossy(&said).trim_end()))
}
