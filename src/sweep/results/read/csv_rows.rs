//! The rows of a CSV file, one after the other, with the place of each field for messages.

use std::path::{Path, PathBuf};

use crate::results::read::CURE;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

/// A file with a header and some wanted columns.
pub(super) struct CsvRows<'b> {
    path: PathBuf,
    reader: csv::Reader<&'b [u8]>,
    columns: Vec<String>,
    /// The places of the wanted columns.
    at: Vec<usize>,
    record: csv::StringRecord,
    line: u64,
}

/// The current row.
#[derive(Clone, Copy)]
pub(super) struct CsvRow<'a>(&'a CsvRows<'a>);

impl<'b> CsvRows<'b> {
    /// The bytes of a file that must have these columns; others are ignored.
    pub(super) fn new(path: &Path, bytes: &'b [u8], columns: &[&str]) -> Result<Self> {
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(bytes);
        let unreadable =
            |e: csv::Error| Error::from(Issue::damaged(e.to_string()).cure(CURE).with_place(path));
        let header = reader.headers().map_err(unreadable)?.clone();
        let place = |column: &&str| {
            let at = header.iter().position(|name| name == *column);
            let what = || Issue::says(format!("there is no column {column:?}")).with_place("line 1");
            at.ok_or_else(|| what().cure(CURE).with_place(path).into())
        };
        let at = columns.iter().map(place).collect::<Result<_>>()?;
        let columns = columns.iter().map(|name| name.to_string()).collect();
        let record = csv::StringRecord::new();
        Ok(CsvRows { path: path.into(), reader, columns, at, record, line: 1 })
    }

    /// The next row, if any.
    pub(super) fn next_if_any(&mut self) -> Result<Option<CsvRow<'_>>> {
        let place = &self.path;
        match self.reader.read_record(&mut self.record) {
            Ok(false) => return Ok(None),
            Ok(true) => self.line = self.record.position().map_or(self.line + 1, csv::Position::line),
            Err(e) => return Err(Issue::damaged(e.to_string()).cure(CURE).with_place(place).into()),
        }
        let (fields, columns) = (self.record.len(), self.reader.headers().map_or(0, csv::StringRecord::len));
        if fields != columns {
            let what = format!("has {fields} fields, the header {columns}");
            let line = format!("line {}", self.line);
            return Err(Issue::damaged(what).cure(CURE).with_place(line).with_place(place).into());
        }
        Ok(Some(CsvRow(self)))
    }

    /// The next row, which must exist.
    pub(super) fn next(&mut self) -> Result<CsvRow<'_>> {
        let what = format!("ends after line {}, but manifest.json requires more rows", self.line);
        let ends = Issue::damaged(what).cure(CURE).with_place(&self.path);
        self.next_if_any()?.ok_or(ends.into())
    }

    /// Fails if another row follows.
    pub(super) fn end(&mut self) -> Result<()> {
        match self.next_if_any()? {
            None => Ok(()),
            Some(row) => Err(row.wrong(0, "is in a row beyond those of manifest.json")),
        }
    }
}

impl CsvRow<'_> {
    /// A field, by the index of its column among the wanted.
    pub(super) fn text(&self, column: usize) -> &str {
        &self.0.record[self.0.at[column]]
    }

    /// The error for a field.
    pub(super) fn wrong(&self, column: usize, what: &str) -> Error {
        let CsvRows { path, columns, line, .. } = self.0;
        let (name, value) = (&columns[column], self.text(column));
        let issue = Issue::says(format!("{value:?} {what}")).cure(CURE);
        issue.with_place(format!("line {line}, column {name}")).with_place(path).into()
    }
}
