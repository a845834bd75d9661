//! The table `scores` for pandas: the scores of every choice over snapshots and repeats, for each scene and for all
//! scenes together.

use std::path::Path;

use crate::results::Results;
use crate::results::over::{Over, summarize, weighted_mean};
use crate::results::table::{Column, ColumnKind, Datum, RowSink, TableFile, TableFormat, csv_bytes};
use perirobot_march::Result;
use perirobot_march::metrics::{Confusion, Score};

/// The name of the file, without its extension.
pub const SCORES: &str = "scores";

/// The entry of the column `scene` for all scenes together.
pub const ALL_SCENES: &str = "*";

/// Writes the table into a folder: one row per scene, combination, choice of poses, representation and region, in the
/// order of `results`; then the same for all scenes, and, if objects have candidate places, for all scenes with them at
/// each place (`*@robot/0.5/0/90`). `worst_part` is the body part that is missed in most rows of `results`, and
/// `worst_part_missed` their number. Missing values are empty: an undefined score, and the spread of a single repeat.
pub fn write(results: &Results, folder: &Path, format: TableFormat) -> Result<()> {
    let path = folder.join(format!("{SCORES}.{}", format.extension()));
    let mut table = TableFile::create(&path, format, &columns(results))?;
    each(results, &mut |fields| table.row(fields))?;
    table.finish()
}

/// The table as CSV, in memory.
pub fn csv(results: &Results) -> Result<Vec<u8>> {
    csv_bytes(&columns(results), |sink| each(results, sink))
}

fn columns(results: &Results) -> Vec<Column> {
    let names = ["scene", "combination", "poses", "representation", "region"];
    let mut columns = names.map(|name| Column::new(name, ColumnKind::Text)).to_vec();
    let of_score = |score: Score| {
        let column = |what: &str, kind| Column::new(format!("{}_{what}", score.name()), kind);
        let mut columns =
            ["mean", "std", "worst", "pooled"].map(|what| column(what, ColumnKind::Score)).to_vec();
        columns.push(column("n", ColumnKind::Count));
        columns.extend(results.dwell_s.is_some().then(|| column("weighted", ColumnKind::Score)));
        columns
    };
    let (first, last) = in_column_order();
    columns.extend(first.iter().copied().flat_map(of_score));
    columns.push(Column::new("worst_part", ColumnKind::Text));
    columns.push(Column::new("worst_part_missed", ColumnKind::Count));
    columns.extend(last.iter().copied().flat_map(of_score));
    columns
}

/// The scores with columns before those of the worst part, and the newer ones after it, so that columns keep their
/// places of older tables.
fn in_column_order() -> (&'static [Score], &'static [Score]) {
    Score::ALL.split_at(Score::FalseAlarm as usize + 1)
}

fn each(results: &Results, sink: RowSink) -> Result<()> {
    for (scene, moments) in groups(results) {
        let lasting =
            |dwell_s: &Vec<f64>| moments.iter().map(|&moment| dwell_s[moment]).collect::<Vec<f64>>();
        let lasting = results.dwell_s.as_ref().map(lasting);
        results.each_key(|names, key| {
            let mut fields = vec![Datum::Text(&scene)];
            fields.extend(names.map(Datum::Text));
            let readings = results.readings(moments.iter().copied(), &key)?;
            let of_score = |&score: &Score| {
                let weighted = |dwell_s: &Vec<f64>| Datum::Score(weighted_mean(&readings, dwell_s, score));
                values(summarize(&readings, score)).into_iter().chain(lasting.as_ref().map(weighted))
            };
            let (first, last) = in_column_order();
            fields.extend(first.iter().flat_map(of_score));
            let together = readings.iter().flatten().fold(Confusion::default(), |all, one| all.plus(one));
            let worst = together.detection.worst_part();
            fields.push(Datum::Text(worst.map_or("", |(part, _)| part.name())));
            fields.push(Datum::Count(worst.map_or(0, |(_, rows)| rows)));
            fields.extend(last.iter().flat_map(of_score));
            sink(&fields)
        })?;
    }
    Ok(())
}

/// The entry of the column `scene`, and its moments.
fn groups(results: &Results) -> Vec<(String, Vec<usize>)> {
    let scenes = results.scenes.iter().map(|scene| (scene.name.clone(), scene.moments.clone().collect()));
    let mut groups: Vec<(String, Vec<usize>)> = scenes.collect();
    groups.push((ALL_SCENES.into(), results.moments().collect()));
    let places = results.places();
    // For a single scene they are its variants, which are already listed.
    let places = places.into_iter().filter(|place| place.scenes > 1);
    groups.extend(places.map(|place| (format!("{ALL_SCENES}@{}", place.name), place.moments)));
    groups
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
