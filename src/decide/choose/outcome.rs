//! The end of a search: the answer is written into a folder together with a sweep of its sets, so that every command that
//! takes the folder of a sweep takes this one.

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

/// What was found, to be written.
pub struct Outcome<'a> {
    /// The answer.
    pub chosen: Chosen,
    choose: &'a Choose,
    /// The sets as combinations, and the worlds with the poses of refined ones.
    sets: Study,
    worlds: Cow<'a, [World]>,
}

impl<'a> Outcome<'a> {
    /// What was found of a question; `with_poses` are the study and the worlds with the poses that refining found, if it
    /// found any.
    pub fn new(
        (study, choose, worlds): (&Study, &'a Choose, &'a [World]),
        told: FrontReport,
        with_poses: Option<(Study, Vec<World>)>,
    ) -> Outcome<'a> {
        let (sets, in_worlds) = match with_poses {
            Some((refined, worlds)) => (told.study_of_sets(&refined, choose), Cow::Owned(worlds)),
            None => (told.study_of_sets(study, choose), Cow::Borrowed(worlds)),
        };
        Outcome { chosen: Chosen::new(study, choose, worlds, told), choose, sets, worlds: in_worlds }
    }

    /// How many sets there are to score, each in each snapshot and repeat.
    pub fn total(&self) -> u64 {
        jobs(&self.sets)
    }

    /// Writes the answer into a folder that [`Chosen::folder`] opened, scores its sets as a sweep does, and writes the tables.
    /// `prepare_s` and `command` are for the manifest; one choice in `verify` that a device counts is checked.
    ///
    /// # Errors
    /// When a file cannot be written; when a backend fails; `Error::Disagreement` where a set is counted otherwise than it
    /// was found; `Error::Stopped`.
    pub fn write(
        &self,
        folder: OutputFolder,
        backends: &mut dyn BackendFactory,
        (verify, prepare_s): (u64, f64),
        command: &[String],
        progress: &dyn Progress,
    ) -> Result<Results> {
        let out = folder.path();
        // A folder with a sweep, but without an answer, would be taken for a sweep that is to be kept.
        self.chosen.write(out)?;
        let run = (verify, prepare_s);
        let results = sweep_sets((&self.sets, &self.worlds), out, backends, run, command, progress)?;
        self.chosen.report.agrees(self.choose, &results)?;
        rows::write(&results, out, TableFormat::Csv)?;
        scores::write(&results, out, TableFormat::Csv)?;
        Ok(results)
    }
}

/// Sweeps sets, each a combination of a study with one choice of poses, into a folder; the tables are not written yet.
/// `prepare_s` and `command` are for the manifest; one choice in `verify` that a device counts is checked.
///
/// # Errors
/// When a file cannot be written; when a backend fails; `Error::Stopped`.
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

/// What was swept into a folder: the study with these worlds, or sets of its sensors that were chosen, in its poses and
/// in those that refining found.
///
/// # Errors
/// When it is neither, with what has changed since.
pub fn as_swept(folder: &Path, study: Study, worlds: Vec<World>) -> Result<(Study, Vec<World>)> {
    let chosen = Chosen::read(folder)?;
    let refined = chosen
        .map(|chosen| chosen.report.with_poses(&study))
        .transpose()
        .map_err(|e: Error| e.with_place(folder))?;
    // A sweep may have taken the place of what was chosen.
    let refined = refined.flatten().filter(|refined| reopen::has_poses_of(folder, refined));
    let (study, worlds) = match refined {
        Some(study) => World::prepare_all(&study).map(|worlds| (study, worlds))?,
        None => (study, worlds),
    };
    Ok((reopen::as_swept(folder, study, &worlds)?, worlds))
}
