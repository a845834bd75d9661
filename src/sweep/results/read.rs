//! The folder of a sweep read back, strictly: whatever is missing or does not fit together is an error that
//! says where.

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

/// What helps with a folder whose files do not fit together.
const CURE: &str = "leave the files as the sweep wrote them, or sweep again";

/// The folder of a sweep, or of a shard of one, before its counts are looked at.
#[derive(Debug)]
pub struct Folder {
    /// What its manifest says.
    pub manifest: Manifest,
    /// What was swept.
    pub subject: Subject,
    /// The finished rows.
    pub journal: Journal,
}

impl Folder {
    /// Reads manifest.json, poses.csv and the beginning of counts.journal, which must be of one sweep.
    ///
    /// # Errors
    /// `Error::Input` that names the file and what does not fit; `Error::Busy` if a run is at work in the
    /// folder.
    pub fn open(folder: &Path) -> Result<Folder> {
        if !folder.is_dir() {
            let cure = "name one that `perirobot sweep` or `perirobot choose` has written";
            return Err(Error::input(folder, "is not a folder").with_advice(cure));
        }
        let manifest = Manifest::read(folder)?;
        let subject = subject::read(folder, &manifest)?;
        let journal = Journal::read(folder)?;
        fits(&subject, &manifest, &journal)?;
        Ok(Folder { manifest, subject, journal })
    }
}

/// Fails unless a journal is of the sweep of a manifest, and of the part of it that it claims to be.
pub(crate) fn fits(subject: &Subject, manifest: &Manifest, journal: &Journal) -> Result<()> {
    let (header, layout) = (journal.header(), subject.layout());
    let of_one = header.fingerprint == manifest.fingerprint()
        && header.blocks == layout.blocks() as u64
        && header.block_rows == layout.block_rows();
    if !of_one {
        let what = format!("is of another sweep than {MANIFEST} beside it");
        return Err(Issue::damaged(what).cure(CURE).with_place(journal.path()).into());
    }
    let Shard { number, of } = header.shard;
    let choices = layout.pose_choices();
    if of as usize > choices || header.kept != layout.rows_of_choices(&places_of(&layout, header.shard)) {
        let what = format!(
            "keeps rows {:?} of each block as shard {number} of {of}, which are not that shard's of {choices} choices \
             of poses",
            header.kept
        );
        return Err(Issue::damaged(what).cure(CURE).with_place(journal.path()).into());
    }
    Ok(())
}

/// How many rows a journal lacks. Every row that it has must be one that its region can have.
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
    /// Reads the folder of a finished sweep. With the results come warnings, such as that another version of
    /// the program counted. Errors name file and place.
    pub fn read(path: &Path) -> Result<(Results, Vec<String>)> {
        let folder = Folder::open(path)?;
        let JournalHeader { shard, .. } = folder.journal.header();
        if *shard != Shard::WHOLE {
            let Shard { number, of } = shard;
            let what = Issue::says(format!("holds shard {number} of {of}"));
            return Err(what
                .with_advice("run `perirobot merge` on the folder above it")
                .with_place(path)
                .into());
        }
        let missing = missing(&folder.subject, &folder.journal)?;
        if missing > 0 {
            let cure = format!(
                "run the command that began it again, it goes on: {}",
                shell::command(&folder.manifest.provenance.about.command)
            );
            let what = Issue::says(format!("is not finished, {missing} rows are missing"));
            return Err(what.with_advice(cure).with_place(path).into());
        }
        let mut warnings = Vec::new();
        let version = folder.manifest.identity.semantics_version;
        if version != SEMANTICS_VERSION {
            warnings.push(format!(
                "{}: perirobot {} counted by version {version} of the rules, this is perirobot {} with version \
                 {SEMANTICS_VERSION}: do not hold these scores against new ones; sweep again to compare",
                path.join(MANIFEST).display(),
                folder.manifest.provenance.about.perirobot,
                env!("CARGO_PKG_VERSION"),
            ));
        }
        Ok((Results::new(folder.subject, Pages::new(vec![folder.journal])), warnings))
    }
}
