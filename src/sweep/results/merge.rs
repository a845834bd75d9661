//! Merges shards: proves that they belong to one sweep and are complete and disjoint, and writes the folder of a single
//! run.

use std::path::{Path, PathBuf};

use super::read::{fits, missing};
use crate::results::files::{JOURNAL, MANIFEST, OutputFolder, read_regular};
use crate::results::journal::{Journal, JournalHeader, Locked, Pages, Shard};
use crate::results::manifest::{Manifest, Provenance};
use crate::results::{Folder, Results, Subject};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::shell;

/// Most missing shards that are named.
const MOST_REPORTED: usize = 10;

/// Rows per copy.
const ROWS: u64 = 1 << 14;

/// The facts about a shard while its folder is closed: there may be more shards than open files.
struct ShardPart {
    path: PathBuf,
    shard: Shard,
    rows: u64,
    lacks: u64,
    manifest: Manifest,
}

/// Merges the shards in some folders into one, and returns their results. The caller writes the tables. Nothing is
/// written before everything is proven.
///
/// # Errors
/// `Error::Input` that names the folder if a shard is missing, incomplete, duplicate or of another sweep, or if `out`
/// contains something else; `Error::Busy` if a run uses one of them.
pub fn merge(out: &Path, folders: &[PathBuf]) -> Result<Results> {
    let Some(first) = folders.first() else {
        return Err(Issue::says("no shards").with_advice("name the folder of each").into());
    };
    let reference = Folder::open(first)?;
    let header = reference.journal.header().clone();
    let Folder { manifest, subject, journal } = reference;
    let part = |path: &PathBuf, manifest: Manifest, journal: &Journal| -> Result<ShardPart> {
        let (lacks, header) = (missing(&subject, journal)?, journal.header());
        Ok(ShardPart { path: path.clone(), shard: header.shard, rows: header.rows(), lacks, manifest })
    };
    let mut parts = vec![part(first, manifest.clone(), &journal)?];
    drop(journal);
    for path in &folders[1..] {
        let (manifest, journal) = read_shard(path, first, (&manifest, &subject), &header)?;
        parts.push(part(path, manifest, &journal)?);
    }
    sort_parts(&mut parts)?;
    complete(&parts)?;

    let folder = OutputFolder::open(out)?;
    let locked = Locked::open(out)?;
    let whole = JournalHeader { shard: Shard::WHOLE, kept: 0..header.block_rows, ..header };
    let elsewhere = "name another output folder";
    match &locked.header {
        Ok(None) => {}
        Ok(Some(found)) if found.fingerprint != whole.fingerprint => {
            let what = format!("contains another sweep: {elsewhere}");
            return Err(Error::input(out, what));
        }
        Ok(Some(found)) if found.shard != Shard::WHOLE => {
            let Shard { number, of } = found.shard;
            let what = format!("contains shard {number} of {of}: {elsewhere}");
            return Err(Error::input(out, what));
        }
        Ok(Some(_)) => {}
        Err(unfit) => return Err(Error::input(out.join(JOURNAL), format!("{unfit}; {elsewhere}"))),
    }
    let here = |path: &PathBuf| path.canonicalize().ok() == out.canonicalize().ok();
    if folders.iter().any(here) {
        let what = format!("is both a shard and the output folder: {elsewhere}");
        return Err(Error::input(out, what));
    }
    folder.tidy();
    folder.clear(matches!(locked.header, Ok(Some(_))));
    let mut journal = locked.begin(whole)?;
    let mut whole = manifest;
    whole.provenance = Provenance { shard: Shard::WHOLE, runs: Vec::new(), ..whole.provenance };
    for part in &parts {
        let shard = Journal::read(&part.path)?;
        for block in 0..shard.header().blocks {
            let rows = shard.header().rows_of_block(block);
            for first in rows.clone().step_by(ROWS as usize) {
                journal.put(first, &shard.counts(first..rows.end.min(first + ROWS))?)?;
            }
        }
        whole.provenance.runs.extend_from_slice(&part.manifest.provenance.runs);
    }
    journal.sync()?;
    folder.write("poses.csv", &read_regular(&first.join("poses.csv"))?)?;
    folder.write(MANIFEST, &whole.bytes())?;
    Ok(Results::new(subject, Pages::new(vec![journal])))
}

/// The manifest and the journal of a folder, if it is a shard of the same sweep as the first one.
fn read_shard(
    path: &Path,
    first: &Path,
    (reference, subject): (&Manifest, &Subject),
    header: &JournalHeader,
) -> Result<(Manifest, Journal)> {
    let (manifest, journal) = (Manifest::read(path)?, Journal::read(path)?);
    let (first, other) = (first.display(), journal.header());
    let wrong = |what: String| Err(Error::input(path, what));
    if other.fingerprint != header.fingerprint {
        let changes = match reference.changes(&manifest) {
            changes if changes.is_empty() => "unknown differences".into(),
            changes => changes.join("; "),
        };
        return wrong(format!(
            "belongs to another sweep than {first}: {changes}. Only shards of one sweep can be merged"
        ));
    }
    if other.shard.of != header.shard.of {
        let [a, b] = [other, header].map(|header| header.shard.of);
        return wrong(format!(
            "is one of {a} shards, but {first} is one of {b}: name shards of the same number"
        ));
    }
    fits(subject, &manifest, &journal)?;
    Ok((manifest, journal))
}

/// Orders shards by their numbers; each must occur once.
fn sort_parts(parts: &mut [ShardPart]) -> Result<()> {
    parts.sort_by_key(|part| part.shard.number);
    for two in parts.windows(2) {
        if two[0].shard == two[1].shard {
            let what = format!("is the same shard as {}: name each once", two[0].path.display());
            return Err(Error::input(&two[1].path, what));
        }
    }
    Ok(())
}

/// Fails unless every row of the sweep is in one of its shards; names the missing rows and the commands that compute
/// them.
fn complete(parts: &[ShardPart]) -> Result<()> {
    let of = parts[0].shard.of;
    let lacking = parts.iter().filter(|part| part.lacks > 0);
    let mut missing: Vec<(u32, String)> = lacking
        .map(|part| {
            let ShardPart { path, shard: Shard { number, .. }, rows, lacks, .. } = part;
            (*number, format!("shard {number} of {of} lacks {lacks} of {rows} rows ({})", path.display()))
        })
        .collect();
    let lacking = missing.len() + of as usize - parts.len();
    if lacking == 0 {
        return Ok(());
    }
    // No more than are reported: a file may claim billions of shards.
    let absent =
        (0..of).filter(|number| parts.binary_search_by_key(number, |part| part.shard.number).is_err());
    let absent = absent.take(MOST_REPORTED);
    missing.extend(absent.map(|number| (number, format!("shard {number} of {of} is missing"))));
    missing.sort();
    let command = |number: u32| command_of_shard(&parts[0].manifest, Shard { number, of });
    let reported = missing.iter().take(MOST_REPORTED);
    let mut text: String = reported
        .map(|(number, what)| format!("\n  {what}; to compute it:\n    {}", command(*number)))
        .collect();
    if lacking > MOST_REPORTED {
        text += &format!("\n  and {} more", lacking - MOST_REPORTED);
    }
    Err(Issue::says(format!("the sweep is not complete:{text}")).into())
}

/// The command of a shard, from the command of another.
fn command_of_shard(manifest: &Manifest, shard: Shard) -> String {
    let mut words = manifest.provenance.about.command.clone();
    let wanted = format!("{}/{}", shard.number, shard.of);
    match words.iter().position(|word| word == "--shard" || word.starts_with("--shard=")) {
        Some(at) if words[at] == "--shard" && at + 1 < words.len() => words[at + 1] = wanted,
        Some(at) => words[at] = format!("--shard={wanted}"),
        None => words.extend(["--shard".into(), wanted]),
    }
    shell::command(&words)
}
