//! Rows as CSV: numbers as Rust prints them, the shortest text that reads back as the same number.

use std::io;

use crate::results::files::WholeFile;
use crate::results::table::{Column, Datum, RowWriter};

/// Bytes per write.
const BUFFER: usize = 1 << 18;

pub(super) struct CsvWriter {
    csv: ::csv::Writer<WholeFile>,
    /// The text of one number.
    number: Vec<u8>,
}

impl CsvWriter {
    /// Writes the header.
    pub(super) fn new(file: WholeFile, columns: &[Column]) -> io::Result<Self> {
        let mut csv = ::csv::WriterBuilder::new().buffer_capacity(BUFFER).from_writer(file);
        csv.write_record(columns.iter().map(|column| &column.name)).map_err(io_error)?;
        Ok(CsvWriter { csv, number: Vec::new() })
    }

    fn number(&mut self, number: &impl std::fmt::Display) -> io::Result<()> {
        use io::Write;
        self.number.clear();
        write!(self.number, "{number}")?;
        self.csv.write_field(&self.number).map_err(io_error)
    }
}

impl RowWriter for CsvWriter {
    fn row(&mut self, fields: &[Datum<'_>]) -> io::Result<()> {
        for field in fields {
            match field {
                Datum::Text(text) => self.csv.write_field(text).map_err(io_error)?,
                Datum::Count(count) => self.number(count)?,
                Datum::Score(Some(score)) => self.number(score)?,
                Datum::Score(None) => self.csv.write_field("").map_err(io_error)?,
            }
        }
        self.csv.write_record(None::<&[u8]>).map_err(io_error)
    }

    fn finish(self: Box<Self>) -> io::Result<WholeFile> {
        self.csv.into_inner().map_err(|e| e.into_error())
    }
}

/// The underlying error, whose kind decides the exit code.
fn io_error(error: ::csv::Error) -> io::Error {
    match error.into_kind() {
        ::csv::ErrorKind::Io(beneath) => beneath,
        other => io::Error::other(format!("{other:?}")),
    }
}
