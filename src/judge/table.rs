//! The files of a judgement, made for pandas: `requirements.csv`, a row for each set of sensors, requirement and
//! condition, and `conditions.csv`, a row for each set, condition, region and score.

use std::path::Path;

use super::judged::JudgedSet;
use super::spread::spreads;
use super::verdict::{Judgement, Where};
use crate::Result;
use crate::results::Subject;
use crate::results::files::{CONDITIONS, REQUIREMENTS};
use crate::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};
use crate::study::Limit;

fn names<'s>(set: &'s JudgedSet) -> [Datum<'s>; 3] {
    [&set.combination, &set.poses, &set.representation].map(|name| Datum::Text(name))
}

/// Scene, snapshot and repeat of a moment; empty where there is none.
fn place_of<'s>(set: &JudgedSet, subject: &'s Subject, at: &Where) -> [Datum<'s>; 3] {
    match at.moment.map(|moment| set.conditions.moments[moment]) {
        None => [Datum::Text(""), Datum::Score(None), Datum::Score(None)],
        Some(moment) => {
            let [snapshot, repeat] = [moment.snapshot, moment.repeat].map(|n| Datum::Score(Some(n as f64)));
            [Datum::Text(&subject.scenes[moment.scene].name), snapshot, repeat]
        }
    }
}

fn columns(all: &[(&str, ColumnKind)]) -> Vec<Column> {
    all.iter().map(|&(name, kind)| Column::new(name, kind)).collect()
}

/// Writes what is required and whether it is met.
pub fn requirements_csv(folder: &Path, subject: &Subject, sets: &[JudgedSet]) -> Result<()> {
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
        ("out_of_reach", Score),
    ]);
    let mut table = TableFile::create(&folder.join(REQUIREMENTS), TableFormat::Csv, &columns)?;
    for set in sets {
        for judgement in &set.judgements {
            let requirement = judgement.requirement;
            let (at_least, at_most) = match requirement.limit {
                Limit::AtLeast(ratio) => (Some(ratio.value()), None),
                Limit::AtMost(ratio) => (None, Some(ratio.value())),
            };
            let mut row = names(set).to_vec();
            let (over, region) = (requirement.over.name(), subject.regions[requirement.region].as_str());
            let texts = [
                requirement.name.as_str(),
                judgement.condition.name(),
                judgement.word(),
                requirement.score.name(),
                region,
                over,
            ];
            row.extend(texts.map(Datum::Text));
            let value = judgement.value.as_ref().map(|value| value.number());
            row.extend([at_least, at_most, value].map(Datum::Score));
            let Judgement { cases, failed, values, of, kept, .. } = *judgement;
            row.extend([cases, failed, values, of, kept].map(|n| Datum::Count(n as u64)));
            let cases = set.conditions.of(judgement.condition);
            let case = cases[judgement.worst.case].alteration.words();
            row.push(Datum::Text(&case));
            row.extend(place_of(set, subject, &judgement.worst));
            row.push(Datum::Score(judgement.out_of_reach.as_ref().map(|bound| bound.number())));
            table.row(&row)?;
        }
    }
    table.finish()
}

/// Writes how good each score is under each condition.
pub fn conditions_csv(folder: &Path, subject: &Subject, sets: &[JudgedSet]) -> Result<()> {
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
        ("values", Count),
        ("of", Count),
    ]);
    let mut table = TableFile::create(&folder.join(CONDITIONS), TableFormat::Csv, &columns)?;
    for set in sets {
        for spread in spreads(&set.conditions) {
            let mut row = names(set).to_vec();
            let region = subject.regions[spread.region].as_str();
            row.extend([spread.condition.name(), region, spread.score.name()].map(Datum::Text));
            let numbers = [spread.best, spread.mean, spread.twentieth, spread.worst];
            row.extend(numbers.map(|number| Datum::Score(Some(number))));
            let case = set.conditions.of(spread.condition)[spread.at.case].alteration.words();
            row.push(Datum::Text(&case));
            row.extend(place_of(set, subject, &spread.at));
            row.extend([spread.values, spread.of].map(|n| Datum::Count(n as u64)));
            table.row(&row)?;
        }
    }
    table.finish()
}
