//! The text of pages about each kind, and the lists that are made of it.
//!
//! `PERIROBOT_REGENERATE=1 cargo test --lib pages` writes the lists instead of comparing them.

use std::path::Path;

use super::KINDS;

/// The text of pages about a kind.
pub(crate) struct Page {
    /// What it is, in `scenes/README.md`.
    pub(crate) what: &'static str,
    /// Its own keys there; `?` marks optional ones, brackets hold the default.
    pub(crate) keys: &'static str,
    /// What it labels occupied and free, in `SEMANTICS.md`.
    pub(crate) evidence: &'static [EvidenceWords],
}

/// What some representations of a kind label occupied and free.
#[derive(PartialEq)]
pub(crate) struct EvidenceWords {
    /// The representations; empty if the kind has no other.
    pub(crate) says: &'static str,
    /// Which voxels it labels occupied.
    pub(crate) occupied: &'static str,
    /// Which it labels free.
    pub(crate) free: &'static str,
}

/// The evidence of a sensor that casts rays, by their returns alone.
pub(crate) const POINTS: EvidenceWords = EvidenceWords {
    says: "`points`",
    occupied: "the last voxel of each return",
    free: "the voxels before it, the first included; all voxels of a ray that left towards a backdrop, and of \
        one that ended in nothing if `no_return = \"free\"`, those behind a blocker included if its return \
        was lost. A blind ray labels nothing",
};

/// An item of a list, broken at 100 columns; text in backquotes stays whole.
fn item(indent: usize, text: &str) -> String {
    let (mut lines, mut line) = (String::new(), format!("{}- ", " ".repeat(indent)));
    let mut is_code = false;
    let is_break = |c: char| {
        is_code ^= c == '`';
        c == ' ' && !is_code
    };
    for (number, word) in text.split(is_break).enumerate() {
        if line.chars().count() + 1 + word.chars().count() > 100 {
            lines += &(line + "\n");
            line = " ".repeat(indent + 2) + word;
        } else {
            line = if number == 0 { line + word } else { format!("{line} {word}") };
        }
    }
    lines + &line + "\n"
}

/// The list of kinds in `scenes/README.md`.
fn kinds() -> String {
    let of = |kind: &super::KindEntry| match kind.page.keys {
        "" => item(0, &format!("**`{}`**: {}.", kind.name, kind.page.what)),
        keys => item(0, &format!("**`{}`**: {}.", kind.name, kind.page.what)) + &item(2, &format!("{keys}.")),
    };
    KINDS.iter().map(of).collect()
}

/// The list of evidence in `SEMANTICS.md`: an item for all kinds with the same words.
fn evidence() -> String {
    let mut rows: Vec<(&EvidenceWords, Vec<String>)> = Vec::new();
    for kind in KINDS {
        let name = format!("`{}`", kind.name);
        for said in kind.page.evidence {
            match rows.iter_mut().find(|(known, _)| *known == said) {
                Some((_, names)) => names.push(name.clone()),
                None => rows.push((said, vec![name.clone()])),
            }
        }
    }
    let of = |(said, names): &(&EvidenceWords, Vec<String>)| {
        let by = if said.says.is_empty() { String::new() } else { format!(" by {}", said.says) };
        item(0, &format!("**{}**{by}", names.join(", ")))
            + &item(2, &format!("occupied: {}.", said.occupied))
            + &item(2, &format!("free: {}.", said.free))
    };
    rows.iter().map(of).collect()
}

/// The marks around a list that is made here.
const BEGIN: &str = "<!-- made of src/study/sensor/kinds -->\n\n";
const END: &str = "\n<!-- end -->";

#[test]
fn lists_of_pages_are_those_of_the_kinds() {
    for (page, list) in [("scenes/README.md", kinds()), ("src/march/SEMANTICS.md", evidence())] {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(page);
        let text = std::fs::read_to_string(&path).unwrap();
        let (before, rest) = text.split_once(BEGIN).unwrap_or_else(|| panic!("{page} has no {BEGIN:?}"));
        let (ships, after) = rest.split_once(END).unwrap_or_else(|| panic!("{page} has no {END:?}"));
        if std::env::var("PERIROBOT_REGENERATE").is_ok_and(|value| value == "1") {
            std::fs::write(&path, format!("{before}{BEGIN}{list}{END}{after}")).unwrap();
            continue;
        }
        let cure = "see the top of src/study/sensor/kinds/pages.rs for how to write it anew";
        assert!(ships == list, "{page}: its list is not that of the kinds; {cure}");
    }
}
