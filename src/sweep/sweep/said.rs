//! Reads the evidence of sensors back from a backend, voxel by voxel: of choices in study order, cast as a
//! sweep casts them, without counting.

use super::evidence::{BatchSize, Store};
use super::fallback::{Resumable, work_on};
use super::order::{Task, each_world};
use crate::results::PoseChoice;
use crate::results::manifest::Fault;
use perirobot_march::Result;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::backend::{self, Backend, Planes, Slot};
use perirobot_study::study::Study;
use perirobot_study::world::World;

/// Choices whose evidence is read back at once.
const AT_ONCE: usize = 64;

/// The evidence of one sensor of a choice.
#[derive(Clone, Debug)]
pub struct SensorSays {
    /// Its evidence in parts, which are joined. Each covers the bounding box of the regions, or a part of it
    /// outside of which it says nothing.
    pub parts: Vec<Planes>,
    /// Whether its hits are voxels of people that a presence sensor feels.
    pub presence: bool,
}

/// Says which evidence is wanted, and takes it.
pub trait EvidenceReader {
    /// Whether the evidence of a choice is wanted, in one repeat of a world.
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool;

    /// Takes the evidence of the sensors of some choices in one repeat of a world. A sensor without evidence
    /// is left out.
    fn take(&mut self, world: &World, repeat: usize, said: Vec<(PoseChoice, Vec<SensorSays>)>) -> Result<()>;

    /// Whether nothing more is to be begun.
    fn enough(&mut self) -> bool;

    /// This backend begins.
    fn runs_on(&mut self, _: &dyn Backend) {}

    /// Something failed; what was not taken yet is wanted from somebody else.
    fn failed(&mut self, _: &Fault) {}
}

/// What is read, and in which representation of each sensor.
#[derive(Clone, Copy)]
pub struct ReadPlan<'a> {
    /// The study.
    pub study: &'a Study,
    /// Its scenes at their moments.
    pub worlds: &'a [World],
    /// Which choices.
    pub pose_choices: &'a [PoseChoice],
    /// Of each sensor of the study, the number of a representation.
    pub representations: &'a [usize],
}

impl ReadPlan<'_> {
    /// Reads it with the backend of a user's choice. Of a device that fails what is left is read in small batches,
    /// and if it fails at those too, from the CPU. A reader must not want again what it took.
    pub fn read_on(&self, backends: &mut dyn BackendFactory, reader: &mut dyn EvidenceReader) -> Result<()> {
        work_on(backends, &mut Reading { plan: self, reader })
    }

    /// Reads it with one backend.
    pub fn read(&self, backend: &mut dyn Backend, reader: &mut dyn EvidenceReader) -> Result<()> {
        self.read_batches(BatchSize::FULL, backend, reader)
    }

    fn read_batches(
        &self,
        batch: BatchSize,
        backend: &mut dyn Backend,
        reader: &mut dyn EvidenceReader,
    ) -> Result<()> {
        let ReadPlan { study, worlds, pose_choices, representations } = *self;
        each_world(study, worlds, pose_choices, batch, backend, &mut ReadTask { representations, reader })
    }
}

/// A plan and who takes what is read.
struct Reading<'a> {
    plan: &'a ReadPlan<'a>,
    reader: &'a mut dyn EvidenceReader,
}

impl Resumable for Reading<'_> {
    fn work(&mut self, batch: BatchSize, backend: &mut dyn Backend) -> Result<()> {
        self.plan.read_batches(batch, backend, self.reader)
    }

    fn runs_on(&mut self, backend: &dyn Backend) {
        self.reader.runs_on(backend);
    }

    fn failed(&mut self, fault: &Fault) {
        self.reader.failed(fault);
    }
}

/// The task of reading what a reader wants.
struct ReadTask<'a> {
    /// Of each sensor of the study.
    representations: &'a [usize],
    reader: &'a mut dyn EvidenceReader,
}

impl Task for ReadTask<'_> {
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        self.reader.wants(world, repeat, pose_choice)
    }

    fn work(
        &mut self,
        mut store: Store,
        pose_choices: &[PoseChoice],
        backend: &mut dyn Backend,
    ) -> Result<()> {
        let study = store.study;
        for repeat in 0..study.repeats as usize {
            let mut wanted = pose_choices.to_vec();
            wanted.retain(|pose_choice| self.reader.wants(store.world, repeat, pose_choice));
            let mut left = wanted.as_slice();
            while !left.is_empty() && !self.reader.enough() {
                let made;
                (made, left) = left.split_at(store.make_ready(left, repeat, backend)?);
                for some in made.chunks(AT_ONCE) {
                    let said = self.said(&store, some, repeat, backend)?;
                    self.reader.take(store.world, repeat, said)?;
                }
            }
        }
        Ok(())
    }

    fn enough(&mut self) -> bool {
        self.reader.enough()
    }
}

impl ReadTask<'_> {
    /// The evidence of each sensor of some choices.
    fn said(
        &self,
        store: &Store,
        pose_choices: &[PoseChoice],
        repeat: usize,
        backend: &mut dyn Backend,
    ) -> Result<Vec<(PoseChoice, Vec<SensorSays>)>> {
        let readings = pose_choices.iter().map(|pose_choice| {
            let members = &store.study.combinations[pose_choice.combination].members;
            let representations: Vec<usize> =
                members.iter().map(|member| self.representations[member.sensor]).collect();
            store.readings(pose_choice, repeat, &representations)
        });
        let readings: Vec<Vec<backend::Reading>> = readings.collect();
        let slots = |reading: &backend::Reading| [Some(reading.slot), reading.volume].into_iter().flatten();
        let all: Vec<Slot> = readings.iter().flatten().flat_map(slots).collect();
        let mut planes = backend.planes(&all)?.into_iter();
        let said = pose_choices.iter().zip(readings).map(|(pose_choice, readings)| {
            let each = readings.iter().map(|reading| SensorSays {
                parts: planes.by_ref().take(slots(reading).count()).collect(),
                presence: reading.presence,
            });
            (*pose_choice, each.collect())
        });
        Ok(said.collect())
    }
}
