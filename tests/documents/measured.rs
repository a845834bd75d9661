//! `benches/RESULTS.md` is made from `benches/results.toml`, and pages quote the values of that file.
//! `PERIROBOT_REGENERATE=1 cargo test --test documents measured` writes RESULTS.md.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use serde::Deserialize;

use crate::common::place::{pages, read, root};

const RESULTS: &str = "benches/RESULTS.md";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Measurements {
    title: String,
    begin: String,
    end: String,
    /// Names of machines, described.
    machines: BTreeMap<String, String>,
    table: Vec<Table>,
    run: Vec<Run>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    name: String,
    title: String,
    /// Whether another page has it.
    #[serde(default)]
    is_elsewhere: bool,
    /// Heading of the first column.
    first: String,
    rows: Vec<String>,
    /// The row to which the others are also given as a ratio.
    ratio: Option<String>,
}

/// A run of a command, which fills a column of a table, or a part of one.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Run {
    table: String,
    column: String,
    /// By row.
    values: BTreeMap<String, f64>,
    unit: String,
    /// How often it was run; a value is the best.
    runs: u32,
    machine: String,
    commit: String,
    date: String,
    command: String,
}

impl Run {
    /// A value as pages show it: seconds with two digits, all else as it is in the file.
    fn shown(&self, row: &str) -> Option<String> {
        let value = *self.values.get(row)?;
        Some(match self.unit.as_str() {
            "s" if value >= 10.0 => format!("{value:.0} s"),
            "s" if value >= 1.0 => format!("{value:.1} s"),
            "" => format!("{value}"),
            unit => format!("{value} {unit}"),
        })
    }

    /// Where a command ran, as a comment above it.
    fn origin(&self, machines: &BTreeMap<String, String>) -> String {
        format!("# {}, {}, {}\n", self.date, self.commit, machines[&self.machine])
    }

    /// The command for any size of voxels.
    fn any_size(&self) -> String {
        let mut words: Vec<&str> = self.command.split(' ').collect();
        if let Some(at) = words.iter().position(|word| *word == "--voxel-size") {
            words[at + 1] = "SIZE";
        }
        words.join(" ") + "\n"
    }
}

impl Measurements {
    fn load() -> Measurements {
        let all: Measurements = toml::from_str(&read("benches/results.toml")).unwrap();
        for run in &all.run {
            let table = all.table.iter().find(|table| table.name == run.table);
            let table = table.unwrap_or_else(|| panic!("results.toml: no table {}", run.table));
            for row in run.values.keys() {
                assert!(table.rows.contains(row), "results.toml: {} has no row {row}", run.table);
            }
            let is_whole = !run.command.is_empty() && run.commit.len() >= 7 && run.runs > 0;
            assert!(is_whole, "results.toml: {}/{}", run.table, run.column);
        }
        all
    }

    fn value(&self, table: &str, column: &str, row: &str) -> Option<(f64, String)> {
        let runs = self.run.iter().filter(|run| run.table == table && run.column == column);
        let mut found = runs.filter_map(|run| Some((*run.values.get(row)?, run.shown(row)?)));
        let value = found.next();
        assert!(found.next().is_none(), "results.toml: {table}/{column}/{row} is there twice");
        value
    }

    fn table(&self, table: &Table) -> String {
        let runs: Vec<&Run> = self.run.iter().filter(|run| run.table == table.name).collect();
        let mut columns: Vec<&str> = Vec::new();
        for run in &runs {
            if !columns.contains(&run.column.as_str()) {
                columns.push(&run.column);
            }
        }
        let mut text = format!("## {}\n\n", table.title);
        text += &format!("| {} | {} |\n", table.first, columns.join(" | "));
        text += &format!("|---|{}\n", "---:|".repeat(columns.len()));
        for row in &table.rows {
            let cell = |column: &&str| {
                let (value, shown) = self.value(&table.name, column, row)?;
                let base = table.ratio.as_ref().filter(|base| *base != row);
                let base = base.and_then(|base| self.value(&table.name, column, base));
                Some(base.map_or(shown.clone(), |(base, _)| format!("{shown}, {:.0} ×", base / value)))
            };
            let cells: Vec<String> = columns.iter().map(|c| cell(c).unwrap_or_default()).collect();
            text += &format!("| {row} | {} |\n", cells.join(" | "));
        }
        text += "\n```sh\n";
        let (mut last, mut all) = (String::new(), BTreeSet::new());
        for run in &runs {
            let (from, command) = (run.origin(&self.machines), run.any_size());
            if !all.insert((from.clone(), command.clone())) {
                continue;
            }
            // The same command with other origins stands once, below all of them.
            if last != from {
                let is_again = text.ends_with(&command);
                text.truncate(text.len() - if is_again { command.len() } else { 0 });
                text += &from;
            }
            text += &command;
            last = from;
        }
        text + "```\n"
    }

    fn page(&self) -> String {
        let tables: Vec<String> =
            self.table.iter().filter(|t| !t.is_elsewhere).map(|t| self.table(t)).collect();
        format!("# {}\n\n{}\n{}\n{}", self.title, self.begin, tables.join("\n"), self.end)
    }
}

#[test]
fn results_are_those_of_the_file() {
    let page = Measurements::load().page();
    if std::env::var_os("PERIROBOT_REGENERATE").is_some() {
        fs::write(root(RESULTS), page).unwrap();
        return;
    }
    assert!(read(RESULTS) == page, "PERIROBOT_REGENERATE=1 cargo test --test documents measured");
    let lines = page.lines().count();
    assert!(lines <= 140, "{RESULTS} has {lines} lines");
}

#[test]
fn the_speeds_of_the_readme_are_in_the_file() {
    let all = Measurements::load();
    let readme = read("README.md");
    for (device, column) in [
        ("2 x86-64 cores with AVX-512", "2 cores"),
        ("16 Xeon cores with AVX-512", "16 cores"),
        ("NVIDIA H100 80GB", "H100"),
    ] {
        let [at_5_cm, at_2_cm] = ["5 cm", "2 cm"]
            .map(|size| all.value("experiments", column, &format!("Experiment 1 at {size}")).unwrap().1);
        let expected = format!("| {device} | {at_5_cm} | {at_2_cm} |");
        assert!(readme.lines().any(|line| line == expected), "README.md must have: {expected}");
    }
}

/// A page marks a value of the file as `12 s<!-- table/column/row -->`.
#[test]
fn values_that_pages_quote_are_those_of_the_file() {
    let all = Measurements::load();
    let mut quoted = 0;
    for page in pages() {
        let text = read(&page);
        let mut rest = text.as_str();
        while let Some((before, after)) = rest.split_once("<!-- ") {
            let (comment, after) = after.split_once(" -->").expect("the end of a comment");
            rest = after;
            let [table, column, row] = comment.splitn(3, '/').collect::<Vec<_>>()[..] else { continue };
            let Some((_, shown)) = all.value(table, column, row) else {
                assert!(!all.table.iter().any(|known| known.name == table), "{page}: no {comment}");
                continue;
            };
            assert!(before.ends_with(&shown), "{page}: {comment} must be {shown}");
            quoted += 1;
        }
    }
    assert!(quoted >= 6, "{quoted} values are quoted");
}
