//! Counts some sets of sensors, each a combination with one choice of poses, without a folder.

use std::collections::HashSet;

use super::checkpoint::Watch;
use super::evidence::BatchSize;
use super::fallback::{Resumable, work_on};
use super::{Ledger, Row, run_choices};
use crate::results::manifest::Fault;
use crate::results::{PoseChoice, layout_of};
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_study::study::Study;
use perirobot_study::world::World;

/// Scores every choice of every combination of a study on the backend of a user's choice, rows in study order. Other
/// backends step in where a device fails.
///
/// # Errors
/// When the backend fails; `Error::Stopped` with the watch's reason.
pub fn run_on(
    study: &Study,
    worlds: &[World],
    backends: &mut dyn BackendFactory,
    watch: &mut dyn Watch,
) -> Result<Vec<Row>> {
    let pose_choices: Vec<PoseChoice> = layout_of(study).all_choices().collect();
    let taken = Taken { rows: Vec::new(), done: HashSet::new(), stopped: None, watch };
    let mut task = Counting { study, worlds, pose_choices, taken };
    work_on(backends, &mut task)?;
    let Taken { mut rows, stopped, .. } = task.taken;
    if let Some(why) = stopped {
        return Err(Error::Stopped(Issue::says(why)));
    }
    rows.sort_by_key(Row::place);
    Ok(rows)
}

struct Counting<'a> {
    study: &'a Study,
    worlds: &'a [World],
    pose_choices: Vec<PoseChoice>,
    taken: Taken<'a>,
}

impl Resumable for Counting<'_> {
    fn work(&mut self, batch: BatchSize, backend: &mut dyn Backend) -> Result<()> {
        run_choices(self.study, self.worlds, &self.pose_choices, batch, backend, &mut self.taken)
    }

    fn runs_on(&mut self, backend: &dyn Backend) {
        self.taken.watch.runs_on(backend);
    }

    fn failed(&mut self, fault: &Fault) {
        self.taken.watch.failed(fault);
    }
}

/// The rows that were counted.
struct Taken<'a> {
    rows: Vec<Row>,
    /// Scene, snapshot, repeat, combination and choice of what is there.
    done: HashSet<[usize; 5]>,
    stopped: Option<String>,
    watch: &'a mut dyn Watch,
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
        self.watch.finished((self.done.len() - before) as u64);
        Ok(())
    }

    fn enough(&mut self) -> bool {
        self.stopped = self.stopped.take().or_else(|| self.watch.stop());
        self.stopped.is_some()
    }
}
