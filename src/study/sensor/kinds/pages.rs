//! What pages say of each kind, and the tables that are made of it.
//!
//! `PERIROBOT_REGENERATE=1 cargo test --lib pages` writes the tables instead of comparing them.

use std::path::Path;

use super::KINDS;

/// What pages say of a kind.
pub(crate) struct Page {
    /// What it is, in `scenes/README.md`.
    pub(crate) what: &'static str,
    /// Its own keys there; `?` marks what may be left out, brackets hold the default.
    pub(crate) keys: &'static str,
    /// What it calls occupied and free, in `SEMANTICS.md`.
    pub(crate) evidence: &'static [EvidenceWords],
}

/// What some representations of a kind call occupied and free.
#[derive(PartialEq)]
pub(crate) struct EvidenceWords {
    /// The representations; empty if the kind has no other.
    pub(crate) says: &'static str,
    /// Which voxels it calls occupied.
    pub(crate) occupied: &'static str,
    /// Which it calls free.
    pub(crate) free: &'static str,
}

/// What a sensor that casts rays says by their returns alone.
pub(crate) const POINTS: EvidenceWords = EvidenceWords {
    says: "`points`",
    occupied: "the last voxel of each return",
    free: "the voxels before it, the first included; all voxels of a ray that left towards a backdrop, and of \
        one that ended in nothing if `no_return = \"free\"`, those behind a blocker included if its return \
        was lost. A blind ray says nothing",
};

/// The table of kinds in `scenes/README.md`.
fn kinds() -> String {
    let row = |kind: &super::KindEntry| match kind.page.keys {
        "" => format!("| `{}` | {} | |\n", kind.name, kind.page.what),
        keys => format!("| `{}` | {} | {keys} |\n", kind.name, kind.page.what),
    };
    let head =
        "| `kind` | what it is | own keys (`?`: may be left out, in brackets the default) |\n|---|---|---|\n";
    head.to_owned() + &KINDS.iter().map(row).collect::<String>()
}

/// The table of evidence in `SEMANTICS.md`: a row for all kinds that say the same.
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
    let row = |(said, names): &(&EvidenceWords, Vec<String>)| {
        let colon = if said.says.is_empty() { "" } else { ": " };
        format!("| {}{colon}{} | {} | {} |\n", names.join(", "), said.says, said.occupied, said.free)
    };
    "| sensor | occupied | free |\n|---|---|---|\n".to_owned() + &rows.iter().map(row).collect::<String>()
}

/// What stands before and after a table that is made here.
const BEGIN: &str = "<!-- made of src/study/sensor/kinds -->\n\n";
const END: &str = "\n<!-- end -->";

#[test]
fn tables_of_pages_are_those_of_the_kinds() {
    for (page, table) in [("scenes/README.md", kinds()), ("src/march/SEMANTICS.md", evidence())] {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(page);
        let text = std::fs::read_to_string(&path).unwrap();
        let (before, rest) = text.split_once(BEGIN).unwrap_or_else(|| panic!("{page} has no {BEGIN:?}"));
        let (ships, after) = rest.split_once(END).unwrap_or_else(|| panic!("{page} has no {END:?}"));
        if std::env::var("PERIROBOT_REGENERATE").is_ok_and(|value| value == "1") {
            std::fs::write(&path, format!("{before}{BEGIN}{table}{END}{after}")).unwrap();
            continue;
        }
        let cure = "see the top of src/study/sensor/kinds/pages.rs for how to write it anew";
        assert!(ships == table, "{page}: its table is not what the kinds say; {cure}");
    }
}
