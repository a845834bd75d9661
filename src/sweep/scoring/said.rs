//! Reads the evidence of sensors from a backend, voxel by voxel: for choices in study order, cast as in a sweep,
//! without counting.

use super::evidence::{BatchSize, Store};
use super::failover::{Failover, Resumable, TaskChoices};
use super::order::{Task, each_world};
use crate::results::PoseChoice;
use perirobot_march::Result;
use perirobot_march::backend::{self, Backend, Planes, Slot};
use perirobot_march::voxel::Window;
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// Choices per read; fewer if their planes take more bytes than this.
const AT_ONCE: usize = 64;
const BYTES_AT_ONCE: u64 = 256 << 20;

/// The evidence of one sensor of a choice.
#[derive(Clone, Debug)]
pub struct SensorSays {
    /// Its evidence in parts, to be merged. Each covers the reader's window, or a part of it, and is empty elsewhere.
    pub parts: Vec<Planes>,
    /// Whether its hits are people's voxels that a presence sensor feels.
    pub presence: bool,
}

/// Selects the wanted evidence, and receives it.
pub trait EvidenceReader {
    /// The part of a world to read.
    fn window(&self, world: &World) -> Window;

    /// Whether the evidence of a choice is wanted, in one repeat of a world.
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool;

    /// Receives the evidence of the sensors of some choices in one repeat of a world. A sensor without evidence is left
    /// out.
    fn take(&mut self, world: &World, repeat: usize, said: Vec<(PoseChoice, Vec<SensorSays>)>) -> Result<()>;

    /// Whether no more work may start.
    fn enough(&mut self) -> bool;
}

/// The evidence to read, with the representation of each sensor.
#[derive(Clone, Copy)]
pub struct ReadPlan<'a> {
    /// The study.
    pub study: &'a Study,
    /// Its scenes at their moments.
    pub worlds: &'a [World],
    /// The choices.
    pub pose_choices: &'a [PoseChoice],
    /// The index of a representation for each sensor of the study.
    pub representations: &'a [usize],
}

impl ReadPlan<'_> {
    /// Reads the evidence with the user's backend, and fallbacks for a failing device. A reader must not want evidence
    /// twice.
    pub fn read_on(&self, failover: &mut Failover, reader: &mut dyn EvidenceReader) -> Result<()> {
        let ReadPlan { study, worlds, pose_choices, representations } = *self;
        let choices = TaskChoices { study, worlds, pose_choices };
        let backend = failover.open()?;
        failover.work(choices, backend, &mut ReadTask { representations, reader, taken: 0 }).map(drop)
    }

    /// Reads the evidence with one backend.
    pub fn read(&self, backend: &mut dyn Backend, reader: &mut dyn EvidenceReader) -> Result<()> {
        let ReadPlan { study, worlds, pose_choices, representations } = *self;
        let mut task = ReadTask { representations, reader, taken: 0 };
        each_world(study, worlds, pose_choices, BatchSize::FULL, backend, &mut task)
    }
}

/// The task of reading a reader's wanted evidence.
struct ReadTask<'a> {
    /// For each sensor of the study.
    representations: &'a [usize],
    reader: &'a mut dyn EvidenceReader,
    /// The number of received choices.
    taken: u64,
}

impl Task for ReadTask<'_> {
    fn window(&self, world: &World) -> Window {
        self.reader.window(world)
    }

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
        let planes_bytes = 3 * self.reader.window(store.world).volume() / 8;
        let at_once = (BYTES_AT_ONCE / planes_bytes.max(1)).clamp(1, AT_ONCE as u64) as usize;
        for repeat in 0..study.repeats as usize {
            let mut wanted = pose_choices.to_vec();
            wanted.retain(|pose_choice| self.reader.wants(store.world, repeat, pose_choice));
            let mut left = wanted.as_slice();
            while !left.is_empty() && !self.reader.enough() {
                let made;
                (made, left) = left.split_at(store.make_ready(left, repeat, backend)?);
                for some in made.chunks(at_once) {
                    let evidence = self.sense_choices(&store, some, repeat, backend)?;
                    self.reader.take(store.world, repeat, evidence)?;
                    self.taken += some.len() as u64;
                }
            }
        }
        Ok(())
    }

    fn enough(&mut self) -> bool {
        self.reader.enough()
    }
}

impl Resumable for ReadTask<'_> {
    fn finished(&self) -> u64 {
        self.taken
    }
}

impl ReadTask<'_> {
    /// The evidence of each sensor of some choices.
    fn sense_choices(
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
        let evidence = pose_choices.iter().zip(readings).map(|(pose_choice, readings)| {
            let each = readings.iter().map(|reading| SensorSays {
                parts: planes.by_ref().take(slots(reading).count()).collect(),
                presence: reading.presence,
            });
            (*pose_choice, each.collect())
        });
        Ok(evidence.collect())
    }
}
