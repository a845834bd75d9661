//! The order of the rooms, as the first page of the crate has it: no room uses one above it. Tests may look
//! up. And the names of flags, which are the command line's: no text below it has one.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The rooms in the order of the table in lib.rs, with the row of each: rooms of one row may use those to
/// their left.
fn order() -> BTreeMap<String, (usize, usize)> {
    let lib = fs::read_to_string(src().join("lib.rs")).unwrap();
    let rows = lib.lines().filter(|line| line.starts_with("//! | `"));
    let of_row = |(row, line): (usize, &str)| {
        let names = line.split('|').nth(1).unwrap().split('`').skip(1).step_by(2);
        let names: Vec<String> = names.map(str::to_string).collect();
        names.into_iter().enumerate().map(move |(place, name)| (name, (row, place)))
    };
    rows.enumerate().flat_map(of_row).collect()
}

/// Rust files below a folder, but for those of tests.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
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

/// The rooms that a text names by `crate::room`, also in lists; comments and tests left out.
fn named(text: &str, rooms: &BTreeMap<String, (usize, usize)>) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let code: Vec<&str> = code.lines().map(|line| line.split("//").next().unwrap()).collect();
    let code = code.join("\n");
    let after = code.split("crate::").skip(1).flat_map(|rest| {
        let list = rest.strip_prefix('{').and_then(|list| list.split('}').next());
        list.unwrap_or(rest).split(',').take(if list.is_some() { usize::MAX } else { 1 }).collect::<Vec<_>>()
    });
    let first = |path: &str| -> String {
        path.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    let mut found: Vec<String> = after.map(first).filter(|name| rooms.contains_key(name)).collect();
    found.sort();
    found.dedup();
    found
}

/// What a file uses that stands above its own room.
fn above(room: &str, text: &str, rooms: &BTreeMap<String, (usize, usize)>) -> Vec<String> {
    named(text, rooms).into_iter().filter(|used| rooms[used] > rooms[room]).collect()
}

/// The first rows of the table are the crate in src/march.
const OF_THE_MARCHER: usize = 5;

#[test]
fn no_room_uses_one_above_it() {
    let (rooms, mut all) = (order(), Vec::new());
    files(&src(), &mut all);
    let mut used = 0;
    for path in &all {
        let below = path.strip_prefix(src()).unwrap();
        // The crate in src/march has rooms, too.
        let (within, roomless) = match below.strip_prefix("march") {
            Ok(within) => (within, &["lib"][..]),
            // The guide is pages, the Python package is a crate that uses this one, and `thorough` is for tests.
            Err(_) => (below, &["lib", "main", "cli", "guide", "python", "thorough"][..]),
        };
        let first = within.iter().next().unwrap().to_string_lossy();
        let room = first.trim_end_matches(".rs");
        if roomless.contains(&room) {
            continue;
        }
        assert!(rooms.contains_key(room), "{room} is not in the table of lib.rs");
        assert_eq!(
            below != within,
            rooms[room].0 < OF_THE_MARCHER,
            "{}: in the wrong crate",
            below.display()
        );
        let text = fs::read_to_string(path).unwrap();
        let wrong = above(room, &text, &rooms);
        assert!(wrong.is_empty(), "{} uses {wrong:?}, above {room} in the table of lib.rs", below.display());
        used += named(&text, &rooms).len();
    }
    assert!(all.len() > 200 && used > 400, "{} files, {used} uses: are they found?", all.len());
}

#[test]
fn a_use_of_a_room_above_is_found() {
    let rooms = order();
    for (room, text, expected) in [
        ("voxel", "use crate::metrics::BodyPart;\nuse crate::backend::Planes;", &["backend"][..]),
        ("truth", "use crate::scene::Mesh;\nuse crate::sensor::Kind;", &["sensor"]),
        ("scene", "use crate::{Error, study::Study};", &["study"]),
        ("scene", "fn f() { let _ = crate::sweep::run; }", &["sweep"]),
        ("render", "use crate::{view, export};", &["export"]),
        ("scene", "// use crate::study::Study;\n#[cfg(test)]\nmod tests {\n use crate::study::Study; }", &[]),
    ] {
        assert_eq!(above(room, text, &rooms), expected, "{text}");
    }
}

/// What stands between quotes in Rust.
fn literals(code: &str) -> Vec<&str> {
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
    "export/ros.rs",
    "results/merge.rs",
    "source/formats.rs",
    "report/html/data.rs",
    "report/html/facts/good.rs",
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
