//! Rows as Parquet: gathered in columns until a row group is full, then encoded and written a column at a
//! time.

use std::io;
use std::sync::Arc;

use ::parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as PhysicalType};
use ::parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use ::parquet::errors::{ParquetError, Result};
use ::parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder};
use ::parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use ::parquet::schema::types::{ColumnPath, Type};

use crate::results::files::WholeFile;
use crate::results::table::{Column, ColumnKind, Datum, RowWriter};

/// Rows per group: enough to compress columns well, few enough for about 30 MB of rows of results.
pub(super) const GROUP_ROWS: usize = 1 << 17;

/// Text that closes a group early, so that long names do not take unbounded memory.
const GROUP_TEXT_BYTES: usize = 1 << 26;

/// Values per call of the encoder.
const BATCH: usize = 1 << 13;

pub(super) struct ParquetWriter {
    file: SerializedFileWriter<WholeFile>,
    /// The columns of the current group.
    columns: Vec<Gathered>,
    rows: usize,
    text_bytes: usize,
}

/// A column of a row group.
enum Gathered {
    /// All texts in a row, and their ends.
    Text {
        bytes: Vec<u8>,
        ends: Vec<usize>,
    },
    Count(Vec<i64>),
    /// The values, and for each row 1 if it has one, else 0.
    Score {
        values: Vec<f64>,
        present: Vec<i16>,
    },
}

impl ParquetWriter {
    /// Starts the file.
    pub(super) fn new(file: WholeFile, columns: &[Column]) -> io::Result<Self> {
        let properties = columns.iter().fold(WriterProperties::builder(), properties_of).build();
        let schema = schema(columns).map_err(io_error)?;
        let file =
            SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties)).map_err(io_error)?;
        let columns = columns.iter().map(|column| Gathered::new(column.kind)).collect();
        Ok(ParquetWriter { file, columns, rows: 0, text_bytes: 0 })
    }

    fn write_group(&mut self) -> Result<()> {
        let mut group = self.file.next_row_group()?;
        for column in &mut self.columns {
            let mut writer = group.next_column()?.expect("the schema has these columns");
            column.write(&mut writer)?;
            writer.close()?;
        }
        group.close()?;
        (self.rows, self.text_bytes) = (0, 0);
        Ok(())
    }
}

impl RowWriter for ParquetWriter {
    fn row(&mut self, fields: &[Datum<'_>]) -> io::Result<()> {
        for (column, field) in self.columns.iter_mut().zip(fields) {
            self.text_bytes += column.push(field);
        }
        self.rows += 1;
        if self.rows == GROUP_ROWS || self.text_bytes >= GROUP_TEXT_BYTES {
            self.write_group().map_err(io_error)?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> io::Result<WholeFile> {
        if self.rows > 0 {
            self.write_group().map_err(io_error)?;
        }
        self.file.into_inner().map_err(io_error)
    }
}

impl Gathered {
    fn new(kind: ColumnKind) -> Self {
        match kind {
            ColumnKind::Text => Gathered::Text { bytes: Vec::new(), ends: Vec::new() },
            ColumnKind::Count => Gathered::Count(Vec::new()),
            ColumnKind::Score => Gathered::Score { values: Vec::new(), present: Vec::new() },
        }
    }

    /// Adds a field, and returns its bytes of text.
    fn push(&mut self, field: &Datum<'_>) -> usize {
        match (self, field) {
            (Gathered::Text { bytes, ends }, Datum::Text(text)) => {
                bytes.extend_from_slice(text.as_bytes());
                ends.push(bytes.len());
                return text.len();
            }
            (Gathered::Count(counts), Datum::Count(count)) => counts.push(*count as i64),
            (Gathered::Score { values, present }, Datum::Score(score)) => {
                values.extend(score);
                present.push(score.is_some() as i16);
            }
            _ => unreachable!("fields fit the columns"),
        }
        0
    }

    /// Writes the group, and starts the next.
    fn write(&mut self, writer: &mut SerializedColumnWriter<'_>) -> Result<()> {
        match self {
            Gathered::Text { bytes, ends } => {
                let all = ByteArray::from(std::mem::take(bytes));
                let mut begin = 0;
                for batch in ends.chunks(BATCH) {
                    let text = |&end: &usize| {
                        let text = all.slice(begin, end - begin);
                        begin = end;
                        text
                    };
                    let texts: Vec<ByteArray> = batch.iter().map(text).collect();
                    writer.typed::<ByteArrayType>().write_batch(&texts, None, None)?;
                }
                ends.clear();
            }
            Gathered::Count(counts) => {
                writer.typed::<Int64Type>().write_batch(counts, None, None)?;
                counts.clear();
            }
            Gathered::Score { values, present } => {
                writer.typed::<DoubleType>().write_batch(values, Some(present), None)?;
                values.clear();
                present.clear();
            }
        }
        Ok(())
    }
}

/// The underlying error, in the system's own words if available.
fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(beneath) => match beneath.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(other) => io::Error::other(other),
        },
        error => io::Error::other(error),
    }
}

fn schema(columns: &[Column]) -> Result<Type> {
    let field = |column: &Column| {
        let (physical, logical, repetition) = match column.kind {
            ColumnKind::Text => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
            ColumnKind::Count => (PhysicalType::INT64, None, Repetition::REQUIRED),
            ColumnKind::Score => (PhysicalType::DOUBLE, None, Repetition::OPTIONAL),
        };
        let column = Type::primitive_type_builder(&column.name, physical);
        column.with_logical_type(logical).with_repetition(repetition).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
    Type::group_type_builder("table").with_fields(fields).build()
}

/// Counts differ little from row to row, and scores hardly ever repeat, so only text has a dictionary.
fn properties_of(builder: WriterPropertiesBuilder, column: &Column) -> WriterPropertiesBuilder {
    let path = ColumnPath::from(column.name.as_str());
    let builder = builder
        .set_compression(Compression::SNAPPY)
        // Those of pages would stay in memory until the end.
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_column_dictionary_enabled(path.clone(), column.kind == ColumnKind::Text);
    match column.kind {
        ColumnKind::Count => builder.set_column_encoding(path, Encoding::DELTA_BINARY_PACKED),
        ColumnKind::Text | ColumnKind::Score => builder,
    }
}
