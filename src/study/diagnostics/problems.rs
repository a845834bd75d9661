//! Collects everything that is wrong with a study's files, so that it can be told at once. A caller that
//! reports one error takes the first.

use std::path::Path;

use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::{Place, Step, Unread, Unreadable, Written, describe, parse, read};
use perirobot_march::{Error, Result};

/// The errors found so far, in the order of the checks.
#[derive(Debug, Default)]
pub(crate) struct Problems(Vec<Error>);

impl Problems {
    /// The value of a check that passed; an error is kept.
    pub(crate) fn keep<T>(&mut self, checked: Result<T>) -> Option<T> {
        checked.map_err(|e| self.0.push(e)).ok()
    }

    /// The same for checks with several errors.
    pub(crate) fn keep_all<T>(&mut self, checked: Result<T, Vec<Error>>) -> Option<T> {
        checked.map_err(|all| self.0.extend(all)).ok()
    }

    /// The same for several checks of their own.
    pub(crate) fn keep_each(&mut self, checked: impl IntoIterator<Item = Result<()>>) {
        self.0.extend(checked.into_iter().filter_map(Result::err));
    }

    /// Whether all checks passed.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All errors, if there are any.
    pub(crate) fn none(self) -> Result<(), Vec<Error>> {
        if self.0.is_empty() { Ok(()) } else { Err(self.0) }
    }
}

/// A list of a file that can be read entry by entry: its key, and what is wrong with an entry.
pub(crate) type List = (&'static str, fn(Value) -> Vec<Unreadable>);

/// Why an entry cannot be read.
pub(crate) fn wrong_with<T: DeserializeOwned>(entry: Value) -> Vec<Unreadable> {
    read_without_wrong_keys::<T>(entry).1
}

/// Reads a file. If it cannot be read as it is, then without the keys that are wrong, and without the entries
/// of these lists that cannot be read, so that the others can still be checked.
pub(crate) fn parse_in_parts<T: DeserializeOwned>(
    path: &Path,
    text: &str,
    lists: &[List],
    problems: &mut Problems,
) -> Option<T> {
    // The parser's own error shows the line in the file, so it comes first.
    let shown = match parse(path, text) {
        Ok(file) => return Some(file),
        Err((error, shown)) => {
            problems.0.push(error);
            shown
        }
    };
    let mut table: Table = toml::from_str(text).ok()?;
    let at = Place::new(path);
    let written = Written::new(text);
    let mut told = |place: Option<&str>, within: &[Step], all: Vec<Unreadable>| {
        let is_shown = |e: &Unreadable| shown.as_ref() == Some(&e.message);
        for e in all.into_iter().filter(|e| !is_shown(e)) {
            let said = describe(&e, &|steps| written.line_of(steps), within);
            problems.0.push(
                place.map_or_else(|| at.says(said.as_str()), |place| at.key(place).says(said.as_str())),
            );
        }
    };
    for (list, wrong_with) in lists {
        let Some(entries) = table.get_mut(*list).and_then(Value::as_array_mut) else { continue };
        let mut number = 0;
        entries.retain(|entry| {
            let name = entry.get("name").and_then(Value::as_str);
            let place = name.map_or(format!("{list}[{number}]"), |name| format!("{list} {name:?}"));
            number += 1;
            let wrong = wrong_with(entry.clone());
            let is_right = wrong.is_empty();
            told(Some(&place), &[Step::Key((*list).into()), Step::Entry(number - 1)], wrong);
            is_right
        });
    }
    let (file, wrong) = read_without_wrong_keys(table.into());
    told(None, &[], wrong);
    file
}

/// What can be read of a value when wrong keys are left out, and the error of each of them. A key that is
/// missing only for that reason is no error.
fn read_without_wrong_keys<T: DeserializeOwned>(mut value: Value) -> (Option<T>, Vec<Unreadable>) {
    let mut wrong = Vec::new();
    loop {
        let error = match read(value.clone()) {
            Ok(found) => return (Some(found), wrong),
            Err(error) => error,
        };
        let is_missing = matches!(error.kind, Unread::Missing(_));
        let is_left_out = !is_missing && leave_out(&mut value, &error.culprit());
        if !is_missing || wrong.is_empty() {
            wrong.push(error);
        }
        if !is_left_out {
            return (None, wrong);
        }
    }
}

/// Takes out the key to which some steps lead; whether it was there.
fn leave_out(value: &mut Value, steps: &[Step]) -> bool {
    let Some((Step::Key(last), tables)) = steps.split_last() else { return false };
    let table = tables.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.get_mut(key),
        Step::Entry(number) => value.get_mut(number),
    });
    table.and_then(Value::as_table_mut).is_some_and(|table| table.remove(last).is_some())
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct ProblemCell {
        #[serde(default)]
        sizes: Vec<f64>,
        #[serde(default)]
        body: Vec<ProblemBody>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "it is only read")]
    struct ProblemBody {
        size: f64,
    }

    /// A wrong number in a list takes the key of the list with it.
    #[test]
    fn what_can_be_read_is_read_without_wrong_keys() {
        for (text, expected, told) in [
            ("sizes = [1, 2]\nbody = [{ size = 1 }]", Some((2, 1)), &[][..]),
            (
                "size = 1\nsizes = [1]",
                Some((1, 0)),
                &["unknown field `size`, expected `sizes` or `body`"][..],
            ),
            ("sizes = [1, \"2\"]\nbody = [{ size = 1 }]", Some((0, 1)), &["found \"2\", wanted a number"]),
            (
                "sizes = 1\nbody = [{ size = 1 }, { size = 1, sise = 1, seize = 1 }]",
                Some((0, 2)),
                &[
                    "unknown field `seize`, expected `size`",
                    "unknown field `sise`, expected `size`",
                    "found 1, wanted a list",
                ],
            ),
            ("body = [{}]", None, &["missing field `size`"]),
        ] {
            let table: Table = toml::from_str(text).unwrap();
            let (found, wrong) = read_without_wrong_keys::<ProblemCell>(table.into());
            let found = found.map(|cell| (cell.sizes.len(), cell.body.len()));
            let wrong: Vec<&str> = wrong.iter().map(|error| error.message.as_str()).collect();
            assert_eq!((found, &wrong[..]), (expected, told), "{text}");
        }
    }
}
