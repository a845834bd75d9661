//! What the planner counts: a plan, which is a few sensors at listed poses or anywhere else, scored, judged and explained
//! while a person moves them. All that poses do not change stays ready between two requests: voxels, tables of rays, the
//! scene in the backend, and what each sensor that did not move says.
//!
//! # Theory
//! The counts are the integers of a sweep: the same scene, placements and draws go to the same backend and are fused in the
//! same order ([`Study::with_plan`]). A scene that stands still for one request is loaded without the layers by which a sweep
//! shares work between moments; no count depends on them.
//!
//! # Practice
//! - `cell` has a study in voxels: the study's own and, for quick answers while something is dragged, larger ones
//!   ([`coarse_voxel_m`]), made in the background. `evidence` has what each sensor says, in slots of the backend.
//! - `score` counts at one moment, with `floor` for the map of the floor and `frustum` for where rays end. `verdicts` judges
//!   all moments. `sight` tells why a sensor does not see a place, `eye` draws what a sensor sees, `scenery` the cell itself.
//! - One thread owns a [`Live`]. Requests that take long take a [`Progress`], by which a newer request stops
//!   them.

mod cell;
mod disturbed;
mod evidence;
mod eye;
mod floor;
mod frustum;
mod mid_air;
mod scenery;
mod score;
mod sight;
mod verdicts;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod times;

use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, ChosenBackends, Fallback, KeptBackends};
use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Planned, Study};
use perirobot_study::world::World;

pub use cell::coarse_voxel_m;
use cell::{Background, Cell};
pub use disturbed::DisturbingPair;
use evidence::HeldEvidence;
pub use floor::{FloorMap, NOT_COUNTED, PERSON_M};
pub use frustum::Frustum;
pub use scenery::{Scenery, Thing};
pub use score::{PlacedProblem, ScoreAnswer, ScoreRequest};
pub use sight::{SensorSight, WhyAnswer};
pub use verdicts::{JudgeAnswer, MomentCounts, Nearest, VerdictLine};

/// In which voxels something is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// Those of the study.
    Fine,
    /// Larger ones.
    Coarse,
}

/// A study that is planned, ready to be counted again and again.
pub struct Live {
    backends: KeptBackends<ChosenBackends>,
    /// The device failed, and the CPU counts instead.
    fallback: Fallback,
    fine: Option<Cell>,
    coarse: Option<Background>,
    /// What the backend holds, if nothing else was done with it since.
    held: Option<HeldEvidence>,
}

impl Live {
    /// Without a study yet.
    pub fn new(backends: ChosenBackends) -> Live {
        let backends = KeptBackends::new(backends);
        Live { backends, fallback: Fallback::None, fine: None, coarse: None, held: None }
    }

    /// Takes a study that was read, and the same in voxels of [`coarse_voxel_m`], if it could be read so. Its scenes become
    /// voxels, unless only sensors, their poses or what is asked of them changed; whether they did.
    ///
    /// # Errors
    /// When a scene cannot be prepared; the study before stays. `Error::Stopped`.
    pub fn set_study(
        &mut self,
        study: Study,
        coarse: Option<Study>,
        progress: &dyn Progress,
    ) -> Result<bool> {
        let (fine, is_new) = Cell::new(study, self.fine.as_ref(), progress)?;
        (self.fine, self.held) = (Some(fine), None);
        let before = self.coarse.take().and_then(Background::finished);
        self.coarse = coarse.map(|study| Background::new(study, before));
        Ok(is_new)
    }

    /// The study as it was taken, each sensor in the representation in which it is scored.
    ///
    /// # Errors
    /// Without a study.
    pub fn study(&self) -> Result<&Study> {
        Ok(&self.fine()?.study)
    }

    /// Its worlds, scene by scene and in each snapshot by snapshot: moments are numbered so.
    ///
    /// # Errors
    /// As [`Live::study`]; of the larger voxels when they cannot be prepared.
    pub fn worlds(&mut self, resolution: Resolution) -> Result<&[World]> {
        Ok(&self.cell(resolution)?.worlds)
    }

    /// The study with a plan as its only combination, its worlds with it, and the candidate of each sensor.
    fn plan(&self, plan: &[Planned]) -> Result<(Study, Vec<World>, Vec<usize>)> {
        let Cell { study, worlds, .. } = self.fine()?;
        let (study, candidates) = study.with_plan(plan)?;
        let worlds = worlds.iter().map(|world| world.with_sensors(&study.sensors)).collect();
        Ok((study, worlds, candidates))
    }

    fn fine(&self) -> Result<&Cell> {
        self.fine.as_ref().ok_or_else(|| Error::from(Issue::says("no study is loaded")))
    }

    /// The cell in voxels of one size, which may still have to be made.
    fn cell(&mut self, resolution: Resolution) -> Result<&mut Cell> {
        let none = |what: &str| Error::from(Issue::says(what));
        match resolution {
            Resolution::Fine => self.fine.as_mut().ok_or_else(|| none("no study is loaded")),
            Resolution::Coarse => {
                self.coarse.as_mut().ok_or_else(|| none("the study cannot be read in larger voxels"))?.wait()
            }
        }
    }

    /// Does something with the backend, which then holds no evidence that is known. A device that fails is replaced by the
    /// CPU, which does it again.
    fn use_backend<T>(&mut self, mut job: impl FnMut(&mut dyn Backend) -> Result<T>) -> Result<T> {
        self.held = None;
        let mut backend = self.backends.open(self.fallback)?;
        match job(&mut *backend) {
            Err(Error::Device(issue)) if self.may_fall_back() => {
                log::warn!("{issue}; using the CPU instead");
                drop(backend);
                self.fallback = Fallback::Cpu;
                self.use_backend(job)
            }
            Err(error @ (Error::Device(_) | Error::Bug(_))) => Err(error),
            done => {
                self.backends.take_back(backend);
                done
            }
        }
    }

    fn may_fall_back(&self) -> bool {
        self.backends.needs_check() && self.fallback == Fallback::None
    }
}
