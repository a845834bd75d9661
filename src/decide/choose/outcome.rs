//! The end of a search: writes the answer into a folder together with a sweep of its sets, so that every command on the
//! folder of a sweep accepts it.

use std::borrow::Cow;
use std::path::Path;

use super::files::Chosen;
use super::report::FrontReport;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choose, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::files::OutputFolder;
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::results::table::TableFormat;
use perirobot_sweep::results::{Results, Subject, jobs, rows, scores};
use perirobot_sweep::scoring::reopen;
use perirobot_sweep::scoring::session::{Ending, Session};

/// An answer, ready to be written.
pub struct Outcome<'a> {
    /// The answer.
    pub chosen: Chosen,
    choose: &'a Choose,
    /// The sets as combinations, and the worlds with the poses of refined ones.
    sets: Study,
    worlds: Cow<'a, [World]>,
}

impl<'a> Outcome<'a> {
    /// The answer to a question; `with_poses` are the study and the worlds with the poses that refining found, if any.
    pub fn new(
        (study, choose, worlds): (&Study, &'a Choose, &'a [World]),
        report: FrontReport,
        with_poses: Option<(Study, Vec<World>)>,
    ) -> Outcome<'a> {
        let (sets, in_worlds) = match with_poses {
            Some((refined, worlds)) => (report.study_of_sets(&refined, choose), Cow::Owned(worlds)),
            None => (report.study_of_sets(study, choose), Cow::Borrowed(worlds)),
        };
        Outcome { chosen: Chosen::new(study, choose, worlds, report), choose, sets, worlds: in_worlds }
    }

    /// The number of sets to score, in each snapshot and repeat.
    pub fn total(&self) -> u64 {
        jobs(&self.sets)
    }

    /// Writes the answer into a folder that [`Chosen::folder`] opened, scores its sets as a sweep does, and writes the
    /// tables. `prepare_s` and `command` go into the manifest; on a device, one choice in `verify` is recounted.
    ///
    /// # Errors
    /// If a file cannot be written; if a backend fails; `Error::Disagreement` if the sweep and the search disagree
    /// about a set; `Error::Stopped`.
    pub fn write(
        &self,
        folder: OutputFolder,
        backends: &mut dyn BackendFactory,
        (verify, prepare_s): (u64, f64),
        command: &[String],
        progress: &dyn Progress,
    ) -> Result<Results> {
        let out = folder.path();
        // Without this answer, the folder would look like a user's sweep, which is never overwritten.
        self.chosen.write(out)?;
        let run = (verify, prepare_s);
        let results = sweep_sets((&self.sets, &self.worlds), out, backends, run, command, progress)?;
        self.chosen.report.agrees(self.choose, &results)?;
        rows::write(&results, out, TableFormat::Csv)?;
        scores::write(&results, out, TableFormat::Csv)?;
        Ok(results)
    }
}

/// Sweeps sets, each a combination of a study with one choice of poses, into a folder, without the tables. `prepare_s`
/// and `command` go into the manifest; on a device, one choice in `verify` is recounted.
///
/// # Errors
/// If a file cannot be written; if a backend fails; `Error::Stopped`.
pub(crate) fn sweep_sets(
    (sets, worlds): (&Study, &[World]),
    out: &Path,
    backends: &mut dyn BackendFactory,
    (verify, prepare_s): (u64, f64),
    command: &[String],
    progress: &dyn Progress,
) -> Result<Results> {
    let mut session = Session::open(sets, worlds, out, Shard::WHOLE, true, command)?;
    if let Ending::Stopped(why) = session.run(backends, verify, prepare_s, progress)?.ending {
        return Err(Error::Stopped(Issue::says(why)));
    }
    Ok(Results::new(Subject::from_study(sets, worlds), session.into_pages()))
}

/// The study of a folder's sweep: the study with these worlds, or its chosen sets, with the poses that refining found.
///
/// # Errors
/// If the folder is neither, with the differences.
pub fn as_swept(folder: &Path, study: Study, worlds: Vec<World>) -> Result<(Study, Vec<World>)> {
    let chosen = Chosen::read(folder)?;
    let refined = chosen
        .map(|chosen| chosen.report.with_poses(&study))
        .transpose()
        .map_err(|e: Error| e.with_place(folder))?;
    // A later sweep may have replaced the chosen sets.
    let refined = refined.flatten().filter(|refined| reopen::has_poses_of(folder, refined));
    let (study, worlds) = match refined {
        Some(study) => World::prepare_all(&study).map(|worlds| (study, worlds))?,
        None => (study, worlds),
    };
    Ok((reopen::as_swept(folder, study, &worlds)?, worlds))
}
