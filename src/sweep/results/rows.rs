//! The table `results` for pandas: counts and scores of every scene, snapshot, repeat, choice of poses, representation
//! and region, in study order.

use std::path::Path;

use crate::results::Results;
use crate::results::columns::{COUNT_COLUMNS, DETECTION_COLUMNS, MISSED_COLUMN, OVERLAP_COLUMNS};
use crate::results::table::{Column, ColumnKind, Datum, RowSink, TableFile, TableFormat, csv_bytes};
use perirobot_march::Result;
use perirobot_march::metrics::{Confusion, Score};

/// The name of the file, without its extension.
pub const RESULTS: &str = "results";

/// Writes the table into a folder. A score without a value (a zero denominator) is empty.
pub fn write(results: &Results, folder: &Path, format: TableFormat) -> Result<()> {
    let path = folder.join(format!("{RESULTS}.{}", format.extension()));
    let mut table = RowsFile::create(&path, format)?;
    each(results, &mut |fields| table.0.row(fields))?;
    table.finish()
}

/// The table as CSV, in memory.
pub fn csv(results: &Results) -> Result<Vec<u8>> {
    csv_bytes(&columns(), |sink| each(results, sink))
}

fn each(results: &Results, sink: RowSink) -> Result<()> {
    for scene in &results.scenes {
        for moment in scene.moments.clone() {
            let snapshot = moment - scene.moments.start;
            for repeat in 0..results.repeats {
                results.each_key(|names, key| {
                    let counts = results.counts(moment, repeat, &key)?;
                    row(&scene.name, [snapshot, repeat], names, &counts, &mut *sink)
                })?;
            }
        }
    }
    Ok(())
}

fn columns() -> Vec<Column> {
    let of_kind = |kind: ColumnKind| move |name: &str| Column::new(name, kind);
    let mut columns = vec![Column::new("scene", ColumnKind::Text)];
    columns.extend(["snapshot", "repeat"].map(of_kind(ColumnKind::Count)));
    columns.extend(["combination", "poses", "representation", "region"].map(of_kind(ColumnKind::Text)));
    columns.extend(COUNT_COLUMNS.map(of_kind(ColumnKind::Count)));
    columns.extend(DETECTION_COLUMNS.map(of_kind(ColumnKind::Count)));
    columns.push(Column::new(MISSED_COLUMN, ColumnKind::Text));
    columns.extend(scores().map(Score::name).map(of_kind(ColumnKind::Score)));
    columns.extend(OVERLAP_COLUMNS.map(of_kind(ColumnKind::Count)));
    columns
}

/// Passes a row to a sink.
fn row(scene: &str, moment: [usize; 2], names: [&str; 4], counts: &Confusion, sink: RowSink) -> Result<()> {
    let mut fields = vec![Datum::Text(scene)];
    fields.extend(moment.map(|number| Datum::Count(number as u64)));
    fields.extend(names.map(Datum::Text));
    fields.extend(counts.counts().map(Datum::Count));
    fields.extend(counts.detection.counts().map(Datum::Count));
    let missed = counts.detection.missed_names();
    fields.push(Datum::Text(&missed));
    fields.extend(scores().map(|score| Datum::Score(score.evaluate(counts))));
    fields.extend(counts.overlap.counts().map(Datum::Count));
    sink(&fields)
}

/// The table during writing.
pub struct RowsFile(TableFile);

impl RowsFile {
    /// Starts the table in this file.
    pub fn create(path: &Path, format: TableFormat) -> Result<RowsFile> {
        Ok(RowsFile(TableFile::create(path, format, &columns())?))
    }

    /// Adds a row: the scene, its snapshot and repeat, the names of combination, poses, representation and region, and
    /// the counts.
    pub fn row(
        &mut self,
        scene: &str,
        moment: [usize; 2],
        names: [&str; 4],
        counts: &Confusion,
    ) -> Result<()> {
        row(scene, moment, names, counts, &mut |fields| self.0.row(fields))
    }

    /// Finishes the table and moves it to its path.
    pub fn finish(self) -> Result<()> {
        self.0.finish()
    }
}

/// The scores of a row. People and parts detected are present as counts, under the same names.
pub fn scores() -> impl Iterator<Item = Score> {
    Score::ALL.into_iter().filter(|score| !DETECTION_COLUMNS.contains(&score.name()))
}
