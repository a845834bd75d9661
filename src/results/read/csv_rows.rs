//! The rows of a CSV file, one after the other, with the place of each field for messages.

use std::path::{Path, PathBuf};

use crate::results::read::CURE;
use crate::{Error, Result};

/// A file with a header, of which some columns are wanted.
pub(super) struct CsvRows<'b> {
    path: PathBuf,
    reader: csv::Reader<&'b [u8]>,
    columns: Vec<String>,
    /// Where the wanted columns stand.
    at: Vec<usize>,
    record: csv::StringRecord,
    line: u64,
}

/// The row that was read last.
#[derive(Clone, Copy)]
pub(super) struct CsvRow<'a>(&'a CsvRows<'a>);

impl<'b> CsvRows<'b> {
    /// The bytes of a file that must have these columns; others are passed over.
    pub(super) fn new(path: &Path, bytes: &'b [u8], columns: &[&str]) -> Result<Self> {
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(bytes);
        let unreadable = |e: csv::Error| Error::input(path.display(), format!("{e}; {CURE}"));
        let header = reader.headers().map_err(unreadable)?.clone();
        let place = |column: &&str| {
            let at = header.iter().position(|name| name == *column);
            let what = || format!("line 1: there is no column {column:?}; {CURE}");
            at.ok_or_else(|| Error::input(path.display(), what()))
        };
        let at = columns.iter().map(place).collect::<Result<_>>()?;
        let columns = columns.iter().map(|name| name.to_string()).collect();
        let record = csv::StringRecord::new();
        Ok(CsvRows { path: path.into(), reader, columns, at, record, line: 1 })
    }

    /// The next row, if there is one.
    pub(super) fn next_if_any(&mut self) -> Result<Option<CsvRow<'_>>> {
        let place = self.path.display();
        match self.reader.read_record(&mut self.record) {
            Ok(false) => return Ok(None),
            Ok(true) => self.line = self.record.position().map_or(self.line + 1, csv::Position::line),
            Err(e) => return Err(Error::input(place, format!("{e}; {CURE}"))),
        }
        let (fields, columns) = (self.record.len(), self.reader.headers().map_or(0, csv::StringRecord::len));
        if fields != columns {
            let what = format!("line {}: has {fields} fields, the header {columns}; {CURE}", self.line);
            return Err(Error::input(place, what));
        }
        Ok(Some(CsvRow(self)))
    }

    /// The next row, which must be there.
    pub(super) fn next(&mut self) -> Result<CsvRow<'_>> {
        let what = format!("ends after line {}, and manifest.json promises more rows; {CURE}", self.line);
        let ends = Error::input(self.path.display(), what);
        self.next_if_any()?.ok_or(ends)
    }

    /// Nothing may follow.
    pub(super) fn end(&mut self) -> Result<()> {
        match self.next_if_any()? {
            None => Ok(()),
            Some(row) => Err(row.wrong(0, "is in a row more than manifest.json promises")),
        }
    }
}

impl CsvRow<'_> {
    /// A field, by the number of its column among the wanted.
    pub(super) fn text(&self, column: usize) -> &str {
        &self.0.record[self.0.at[column]]
    }

    /// The error for a field.
    pub(super) fn wrong(&self, column: usize, what: &str) -> Error {
        let CsvRows { path, columns, line, .. } = self.0;
        let (name, value) = (&columns[column], self.text(column));
        Error::input(path.display(), format!("line {line}, column {name}: {value:?} {what}; {CURE}"))
    }
}
