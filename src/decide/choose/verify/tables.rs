//! Checks the tables of a folder: the sets are swept again, and every field is compared.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::choose::files::{Chosen, PROOF};
use perirobot_march::backend::Backend;
use perirobot_march::error::Issue;
use perirobot_march::metrics::Confusion;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choose, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::columns::{COUNT_COLUMNS, DETECTION_COLUMNS, OVERLAP_COLUMNS, poses_csv};
use perirobot_sweep::results::files::{JOURNAL, MANIFEST};
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::results::manifest::Manifest;
use perirobot_sweep::results::{Results, RowKey, rows, scores};
use perirobot_sweep::scoring::{Row, run_unless};

/// The remedy for wrong tables.
const CURE: &str = "choose again";

/// Sweeps the sets of a folder again, and compares its journal, results.csv, scores.csv and poses.csv with the new
/// ones.
///
/// # Errors
/// `Error::Input` that names file, row and column of a wrong field; `Error::Stopped`.
pub(super) fn verify_tables(
    folder: &Path,
    (study, choose, worlds): (&Study, &Choose, &[World]),
    recounter: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<()> {
    let Some(chosen) = Chosen::read(folder)? else { return Ok(()) };
    let refined = chosen.report.with_poses(study).map_err(|e| e.with_place(folder))?;
    let with_poses = refined.as_ref().map(World::prepare_all).transpose()?;
    let worlds = with_poses.as_deref().unwrap_or(worlds);
    let sets = chosen.report.study_of_sets(refined.as_ref().unwrap_or(study), choose);
    let about = [&*chosen.perirobot, &chosen.study];
    sweep_again(&SweptSets { folder, sets: &sets, worlds, file: PROOF, about }, recounter, progress)
}

/// Sets of an answer that were swept into its folder.
pub(crate) struct SweptSets<'a> {
    pub(crate) folder: &'a Path,
    /// The sets as combinations of their study.
    pub(crate) sets: &'a Study,
    pub(crate) worlds: &'a [World],
    /// The file of the answer, with its program version and the study's file.
    pub(crate) file: &'static str,
    pub(crate) about: [&'a str; 2],
}

/// Sweeps sets again, and compares their tables.
///
/// # Errors
/// Those of [`verify_tables`].
pub(crate) fn sweep_again(
    swept: &SweptSets,
    recounter: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<()> {
    let &SweptSets { folder, sets, worlds, file, about: [perirobot, study] } = swept;
    is_written(&folder.join("poses.csv"), Some(&poses_csv(sets, &worlds[0])))?;
    let wrong = |path: PathBuf, what: &str| Err(Issue::damaged(what).cure(CURE).with_place(path).into());
    let manifest = Manifest::read(folder)?;
    if manifest.fingerprint() != Manifest::new(sets, worlds, Shard::WHOLE, &[]).fingerprint() {
        return wrong(folder.join(MANIFEST), &format!("does not belong to the sets in {file}"));
    }
    let about = &manifest.provenance.about;
    for (key, own, other) in [("perirobot", perirobot, &about.perirobot), ("study", study, &about.study.file)]
    {
        if own != other {
            let what = format!("is {own:?}, but {MANIFEST} has {other:?}");
            return Err(Issue::damaged(what).cure(CURE).with_place(key).with_place(folder.join(file)).into());
        }
    }
    let (results, _) = Results::read(folder)?;
    for row in run_unless(sets, worlds, recounter, progress)? {
        counts_again(folder, &results, &row)?;
    }
    is_written(&folder.join("results.csv"), Some(&rows::csv(&results)?))?;
    is_written(&folder.join("scores.csv"), Some(&scores::csv(&results)?))
}

/// Checks a row of the journal against its recount.
fn counts_again(folder: &Path, results: &Results, row: &Row) -> Result<()> {
    let Row { combination, choice, representation, region, repeat, .. } = *row;
    let moment = results.scenes[row.scene].moments.start + row.snapshot;
    let found = results.counts(moment, repeat, &RowKey { combination, choice, representation, region })?;
    let numbers = |counts: &Confusion| {
        [&counts.counts()[..], &counts.detection.counts(), &counts.overlap.counts()].concat()
    };
    let (own, again) = (numbers(&found), numbers(&row.counts));
    if found == row.counts {
        return Ok(());
    }
    let columns = COUNT_COLUMNS.into_iter().chain(DETECTION_COLUMNS).chain(OVERLAP_COLUMNS);
    let differs = columns.zip(own).zip(again).find(|((_, own), again)| own != again);
    let what = differs.map_or("differs from the recount".into(), |((column, own), again)| {
        format!("{column} is {own}, but counted again it is {again}")
    });
    let set = results.combinations[combination].name_of(choice);
    let place = format!("{set}, scene {}, snapshot {}", results.scenes[row.scene].name, row.snapshot);
    Err(Issue::damaged(what).cure(CURE).with_place(place).with_place(folder.join(JOURNAL)).into())
}

/// Checks that a table of a folder has these bytes, or is absent for `None`.
///
/// # Errors
/// `Error::Input` that names file, row and column.
pub(crate) fn is_written(path: &Path, expected: Option<&[u8]>) -> Result<()> {
    let found = match fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        found => Some(found.map_err(|error| Error::io(path, "cannot be read", error))?),
    };
    let what = match (&found, expected) {
        (None, None) => return Ok(()),
        (Some(found), Some(expected)) if found == expected => return Ok(()),
        (None, Some(_)) => Issue::damaged("is missing"),
        (Some(_), None) => Issue::damaged("exists, but choose.json does not mention it"),
        (Some(found), Some(expected)) => difference(found, expected),
    };
    Err(what.cure(CURE).with_place(path).into())
}

/// The first field that differs, by row and column.
fn difference(found: &[u8], expected: &[u8]) -> Issue {
    let reader = |bytes| csv::ReaderBuilder::new().flexible(true).has_headers(false).from_reader(bytes);
    let (mut found, mut expected) = (reader(found), reader(expected));
    let mut header = csv::ByteRecord::new();
    let (mut own, mut right) = (csv::ByteRecord::new(), csv::ByteRecord::new());
    for row in 0.. {
        let has_row = found.read_byte_record(&mut own);
        let wants_row = expected.read_byte_record(&mut right).unwrap_or(false);
        let at =
            |issue: Issue| issue.with_place(if row == 0 { "header".into() } else { format!("row {row}") });
        match (has_row, wants_row) {
            (Err(error), _) => return at(Issue::damaged(error.to_string())),
            (Ok(false), false) => break,
            (Ok(false), true) => return at(Issue::damaged("is missing: the file ends before it")),
            (Ok(true), false) => return at(Issue::damaged("is one row too many")),
            (Ok(true), true) => {}
        }
        if row == 0 {
            header.clone_from(&right);
        }
        let text = |record: &csv::ByteRecord, column: usize| {
            record
                .get(column)
                .map_or("missing".into(), |field| format!("{:?}", String::from_utf8_lossy(field)))
        };
        for column in 0..own.len().max(right.len()) {
            let [own, right] = [&own, &right].map(|record| text(record, column));
            if own != right {
                let name = header.get(column).map_or("?".into(), String::from_utf8_lossy);
                let what = format!("column {name} is {own}, but made again it is {right}");
                return at(Issue::damaged(what));
            }
        }
    }
    Issue::damaged("has the correct fields, but written in another way")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_has_its_row_and_column() {
        let right = b"a,b\n1,2\n3,\"4,5\"\n";
        let check = |found: &[u8], expected: &str| {
            let message = difference(found, right).to_string();
            assert!(message.contains(expected), "no {expected:?} in {message}");
        };
        check(b"a,b\n1,2\n3,4\n", "row 2: column b is \"4\", but made again it is \"4,5\"");
        check(b"a,b\n1,2\n", "row 2: is missing");
        check(b"a,b\n1\n3,\"4,5\"\n", "row 1: column b is missing, but made again it is \"2\"");
        check(b"a,b\n1,2\n3,\"4,5\"\n6,7\n", "row 3: is one row too many");
        check(b"a,c\n1,2\n3,\"4,5\"\n", "header: column b is \"c\"");
        check(b"", "header: is missing");
        check(b"a,b\r\n1,2\n3,\"4,5\"\n", "written in another way");
    }
}
