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

/// Runs the program that `PERIROBOT` names, else the one that the tests built. The layer loses devices as set.
fn run(folder: &Folder, args: &[&str], backend: &[&str], lose: &[(&str, &str)]) -> Output {
    let built = env!("CARGO_BIN_EXE_perirobot").into();
    let mut command = Command::new(std::env::var_os("PERIROBOT").unwrap_or(built));
    command.args(args).args(backend).current_dir(folder.path(""));
    command.env("VK_LAYER_PATH", folder.path("layers")).env("VK_INSTANCE_LAYERS", "VK_LAYER_lose");
    command.envs(lose.iter().copied());
    command.output().unwrap()
}

fn with_layer() -> Folder {
    let folder = Folder::noisy();
    fs::create_dir(folder.path("layers")).unwrap();
    layer(&folder.path("layers"));
    folder
}

#[test]
fn when_a_device_is_lost_others_go_on() {
    let Some(on_adapter) = common::on_adapter() else { return };
    let folder = with_layer();
    let sweep = |out: &str, backend: &[&str], lose: &[(&str, &str)]| {
        run(&folder, &["sweep", "study.toml", "--out", out, "--progress=none", "-v"], backend, lose)
    };
    let results = |out: &str| fs::read(folder.path(out).join("results.csv")).unwrap();
    assert!(sweep("cpu", &["--backend", "cpu"], &[]).status.success());
    let cases: [(&str, &[(&str, &str)]); 4] = [
        ("first", &[("LOSE_DEVICES", "1"), ("LOSE_AT", "1")]),
        ("later", &[("LOSE_DEVICES", "1"), ("LOSE_AT", "2")]),
        ("all", &[("LOSE_DEVICES", "99"), ("LOSE_AT", "2")]),
        ("closing", &[("LOSE_DEVICES", "99"), ("LOSE_AT", "2"), ("LOSE_ON_CLOSE", "1")]),
    ];
    for (out, lose) in cases {
        let run = sweep(out, &on_adapter, lose);
        let said = String::from_utf8(run.stderr).unwrap();
        assert!(run.status.success(), "{out}: {:?}: {said}", run.status);
        assert!(said.contains("device lost: "), "{out}: {said}");
        assert_eq!(said.contains("could not be closed: panicked"), out == "closing", "{out}: {said}");
        assert!(results(out) == results("cpu"), "{out}: {said}");
    }
}

/// Commands that end in another way than `sweep`: their devices did their work, or cannot be replaced.
#[test]
fn a_device_that_cannot_be_closed_ends_no_command() {
    let Some(on_adapter) = common::on_adapter() else { return };
    let folder = with_layer();
    let commands: [&[&str]; 6] = [
        &["check", "study.toml"],
        &["verify-backends", "study.toml", "--poses", "2"],
        &["bench", "study.toml", "--poses", "2"],
        &["sweep", "study.toml", "--out", "swept", "--progress=none"],
        &["report", "swept", "--out", "report.html"],
        &["render", "study.toml", "--out", "picture.png"],
    ];
    // Lost at the first wait, and never lost.
    for at in ["1", "1000000"] {
        for args in commands {
            let _ = fs::remove_dir_all(folder.path("swept"));
            if args.contains(&"swept") && args[0] != "sweep" {
                let sweep = ["sweep", "study.toml", "--out", "swept", "--progress=none"];
                assert!(run(&folder, &sweep, &["--backend", "cpu"], &[]).status.success());
            }
            let lose = [("LOSE_DEVICES", "99"), ("LOSE_AT", at), ("LOSE_ON_CLOSE", "1")];
            let run = run(&folder, args, &on_adapter, &lose);
            let said = String::from_utf8(run.stderr).unwrap();
            let may_end = args[0] == "sweep" || at == "1000000";
            let expected: &[i32] = if may_end { &[0] } else { &[0, 3] };
            let code = run.status.code();
            assert!(code.is_some_and(|code| expected.contains(&code)), "{args:?} at {at}: {code:?}: {said}");
        }
    }
}
