//! Counts some sets of sensors, each a combination with one choice of poses, without a folder.

use std::collections::HashSet;

use super::devices::{Parts, devices, on_each};
use super::evidence::Store;
use super::failover::{Failover, Resumable, TaskChoices};
use super::order::{Task, score};
use super::{Ledger, Row};
use crate::results::{PoseChoice, layout_of};
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, KeptBackends};
use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// Scores every choice of every combination of a study on the user's backend, rows in study order, with fallbacks for a
/// failing device.
///
/// # Errors
/// If the backend fails; `Error::Stopped`.
pub fn run_on(
    study: &Study,
    worlds: &[World],
    backends: &mut dyn BackendFactory,
    progress: &dyn Progress,
) -> Result<Vec<Row>> {
    let pose_choices: Vec<PoseChoice> = layout_of(study).all_choices().collect();
    let choices = TaskChoices { study, worlds, pose_choices: &pose_choices };
    let mut devices = devices(backends);
    let parts = Parts::new(&pose_choices, devices.len());
    let taken = on_each(devices.iter_mut().collect(), &parts, |device| {
        let taken = Taken { rows: Vec::new(), done: HashSet::new(), stopped: None, parts: &parts, progress };
        let mut counting = Counting(taken);
        parts.work(&mut Failover::new(device, progress), choices, &mut counting)?;
        Ok(counting.0)
    })?;
    devices.iter_mut().for_each(KeptBackends::give_back);
    let mut rows = Vec::new();
    for Taken { rows: of_device, stopped, .. } in taken {
        if let Some(why) = stopped {
            return Err(Error::Stopped(Issue::says(why)));
        }
        rows.extend(of_device);
    }
    rows.sort_by_key(Row::place);
    Ok(rows)
}

/// The task of counting all choices.
struct Counting<'a>(Taken<'a>);

impl Task for Counting<'_> {
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        self.0.wants(world, repeat, pose_choice)
    }

    fn work(&mut self, store: Store, pose_choices: &[PoseChoice], backend: &mut dyn Backend) -> Result<()> {
        score(store, pose_choices, backend, &mut self.0)
    }

    fn enough(&mut self) -> bool {
        self.0.enough()
    }
}

impl Resumable for Counting<'_> {
    fn finished(&self) -> u64 {
        self.0.done.len() as u64
    }

    fn is_stopped(&self) -> bool {
        self.0.stopped.is_some()
    }
}

/// The received rows.
struct Taken<'a> {
    rows: Vec<Row>,
    /// Scene, snapshot, repeat, combination and choice of the received rows.
    done: HashSet<[usize; 5]>,
    stopped: Option<String>,
    parts: &'a Parts<'a>,
    progress: &'a dyn Progress,
}

impl Ledger for Taken<'_> {
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        let PoseChoice { combination, choice } = *pose_choice;
        !self.done.contains(&[world.scene, world.snapshot, repeat, combination, choice])
    }

    fn take(&mut self, rows: &[Row]) -> Result<()> {
        let before = self.done.len();
        for row in rows {
            self.done.insert([row.scene, row.snapshot, row.repeat, row.combination, row.choice]);
        }
        self.rows.extend(rows);
        self.progress.advance((self.done.len() - before) as u64);
        Ok(())
    }

    fn enough(&mut self) -> bool {
        self.stopped = self.stopped.take().or_else(|| self.progress.stop_reason());
        self.stopped.is_some() || self.parts.is_halted()
    }
}
