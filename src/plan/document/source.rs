//! A TOML text that is changed in places. `toml_edit` says where in the text each key and value is; what is written there
//! is spliced in, and all other bytes stay as they are: comments, order, line ends.

use std::ops::Range;

use toml_edit::{Document, InlineTable, Item, Value};

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

use super::path::{Path, Step};
use super::span::{
    comma_after, comment_lines, indent, indent_of_line, inline_members, is_rest_free, line_end, line_start,
    next_line, own_end, pieces,
};

/// Bytes, and what stands there instead.
pub(super) type Patch = (Range<usize>, String);

/// A TOML text and what it says.
pub(super) struct Source {
    document: Document<String>,
}

impl Source {
    /// # Errors
    /// If the text is not TOML.
    pub(super) fn new(text: String) -> Result<Source> {
        let not_toml = |e: toml_edit::TomlError| Error::input("the study", format!("not TOML: {e}"));
        Document::parse(text).map(|document| Source { document }).map_err(not_toml)
    }

    pub(super) fn text(&self) -> &str {
        self.document.raw()
    }

    pub(super) fn into_text(self) -> String {
        self.document.raw().to_string()
    }

    /// What is at a place.
    pub(super) fn get(&self, path: &Path) -> Option<&Item> {
        path.find(self.document.as_item())
    }

    /// A text at a place.
    pub(super) fn str(&self, path: &Path) -> Option<&str> {
        self.get(path)?.as_str()
    }

    /// A list of texts at a place; empty if there is none.
    pub(super) fn strings(&self, path: &Path) -> Result<Vec<String>> {
        let Some(item) = self.get(path) else { return Ok(Vec::new()) };
        let all = item.as_array().map(|all| all.iter().map(|one| one.as_str().map(String::from)).collect());
        all.flatten().ok_or_else(|| Error::input(path.to_string(), "not a list of names"))
    }

    /// How many entries a list has.
    pub(super) fn count(&self, path: &Path) -> usize {
        match self.get(path) {
            Some(Item::ArrayOfTables(tables)) => tables.len(),
            Some(Item::Value(Value::Array(values))) => values.len(),
            _ => 0,
        }
    }

    /// The entries of a list by a text that each has.
    pub(super) fn position(&self, list: &Path, key: &str, value: &str) -> Option<usize> {
        (0..self.count(list)).find(|&i| self.str(&list.entry(i).key(key)) == Some(value))
    }

    /// Changes some bytes.
    ///
    /// # Errors
    /// If the result were not TOML.
    pub(super) fn splice(&mut self, mut patches: Vec<Patch>) -> Result<()> {
        let is_windows = self.text().find('\n').is_some_and(|end| self.text()[..end].ends_with('\r'));
        patches.sort_by_key(|(bytes, _)| (bytes.start, bytes.end));
        let mut text = self.text().to_string();
        for (bytes, new) in patches.into_iter().rev() {
            let new = if is_windows { new.replace("\r\n", "\n").replace('\n', "\r\n") } else { new };
            text.replace_range(bytes, &new);
        }
        let document = Document::parse(text);
        self.document = document
            .map_err(|e| Error::Bug(Issue::says(format!("the edited study would not be TOML: {e}"))))?;
        Ok(())
    }

    /// Writes the value of a key, which is added if it is not there.
    pub(super) fn set(&mut self, table: &Path, key: &str, value: &str) -> Result<()> {
        let patch = match self.get(&table.key(key)) {
            Some(Item::Value(old)) => (old.span().ok_or_else(|| unplaced(table))?, value.to_string()),
            Some(_) => {
                let what = format!("{key} is a table of its own");
                return Err(Error::input(table.to_string(), what).with_advice("write it as one value"));
            }
            None => self.insertion(table, key, value)?,
        };
        match self.text()[patch.0.clone()] == *patch.1 {
            true => Ok(()),
            false => self.splice(vec![patch]),
        }
    }

    /// Where a new key of a table goes.
    fn insertion(&self, path: &Path, key: &str, value: &str) -> Result<Patch> {
        let (text, shown) = (self.text(), quote_key(key));
        let unplaced = || unplaced(path);
        // `poses.camera = …` has the names of its tables before it.
        let dotted: String = self.dotted(path).iter().map(|name| quote_key(name) + ".").collect();
        match self.get(path) {
            Some(Item::Table(table)) if !table.is_implicit() || table.is_dotted() => {
                let end = own_end(table).or(table.span().map(|span| span.end)).ok_or_else(unplaced)?;
                let line = format!("{}{dotted}{shown} = {value}", indent_of_line(text, end));
                Ok(self.line_after(end, &line))
            }
            Some(Item::Value(Value::InlineTable(table))) => {
                let (pair, members) = (format!("{dotted}{shown} = {value}"), inline_members(text, table));
                match (members.last(), table.span()) {
                    (Some((_, last)), _) => Ok((last.end..last.end, format!(", {pair}"))),
                    (None, Some(span)) => Ok((span.start + 1..span.start + 1, format!(" {pair} "))),
                    (None, None) => Err(unplaced()),
                }
            }
            _ => Err(unplaced()),
        }
    }

    /// The last names of a path that are written before their keys, with dots.
    fn dotted(&self, path: &Path) -> Vec<String> {
        let is_dotted = |length: usize| match self.get(&Path(path.0[..length].to_vec())) {
            Some(Item::Table(table)) => table.is_dotted(),
            Some(Item::Value(Value::InlineTable(table))) => table.is_dotted(),
            _ => false,
        };
        let first = (1..=path.0.len()).rev().take_while(|&length| is_dotted(length)).last();
        let names = first.map_or(&[][..], |first| &path.0[first - 1..]).iter();
        names.filter_map(|step| if let Step::Key(key) = step { Some(key.clone()) } else { None }).collect()
    }

    /// New lines behind the one in which a byte is.
    pub(super) fn line_after(&self, at: usize, lines: &str) -> Patch {
        let text = self.text();
        match line_end(text, at) {
            end if end == text.len() => (end..end, format!("\n{lines}")),
            end => (end + 1..end + 1, format!("{lines}\n")),
        }
    }

    /// New lines behind some value, and behind the comments that belong to it.
    pub(super) fn append_block(&mut self, after: usize, block: &str) -> Result<()> {
        let text = self.text();
        let (mut end, mut next) = (after, next_line(text, after));
        while next < text.len() && text[next..line_end(text, next)].trim_start().starts_with('#') {
            (end, next) = (next, next_line(text, next));
        }
        let is_free = next >= text.len() || text[next..line_end(text, next)].trim().is_empty();
        // Comments right before a table belong to that table.
        let patch = self.line_after(if is_free { end } else { after }, block);
        self.splice(vec![patch])
    }

    /// Removes a key with its line. Lines of comments inside its value stay.
    pub(super) fn unset(&mut self, path: &Path, key: &str) -> Result<()> {
        let whole = path.key(key);
        let text = self.text();
        let patches = match (self.get(&whole), self.get(path)) {
            (None, _) => return Ok(()),
            (Some(Item::Table(table)), _) if !table.is_dotted() => self.without_pieces(pieces(table)),
            (Some(Item::ArrayOfTables(tables)), _) => {
                self.without_pieces(tables.iter().flat_map(pieces).collect())
            }
            (Some(Item::Table(table)), _) => {
                let keys: Vec<String> = table.iter().map(|(key, _)| key.to_string()).collect();
                return keys.iter().try_for_each(|key| self.unset(&whole, key));
            }
            (Some(Item::Value(value)), Some(Item::Table(table))) => {
                let key = table.key(key).and_then(|key| key.span());
                let (key, value) = key.zip(value.span()).ok_or_else(|| unplaced(path))?;
                let lines = line_start(text, key.start)..next_line(text, value.end);
                let comments = comment_lines(&text[lines.clone()]);
                vec![(lines, comments)]
            }
            (Some(Item::Value(_)), Some(Item::Value(_))) => {
                let dotted = self.dotted(path);
                let outer = Path(path.0[..path.0.len() - dotted.len()].to_vec());
                let names = [dotted, vec![key.to_string()]].concat();
                let table = self.get(&outer).and_then(Item::as_inline_table).ok_or_else(|| unplaced(path))?;
                self.without_inline(table, &names)
            }
            _ => return Err(unplaced(path)),
        };
        self.splice(patches)
    }

    fn without_inline(&self, table: &InlineTable, names: &[String]) -> Vec<Patch> {
        let members = inline_members(self.text(), table);
        let index = members.iter().position(|(own, _)| own.starts_with(names));
        let spans: Vec<Range<usize>> = members.into_iter().map(|(_, span)| span).collect();
        index.map_or(Vec::new(), |index| without_member(self.text(), &spans, index))
    }

    /// Removes tables with headers, and the empty line before the first.
    fn without_pieces(&self, pieces: Vec<Range<usize>>) -> Vec<Patch> {
        let text = self.text();
        let lines = |piece: &Range<usize>| line_start(text, piece.start)..next_line(text, piece.end);
        let mut patches: Vec<Patch> = Vec::new();
        for (i, piece) in pieces.iter().enumerate() {
            let mut lines = lines(piece);
            let comments = comment_lines(&text[lines.clone()]);
            let before = line_start(text, lines.start.saturating_sub(1));
            let is_empty = lines.start > 0 && text[before..lines.start].trim().is_empty();
            if i == 0 && is_empty && comments.is_empty() {
                lines.start = before;
            }
            patches.push((lines, comments));
        }
        patches
    }

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
        let old = self.get(&table.key(key)).and_then(Item::as_array);
        let old: Option<Vec<(f64, Range<usize>)>> =
            old.and_then(|old| old.iter().map(|value| Some((to_number(value)?, value.span()?))).collect());
        match old {
            Some(old) if old.len() == numbers.len() => {
                let differs = |&(old, new): &(&(f64, Range<usize>), &f64)| old.0 != *new;
                let differing = old.iter().zip(numbers).filter(differs);
                self.splice(differing.map(|(old, new)| (old.1.clone(), number(*new))).collect())
            }
            _ => self.set(table, key, &list(numbers.iter().map(|value| number(*value)))),
        }
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
fn without_member(text: &str, members: &[Range<usize>], index: usize) -> Vec<Patch> {
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

/// A number, whole or not.
pub(super) fn to_number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// A number as people write it: 1.25, -20.
pub(super) fn number(value: f64) -> String {
    // A zero has no sign here.
    format!("{}", value + 0.0)
}

/// A text in quotes.
pub(super) fn quote(text: &str) -> String {
    Value::from(text).to_string()
}

/// A key, in quotes if it needs them.
pub(super) fn quote_key(key: &str) -> String {
    toml_edit::Key::new(key).to_string().trim().to_string()
}

/// A list in brackets.
pub(super) fn list(values: impl Iterator<Item = String>) -> String {
    format!("[{}]", values.collect::<Vec<_>>().join(", "))
}

fn unplaced(path: &Path) -> Error {
    Error::input(path.to_string(), "cannot be edited here: it is not where a table or a list would be")
        .with_advice("edit it in the file")
}
