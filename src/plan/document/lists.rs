//! Entries of lists in brackets, and of tables in braces: each comes and goes with its comma, and with its line if it has
//! one of its own.

use std::ops::Range;

use toml_edit::{Item, Value};

use perirobot_march::Result;

use super::number::{list, number, quote, to_number};
use super::path::Path;
use super::source::{Patch, Source, unplaced};
use super::span::{
    comma_after, comment_lines, indent, is_rest_free, line_end, line_start, next_line, pieces,
};

impl Source {
    /// Adds a value to the end of a list in brackets, in the manner of its other values.
    pub(super) fn push(&mut self, list: &Path, value: &str) -> Result<()> {
        let text = self.text();
        let array = self.get(list).and_then(Item::as_array).ok_or_else(|| unplaced(list))?;
        let span = array.span().ok_or_else(|| unplaced(list))?;
        let last = array.iter().filter_map(Value::span).last();
        let patches = match last.map(|last| (indent(text, last.start), comma_after(text, last.end), last)) {
            None => vec![(span.end - 1..span.end - 1, value.to_string())],
            Some((None, _, last)) => vec![(last.end..last.end, format!(", {value}"))],
            Some((Some(indent), comma, last)) => {
                let end = line_end(text, comma.unwrap_or(last.end));
                let at = if end < span.end { end } else { comma.map_or(last.end, |comma| comma + 1) };
                let at = if text[..at].ends_with('\r') { at - 1 } else { at };
                let new = format!("\n{indent}{value}");
                match comma {
                    Some(_) => vec![(at..at, new + ",")],
                    None if at == last.end => vec![(at..at, ",".to_string() + &new)],
                    None => vec![(last.end..last.end, ",".into()), (at..at, new)],
                }
            }
        };
        self.splice(patches)
    }

    /// Removes an entry of a list.
    pub(super) fn remove(&mut self, list: &Path, index: usize) -> Result<()> {
        let patches = match self.get(list) {
            Some(Item::ArrayOfTables(tables)) => {
                self.without_pieces(tables.get(index).map_or(Vec::new(), pieces))
            }
            Some(Item::Value(Value::Array(array))) => {
                let spans: Vec<Range<usize>> = array.iter().filter_map(Value::span).collect();
                without_member(self.text(), &spans, index)
            }
            _ => return Err(unplaced(list)),
        };
        self.splice(patches)
    }

    /// Writes an entry of a list in brackets.
    pub(super) fn set_entry(&mut self, list: &Path, index: usize, value: &str) -> Result<()> {
        let span = self.get(&list.entry(index)).and_then(Item::span).ok_or_else(|| unplaced(list))?;
        self.splice(vec![(span, value.into())])
    }

    /// Writes a list of numbers. Of one that is there only the numbers that differ are written, so that comments between
    /// them stay.
    pub(super) fn set_numbers(&mut self, table: &Path, key: &str, numbers: &[f64]) -> Result<()> {
        match self.numbers(&table.key(key)) {
            Some(old) if old.len() == numbers.len() => self.replace_numbers(&table.key(key), numbers),
            _ => self.set(table, key, &list(numbers.iter().map(|value| number(*value)))),
        }
    }

    /// Writes the numbers of a list that differ.
    pub(super) fn replace_numbers(&mut self, list: &Path, numbers: &[f64]) -> Result<()> {
        let array = self.get(list).and_then(Item::as_array).ok_or_else(|| unplaced(list))?;
        let differs = |(old, new): &(&Value, &f64)| to_number(old) != Some(**new);
        let differing = array.iter().zip(numbers).filter(differs);
        let patch = |(old, new): (&Value, &f64)| Some((old.span()?, number(*new)));
        let patches: Option<Vec<Patch>> = differing.map(patch).collect();
        self.splice(patches.ok_or_else(|| unplaced(list))?)
    }

    /// The numbers of a list; `None` if there is none, or it has something else.
    pub(super) fn numbers(&self, list: &Path) -> Option<Vec<f64>> {
        self.get(list)?.as_array()?.iter().map(to_number).collect()
    }

    /// Writes a number. One that is there and equal stays as it is written.
    pub(super) fn set_number(&mut self, table: &Path, key: &str, value: f64) -> Result<()> {
        let (mut new, old) = (number(value), self.get(&table.key(key)).and_then(Item::as_value));
        if old.and_then(to_number) == Some(value) {
            return Ok(());
        }
        if old.is_some_and(Value::is_float) && value.fract() == 0.0 {
            new += ".0";
        }
        self.set(table, key, &new)
    }

    /// Writes a list of texts, in which as few entries as can be are touched.
    pub(super) fn set_strings(&mut self, table: &Path, key: &str, wanted: &[String]) -> Result<()> {
        let path = table.key(key);
        let old = self.strings(&path)?;
        if old.len() == wanted.len() && self.get(&path).is_some() {
            let differing = (0..old.len()).filter(|&i| old[i] != wanted[i]);
            return differing.into_iter().try_for_each(|i| self.set_entry(&path, i, &quote(&wanted[i])));
        }
        let gone = (0..old.len()).rev().filter(|&i| !wanted.contains(&old[i]));
        let left: Vec<String> = old.iter().filter(|name| wanted.contains(name)).cloned().collect();
        match !left.is_empty() && wanted.starts_with(&left) {
            true => {
                gone.into_iter().try_for_each(|i| self.remove(&path, i))?;
                wanted[left.len()..].iter().try_for_each(|name| self.push(&path, &quote(name)))
            }
            false => self.set(table, key, &list(wanted.iter().map(|name| quote(name)))),
        }
    }
}

/// Removes one of several values between commas, with its line if it has one of its own. Lines of comments stay.
pub(super) fn without_member(text: &str, members: &[Range<usize>], index: usize) -> Vec<Patch> {
    let Some(member) = members.get(index) else { return Vec::new() };
    let has_line = indent(text, member.start).is_some();
    let lines = |end: usize| line_start(text, member.start)..next_line(text, end);
    match (comma_after(text, member.end), index.checked_sub(1).map(|before| members[before].end)) {
        (Some(comma), _) if has_line && is_rest_free(text, comma + 1) => {
            vec![(lines(comma), comment_lines(&text[lines(comma)]))]
        }
        (Some(comma), _) => {
            let rest = &text[comma + 1..];
            let space = rest.len() - rest.trim_start_matches([' ', '\t']).len();
            vec![(member.start..comma + 1 + space, String::new())]
        }
        (None, Some(before)) => {
            let comma = comma_after(text, before).unwrap_or(before);
            match has_line && is_rest_free(text, member.end) {
                true => {
                    vec![
                        (comma..comma + 1, String::new()),
                        (lines(member.end), comment_lines(&text[lines(member.end)])),
                    ]
                }
                false => vec![
                    (comma..comma + 1, String::new()),
                    (after_space(text, comma + 1, member.start)..member.end, String::new()),
                ],
            }
        }
        (None, None) => vec![(member.clone(), String::new())],
    }
}

/// Where the space before a byte begins, but not before another.
fn after_space(text: &str, from: usize, to: usize) -> usize {
    from + text[from..to].trim_end_matches([' ', '\t']).len()
}
