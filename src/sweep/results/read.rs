//! Reads the folder of a sweep strictly: anything missing or inconsistent is an error with its place.

mod csv_rows;
mod subject;

use std::path::Path;

use crate::results::files::MANIFEST;
use crate::results::journal::{Journal, JournalHeader, Pages, Shard};
use crate::results::manifest::Manifest;
use crate::results::places_of;
use crate::results::swept::{Results, Subject};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result, SEMANTICS_VERSION};
use perirobot_scene::shell;

/// The remedy for a folder with inconsistent files.
const CURE: &str = "leave the files as the sweep wrote them, or sweep again";

/// The folder of a sweep, or of a shard of one, before its counts are read.
#[derive(Debug)]
pub struct Folder {
    /// Its manifest.
    pub manifest: Manifest,
    /// The subject of the sweep.
    pub subject: Subject,
    /// The finished rows.
    pub journal: Journal,
}

impl Folder {
    /// Reads manifest.json, poses.csv and the header of counts.journal, which must belong to one sweep.
    ///
    /// # Errors
    /// `Error::Input` that names the file and the inconsistency; `Error::Busy` if a run uses the folder.
    pub fn open(folder: &Path) -> Result<Folder> {
        if !folder.is_dir() {
            let cure = "name one written by `perirobot sweep` or `perirobot choose`";
            return Err(Error::input(folder, "is not a folder").with_advice(cure));
        }
        let manifest = Manifest::read(folder)?;
        let subject = subject::read(folder, &manifest)?;
        let journal = Journal::read(folder)?;
        fits(&subject, &manifest, &journal)?;
        Ok(Folder { manifest, subject, journal })
    }
}

/// Fails unless a journal belongs to the sweep of a manifest, and to the part of it that it claims.
pub(crate) fn fits(subject: &Subject, manifest: &Manifest, journal: &Journal) -> Result<()> {
    let (header, layout) = (journal.header(), subject.layout());
    let of_one = header.fingerprint == manifest.fingerprint()
        && header.blocks == layout.blocks() as u64
        && header.block_rows == layout.block_rows();
    if !of_one {
        let what = format!("belongs to another sweep than {MANIFEST}");
        return Err(Issue::damaged(what).cure(CURE).with_place(journal.path()).into());
    }
    let Shard { number, of } = header.shard;
    let choices = layout.pose_choices();
    if of as usize > choices || header.kept != layout.rows_of_choices(&places_of(&layout, header.shard)) {
        let what = format!(
            "has rows {:?} of each block as shard {number} of {of}, which differ from that shard's rows of {choices} choices \
             of poses",
            header.kept
        );
        return Err(Issue::damaged(what).cure(CURE).with_place(journal.path()).into());
    }
    Ok(())
}

/// The number of missing rows of a journal. Every row must be possible in its region.
pub(crate) fn missing(subject: &Subject, journal: &Journal) -> Result<u64> {
    let JournalHeader { block_rows, .. } = journal.header();
    let (regions, repeats) = (subject.regions.len() as u64, subject.repeats as u64);
    let mut missing = journal.header().rows();
    journal.scan(|row, counts| {
        missing -= 1;
        // Regions vary fastest, and blocks have whole choices.
        let moment = (row / block_rows / repeats) as usize;
        let region = (row % block_rows % regions) as usize;
        let voxels = subject.baselines[moment][region].nothing_seen.total();
        if counts.total() == voxels {
            return Ok(());
        }
        let what = format!(
            "tp to uf are {} together, region {:?} has {voxels} voxels",
            counts.total(),
            subject.regions[region]
        );
        let issue = Issue::damaged(what).cure(CURE).with_place(format!("row {row}"));
        Err(issue.with_place(journal.path()).into())
    })?;
    Ok(missing)
}

impl Results {
    /// Reads the folder of a finished sweep. Returns warnings as well, for example that another version of the program
    /// counted. Errors name file and place.
    pub fn read(path: &Path) -> Result<(Results, Vec<String>)> {
        let folder = Folder::open(path)?;
        let JournalHeader { shard, .. } = folder.journal.header();
        if *shard != Shard::WHOLE {
            let Shard { number, of } = shard;
            let what = Issue::says(format!("contains shard {number} of {of}"));
            return Err(what
                .with_advice("run `perirobot merge` on the folder above it")
                .with_place(path)
                .into());
        }
        let missing = missing(&folder.subject, &folder.journal)?;
        if missing > 0 {
            let cure =
                format!("to resume it, run: {}", shell::command(&folder.manifest.provenance.about.command));
            let what = Issue::says(format!("is not finished: {missing} rows are missing"));
            return Err(what.with_advice(cure).with_place(path).into());
        }
        let mut warnings = Vec::new();
        let version = folder.manifest.identity.semantics_version;
        if version != SEMANTICS_VERSION {
            warnings.push(format!(
                "{}: perirobot {} counted by version {version} of the rules, this is perirobot {} with version \
                 {SEMANTICS_VERSION}: these scores are not comparable with new ones; sweep again to compare",
                path.join(MANIFEST).display(),
                folder.manifest.provenance.about.perirobot,
                env!("CARGO_PKG_VERSION"),
            ));
        }
        Ok((Results::new(folder.subject, Pages::new(vec![folder.journal])), warnings))
    }
}
