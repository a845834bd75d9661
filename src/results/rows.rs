//! The table `results`: counts and scores of every scene, snapshot, repeat, choice of poses, representation
//! and region, in study order, made for pandas.

use std::path::Path;

use crate::Result;
use crate::metrics::Score;
use crate::results::Results;
use crate::results::columns::{COUNT_COLUMNS, DETECTION_COLUMNS, MISSED_COLUMN};
use crate::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};

/// The name of the file, without its extension.
pub const RESULTS: &str = "results";

/// Writes the table into a folder. A score that has no value (a zero denominator) is empty.
pub fn write(results: &Results, folder: &Path, format: TableFormat) -> Result<()> {
    let of_kind = |kind: ColumnKind| move |name: &str| Column::new(name, kind);
    let mut columns = vec![Column::new("scene", ColumnKind::Text)];
    columns.extend(["snapshot", "repeat"].map(of_kind(ColumnKind::Count)));
    columns.extend(["combination", "poses", "representation", "region"].map(of_kind(ColumnKind::Text)));
    columns.extend(COUNT_COLUMNS.map(of_kind(ColumnKind::Count)));
    columns.extend(DETECTION_COLUMNS.map(of_kind(ColumnKind::Count)));
    columns.push(Column::new(MISSED_COLUMN, ColumnKind::Text));
    columns.extend(scores().map(Score::name).map(of_kind(ColumnKind::Score)));
    let path = folder.join(format!("{RESULTS}.{}", format.extension()));
    let mut table = TableFile::create(&path, format, &columns)?;
    for scene in &results.scenes {
        for moment in scene.moments.clone() {
            let snapshot = (moment - scene.moments.start) as u64;
            for repeat in 0..results.repeats {
                results.each_key(|[combination, poses, representation, region], key| {
                    let c = results.counts(moment, repeat, &key)?;
                    let mut fields = vec![Datum::Text(&scene.name)];
                    fields.extend([snapshot, repeat as u64].map(Datum::Count));
                    fields.extend([combination, poses, representation, region].map(Datum::Text));
                    fields.extend(c.counts().map(Datum::Count));
                    fields.extend(c.detection.counts().map(Datum::Count));
                    let missed = c.detection.missed_names();
                    fields.push(Datum::Text(&missed));
                    fields.extend(scores().map(|score| Datum::Score(score.of(&c))));
                    table.row(&fields)
                })?;
            }
        }
    }
    table.finish()
}

/// The scores of a row. Of people and parts detected the counts are there, under the same names.
fn scores() -> impl Iterator<Item = Score> {
    Score::ALL.into_iter().filter(|score| !DETECTION_COLUMNS.contains(&score.name()))
}
