//! Tables are what pandas takes them for: CSV and Parquet, read back by a script, are the same frame.

use crate::common::python;
use perirobot_sweep::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};

/// As many as tests/pandas/read_back.py expects.
const ROWS: u64 = 200_000;

#[test]
fn pandas_reads_the_same_frame_from_csv_and_parquet() {
    let Some(interpreter) = python::python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let columns = [
        ("scene", ColumnKind::Text),
        ("tp", ColumnKind::Count),
        ("poses", ColumnKind::Text),
        ("f1", ColumnKind::Score),
    ];
    let columns = columns.map(|(name, kind)| Column::new(name, kind));
    for format in [TableFormat::Csv, TableFormat::Parquet] {
        let path = folder.path().join("table").with_extension(format.extension());
        let mut table = TableFile::create(&path, format, &columns).unwrap();
        for i in 0..ROWS {
            let scene = ["a, \"b\"", "Straße", ""][i as usize % 3];
            let poses = format!("camera:wall/{}", i / 10);
            let f1 = (i % 7 != 0).then(|| 1.0 / i as f64);
            let fields = [Datum::Text(scene), Datum::Count(i * i), Datum::Text(&poses), Datum::Score(f1)];
            table.row(&fields).unwrap();
        }
        table.finish().unwrap();
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/pandas/read_back.py");
    python::run(&interpreter, &[script, folder.path().to_str().unwrap()]).unwrap();
}
