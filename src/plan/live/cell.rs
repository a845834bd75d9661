//! A study in voxels, kept as long as only its sensors change; and the same made in the background.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use perirobot_march::backend::cpu::BlockerSearch;
use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::voxel::grid::VOXEL_SIZES_M;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Study, Wanted};
use perirobot_study::world::{World, share_kinds, with_sensors_of, worlds_key};

use super::floor::{CarryingFloor, CountedFloor};

/// The least edge of larger voxels, in metres.
const LEAST_COARSE_M: f64 = 0.05;

/// The edge of the voxels in which is counted while something is dragged: twice that of the study, at least 5 cm.
pub fn coarse_voxel_m(voxel_size_m: f64) -> f64 {
    (2.0 * voxel_size_m).max(LEAST_COARSE_M).min(*VOXEL_SIZES_M.end()).max(voxel_size_m)
}

/// A study in voxels.
pub(super) struct Cell {
    /// Each sensor in one representation.
    pub(super) study: Study,
    pub(super) worlds: Vec<World>,
    /// What the worlds were made of.
    key: String,
    /// What is ready of each moment.
    pub(super) moments: Vec<Option<Arc<ReadyMoment>>>,
    /// By the number of a scene, what its floor map is counted above, once it was needed.
    floors: Vec<Option<Arc<CarryingFloor>>>,
}

/// What does not depend on sensors at a moment.
pub(super) struct ReadyMoment {
    pub(super) search: BlockerSearch,
    pub(super) floor: CountedFloor,
}

impl Cell {
    /// A study in voxels; those of an earlier study, if they are the same. With it, whether they are new.
    pub(super) fn new(study: Study, before: Option<&Cell>, progress: &dyn Progress) -> Result<(Cell, bool)> {
        let key = worlds_key(&study);
        let mut study = one_representation(study);
        let before = before.filter(|before| before.key == key);
        if let Some(before) = before {
            share_kinds(&before.study, &mut study);
            if let Some(worlds) = with_sensors_of(&before.worlds, &before.study, &study) {
                // Where bodies come in decides which floors they get to.
                let (moments, floors) = match before.study.approach == study.approach {
                    true => (before.moments.clone(), before.floors.clone()),
                    false => (vec![None; worlds.len()], vec![None; study.scenes.len()]),
                };
                return Ok((Cell { study, worlds, key, moments, floors }, false));
            }
        }
        let worlds = World::prepare_all_unless(&study, progress)?;
        let (moments, floors) = (vec![None; worlds.len()], vec![None; study.scenes.len()]);
        Ok((Cell { study, worlds, key, moments, floors }, true))
    }

    /// A moment by its number.
    pub(super) fn world(&self, moment: usize) -> Result<&World> {
        self.worlds.get(moment).ok_or_else(|| {
            let what = format!("there is no moment {moment}: the study has {}", self.worlds.len());
            Error::from(Issue::says(what))
        })
    }

    /// What is ready of a moment, made when it is first needed.
    pub(super) fn ready(&mut self, moment: usize) -> Result<Arc<ReadyMoment>> {
        let world = self.world(moment)?;
        if let Some(ready) = &self.moments[moment] {
            return Ok(ready.clone());
        }
        let search = BlockerSearch::new(&world.truth().blockers);
        let carrying = self.floors[world.scene].clone().unwrap_or_else(|| {
            let of_scene = self.worlds.chunk_by(|one, next| one.scene == next.scene);
            let of_scene = of_scene.into_iter().find(|all| all[0].scene == world.scene).unwrap_or_default();
            Arc::new(CarryingFloor::new(&self.study, of_scene))
        });
        let (scene, floor) = (world.scene, CountedFloor::new(world, &carrying));
        let ready = Arc::new(ReadyMoment { search, floor });
        self.floors[scene] = Some(carrying);
        self.moments[moment] = Some(ready.clone());
        Ok(ready)
    }
}

/// The same study with each sensor in the representation that `[choose]` names, else in its first.
fn one_representation(study: Study) -> Study {
    let representations = match &study.choose {
        Some(Wanted::Best(choose)) => choose.representations.clone(),
        Some(Wanted::Cheapest(purchase)) => purchase.representations.clone(),
        None => vec![0; study.sensors.len()],
    };
    let combinations = study.combinations.clone();
    study.with_combinations(&representations, combinations)
}

/// A cell that is made in a thread of its own.
pub(super) struct Background {
    made: Option<Result<Cell>>,
    thread: Option<JoinHandle<Result<Cell>>>,
    stopped: Arc<AtomicBool>,
}

impl Background {
    /// Begins to make a study's cell, perhaps from an earlier one.
    pub(super) fn new(study: Study, before: Option<Cell>) -> Background {
        let stopped = Arc::new(AtomicBool::new(false));
        let flag = stopped.clone();
        let make = move || {
            let progress = move || flag.load(Ordering::Relaxed).then(|| String::from("another study came"));
            Cell::new(study, before.as_ref(), &progress).map(|(cell, _)| cell)
        };
        Background { made: None, thread: Some(std::thread::spawn(make)), stopped }
    }

    /// The cell, once it is made.
    pub(super) fn wait(&mut self) -> Result<&mut Cell> {
        if let Some(thread) = self.thread.take() {
            let panicked = || Error::Bug(Issue::says("larger voxels could not be made"));
            self.made = Some(thread.join().unwrap_or_else(|_| Err(panicked())));
        }
        match self.made.as_mut() {
            Some(Ok(cell)) => Ok(cell),
            Some(Err(error)) => Err(Error::from(error.issue().clone())),
            None => Err(Error::Bug(Issue::says("larger voxels were never begun"))),
        }
    }

    /// The cell, if it is made; one that is under way is given up.
    pub(super) fn finished(mut self) -> Option<Cell> {
        let is_done = self.thread.as_ref().is_none_or(JoinHandle::is_finished);
        if !is_done {
            self.stopped.store(true, Ordering::Relaxed);
            return None;
        }
        let _ = self.wait();
        self.made.take()?.ok()
    }
}
