//! Small tables with bytes and values written by hand, and the state after a failed write.

use std::fs;

use ::parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::record::Row;

use super::*;
use crate::results::table::parquet::GROUP_ROWS;

const FORMATS: [TableFormat; 2] = [TableFormat::Csv, TableFormat::Parquet];

fn columns() -> Vec<Column> {
    vec![
        Column::new("scene", ColumnKind::Text),
        Column::new("tp", ColumnKind::Count),
        Column::new("poses", ColumnKind::Text),
        Column::new("f1", ColumnKind::Score),
    ]
}

type TestRow = (&'static str, u64, &'static str, Option<f64>);

/// Text that CSV must quote, an empty text, the largest count, a score that has no short decimal, and none.
const ROWS: [TestRow; 4] = [
    ("cell", 0, "camera:wall/1;pads:floor/0", Some(0.5)),
    ("a, \"b\"", i64::MAX as u64, "", Some(0.1 + 0.2)),
    ("Straße", 7, "two\nlines", None),
    ("cell", 12, "camera:wall/1;pads:floor/0", Some(-1e-7)),
];

fn fields((scene, tp, poses, f1): TestRow) -> [Datum<'static>; 4] {
    [Datum::Text(scene), Datum::Count(tp), Datum::Text(poses), Datum::Score(f1)]
}

fn write(path: &Path, format: TableFormat, rows: impl IntoIterator<Item = TestRow>) {
    let mut table = TableFile::create(path, format, &columns()).unwrap();
    for row in rows {
        table.row(&fields(row)).unwrap();
    }
    table.finish().unwrap();
}

fn bytes(format: TableFormat, rows: impl IntoIterator<Item = TestRow>) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table");
    write(&path, format, rows);
    fs::read(path).unwrap()
}

fn read(rows: impl IntoIterator<Item = TestRow>) -> SerializedFileReader<fs::File> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table");
    write(&path, TableFormat::Parquet, rows);
    SerializedFileReader::new(fs::File::open(path).unwrap()).unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[track_caller]
fn check_row(row: &Row, (scene, tp, poses, f1): TestRow) {
    use ::parquet::record::Field::{Double, Long, Null, Str};
    let found: Vec<_> = row.get_column_iter().map(|(_, field)| field.clone()).collect();
    let expected =
        [Str(scene.into()), Long(tp.try_into().unwrap()), Str(poses.into()), f1.map_or(Null, Double)];
    assert_eq!(found, expected);
}

#[test]
fn csv_is_written_to_the_byte() {
    let expected = "scene,tp,poses,f1\n\
        cell,0,camera:wall/1;pads:floor/0,0.5\n\
        \"a, \"\"b\"\"\",9223372036854775807,,0.30000000000000004\n\
        Straße,7,\"two\nlines\",\n\
        cell,12,camera:wall/1;pads:floor/0,-0.0000001\n";
    assert_eq!(String::from_utf8(bytes(TableFormat::Csv, ROWS)).unwrap(), expected);
    assert_eq!(bytes(TableFormat::Csv, []), b"scene,tp,poses,f1\n");
    assert_eq!(TableFormat::Csv.extension(), "csv");
}

#[test]
fn parquet_has_names_types_and_values() {
    let reader = read(ROWS);
    let schema = reader.metadata().file_metadata().schema_descr();
    let found: Vec<_> = schema
        .columns()
        .iter()
        .map(|column| {
            let info = column.self_type().get_basic_info();
            (column.name(), column.physical_type(), info.logical_type_ref().cloned(), info.repetition())
        })
        .collect();
    let expected = [
        ("scene", PhysicalType::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
        ("tp", PhysicalType::INT64, None, Repetition::REQUIRED),
        ("poses", PhysicalType::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
        ("f1", PhysicalType::DOUBLE, None, Repetition::OPTIONAL),
    ];
    assert_eq!(found, expected);
    let rows: Vec<Row> = reader.get_row_iter(None).unwrap().map(|row| row.unwrap()).collect();
    assert_eq!(rows.len(), ROWS.len());
    for (row, expected) in rows.iter().zip(ROWS) {
        check_row(row, expected);
    }
    assert_eq!(TableFormat::Parquet.extension(), "parquet");
}

#[test]
fn only_text_has_a_dictionary() {
    let reader = read(ROWS);
    for column in reader.metadata().row_group(0).columns() {
        let text = column.column_type() == PhysicalType::BYTE_ARRAY;
        assert_eq!(column.dictionary_page_offset().is_some(), text, "{}", column.column_path());
        assert_eq!(column.compression(), Compression::SNAPPY);
    }
}

/// Rows that differ from group to group, with gaps in the scores.
fn many(rows: usize) -> impl Iterator<Item = TestRow> {
    let score = |i: usize| (!i.is_multiple_of(7)).then(|| 1.0 / i as f64);
    (0..rows).map(move |i| (["a", "b", "longer"][i % 3], i as u64, ["x", ""][i / 1000 % 2], score(i)))
}

#[test]
fn parquet_has_groups_of_bounded_size() {
    let rows = 2 * GROUP_ROWS + 5;
    let reader = read(many(rows));
    let groups: Vec<_> =
        reader.metadata().row_groups().iter().map(|group| group.num_rows() as usize).collect();
    assert_eq!(groups, [GROUP_ROWS, GROUP_ROWS, 5]);
    let mut found = reader.get_row_iter(None).unwrap();
    for expected in many(rows) {
        check_row(&found.next().unwrap().unwrap(), expected);
    }
    assert!(found.next().is_none());

    // A full group is not followed by an empty one.
    for (rows, groups) in [(0, 0), (GROUP_ROWS, 1)] {
        let reader = read(many(rows));
        assert_eq!(reader.num_row_groups(), groups, "{rows} rows");
    }
}

#[test]
fn long_texts_close_a_group_early() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table");
    let mut table =
        TableFile::create(&path, TableFormat::Parquet, &[Column::new("poses", ColumnKind::Text)]).unwrap();
    // 64 MiB are 64 rows of 1 MiB.
    let long = "x".repeat(1 << 20);
    for _ in 0..65 {
        table.row(&[Datum::Text(&long)]).unwrap();
    }
    table.finish().unwrap();
    let reader = SerializedFileReader::new(fs::File::open(path).unwrap()).unwrap();
    let groups: Vec<_> = reader.metadata().row_groups().iter().map(|group| group.num_rows()).collect();
    assert_eq!(groups, [64, 1]);
}

#[test]
fn the_same_rows_give_the_same_bytes() {
    for format in FORMATS {
        let rows = GROUP_ROWS + 9;
        assert!(bytes(format, many(rows)) == bytes(format, many(rows)), "{format:?}");
        assert!(bytes(format, many(rows)) != bytes(format, many(rows + 1)), "{format:?}");
    }
}

#[test]
fn a_table_appears_whole_or_not_at_all() {
    for format in FORMATS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table");
        fs::write(&path, "old").unwrap();
        let mut table = TableFile::create(&path, format, &columns()).unwrap();
        for row in many(GROUP_ROWS + 1) {
            table.row(&fields(row)).unwrap();
        }
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drop(table);
        assert_eq!(names(folder.path()), ["table"]);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write(&path, format, many(1));
        assert_eq!(names(folder.path()), ["table"]);
        assert_ne!(fs::read(&path).unwrap(), b"old");
    }
}

#[test]
fn a_folder_that_is_gone_is_named() {
    for format in FORMATS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out/table");
        let error = TableFile::create(&path, format, &columns()).err().unwrap().to_string();
        assert!(error.contains("out/table: cannot be written"), "{error}");

        fs::create_dir(folder.path().join("out")).unwrap();
        let table = TableFile::create(&path, format, &columns()).unwrap();
        fs::remove_dir_all(folder.path().join("out")).unwrap();
        let error = table.finish().unwrap_err().to_string();
        assert!(error.contains("out/table: cannot be written"), "{error}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named_and_nothing_stays() {
    for format in FORMATS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table");
        let full = WholeFile::create(&path).unwrap().on_full_disk();
        let mut table = TableFile::start(full, &path, format, &columns()).unwrap();
        let written = many(3 * GROUP_ROWS).try_for_each(|row| table.row(&fields(row)));
        let error = written.unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("{}: cannot be written: No space left", path.display())),
            "{error}"
        );
        drop(table);
        assert_eq!(names(folder.path()), [""; 0]);
    }
}

#[test]
#[should_panic(expected = "columns are [Text, Count, Text, Score], the row is [Text(\"a\")]")]
fn rows_fit_the_columns() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = TableFile::create(&folder.path().join("t"), TableFormat::Csv, &columns()).unwrap();
    let _ = table.row(&[Datum::Text("a")]);
}
