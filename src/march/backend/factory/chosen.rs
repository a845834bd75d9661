//! The backends of a choice for a whole run: one of each device, and what works instead of a device that fails.

use super::{BackendChoice, BackendFactory, BackendKind, Fallback};
use crate::backend::adapter::AdapterChoice;
use crate::backend::{Backend, MEMORY_BYTES};
use crate::{Error, Result};

/// The backend of a user's choice and its fallbacks, or several GPUs with theirs.
pub struct ChosenBackends {
    first: DeviceBackends,
    others: Vec<DeviceBackends>,
}

impl ChosenBackends {
    /// Opens the backend of a choice, so that what is wrong with it is known at once; several GPUs at the same time. With it
    /// comes why a hardware GPU that is there is not used.
    pub fn open(choice: &BackendChoice) -> Result<(ChosenBackends, Option<Error>)> {
        let one = |adapter: Option<&AdapterChoice>| {
            let adapter = adapter.or(choice.adapter.as_ref()).cloned();
            DeviceBackends::open(BackendChoice { adapter, others: Vec::new(), ..choice.clone() })
        };
        let (first, others) = std::thread::scope(|threads| {
            let others: Vec<_> =
                choice.others.iter().map(|adapter| threads.spawn(|| one(Some(adapter)))).collect();
            let first = one(None);
            let joined = others
                .into_iter()
                .map(|opening| opening.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            (first, joined.collect::<Vec<_>>())
        });
        let (first, unused) = first?;
        let others = others.into_iter().map(|opened| Ok(opened?.0)).collect::<Result<_>>()?;
        Ok((ChosenBackends { first, others }, unused))
    }
}

impl BackendFactory for ChosenBackends {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        self.first.open(fallback)
    }

    fn needs_check(&self) -> bool {
        self.first.needs_check()
    }

    fn each_device(&mut self) -> Vec<&mut dyn BackendFactory> {
        if self.others.is_empty() {
            return Vec::new();
        }
        let all = std::iter::once(&mut self.first).chain(&mut self.others);
        all.map(|device| device as &mut dyn BackendFactory).collect()
    }
}

/// The backend of a choice of one device, and its fallbacks.
struct DeviceBackends {
    choice: BackendChoice,
    /// The backend that was opened first, until it is asked for.
    ready: Option<Box<dyn Backend + Send>>,
}

impl DeviceBackends {
    fn open(choice: BackendChoice) -> Result<(DeviceBackends, Option<Error>)> {
        let (backend, unused) = choice.open()?;
        // A backend that was opened as a GPU is opened as a GPU again; using the CPU instead is a fallback of
        // its own.
        let kind = if backend.name() == "gpu" { BackendKind::Gpu } else { choice.kind };
        Ok((DeviceBackends { choice: BackendChoice { kind, ..choice }, ready: Some(backend) }, unused))
    }
}

impl BackendFactory for DeviceBackends {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        match fallback {
            Fallback::None => self.ready.take().map_or_else(|| Ok(self.choice.open()?.0), Ok),
            Fallback::Small => {
                let memory_bytes = self.choice.memory_bytes.unwrap_or(MEMORY_BYTES).min(MEMORY_BYTES) / 4;
                BackendChoice { memory_bytes: Some(memory_bytes), ..self.choice.clone() }.gpu()
            }
            Fallback::Cpu => Ok(Box::new(self.choice.cpu()?)),
        }
    }

    fn needs_check(&self) -> bool {
        self.choice.kind == BackendKind::Gpu
    }
}

/// Backends for one job after the other: that of the user's choice is kept open while it works well.
pub struct KeptBackends<B> {
    backends: B,
    /// The backend that worked last, until it is asked for.
    ready: Option<Box<dyn Backend + Send>>,
}

impl<B: BackendFactory> KeptBackends<B> {
    /// None is open yet.
    pub fn new(backends: B) -> KeptBackends<B> {
        KeptBackends { backends, ready: None }
    }

    /// Hands the backend that is open back to where it came from.
    pub fn give_back(&mut self) {
        self.ready.take().into_iter().for_each(|backend| self.backends.take_back(backend));
    }
}

impl<B: BackendFactory> BackendFactory for KeptBackends<B> {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        let ready = self.ready.take().filter(|_| fallback == Fallback::None);
        ready.map_or_else(|| self.backends.open(fallback), Ok)
    }

    fn needs_check(&self) -> bool {
        self.backends.needs_check()
    }

    fn take_back(&mut self, backend: Box<dyn Backend + Send>) {
        self.ready = Some(backend);
    }
}
