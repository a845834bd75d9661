//! The names of flags are the command line's: no text of the crates below it has one.

use std::fs;
use std::path::{Path, PathBuf};

pub(super) fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Rust files below a folder, but for those of tests.
pub(super) fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let is_test = path.file_stem().is_some_and(|stem| stem.to_string_lossy().contains("tests"));
        if path.is_dir() && !is_test {
            files(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") && !is_test {
            found.push(path);
        }
    }
}

/// What stands between quotes in Rust.
pub(super) fn literals(code: &str) -> Vec<&str> {
    let (mut found, mut rest) = (Vec::new(), code);
    while let Some(at) = rest.find(['"', '/', '\'', '#']) {
        let (begin, end) = match &rest[at..] {
            comment if comment.starts_with("//") => (None, comment.find('\n')),
            raw if raw.starts_with("#\"") => (Some(2), raw.find("\"#")),
            text if text.starts_with('"') => {
                let mut is_escaped = false;
                let is_end = |c: char| {
                    let ends = c == '"' && !is_escaped;
                    is_escaped = c == '\\' && !is_escaped;
                    ends
                };
                (Some(1), text[1..].find(is_end).map(|end| end + 1))
            }
            quote if quote.starts_with("'\"'") => (None, Some(2)),
            _ => (None, Some(0)),
        };
        let end = at + end.unwrap_or(rest.len() - at - 1);
        found.extend(begin.map(|begin| &rest[(at + begin).min(end)..end]));
        rest = &rest[end + 1..];
    }
    found
}

/// Whether a text names a flag, as in `--voxel-size`.
fn names_a_flag(text: &str) -> bool {
    text.match_indices("--").any(|(at, _)| {
        let is_begun = !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '-');
        is_begun && text[at + 2..].starts_with(|c: char| c.is_ascii_lowercase())
    })
}

/// What writes or reads command lines: scripts of engines, the command of a shard, those that a report shows, and those
/// of programs that convert files.
const OF_COMMANDS: [&str; 7] = [
    "cli",
    "cluster",
    "page/export/ros.rs",
    "sweep/results/merge.rs",
    "scene/source/formats.rs",
    "page/report/page/data.rs",
    "page/report/page/sections/good.rs",
];

#[test]
fn no_text_below_the_command_line_names_a_flag() {
    let mut all = Vec::new();
    files(&src(), &mut all);
    let mut seen = 0;
    for path in &all {
        let below = path.strip_prefix(src()).unwrap();
        if OF_COMMANDS.iter().any(|begin| below.starts_with(begin)) {
            continue;
        }
        let text = fs::read_to_string(path).unwrap();
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        for literal in literals(code) {
            seen += 1;
            assert!(
                !names_a_flag(literal),
                "{}: {literal:?} names a flag: say it with `Argument`, which the command line turns into its flag",
                below.display()
            );
        }
    }
    assert!(seen > 2000, "{seen} texts: are they found?");
}

#[test]
fn a_flag_in_a_text_is_found() {
    let code = "let a = \"a \\\"b\\\" (--voxel-size)\"; // \"--out\"\nlet b = '\"'; let c = \"\"; f(r#\"say \"--x\" --\"#, \"/\")";
    assert_eq!(literals(code), ["a \\\"b\\\" (--voxel-size)", "", "say \"--x\" --", "/"]);
    for text in ["--out", "use `--backend cpu`", "(--voxel-size)", "\n--a"] {
        assert!(names_a_flag(text), "{text}");
    }
    for text in ["a--b", "---a", "a -- b", "--", "--A", "-a"] {
        assert!(!names_a_flag(text), "{text}");
    }
}
