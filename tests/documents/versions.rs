//! The version and the oldest Rust are the same in every file that contains them.

use std::path::Path;

use toml::Table;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn manifest(path: &str) -> Table {
    read(path).parse().unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The text between `before` and `after`, each on the same line.
#[track_caller]
fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    let found = text.lines().find_map(|line| line.split_once(before)?.1.split_once(after));
    found.unwrap_or_else(|| panic!("no line has {before:?} and then {after:?}")).0
}

#[test]
fn all_packages_have_the_version_of_the_workspace() {
    let root = manifest("Cargo.toml");
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(root["workspace"]["package"]["version"].as_str(), Some(version));
    let members = root["workspace"]["members"].as_array().unwrap();
    let members = members.iter().map(|member| format!("{}/Cargo.toml", member.as_str().unwrap()));
    let mut packages = 0;
    for path in std::iter::once("Cargo.toml".into()).chain(members) {
        let manifest = manifest(&path);
        for key in ["version", "rust-version", "license", "edition"] {
            let inherited = manifest["package"][key].get("workspace").and_then(|w| w.as_bool());
            assert_eq!(inherited, Some(true), "{path}: {key} must be `{key}.workspace = true`");
        }
        for (name, dependency) in ["dependencies", "dev-dependencies", "build-dependencies"]
            .iter()
            .filter_map(|section| manifest.get(*section)?.as_table())
            .flatten()
        {
            let message = format!("{path}: {name} must be `workspace = true`: the version is in Cargo.toml");
            assert!(dependency.get("path").is_none(), "{message}");
        }
        packages += 1;
    }
    assert!(packages >= 4, "{packages} packages");
    for (name, dependency) in root["workspace"]["dependencies"].as_table().unwrap() {
        if dependency.get("path").is_some() {
            assert_eq!(dependency["version"].as_str(), Some(version), "Cargo.toml: {name}");
        }
    }
}

#[test]
fn python_takes_its_version_from_cargo() {
    let python = manifest("src/python/pyproject.toml");
    let dynamic = python["project"]["dynamic"].as_array().unwrap();
    assert!(dynamic.iter().any(|key| key.as_str() == Some("version")), "pyproject.toml: dynamic");
    assert_eq!(python["project"].get("version"), None, "pyproject.toml: version");
}

#[test]
fn pages_name_the_version() {
    let version = env!("CARGO_PKG_VERSION");
    let cited = read("CITATION.cff");
    let cited: Vec<_> = cited.lines().filter_map(|line| line.strip_prefix("version: ")).collect();
    assert_eq!(cited, [version], "CITATION.cff");
    let changes = read("CHANGELOG.md");
    let newest = changes.lines().find_map(|line| line.strip_prefix("## ")).expect("a section");
    let named = newest.strip_prefix("Unreleased: ").unwrap_or(newest).split(' ').next();
    assert_eq!(named, Some(version), "CHANGELOG.md: the newest section is {newest:?}");
}

#[test]
fn pages_name_the_oldest_rust() {
    let oldest = env!("CARGO_PKG_RUST_VERSION");
    for page in ["README.md", "src/guide/first_hour.md", "src/guide/python.md"] {
        assert_eq!(between(&read(page), "Rust ", " or newer"), oldest, "{page}");
    }
}

#[test]
fn python_packages_carry_the_licences() {
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        assert_eq!(
            read(&format!("src/python/licences/{licence}")),
            read(licence),
            "src/python/licences/{licence}"
        );
    }
}
