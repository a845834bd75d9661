//! The files of a judgement, made for pandas: `requirements.csv`, a row for each set of sensors, requirement and
//! condition, and `conditions.csv`, a row for each set, condition, region and score.

use std::path::Path;

use super::cases::{Moment, Passage};
use super::judged::JudgedSet;
use super::spread::{Summed, spreads};
use super::tables::tables_sha256;
use super::verdict::{Judgement, Part, Where};
use perirobot_march::Result;
use perirobot_study::study::{Limit, Study};
use perirobot_sweep::results::Subject;
use perirobot_sweep::results::files::{CONDITIONS, REQUIREMENTS};
use perirobot_sweep::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};

fn names<'s>(set: &'s JudgedSet) -> [Datum<'s>; 3] {
    [&set.combination, &set.poses, &set.representation].map(|name| Datum::Text(name))
}

/// Scene, snapshot and repeat of a moment, and of a passage the company, body and entry, too; empty where there is
/// none. A passage is of all snapshots at once.
fn place_of<'s>(set: &'s JudgedSet, subject: &'s Subject, at: &Where) -> [Datum<'s>; 6] {
    let [none, nothing] = [Datum::Score(None), Datum::Text("")];
    let number = |n: usize| Datum::Score(Some(n as f64));
    match at.part {
        None => [nothing, none, none, nothing, nothing, nothing],
        Some(Part::Moment(moment)) => {
            let Moment { scene, snapshot, repeat } = set.conditions.moments[moment];
            let scene = Datum::Text(&subject.scenes[scene].name);
            [scene, number(snapshot), number(repeat), nothing, nothing, nothing]
        }
        Some(Part::Passage(passage)) => {
            let Passage { scene, company, repeat, body, entry, .. } = &set.conditions.passages[passage];
            let scene = Datum::Text(&subject.scenes[*scene].name);
            let [company, body, entry] = [company.name(), body, entry].map(Datum::Text);
            [scene, none, number(*repeat), company, body, entry]
        }
    }
}

fn columns(all: &[(&str, ColumnKind)]) -> Vec<Column> {
    all.iter().map(|&(name, kind)| Column::new(name, kind)).collect()
}

/// Writes what is required and whether it is met; the study is the one that was judged.
pub(super) fn requirements_csv(
    folder: &Path,
    study: &Study,
    subject: &Subject,
    sets: &[JudgedSet],
) -> Result<()> {
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
            let region = requirement.counted().map_or("", |counted| subject.regions[counted.region].as_str());
            let (over, score) = (requirement.over().name(), requirement.score_name());
            let texts = [
                requirement.name.as_str(),
                judgement.condition.name(),
                judgement.word(),
                score,
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
            let tables =
                tables_sha256(study, Summed::from_measure(&requirement.measure), judgement.condition);
            row.push(Datum::Text(&tables));
            table.row(&row)?;
        }
    }
    table.finish()
}

/// Writes how good each score is under each condition; the study is the one that was judged.
pub(super) fn conditions_csv(
    folder: &Path,
    study: &Study,
    subject: &Subject,
    sets: &[JudgedSet],
) -> Result<()> {
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
        for spread in spreads(&set.conditions) {
            let mut row = names(set).to_vec();
            let region = spread.of_what.region().map_or("", |region| subject.regions[region].as_str());
            row.extend([spread.condition.name(), region, spread.of_what.name()].map(Datum::Text));
            let numbers = [spread.best, spread.mean, spread.twentieth, spread.worst];
            row.extend(numbers.map(|number| Datum::Score(Some(number))));
            let case = set.conditions.of(spread.condition)[spread.at.case].alteration.words();
            row.push(Datum::Text(&case));
            row.extend(place_of(set, subject, &spread.at));
            row.extend([spread.values, spread.of].map(|n| Datum::Count(n as u64)));
            let tables = tables_sha256(study, spread.of_what, spread.condition);
            row.push(Datum::Text(&tables));
            table.row(&row)?;
        }
    }
    table.finish()
}
