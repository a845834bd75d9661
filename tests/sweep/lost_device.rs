//! A Vulkan device that is lost in the middle of a sweep: others go on, and the counts are the same. A layer between
//! the program and the driver reports the loss as a driver does (`lost_device/layer.c`). `PERIROBOT`
//! names another program to test than the one that the tests build.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common;
use crate::common::program::{Folder, text};

/// Compiles the layer into a folder, with the manifest by which Vulkan's loader finds it.
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

/// Sweeps the small study with the program that `PERIROBOT` names, else the one that the tests built. The layer loses
/// devices as it is told.
fn sweep(folder: &Folder, out: &str, backend: &[&str], lose: &[(&str, &str)]) -> Output {
    let built = env!("CARGO_BIN_EXE_perirobot").into();
    let mut command = Command::new(std::env::var_os("PERIROBOT").unwrap_or(built));
    let (study, out) = (folder.path("study.toml"), folder.path(out));
    command.args(["sweep", text(&study), "--out", text(&out), "--progress=none"]).args(backend);
    command.env("VK_LAYER_PATH", folder.path("layers")).env("VK_INSTANCE_LAYERS", "VK_LAYER_lose");
    command.envs(lose.iter().copied());
    command.output().unwrap()
}

#[test]
fn when_a_device_is_lost_others_go_on() {
    let Some(on_adapter) = common::on_adapter() else { return };
    let folder = Folder::noisy();
    fs::create_dir(folder.path("layers")).unwrap();
    layer(&folder.path("layers"));
    let results = |out: &str| fs::read(folder.path(out).join("results.csv")).unwrap();
    assert!(sweep(&folder, "cpu", &["--backend", "cpu"], &[]).status.success());
    let cases: [(&str, &[(&str, &str)]); 4] = [
        ("first", &[("LOSE_DEVICES", "1"), ("LOSE_AT", "1")]),
        ("later", &[("LOSE_DEVICES", "1"), ("LOSE_AT", "2")]),
        ("all", &[("LOSE_DEVICES", "99"), ("LOSE_AT", "2")]),
        ("closing", &[("LOSE_DEVICES", "99"), ("LOSE_AT", "2"), ("LOSE_ON_CLOSE", "1")]),
    ];
    for (out, lose) in cases {
        let run = sweep(&folder, out, &on_adapter, lose);
        let said = String::from_utf8(run.stderr).unwrap();
        assert!(run.status.success(), "{:?}: {said}", run.status);
        assert!(said.contains("device lost: "), "{said}");
        assert_eq!(said.contains("queue idle on drop"), out == "closing", "{said}");
        assert_eq!(said.contains("panicked"), out == "closing", "{said}");
        assert!(results(out) == results("cpu"), "{out}: {said}");
    }
}
