//! The tables of a judgement for pandas: `requirements.csv`, a row for each set of sensors, requirement and condition,
//! and `conditions.csv`, a row for each set, condition, region and score.

use std::path::Path;

use super::judge_json::{JsonNumber, SetVerdicts, WorstPlace};
use perirobot_march::Result;
use perirobot_sweep::results::files::{CONDITIONS, REQUIREMENTS};
use perirobot_sweep::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};

/// Writes the requirements and their verdicts.
pub(super) fn requirements_csv(folder: &Path, sets: &[SetVerdicts]) -> Result<()> {
    use ColumnKind::{Count, Score, Text};
    let columns = columns(&[
        ("combination", Text),
        ("poses", Text),
        ("representation", Text),
        ("requirement", Text),
        ("condition", Text),
        ("verdict", Text),
        ("score", Text),
        ("region", Text),
        ("over", Text),
        ("at_least", Score),
        ("at_most", Score),
        ("value", Score),
        ("cases", Count),
        ("failed", Count),
        ("values", Count),
        ("of", Count),
        ("draws_as_planned", Count),
        ("case", Text),
        ("scene", Text),
        ("snapshot", Score),
        ("repeat", Score),
        ("people", Text),
        ("body", Text),
        ("entry", Text),
        ("out_of_reach", Score),
        ("tables_sha256", Text),
        ("for", Text),
    ]);
    let mut table = TableFile::create(&folder.join(REQUIREMENTS), TableFormat::Csv, &columns)?;
    for set in sets {
        for one in &set.requirements {
            let mut row = set.names().map(Datum::Text).to_vec();
            let texts = [&one.requirement, one.condition.name(), one.word(), &one.score];
            row.extend(texts.map(Datum::Text));
            row.extend([text(&one.region), Datum::Text(one.over.name())]);
            row.extend([one.at_least, one.at_most].map(Datum::Score));
            row.push(score(one.value));
            row.extend([one.cases, one.failed, one.values, one.of, one.draws_as_planned].map(count));
            row.extend(place_of(&one.worst));
            row.extend([
                score(one.out_of_reach),
                Datum::Text(&one.tables_sha256),
                text(&one.safety_function),
            ]);
            table.row(&row)?;
        }
    }
    table.finish()
}

/// Writes the scores under each condition.
pub(super) fn conditions_csv(folder: &Path, sets: &[SetVerdicts]) -> Result<()> {
    use ColumnKind::{Count, Score, Text};
    let columns = columns(&[
        ("combination", Text),
        ("poses", Text),
        ("representation", Text),
        ("condition", Text),
        ("region", Text),
        ("score", Text),
        ("best", Score),
        ("mean", Score),
        ("quantile_05", Score),
        ("worst", Score),
        ("case", Text),
        ("scene", Text),
        ("snapshot", Score),
        ("repeat", Score),
        ("people", Text),
        ("body", Text),
        ("entry", Text),
        ("values", Count),
        ("of", Count),
        ("tables_sha256", Text),
    ]);
    let mut table = TableFile::create(&folder.join(CONDITIONS), TableFormat::Csv, &columns)?;
    for set in sets {
        for one in &set.conditions {
            let mut row = set.names().map(Datum::Text).to_vec();
            row.extend([Datum::Text(one.condition.name()), text(&one.region), Datum::Text(&one.score)]);
            row.extend([one.best, one.mean, one.quantile_05, one.worst].map(|number| score(Some(number))));
            row.extend(place_of(&one.worst_at));
            row.extend([one.values, one.of].map(count));
            row.push(Datum::Text(&one.tables_sha256));
            table.row(&row)?;
        }
    }
    table.finish()
}

fn columns(all: &[(&str, ColumnKind)]) -> Vec<Column> {
    all.iter().map(|&(name, kind)| Column::new(name, kind)).collect()
}

/// The case, its scene, snapshot and repeat, and for a way in also the company, body and entry; empty if there is none.
fn place_of(at: &WorstPlace) -> [Datum<'_>; 7] {
    let number = |n: Option<usize>| Datum::Score(n.map(|n| n as f64));
    [
        Datum::Text(&at.case),
        text(&at.scene),
        number(at.snapshot),
        number(at.repeat),
        Datum::Text(at.people.map_or("", |company| company.name())),
        text(&at.body),
        text(&at.entry),
    ]
}

fn text(text: &Option<String>) -> Datum<'_> {
    Datum::Text(text.as_deref().unwrap_or_default())
}

fn score<'n>(number: Option<JsonNumber>) -> Datum<'n> {
    Datum::Score(number.map(|number| number.0))
}

fn count<'n>(count: usize) -> Datum<'n> {
    Datum::Count(count as u64)
}
