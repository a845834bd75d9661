//! The stages of a search: evidence is cast, sets are searched and refined, and the answer is written or verified. A
//! caller shows the result of a stage before the next one begins.

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
    /// How many bytes of evidence may be held.
    memory_bytes: u64,
}

/// The best sets that were found.
pub struct Found<'a> {
    /// What is to be written.
    pub outcome: Outcome<'a>,
    /// How the search ended.
    pub ending: SearchEnding,
}

/// How a search ended.
pub enum SearchEnding {
    /// By itself.
    Finished,
    /// It was stopped, for this reason, before all sets were searched.
    NotSearched(String),
    /// It was stopped, for this reason, before all sets were refined.
    NotRefined(String),
    /// Refining failed.
    Failed(Error),
}

impl<'a> Choosing<'a> {
    /// What a study asks for.
    ///
    /// # Errors
    /// When it has no `[choose]`; when a score can have no value, or no exact one.
    pub fn new(study: &'a Study, worlds: &'a [World], memory_bytes: u64) -> Result<Choosing<'a>> {
        let choose = match &study.choose {
            Some(Wanted::Best(choose)) => choose,
            Some(Wanted::Cheapest(_)) => {
                let what = "asks for the cheapest set that passes, which has no score to choose by";
                let cure =
                    "say which score is meant, as in objective = \"f1\", region = \"robot\", at_most = 3";
                return Err(Error::input("choose", what).with_advice(cure).with_place(&study.path));
            }
            None => {
                let example = "[choose] objective = \"f1\", region = \"robot\", at_most = 3";
                return Err(Error::input(&study.path, "no [choose]").with_advice(format!(
                    "say what is looked for, as in {example}; or add [[require]] and the cost of each sensor, and the \
                     cheapest set that passes is looked for"
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

    /// Reads the evidence in a folder, and keeps there what will be cast; with `restart` it is lost. Without a folder
    /// there is none yet, and none is kept.
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

    /// Finds the best sets, and refines them if that is asked for. None if it was stopped before any set was found.
    ///
    /// # Errors
    /// When no set meets the requirements; when evidence in a file cannot be read.
    pub fn search(
        &self,
        evidence: &CandidateEvidence,
        backends: &mut dyn BackendFactory,
        progress: &dyn Progress,
    ) -> Result<Option<Found<'a>>> {
        let asked = (self.study, self.choose, self.worlds);
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
            // As if sensors might disturb each other: whether that they may not is what the answer lacks.
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
            match refine(asked, (&problem, &answer, &report), self.memory_bytes, backends, progress) {
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
        Ok(Some(Found { outcome: Outcome::new(asked, report, with_poses), ending }))
    }

    /// Checks all that is in the folder of a proof.
    ///
    /// # Errors
    /// `Error::Input` that names what does not hold; `Error::Stopped`.
    pub fn verify(
        &self,
        claims: &Claims,
        evidence: &CandidateEvidence,
        backends: &mut dyn BackendFactory,
        progress: &dyn Progress,
    ) -> Result<Verified> {
        let asked = (self.study, self.choose, self.worlds);
        verify(claims, asked, evidence, (backends, self.memory_bytes), progress)
    }
}
