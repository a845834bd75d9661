//! A Vulkan device that is lost in the middle of a sweep: others go on, and the counts are the same. A layer between
//! the program and the driver loses it (`lost_device/layer.c`), so that this is what a driver would do.

mod common;
#[allow(dead_code)]
#[path = "common/program.rs"]
mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use program::{Folder, text};

/// Compiles the layer into a folder, and says there what it is called.
fn layer(folder: &Path) {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/lost_device/layer.c");
    let library = folder.join("liblose.so");
    let mut compiler = Command::new("cc");
    compiler.args(["-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-o", text(&library), text(&source)]);
    assert!(compiler.status().expect("a C compiler links Rust, too").success());
    let described = format!(
        r#"{{"file_format_version": "1.2.0", "layer": {{"name": "VK_LAYER_lose", "type": "GLOBAL",
        "library_path": {:?}, "api_version": "1.3.0", "implementation_version": "1", "description": ""}}}}"#,
        text(&library)
    );
    fs::write(folder.join("lose.json"), described).unwrap();
}

/// Sweeps the small study with another program than the one that the tests built, if it is named. The layer loses
/// so many devices, at which of their waits is said, too.
fn sweep(folder: &Folder, out: &str, backend: &[&str], (at, devices): (u32, u32)) -> Output {
    let built = env!("CARGO_BIN_EXE_perirobot").into();
    let mut command = Command::new(std::env::var_os("PERIROBOT").unwrap_or(built));
    let (study, out) = (folder.path("study.toml"), folder.path(out));
    command.args(["sweep", text(&study), "--out", text(&out), "--progress=none"]).args(backend);
    command.env("VK_LAYER_PATH", folder.path("layers")).env("VK_INSTANCE_LAYERS", "VK_LAYER_lose");
    command.env("LOSE_AT", at.to_string()).env("LOSE_DEVICES", devices.to_string());
    command.output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn when_a_device_is_lost_others_go_on() {
    let Some(on_adapter) = common::on_adapter() else { return };
    let folder = Folder::noisy();
    fs::create_dir(folder.path("layers")).unwrap();
    layer(&folder.path("layers"));
    let results = |out: &str| fs::read(folder.path(out).join("results.csv")).unwrap();
    assert!(sweep(&folder, "cpu", &["--backend", "cpu"], (0, 0)).status.success());
    // The first of all devices, the second time that it is waited for; all that are tried.
    for (out, lost) in [("first", (1, 1)), ("later", (2, 1)), ("all", (2, 99))] {
        let run = sweep(&folder, out, &on_adapter, lost);
        let said = String::from_utf8(run.stderr).unwrap();
        assert!(run.status.success(), "{:?}: {said}", run.status);
        assert!(said.contains("device lost: "), "{said}");
        assert!(!said.contains("panicked"), "{said}");
        assert!(results(out) == results("cpu"), "{out}: {said}");
    }
}
