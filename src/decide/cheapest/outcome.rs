//! The end of a search: writes the answer into a folder together with a sweep of its sets, so that every command on the
//! folder of a sweep accepts it.

use std::path::Path;

use super::report::PurchaseReport;
use crate::choose::{Chosen, FRONT, PROOF, REFINED, SETS, sweep_sets};
use crate::judge::JudgedSet;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Purchase, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::files::{OutputFolder, remove_files};
use perirobot_sweep::results::table::TableFormat;
use perirobot_sweep::results::{Results, jobs, rows, scores};

/// An answer, ready to be written.
pub struct PurchaseOutcome<'a> {
    /// The answer.
    pub report: PurchaseReport,
    /// Its sets as combinations of the study, the recommended one first.
    pub sets: Study,
    worlds: &'a [World],
}

impl<'a> PurchaseOutcome<'a> {
    /// The answer to a study.
    pub fn new(
        (study, purchase, worlds): (&Study, &Purchase, &'a [World]),
        report: PurchaseReport,
    ) -> PurchaseOutcome<'a> {
        let sets = report.study_of_sets(study, purchase);
        PurchaseOutcome { report, sets, worlds }
    }

    /// Opens a folder for an answer to a study and removes an earlier answer from it.
    ///
    /// # Errors
    /// Those of [`Chosen::folder`].
    pub fn folder(path: &Path, study: &Study) -> Result<OutputFolder> {
        PurchaseReport::forget(path)?;
        let folder = Chosen::folder(path, study)?;
        remove_files([PROOF, FRONT, SETS, REFINED].map(|name| path.join(name)))?;
        Ok(folder)
    }

    /// The number of sets to score, in each snapshot and repeat.
    pub fn total(&self) -> u64 {
        if self.sets.combinations.is_empty() { 0 } else { jobs(&self.sets) }
    }

    /// Writes the answer into a folder and scores its sets as a sweep does; `None` if there is no set. `prepare_s` and
    /// `command` go into the manifest; on a device, one choice in `verify` is recounted.
    ///
    /// # Errors
    /// If a file cannot be written; if a backend fails; `Error::Stopped`.
    pub fn write(
        &self,
        folder: OutputFolder,
        backends: &mut dyn BackendFactory,
        (verify, prepare_s): (u64, f64),
        command: &[String],
        progress: &dyn Progress,
    ) -> Result<Option<Results>> {
        let out = folder.path();
        self.report.write(out)?;
        if self.sets.combinations.is_empty() {
            return Ok(None);
        }
        let run = (verify, prepare_s);
        let results = sweep_sets((&self.sets, self.worlds), out, backends, run, command, progress)?;
        rows::write(&results, out, TableFormat::Csv)?;
        scores::write(&results, out, TableFormat::Csv)?;
        Ok(Some(results))
    }

    /// Checks that `judge` agrees on a set that passes all requirements.
    ///
    /// # Errors
    /// `Error::Disagreement`.
    pub fn agrees(&self, judged: &[JudgedSet]) -> Result<()> {
        let is_wrong = self.report.main().set.is_some() && judged.first().is_none_or(|set| !set.meets_all());
        match is_wrong {
            false => Ok(()),
            true => {
                let what = "the search and judge disagree about the set that passes all requirements: please report this";
                Err(Error::Disagreement(Issue::says(what)))
            }
        }
    }
}
