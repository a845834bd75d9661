//! How pages, help and messages read: lines of at most 100 columns, short paragraphs and cells, and none of the
//! phrases that read like a translation. The list has only phrases that cannot be right in any sentence here.

use std::fs;

use super::flags::{files, literals, src};
use super::pages::subcommands;
use crate::common::blocks::prose;
use crate::common::place::{pages, read};
use crate::common::program::perirobot;

/// What not to write, and what to write instead.
const BANNED: [(&str, &str); 19] = [
    ("nobody knows", "is unknown"),
    ("whoever", "a person, users, callers"),
    ("on the clock", "wall time"),
    ("slip of the pen", "typo"),
    ("slips of the pen", "typos"),
    ("the better the more", "improves with"),
    ("at most so many", "at most N"),
    ("so many of", "N of"),
    ("is told of", "is reported for"),
    ("are told of", "are reported for"),
    ("is told with", "is reported with"),
    ("are told with", "are reported with"),
    ("before anything tells", "before any sensor detects it"),
    ("what is cast", "the cast rays, the cast poses"),
    ("is no answer", "is not an answer"),
    ("that of the others", "the others'"),
    ("there is no such one", "unknown name; expected one of: a, b"),
    ("in the place of", "instead of"),
    ("rightly or by", "correctly or by"),
];

/// The first banned phrase of a text.
fn banned(text: &str) -> Option<String> {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
    let found = BANNED.iter().find(|(phrase, _)| contains_words(&text, phrase));
    found.map(|(phrase, better)| format!("{phrase:?}: write {better:?}"))
}

/// Whether a text has a phrase that neither begins nor ends within a word.
fn contains_words(text: &str, phrase: &str) -> bool {
    text.match_indices(phrase).any(|(at, _)| {
        let is_word = |c: char| c.is_alphanumeric();
        !text[..at].ends_with(is_word) && !text[at + phrase.len()..].starts_with(is_word)
    })
}

#[test]
fn pages_have_no_banned_phrase() {
    for page in pages() {
        assert_eq!(banned(&read(&page)), None, "{page}");
    }
}

#[test]
fn help_has_no_banned_phrase() {
    for name in [vec![String::new()], subcommands()].concat() {
        let help = match name.as_str() {
            "" => perirobot(&["--help"]),
            name => perirobot(&[name, "--help"]),
        };
        assert_eq!(banned(&help.stdout), None, "perirobot {name} --help");
    }
}

#[test]
fn messages_have_no_banned_phrase() {
    let mut all = Vec::new();
    files(&src(), &mut all);
    for path in all {
        let text = fs::read_to_string(&path).unwrap();
        for literal in literals(&text) {
            assert_eq!(banned(literal), None, "{}: {literal:?}", path.display());
        }
    }
}

#[test]
fn a_banned_phrase_is_found() {
    assert!(banned("It takes\n  5 s On the clock.").is_some());
    for text in ["neon the clock", "on the clocks", "is told offhand"] {
        assert_eq!(banned(text), None);
    }
}

/// Records with wide tables.
const WIDE_TABLES: [&str; 2] = ["tests/engines/README.md", "tests/fuzz/README.md"];

#[test]
fn lines_have_at_most_100_columns() {
    for page in pages() {
        let is_wide = WIDE_TABLES.contains(&page.as_str());
        for (number, line) in read(&page).lines().enumerate() {
            if is_wide && line.starts_with('|') {
                continue;
            }
            let columns = line.chars().count();
            assert!(columns <= 100, "{page}:{}: {columns} columns", number + 1);
        }
    }
}

#[test]
fn first_pages_are_short() {
    for (page, most_lines, most_words) in [("README.md", 110, 900), ("CHANGELOG.md", 60, 600)] {
        let text = read(page);
        let (lines, words) = (text.lines().count(), text.split_whitespace().count());
        assert!(lines <= most_lines && words <= most_words, "{page}: {lines} lines, {words} words");
    }
}

/// The pages that users read.
fn guide() -> impl Iterator<Item = String> {
    let is_guide = |page: &String| {
        ["README.md", "scenes/README.md", "benches/RESULTS.md"].contains(&page.as_str())
            || ["src/guide/", "scenes/tutorial/", "scenes/palletiser/"].iter().any(|of| page.starts_with(of))
    };
    pages().into_iter().filter(is_guide)
}

#[test]
fn paragraphs_have_at_most_5_lines() {
    for page in guide() {
        let text = prose(&read(&page)).join("\n");
        for paragraph in text.split("\n\n") {
            let is_other = paragraph.trim_start().starts_with(['|', '-', '*', '#', '[', '<', '1']);
            let lines = paragraph.lines().count();
            assert!(is_other || lines <= 5, "{page}: {lines} lines:\n{paragraph}");
        }
    }
}

#[test]
fn cells_of_tables_have_at_most_20_words() {
    for page in guide() {
        for line in prose(&read(&page)).into_iter().filter(|line| line.starts_with('|')) {
            for cell in line.split('|') {
                let words = cell.split_whitespace().count();
                assert!(words <= 20, "{page}: {words} words: {cell}");
            }
        }
    }
}
