//! A TOML text that is changed in places. `toml_edit` says where in the text each key and value is; what is written there
//! is spliced in, and all other bytes stay as they are: comments, order, line ends.

use std::ops::Range;

use toml_edit::{Document, InlineTable, Item, Value};

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

use super::lists::without_member;
use super::number::quote_key;
use super::path::{Path, Step};
use super::span::{
    comment_lines, indent_of_line, inline_members, line_end, line_start, next_line, own_end, pieces,
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
    pub(super) fn without_pieces(&self, pieces: Vec<Range<usize>>) -> Vec<Patch> {
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
}

/// The error for a place that has another form than one can edit.
pub(super) fn unplaced(path: &Path) -> Error {
    Error::input(path.to_string(), "cannot be edited here: it is not where a table or a list would be")
        .with_advice("edit it in the file")
}
