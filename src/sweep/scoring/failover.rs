//! Replaces a device that fails: by the same device with less at a time, or by the CPU.
//!
//! # Theory
//! A device that fails within a task is treated as a run that ended: what is finished is kept, and the same task is
//! begun again with another backend, which does what is left. So no kind of failure needs its own recovery.
//!
//! # Practice
//! A fallback does the next few choices of the world that the device failed in, and the device is tried again. A device
//! that fails again and again is given up.

use super::evidence::{BatchSize, Store};
use super::order::{Task, each_world};
use crate::results::PoseChoice;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::backend::{Backend, StageTiming};
use perirobot_march::error::catch_panic;
use perirobot_march::progress::{Fault, Progress};
use perirobot_march::voxel::Window;
use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// The number of choices of a fallback before the failed device is tried again.
const CHOICES_BEFORE_RETRY: usize = 64;

/// The number of failures, with little work between, before a device is given up.
const MOST_FAILURES: u32 = 3;

/// After this many choices since the last failure, failures are counted from zero again.
const CLEAN_AFTER: u64 = 1000;

/// Stage times of a backend, in stage order.
pub(super) type Timings = Vec<StageTiming>;

/// A task that another backend can continue, because it tracks its finished choices.
pub(super) trait Resumable: Task {
    /// The number of finished choices.
    fn finished(&self) -> u64;

    /// The current backend changes to this one.
    fn begin(&mut self, _: Fallback) {}

    /// Checks the counts of a device, before another backend starts and at the end.
    fn check(&mut self, _: &mut dyn BackendFactory) -> Result<()> {
        Ok(())
    }

    /// Whether nothing is left of some choices, or the task was stopped.
    fn is_over(&self, _: &[PoseChoice]) -> bool {
        true
    }

    /// Whether it was stopped.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// The choices of a task.
#[derive(Clone, Copy)]
pub(super) struct TaskChoices<'a> {
    pub(super) study: &'a Study,
    pub(super) worlds: &'a [World],
    pub(super) pose_choices: &'a [PoseChoice],
}

/// Works with the backend of the user's choice, and replaces it if it fails: for one task after the other.
pub struct Failover<'a> {
    backends: &'a mut dyn BackendFactory,
    progress: &'a dyn Progress,
    /// The next backend to open.
    fallback: Fallback,
    /// The number of failures with little work between.
    failures: u32,
    /// Choices that earlier tasks finished since the last failure.
    finished_since: u64,
    pub(super) faults: Vec<Fault>,
}

impl<'a> Failover<'a> {
    /// Without failures.
    pub fn new(backends: &'a mut dyn BackendFactory, progress: &'a dyn Progress) -> Failover<'a> {
        Failover {
            backends,
            progress,
            fallback: Fallback::None,
            failures: 0,
            finished_since: 0,
            faults: Vec::new(),
        }
    }

    /// The progress of the work.
    pub fn progress(&self) -> &'a dyn Progress {
        self.progress
    }

    /// Whether the CPU is the fallback and checks counts.
    pub fn needs_check(&self) -> bool {
        self.backends.needs_check()
    }

    /// Opens the backend of the user's choice; the CPU if that was given up.
    pub(super) fn open(&mut self) -> Result<Box<dyn Backend + Send>> {
        let backend = self.backends.open(self.fallback)?;
        if self.fallback == Fallback::None {
            self.progress.show_backend(backend.as_ref());
        }
        Ok(backend)
    }

    /// Runs the remaining checks of a task.
    pub(super) fn check(&mut self, task: &mut dyn Resumable) -> Result<()> {
        task.check(self.backends)
    }

    /// Does the rest of a task with a backend from [`Failover::open`], until it is finished or stopped. Returns the
    /// stage times of the last backend.
    pub(super) fn work(
        &mut self,
        choices: TaskChoices,
        mut backend: Box<dyn Backend + Send>,
        task: &mut dyn Resumable,
    ) -> Result<Timings> {
        let TaskChoices { study, worlds, pose_choices } = choices;
        let (mut last_fault, mut entered) = (0, None);
        task.begin(self.fallback);
        loop {
            let mut located = Located { task: &mut *task, entered: &mut entered };
            let worked = catch_panic(|| {
                each_world(study, worlds, pose_choices, BatchSize::FULL, backend.as_mut(), &mut located)
            });
            match worked {
                Err(error @ (Error::Device(_) | Error::Bug(_)))
                    if self.needs_check() && self.fallback != Fallback::Cpu =>
                {
                    // Its memory must be free before the next one is opened.
                    drop(backend);
                    let is_clean = self.finished_since + task.finished() - last_fault > CLEAN_AFTER;
                    self.failures = if is_clean { 1 } else { self.failures + 1 };
                    let world = worlds.iter().find(|world| Some(place_of(world)) == entered);
                    // The fallback does its part; then the device is tried again.
                    let instead = self.do_some(choices, world, task)?;
                    (last_fault, self.finished_since) = (task.finished(), 0);
                    backend = self.open_again()?;
                    let is_given_up = self.fallback == Fallback::Cpu;
                    let for_good = if is_given_up { ", and from then on the CPU" } else { "" };
                    let scene = world.map_or(String::new(), |world| world.title(study));
                    let fault = Fault::new(&error, scene, format!("{instead}{for_good}"));
                    self.progress.show_fault(&fault);
                    self.faults.push(fault);
                    match is_given_up {
                        true => task.check(self.backends)?,
                        false => self.progress.show_backend(backend.as_ref()),
                    }
                    task.begin(self.fallback);
                }
                Err(e) => return Err(e),
                Ok(()) => {
                    task.check(self.backends)?;
                    if task.is_over(pose_choices) {
                        self.finished_since += task.finished() - last_fault;
                        let timings = backend.timings();
                        if self.fallback == Fallback::None {
                            self.backends.take_back(backend);
                        }
                        return Ok(timings);
                    }
                }
            }
        }
    }

    /// Opens the device again; the CPU if it failed too often, or cannot be opened.
    fn open_again(&mut self) -> Result<Box<dyn Backend + Send>> {
        if self.failures < MOST_FAILURES {
            // It was opened before, so a failure now is the device's.
            if let Ok(backend) = self.backends.open(Fallback::None) {
                return Ok(backend);
            }
        }
        self.fallback = Fallback::Cpu;
        self.backends.open(Fallback::Cpu)
    }

    /// Does the next few choices of the world in which a device failed: by the device in small batches, or by the CPU.
    /// Returns the one used.
    fn do_some(
        &mut self,
        choices: TaskChoices,
        world: Option<&World>,
        task: &mut dyn Resumable,
    ) -> Result<&'static str> {
        // Waiting checks would block the next backend.
        task.check(self.backends)?;
        for (fallback, who) in
            [(Fallback::Small, "the same device in small batches"), (Fallback::Cpu, "the CPU")]
        {
            task.begin(fallback);
            let opened = self.backends.open(fallback);
            let done = opened.and_then(|mut backend| {
                catch_panic(|| world.map_or(Ok(()), |world| chunk(choices, world, backend.as_mut(), task)))
            });
            match done {
                // If even small batches do not fit, the input is not the cause.
                Err(Error::Device(_) | Error::Bug(_) | Error::Input(_)) if fallback != Fallback::Cpu => {}
                other => return other.map(|()| who),
            }
        }
        unreachable!("the CPU's outcome was returned")
    }
}

/// Does the next few choices of a world in small batches.
fn chunk(
    TaskChoices { study, pose_choices, .. }: TaskChoices,
    world: &World,
    backend: &mut dyn Backend,
    task: &mut dyn Resumable,
) -> Result<()> {
    let wants = |pose_choice: &&PoseChoice| {
        (0..study.repeats as usize).any(|repeat| task.wants(world, repeat, pose_choice))
    };
    let some: Vec<PoseChoice> =
        pose_choices.iter().filter(wants).take(CHOICES_BEFORE_RETRY).copied().collect();
    let mut located = Located { task, entered: &mut None };
    each_world(study, std::slice::from_ref(world), &some, BatchSize::SMALL, backend, &mut located)
}

/// The scene and snapshot of a world.
fn place_of(world: &World) -> [usize; 2] {
    [world.scene, world.snapshot]
}

/// A task, and the place of its current world.
struct Located<'a> {
    task: &'a mut dyn Resumable,
    entered: &'a mut Option<[usize; 2]>,
}

impl Task for Located<'_> {
    fn begins(&mut self, world: &World) {
        *self.entered = Some(place_of(world));
    }

    fn window(&self, world: &World) -> Window {
        self.task.window(world)
    }

    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        self.task.wants(world, repeat, pose_choice)
    }

    fn work(&mut self, store: Store, pose_choices: &[PoseChoice], backend: &mut dyn Backend) -> Result<()> {
        self.task.work(store, pose_choices, backend)
    }

    fn enough(&mut self) -> bool {
        self.task.enough()
    }
}
