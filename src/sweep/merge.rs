//! Shards put together: proof that they are of one sweep, complete and disjoint, and the folder that a single run would
//! have left. What a shard is, is `session`'s affair; its folder is read by `report`.

use std::path::{Path, PathBuf};

use super::files::OutputFolder;
use super::journal::{Header, Locked, Pages, Shard};
use super::manifest::{MANIFEST, Manifest};
use crate::report::{Folder, Results};
use crate::{Error, Result};

/// Most of what is missing that is told by name.
const MOST_TOLD: usize = 10;

/// Rows that are copied at once.
const ROWS: u64 = 1 << 14;

/// The folders of shards below the folder of a sweep, in order of their numbers.
pub fn shards_below(out: &Path) -> Result<Vec<PathBuf>> {
    let number = |path: &Path| {
        let name = path.file_name()?.to_str()?.strip_prefix("shard-")?;
        let (number, of) = name.split_once("-of-")?;
        Some((of.parse::<u32>().ok()?, number.parse::<u32>().ok()?))
    };
    let entries = std::fs::read_dir(out).map_err(|e| Error::io(out, "cannot be read", e))?;
    let paths = entries.flatten().map(|entry| entry.path());
    let mut found: Vec<_> = paths.filter_map(|path| Some((number(&path)?, path))).collect();
    found.sort();
    if found.is_empty() {
        let what = "has no folders of shards (shard-0-of-4): name the sweep's --out, or each shard's folder";
        return Err(Error::input(out.display(), what));
    }
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

/// Puts the shards in some folders together into one, and gives their results. Tables are the caller's to write. Nothing
/// is written before all is proven.
pub fn merge(out: &Path, folders: &[PathBuf]) -> Result<Results> {
    let shards: Vec<(PathBuf, Folder)> =
        folders.iter().map(|path| Ok((path.clone(), Folder::open(path)?))).collect::<Result<_>>()?;
    let shards = of_one_sweep(shards)?;
    complete(&shards)?;

    let folder = OutputFolder::open(out)?;
    let locked = Locked::open(out)?;
    let first = &shards[0].1;
    let whole = Header {
        shard: Shard::WHOLE,
        kept: 0..first.journal.header().block_rows,
        ..first.journal.header().clone()
    };
    if let Ok(Some(found)) = &locked.header
        && found.fingerprint != whole.fingerprint
    {
        let what = "holds a sweep of something else: name another folder for the whole";
        return Err(Error::input(out.display(), what));
    }
    let mut manifest = first.manifest.of_whole();
    shards.iter().for_each(|(_, shard)| manifest.keep_runs(&shard.manifest));
    let mut journal = locked.begin(whole)?;
    for block in 0..journal.header().blocks {
        for (_, shard) in &shards {
            let rows = shard.journal.header().rows_of_block(block);
            for first in rows.clone().step_by(ROWS as usize) {
                journal.put(first, &shard.journal.counts(first..rows.end.min(first + ROWS))?)?;
            }
        }
    }
    journal.sync()?;
    let poses = shards[0].0.join("poses.csv");
    let poses = std::fs::read(&poses).map_err(|e| Error::io(&poses, "cannot be read", e))?;
    folder.write("poses.csv", &poses)?;
    folder.write(MANIFEST, &manifest.bytes())?;
    Ok(Results::new(first.subject.clone(), Pages::new(vec![journal])))
}

/// Shards of one sweep in the order of their numbers, each once.
fn of_one_sweep(mut shards: Vec<(PathBuf, Folder)>) -> Result<Vec<(PathBuf, Folder)>> {
    let Some((first, reference)) = shards.first() else {
        return Err(Error::Input("no shards: name the folder of each".into()));
    };
    let (first, header) = (first.display().to_string(), reference.journal.header().clone());
    for (path, shard) in &shards[1..] {
        let other = shard.journal.header();
        if other.fingerprint != header.fingerprint {
            let changes = reference.manifest.changes(&shard.manifest).join("; ");
            let what = format!(
                "is of another sweep than {first}: {changes}. Shards of one sweep only can be merged"
            );
            return Err(Error::input(path.display(), what));
        }
        if other.shard.of != header.shard.of {
            let [a, b] = [other, &header].map(|header| header.shard.of);
            return Err(Error::input(path.display(), format!("is one of {a} shards, {first} one of {b}")));
        }
    }
    shards.sort_by_key(|(_, shard)| shard.journal.header().shard.number);
    for two in shards.windows(2) {
        let [a, b] = [&two[0], &two[1]];
        if a.1.journal.header().shard == b.1.journal.header().shard {
            let what = format!("is the same shard as {}: name each once", a.0.display());
            return Err(Error::input(b.0.display(), what));
        }
    }
    Ok(shards)
}

/// Fails unless every row of the sweep is in one of its shards, naming what is missing and what makes it.
fn complete(shards: &[(PathBuf, Folder)]) -> Result<()> {
    let of = shards[0].1.journal.header().shard.of;
    let number_of = |shard: &Folder| shard.journal.header().shard.number;
    let mut missing = Vec::new();
    for (path, shard) in shards {
        let (number, lacks, rows) = (number_of(shard), shard.missing()?, shard.journal.header().rows());
        if lacks > 0 {
            let what = format!("shard {number} of {of} lacks {lacks} of {rows} rows ({})", path.display());
            missing.push((number, what));
        }
    }
    let lacking = missing.len() + of as usize - shards.len();
    if lacking == 0 {
        return Ok(());
    }
    // No more than are told: a file may claim that there are billions.
    let absent = (0..of).filter(|n| shards.binary_search_by_key(n, |(_, shard)| number_of(shard)).is_err());
    let absent =
        absent.take(MOST_TOLD).map(|number| (number, format!("shard {number} of {of} is not there")));
    missing.extend(absent);
    missing.sort();
    let command = |number: u32| command_of_shard(&shards[0].1.manifest, Shard { number, of });
    let told = missing.iter().take(MOST_TOLD);
    let mut text: String =
        told.map(|(number, what)| format!("\n  {what}; to make it:\n    {}", command(*number))).collect();
    if lacking > MOST_TOLD {
        text += &format!("\n  and {} more", lacking - MOST_TOLD);
    }
    Err(Error::Input(format!("the sweep is not complete:{text}")))
}

/// The command that makes a shard, from the one that made another.
fn command_of_shard(manifest: &Manifest, shard: Shard) -> String {
    let command = manifest.get("about")["command"].as_str().unwrap_or("perirobot sweep STUDY --out OUT");
    let wanted = format!("{}/{}", shard.number, shard.of);
    let mut words: Vec<String> = command.split(' ').map(String::from).collect();
    match words.iter().position(|word| word == "--shard" || word.starts_with("--shard=")) {
        Some(at) if words[at] == "--shard" && at + 1 < words.len() => words[at + 1] = wanted,
        Some(at) => words[at] = format!("--shard={wanted}"),
        None => words.extend(["--shard".into(), wanted]),
    }
    words.join(" ")
}
