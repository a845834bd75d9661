//! The table `scores`, made for pandas: the scores of every choice over snapshots and repeats, for each scene
//! and for all scenes together.

use std::path::Path;

use crate::Result;
use crate::metrics::{Confusion, Score};
use crate::results::Results;
use crate::results::over::{Over, over};
use crate::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};

/// The name of the file, without its extension.
pub const SCORES: &str = "scores";

/// What stands in the column `scene` for all scenes together.
pub const ALL_SCENES: &str = "*";

/// Writes the table into a folder: one row a scene, combination, choice of poses, representation and region,
/// in the order of `results`; then the same for all scenes. `worst_part` is the body part that is missed in
/// most rows of `results`, and `worst_part_missed` in how many. What has no value is empty: a score that is
/// nowhere defined, and the spread of a single repeat.
pub fn write(results: &Results, folder: &Path, format: TableFormat) -> Result<()> {
    let names = ["scene", "combination", "poses", "representation", "region"];
    let mut columns = names.map(|name| Column::new(name, ColumnKind::Text)).to_vec();
    for score in Score::ALL {
        let of = |what: &str, kind| Column::new(format!("{}_{what}", score.name()), kind);
        columns.extend(["mean", "std", "worst", "pooled"].map(|what| of(what, ColumnKind::Score)));
        columns.push(of("n", ColumnKind::Count));
    }
    columns.push(Column::new("worst_part", ColumnKind::Text));
    columns.push(Column::new("worst_part_missed", ColumnKind::Count));
    let path = folder.join(format!("{SCORES}.{}", format.extension()));
    let mut table = TableFile::create(&path, format, &columns)?;
    let scenes = results.scenes.iter().map(|scene| (scene.name.as_str(), scene.moments.clone()));
    for (scene, moments) in scenes.chain([(ALL_SCENES, results.moments())]) {
        results.each_key(|names, key| {
            let mut fields = vec![Datum::Text(scene)];
            fields.extend(names.map(Datum::Text));
            let readings = results.readings(moments.clone(), &key)?;
            for score in Score::ALL {
                fields.extend(values(over(&readings, score)));
            }
            let together = readings.iter().flatten().fold(Confusion::default(), |all, one| all.plus(one));
            let worst = together.detection.worst_part();
            fields.push(Datum::Text(worst.map_or("", |(part, _)| part.name())));
            fields.push(Datum::Count(worst.map_or(0, |(_, rows)| rows)));
            table.row(&fields)
        })?;
    }
    table.finish()
}

/// mean, std, worst, pooled, n.
fn values(over: Option<Over>) -> [Datum<'static>; 5] {
    let [mean, std, worst, pooled] = match over {
        Some(Over { mean, std, worst, pooled, .. }) => [Some(mean), std, Some(worst), pooled],
        None => [None; 4],
    };
    let n = over.map_or(0, |over| over.values as u64);
    [Datum::Score(mean), Datum::Score(std), Datum::Score(worst), Datum::Score(pooled), Datum::Count(n)]
}
