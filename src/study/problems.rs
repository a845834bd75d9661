//! Everything that is wrong with a study's files, gathered so that it can be told at once. What is wrong is found
//! elsewhere; who wants one error only takes the first.

use std::path::Path;

use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::{Place, parse};
use crate::{Error, Result};

/// What was found wrong so far, in the order of the checks.
#[derive(Debug, Default)]
pub(super) struct Problems(Vec<Error>);

impl Problems {
    /// The value of a check that passed; else what is wrong is kept.
    pub(super) fn keep<T>(&mut self, checked: Result<T>) -> Option<T> {
        checked.map_err(|e| self.0.push(e)).ok()
    }

    /// The same of checks that find more than one thing.
    pub(super) fn keep_all<T>(&mut self, checked: Result<T, Vec<Error>>) -> Option<T> {
        checked.map_err(|all| self.0.extend(all)).ok()
    }

    /// Whether all checks passed.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All that was found, if anything was.
    pub(super) fn none(self) -> Result<(), Vec<Error>> {
        if self.0.is_empty() { Ok(()) } else { Err(self.0) }
    }
}

/// A list of a file that can be read entry by entry: its key, and whether an entry can be read.
pub(super) type List = (&'static str, fn(Value) -> Result<(), toml::de::Error>);

/// Whether an entry can be read as what it should be.
pub(super) fn reads<T: DeserializeOwned>(entry: Value) -> Result<(), toml::de::Error> {
    entry.try_into::<T>().map(drop)
}

/// Reads a file. If it cannot be read as it is, then without the entries of these lists that cannot be read, so that
/// the others can still be checked.
pub(super) fn parse_in_parts<T: DeserializeOwned>(
    path: &Path,
    text: &str,
    lists: &[List],
    problems: &mut Problems,
) -> Option<T> {
    // The reader's own words on the whole file show the line, so they come first.
    let whole = match parse(path, text) {
        Ok(file) => return Some(file),
        Err(e) => e,
    };
    let shown = whole.to_string();
    problems.0.push(whole);
    let mut table: Table = toml::from_str(text).ok()?;
    let at = Place { file: path, prefix: String::new() };
    for (list, reads) in lists {
        let Some(entries) = table.get_mut(*list).and_then(Value::as_array_mut) else { continue };
        let mut number = 0;
        entries.retain(|entry| {
            let name = entry.get("name").and_then(Value::as_str);
            let place = name.map_or(format!("{list}[{number}]"), |name| format!("{list} {name:?}"));
            number += 1;
            let Err(e) = reads(entry.clone()) else { return true };
            if !shown.contains(e.message()) {
                problems.0.push(at.key(&place).says(e.to_string().trim_end().replace('\n', " ")));
            }
            false
        });
    }
    table.try_into().ok()
}
