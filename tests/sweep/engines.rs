//! Real sweeps through real engines, disturbed on the way and compared with a quiet run: what is in
//! `engines/`. Not run by default, as they need what `sh tests/install.sh engines` installs, and minutes: `cargo test
//! --test sweep engines -- --ignored`.

use std::process::Command;

#[track_caller]
fn run(script: &str) {
    let path = format!("{}/tests/engines/{script}", env!("CARGO_MANIFEST_DIR"));
    let status = Command::new(path).env("PERIROBOT", env!("CARGO_BIN_EXE_perirobot")).status().unwrap();
    assert!(status.success(), "tests/engines/{script}: {status}; what it said is above");
}

#[test]
#[ignore = "needs Slurm and munge, and root"]
fn slurm() {
    run("slurm.sh");
}

#[test]
#[ignore = "needs HyperQueue's engine from PyPI"]
fn hyperqueue() {
    run("hyperqueue.sh");
}

#[test]
#[ignore = "needs Kubernetes' schemas from PyPI"]
fn kubernetes() {
    run("kubernetes.sh");
}
