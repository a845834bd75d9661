//! Tracks the finished choices of a sweep on disk, and writes their rows into the journal.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::devices::Parts;
use super::{Ledger, Row};
use crate::results::journal::Journal;
use crate::results::{PoseChoice, RowKey, RowLayout};
use perirobot_march::Result;
use perirobot_march::metrics::Confusion;
use perirobot_march::progress::Progress;
use perirobot_study::world::World;

/// The finished choices of a shard in each block.
#[derive(Debug)]
pub(super) struct Done {
    /// Choices of the shard, by their places among all.
    places: std::ops::Range<usize>,
    bits: Vec<u64>,
    count: u64,
}

impl Done {
    /// Without finished choices.
    pub(super) fn new(layout: &RowLayout, places: std::ops::Range<usize>) -> Done {
        let bits = vec![0; (layout.blocks() * places.len()).div_ceil(64)];
        Done { places, bits, count: 0 }
    }

    /// The choices with all rows in a journal, and the number of its damaged places.
    pub(super) fn from_journal(
        layout: &RowLayout,
        places: std::ops::Range<usize>,
        journal: &Journal,
    ) -> Result<(Done, u64)> {
        let mut done = Done::new(layout, places.clone());
        let pose_choices: Vec<PoseChoice> =
            layout.all_choices().skip(places.start).take(places.len()).collect();
        // Rows come in order, so those of a choice are consecutive.
        let (mut at, mut block, mut found) = (0, 0, 0);
        let damaged = journal.scan(|row, _| {
            let (now, within) = ((row / layout.block_rows()) as usize, row % layout.block_rows());
            if now != block {
                (at, block, found) = (0, now, 0);
            }
            while within >= layout.rows_of_choice(&pose_choices[at]).end {
                (at, found) = (at + 1, 0);
            }
            found += 1;
            let of_choice = layout.rows_of_choice(&pose_choices[at]);
            if found == of_choice.end - of_choice.start {
                done.set(block, places.start + at);
            }
            Ok(())
        })?;
        Ok((done, damaged))
    }

    /// The number of finished choices, in each block.
    pub(super) fn count(&self) -> u64 {
        self.count
    }

    fn set(&mut self, block: usize, place: usize) {
        let (word, bit) = self.position(block, place);
        self.count += u64::from(self.bits[word] & bit == 0);
        self.bits[word] |= bit;
    }

    /// Whether some choices are finished in all blocks.
    pub(super) fn has_all(&self, layout: &RowLayout, pose_choices: &[PoseChoice]) -> bool {
        // The last one is usually the missing one.
        let is_done = |block| pose_choices.iter().rev().all(|choice| self.has(block, layout.place(choice)));
        self.count == (layout.blocks() * self.places.len()) as u64 || (0..layout.blocks()).rev().all(is_done)
    }

    pub(super) fn has(&self, block: usize, place: usize) -> bool {
        let (word, bit) = self.position(block, place);
        self.bits[word] & bit != 0
    }

    fn position(&self, block: usize, place: usize) -> (usize, u64) {
        let number = block * self.places.len() + place - self.places.start;
        (number / 64, 1 << (number % 64))
    }
}

/// A journal with its finished choices, shared by all devices.
pub(super) struct Record<'a> {
    pub(super) journal: &'a mut Journal,
    pub(super) done: &'a mut Done,
    /// Whether the rows of all devices were set aside, since one of them counts wrongly: no more rows are accepted.
    pub(super) is_set_aside: bool,
}

/// Writes finished rows of one device into the journal, and tracks the remaining ones.
pub(super) struct Checkpoint<'a> {
    pub(super) layout: &'a RowLayout,
    /// The first moment of each scene.
    pub(super) moments: Vec<usize>,
    pub(super) record: &'a Mutex<Record<'a>>,
    pub(super) parts: &'a Parts<'a>,
    pub(super) progress: &'a dyn Progress,
    /// Why it was stopped.
    pub(super) stopped: Option<String>,
    /// Rows of a device that the CPU must still check.
    pub(super) unchecked: Option<super::check::Picked>,
    /// Whether the current rows need no check.
    pub(super) is_trusted: bool,
    /// The number of choices finished by this device.
    pub(super) finished: u64,
}

impl<'a> Checkpoint<'a> {
    fn moment(&self, scene: usize, snapshot: usize) -> usize {
        self.moments[scene] + snapshot
    }

    /// The number of a row.
    fn number(&self, row: &Row) -> u64 {
        let Row { combination, choice, representation, region, .. } = *row;
        let key = RowKey { combination, choice, representation, region };
        self.layout.row(self.moment(row.scene, row.snapshot), row.repeat, &key)
    }

    /// The finished choices of all devices.
    pub(super) fn record(&self) -> MutexGuard<'a, Record<'a>> {
        self.record.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Ledger for Checkpoint<'_> {
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        let moment = self.moment(world.scene, world.snapshot);
        !self.record().done.has(self.layout.block(moment, repeat), self.layout.place(pose_choice))
    }

    fn take(&mut self, rows: &[Row]) -> Result<()> {
        let numbered: Vec<(u64, Confusion)> = rows.iter().map(|row| (self.number(row), row.counts)).collect();
        let mut record = self.record();
        if record.is_set_aside {
            return Ok(());
        }
        for run in numbered.chunk_by(|(a, _), (b, _)| a + 1 == *b) {
            let counts: Vec<Confusion> = run.iter().map(|(_, counts)| *counts).collect();
            record.journal.put(run[0].0, &counts)?;
        }
        let of_one = |a: &Row, b: &Row| (a.combination, a.choice) == (b.combination, b.choice);
        for rows in rows.chunk_by(of_one) {
            let Row { scene, snapshot, repeat, combination, choice, .. } = rows[0];
            let block = self.layout.block(self.moment(scene, snapshot), repeat);
            record.done.set(block, self.layout.place(&PoseChoice { combination, choice }));
            if let Some(unchecked) = self.unchecked.as_mut().filter(|_| !self.is_trusted) {
                unchecked.pick(rows);
            }
            self.finished += 1;
            self.progress.advance(1);
        }
        Ok(())
    }

    fn enough(&mut self) -> bool {
        self.stopped = self.stopped.take().or_else(|| self.progress.stop_reason());
        let is_due = !self.is_trusted && self.unchecked.as_ref().is_some_and(|unchecked| unchecked.are_due());
        self.stopped.is_some() || self.parts.is_halted() || is_due
    }
}
