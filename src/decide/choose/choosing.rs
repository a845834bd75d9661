//! The stages of a search: cast the evidence, search and refine the sets, write or verify the answer. A caller shows
//! the result of a stage before the next one begins.

use std::path::Path;

use super::evidence::Casting;
use super::files::Chosen;
use super::outcome::Outcome;
use super::problem::{answer, examine, problem_of, wanted_counts};
use super::refine::refine;
use super::report::{DisturbedReport, FrontReport};
use super::verify::{Claims, Verified, verify};
use perirobot_cover::CandidateEvidence;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choose, Study, Wanted};
use perirobot_study::world::World;
use perirobot_sweep::results::files::OutputFolder;

/// A question that has an answer.
pub struct Choosing<'a> {
    study: &'a Study,
    choose: &'a Choose,
    worlds: &'a [World],
    /// Limit of evidence in memory, in bytes.
    memory_bytes: u64,
}

/// The best sets found.
pub struct Found<'a> {
    /// The outcome to write.
    pub outcome: Outcome<'a>,
    /// The end of the search.
    pub ending: SearchEnding,
}

/// How a search ended.
pub enum SearchEnding {
    /// It was complete.
    Finished,
    /// It was stopped, for this reason, before all sets were searched.
    NotSearched(String),
    /// It was stopped, for this reason, before all sets were refined.
    NotRefined(String),
    /// Refining failed.
    Failed(Error),
}

impl<'a> Choosing<'a> {
    /// The question of a study.
    ///
    /// # Errors
    /// If it has no `[choose]`; if a score can have no value, or no exact one.
    pub fn new(study: &'a Study, worlds: &'a [World], memory_bytes: u64) -> Result<Choosing<'a>> {
        let choose = match &study.choose {
            Some(Wanted::Best(choose)) => choose,
            Some(Wanted::Cheapest(_)) => {
                let what = "requests the cheapest set that passes, which has no score to choose by";
                let cure = "name a score, as in objective = \"f1\", region = \"robot\", at_most = 3";
                return Err(Error::input("choose", what).with_advice(cure).with_place(&study.path));
            }
            None => {
                let example = "[choose] objective = \"f1\", region = \"robot\", at_most = 3";
                return Err(Error::input(&study.path, "no [choose]").with_advice(format!(
                    "add {example}; or add [[require]] and the cost of each sensor to find the \
                     cheapest set that passes"
                )));
            }
        };
        examine(study, choose, worlds)?;
        Ok(Choosing { study, choose, worlds, memory_bytes })
    }

    /// Opens a folder for the answer.
    ///
    /// # Errors
    /// Those of [`Chosen::folder`].
    pub fn open(&self, out: &Path) -> Result<OutputFolder> {
        Chosen::folder(out, self.study)
    }

    /// Reads the proof in a folder.
    ///
    /// # Errors
    /// Those of [`Claims::read`].
    pub fn read_claims(&self, folder: &Path) -> Result<Claims> {
        Claims::read(folder, self.study, self.choose, self.worlds)
    }

    /// Reads the evidence in a folder, and stores new evidence there; `restart` discards the old. Without a folder none
    /// is read or stored.
    ///
    /// # Errors
    /// Those of [`Casting::begin`].
    pub fn begin_casting(&self, folder: Option<&Path>, restart: bool) -> Result<Casting<'a>> {
        let kept = folder.map(|folder| (folder, restart));
        let regions = [wanted_counts(self.choose)];
        Casting::begin(
            self.study,
            &regions,
            &self.choose.representations,
            self.worlds,
            self.memory_bytes,
            kept,
        )
    }

    /// Finds the best sets, and refines them if requested. `None` if it was stopped before any set was found.
    ///
    /// # Errors
    /// If no set meets the requirements; if evidence in a file cannot be read.
    pub fn search(
        &self,
        evidence: &CandidateEvidence,
        backends: &mut dyn BackendFactory,
        progress: &dyn Progress,
    ) -> Result<Option<Found<'a>>> {
        let question = (self.study, self.choose, self.worlds);
        let problem = problem_of(self.study, self.choose, self.worlds, evidence);
        let answer = answer(&problem, progress)?;
        let mut report = FrontReport::new(self.study, self.worlds, &problem, &answer);
        let (mut ending, mut with_poses) = (SearchEnding::Finished, None);
        if let Some(why) = progress.stop_reason().filter(|_| !answer.complete) {
            if report.steps.is_empty() {
                return Ok(None);
            }
            ending = SearchEnding::NotSearched(why);
        }
        if self.choose.disturb.is_some() && answer.complete {
            // The same search without the exclusion of disturbing pairs, which shows its cost.
            let free = Choose { disturb: None, ..self.choose.clone() };
            let free = problem_of(self.study, &free, self.worlds, evidence);
            let found = super::problem::answer(&free, progress)?;
            report.if_disturbed = DisturbedReport::new(self.study, self.worlds, &problem, &found);
            if let Some(why) = progress.stop_reason().filter(|_| !found.complete) {
                report.stopped = true;
                ending = SearchEnding::NotSearched(why);
            }
        }
        evidence.was_read()?;
        if self.choose.refine && answer.complete {
            match refine(question, (&problem, &answer, &report), self.memory_bytes, backends, progress) {
                Ok(refinement) => {
                    if let Some(why) = progress.stop_reason().filter(|_| !refinement.complete) {
                        ending = SearchEnding::NotRefined(why);
                    }
                    with_poses = refinement.with_poses;
                    report.refined = Some(refinement.told);
                    report.refining_stopped = !refinement.complete;
                }
                Err(error) => ending = SearchEnding::Failed(error),
            }
        }
        Ok(Some(Found { outcome: Outcome::new(question, report, with_poses), ending }))
    }

    /// Checks a proof with all its files.
    ///
    /// # Errors
    /// `Error::Input` that names the wrong claim; `Error::Stopped`.
    pub fn verify(
        &self,
        claims: &Claims,
        evidence: &CandidateEvidence,
        backends: &mut dyn BackendFactory,
        progress: &dyn Progress,
    ) -> Result<Verified> {
        let question = (self.study, self.choose, self.worlds);
        verify(claims, question, evidence, (backends, self.memory_bytes), progress)
    }
}
