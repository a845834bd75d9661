//! The table `results`: counts and scores of every scene, snapshot, repeat, choice of poses, representation
//! and region, in study order, made for pandas.

use std::path::Path;

use crate::Result;
use crate::metrics::Score;
use crate::results::Results;
use crate::results::columns::{COUNT_COLUMNS, DETECTION_COLUMNS, MISSED_COLUMN};
use crate::results::table::{Column, Field, Format, Kind, TableFile};

/// The name of the file, without its extension.
pub const RESULTS: &str = "results";

/// Writes the table into a folder. A score that has no value (a zero denominator) is empty.
pub fn write(results: &Results, folder: &Path, format: Format) -> Result<()> {
    let of_kind = |kind: Kind| move |name: &str| Column::new(name, kind);
    let mut columns = vec![Column::new("scene", Kind::Text)];
    columns.extend(["snapshot", "repeat"].map(of_kind(Kind::Count)));
    columns.extend(["combination", "poses", "representation", "region"].map(of_kind(Kind::Text)));
    columns.extend(COUNT_COLUMNS.map(of_kind(Kind::Count)));
    columns.extend(DETECTION_COLUMNS.map(of_kind(Kind::Count)));
    columns.push(Column::new(MISSED_COLUMN, Kind::Text));
    columns.extend(scores().map(Score::name).map(of_kind(Kind::Score)));
    let path = folder.join(format!("{RESULTS}.{}", format.extension()));
    let mut table = TableFile::create(&path, format, &columns)?;
    for scene in &results.scenes {
        for moment in scene.moments.clone() {
            let snapshot = (moment - scene.moments.start) as u64;
            for repeat in 0..results.repeats {
                results.each_key(|[combination, poses, representation, region], key| {
                    let c = results.counts(moment, repeat, &key)?;
                    let mut fields = vec![Field::Text(&scene.name)];
                    fields.extend([snapshot, repeat as u64].map(Field::Count));
                    fields.extend([combination, poses, representation, region].map(Field::Text));
                    fields.extend(c.counts().map(Field::Count));
                    fields.extend(c.detection.counts().map(Field::Count));
                    let missed = c.detection.missed_names();
                    fields.push(Field::Text(&missed));
                    fields.extend(scores().map(|score| Field::Score(score.of(&c))));
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
