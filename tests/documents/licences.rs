//! Every dependency may be used under a licence that goes with MIT OR Apache-2.0.

use std::process::Command;

/// Licences that ask for no more than attribution.
const ALLOWED: [&str; 11] = [
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "Zlib",
    "Unlicense",
    "Unicode-3.0",
    "CC0-1.0",
];

/// Whether an SPDX expression (or crates.io's old `A/B`) can be met with allowed licences only.
fn allowed(expression: &str) -> bool {
    let plain = expression.replace(['(', ')'], " ").replace('/', " OR ");
    // OR binds loosest; parentheses only ever group ORs under an AND here, which the split by AND first would
    // break.
    let any = |part: &str| part.split(" OR ").any(|name| ALLOWED.contains(&name.trim()));
    if expression.contains('(') {
        plain.split(" AND ").all(any)
    } else {
        plain.split(" OR ").any(|or| or.split(" AND ").all(|n| ALLOWED.contains(&n.trim())))
    }
}

#[test]
fn licences_of_all_dependencies_are_permissive() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--format-version", "1"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    assert!(packages.len() > 50, "the list of packages is whole");
    let refused: Vec<String> = packages
        .iter()
        .filter(|p| !p["license"].as_str().is_some_and(allowed))
        .map(|p| format!("{} {}: {}", p["name"], p["version"], p["license"]))
        .collect();
    assert!(refused.is_empty(), "not allowed: {refused:#?}");
}

#[test]
fn expressions_are_read_as_they_mean() {
    assert!(
        allowed("MIT OR GPL-3.0")
            && allowed("Unlicense/MIT")
            && allowed("(MIT OR Apache-2.0) AND Unicode-3.0")
    );
    assert!(!allowed("GPL-3.0") && !allowed("MIT AND GPL-3.0") && !allowed("(MIT OR Zlib) AND GPL-3.0"));
}

#[test]
fn shipped_robots_say_that_they_are_ours() {
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let files =
        ["paper", "tutorial", "palletiser"].map(|folder| std::fs::read_dir(scenes.join(folder)).unwrap());
    let paths = files.into_iter().flatten().map(|entry| entry.unwrap().path());
    let robots: Vec<_> = paths.filter(|path| path.extension().is_some_and(|e| e == "urdf")).collect();
    assert_eq!(robots.len(), 3);
    for robot in robots {
        let text = std::fs::read_to_string(&robot).unwrap();
        assert!(text.contains("SPDX-License-Identifier: MIT OR Apache-2.0"), "{}", robot.display());
    }
}
