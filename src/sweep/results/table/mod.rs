//! Tables too long for memory: typed columns, written row by row as CSV or Parquet, atomically.

mod csv;
#[cfg(feature = "parquet")]
mod parquet;

use std::io;
use std::path::{Path, PathBuf};

use crate::results::columns::Csv;
use crate::results::files::{WholeFile, cannot_write};
use perirobot_march::Result;

/// The type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Text: a string in Parquet, with a dictionary.
    Text,
    /// Whole numbers below 2^63: int64 in Parquet.
    Count,
    /// Numbers, possibly missing: a nullable double in Parquet, an empty field in CSV.
    Score,
}

/// One column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its header.
    pub name: String,
    /// Its type.
    pub kind: ColumnKind,
}

impl Column {
    /// A column by its header and kind.
    pub fn new(name: impl Into<String>, kind: ColumnKind) -> Self {
        Column { name: name.into(), kind }
    }
}

/// One value of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Datum<'a> {
    /// For [`ColumnKind::Text`].
    Text(&'a str),
    /// For [`ColumnKind::Count`], below 2^63.
    Count(u64),
    /// For [`ColumnKind::Score`]; `None` without a value.
    Score(Option<f64>),
}

impl Datum<'_> {
    /// As in CSV: numbers as Rust prints them, empty without a value.
    pub(crate) fn text(&self) -> String {
        match self {
            Datum::Text(text) => text.to_string(),
            Datum::Count(count) => count.to_string(),
            Datum::Score(score) => score.map_or(String::new(), |score| score.to_string()),
        }
    }

    fn fits(&self, kind: ColumnKind) -> bool {
        match self {
            Datum::Text(_) => kind == ColumnKind::Text,
            Datum::Count(count) => kind == ColumnKind::Count && *count <= i64::MAX as u64,
            Datum::Score(_) => kind == ColumnKind::Score,
        }
    }
}

/// The format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Text with a header: commas, quotes where needed, the shortest decimal that gives the same double.
    Csv,
    /// Apache Parquet: int64, double and string columns, Snappy.
    #[cfg(feature = "parquet")]
    Parquet,
}

impl TableFormat {
    /// The format of a file by the ending of its name.
    pub fn from_path(path: &Path) -> Result<TableFormat> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("csv") => Ok(TableFormat::Csv),
            #[cfg(feature = "parquet")]
            Some("parquet") => Ok(TableFormat::Parquet),
            #[cfg(not(feature = "parquet"))]
            Some("parquet") => {
                Err(perirobot_march::error::Issue::left_out("Parquet", "parquet").with_place(path).into())
            }
            _ => Err(perirobot_march::Error::input(path, "must end in .csv or .parquet")),
        }
    }

    /// The extension of the file's name, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            TableFormat::Csv => "csv",
            #[cfg(feature = "parquet")]
            TableFormat::Parquet => "parquet",
        }
    }
}

/// A sink for the rows of a table.
pub type RowSink<'s> = &'s mut dyn FnMut(&[Datum<'_>]) -> Result<()>;

/// A table as CSV in memory, from a function that passes its rows to a sink.
///
/// # Errors
/// Those of the rows.
pub fn csv_bytes(columns: &[Column], rows: impl FnOnce(RowSink) -> Result<()>) -> Result<Vec<u8>> {
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    let mut csv = Csv::new(&names);
    rows(&mut |fields| {
        csv.row(&fields.iter().map(Datum::text).collect::<Vec<_>>());
        Ok(())
    })?;
    Ok(csv.bytes())
}

/// A table during writing. The same rows give the same bytes, and memory does not grow with their number. If it is
/// dropped before [`TableFile::finish`], no file is left.
pub struct TableFile {
    path: PathBuf,
    kinds: Vec<ColumnKind>,
    writer: Box<dyn RowWriter>,
}

/// Writes rows that fit the columns, in one format.
trait RowWriter: Send {
    fn row(&mut self, fields: &[Datum<'_>]) -> io::Result<()>;

    /// Writes the rest; the file must still be committed.
    fn finish(self: Box<Self>) -> io::Result<WholeFile>;
}

impl TableFile {
    /// Starts a table of at least one column; the file at its path is unchanged until the end.
    ///
    /// # Errors
    /// `Error::Input` that names the file if it cannot be written; the same for all methods.
    pub fn create(path: &Path, format: TableFormat, columns: &[Column]) -> Result<Self> {
        TableFile::start(WholeFile::create(path)?, path, format, columns)
    }

    fn start(file: WholeFile, path: &Path, format: TableFormat, columns: &[Column]) -> Result<Self> {
        let begin = || -> io::Result<Box<dyn RowWriter>> {
            Ok(match format {
                TableFormat::Csv => Box::new(csv::CsvWriter::new(file, columns)?),
                #[cfg(feature = "parquet")]
                TableFormat::Parquet => Box::new(parquet::ParquetWriter::new(file, columns)?),
            })
        };
        let writer = begin().map_err(|e| cannot_write(path, e))?;
        Ok(TableFile { path: path.into(), kinds: columns.iter().map(|column| column.kind).collect(), writer })
    }

    /// Its final path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends a row: one field per column, in their order.
    ///
    /// # Panics
    /// If the fields do not fit the columns.
    pub fn row(&mut self, fields: &[Datum<'_>]) -> Result<()> {
        let fit = fields.len() == self.kinds.len() && fields.iter().zip(&self.kinds).all(|(f, k)| f.fits(*k));
        assert!(fit, "columns are {:?}, the row is {fields:?}", self.kinds);
        self.writer.row(fields).map_err(|e| cannot_write(&self.path, e))
    }

    /// Writes the rest, and moves the file to its path.
    pub fn finish(self) -> Result<()> {
        self.writer.finish().map_err(|e| cannot_write(&self.path, e))?.commit()
    }
}

#[cfg(test)]
mod tests;
