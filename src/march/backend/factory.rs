//! Lists the adapters, and opens the backend that a user chose: which one, on which adapter, with how many threads and how
//! much memory. `chosen` has the fallbacks for when it fails.

mod chosen;

use super::adapter::{AdapterChoice, AdapterReport};
use super::cpu::Cpu;
#[cfg(feature = "gpu")]
use super::gpu::Gpu;
use super::oracle::Oracle;
use super::{Backend, MEMORY_BYTES};
#[cfg(not(feature = "gpu"))]
use crate::error::Words;
use crate::error::{Argument, Issue};
use crate::{Error, Result};
pub use chosen::{ChosenBackends, KeptBackends};

/// Which backend computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendKind {
    /// A hardware GPU if there is one, or the adapter that is named, else the CPU.
    #[default]
    Auto,
    /// All cores.
    Cpu,
    /// Vulkan compute shaders.
    Gpu,
    /// The plain reference, one thread.
    Oracle,
}

/// Which backend computes, and what it may use.
#[derive(Clone, Debug, Default)]
pub struct BackendChoice {
    /// Which one.
    pub kind: BackendKind,
    /// The GPU's adapter; the first hardware one, unless it is named.
    pub adapter: Option<AdapterChoice>,
    /// Adapters of further GPUs, which share the work of a sweep with the first.
    pub others: Vec<AdapterChoice>,
    /// Threads of the CPU; `None` for all that the process may use.
    pub threads: Option<usize>,
    /// Memory for evidence and first hits; `None` for the backend's default.
    pub memory_bytes: Option<u64>,
    /// Whether a software adapter gets the large batches and the kernels of a GPU, for checks.
    pub treat_as_gpu: bool,
}

impl BackendChoice {
    /// The choice for work that is not shared among several devices.
    ///
    /// # Errors
    /// When several are named.
    pub fn for_one_device(self) -> Result<BackendChoice> {
        match self.others.len() {
            0 => Ok(self),
            more => {
                let what = format!("names {} devices, and only a sweep shares its work among them", more + 1);
                Err(Issue::says(what).with_advice("name one").with_place(Argument("adapter")).into())
            }
        }
    }

    /// Opens the backend. Also says why a hardware GPU that is there is not used, if so.
    pub fn open(&self) -> Result<(Box<dyn Backend + Send>, Option<Error>)> {
        match self.kind {
            BackendKind::Oracle => Ok((Box::new(Oracle::default()), None)),
            BackendKind::Cpu => Ok((Box::new(self.cpu()?), None)),
            BackendKind::Auto if self.adapter.is_none() => match has_hardware().then(|| self.gpu()) {
                Some(Ok(gpu)) => Ok((gpu, None)),
                Some(Err(reason)) => Ok((Box::new(self.cpu()?), Some(reason))),
                None => Ok((Box::new(self.cpu()?), None)),
            },
            BackendKind::Auto | BackendKind::Gpu => Ok((self.gpu()?, None)),
        }
    }

    /// Opens the backend that is chosen, or the CPU and a GPU if any will do.
    pub fn open_all(&self) -> Result<Vec<Box<dyn Backend>>> {
        if self.kind != BackendKind::Auto {
            return Ok(vec![self.open()?.0]);
        }
        let mut all: Vec<Box<dyn Backend>> = vec![Box::new(self.cpu()?)];
        if let Some(gpu) = self.any_gpu()? {
            all.push(gpu);
        }
        Ok(all)
    }

    /// Opens the CPU.
    pub fn cpu(&self) -> Result<Cpu> {
        let cpu = Cpu::new(self.threads)?;
        let mib = self.memory_bytes.unwrap_or(MEMORY_BYTES) >> 20;
        log::info!("opened cpu: {}, {mib} MiB of memory for evidence and first hits", cpu.device());
        Ok(self.memory_bytes.into_iter().fold(cpu, Cpu::memory))
    }

    /// Opens the adapter that was named, or a hardware GPU, or a software one; none where there is no adapter
    /// at all.
    pub fn any_gpu(&self) -> Result<Option<Box<dyn Backend + Send>>> {
        if self.adapter.is_none() && self.kind != BackendKind::Gpu {
            if adapters().is_empty() {
                return Ok(None);
            }
            if !has_hardware() {
                let adapter = Some(AdapterChoice::Software);
                return BackendChoice { adapter, ..self.clone() }.gpu().map(Some);
            }
        }
        self.gpu().map(Some)
    }

    #[cfg(feature = "gpu")]
    fn gpu(&self) -> Result<Box<dyn Backend + Send>> {
        let adapter = self.adapter.as_ref().unwrap_or(&AdapterChoice::Hardware);
        // A driver that panics has failed.
        let opened = crate::error::catch_panic(|| {
            let device = super::gpu::open(adapter)?;
            let device = if self.treat_as_gpu { device.treat_as_gpu() } else { device };
            Gpu::from_device(device, &super::gpu::shader_source)
        });
        let gpu = opened.map_err(|error| match error {
            Error::Bug(issue) => Error::Device(issue),
            other => other,
        })?;
        let mib =
            self.memory_bytes.map_or("as the adapter has it".into(), |bytes| format!("{} MiB", bytes >> 20));
        log::info!("opened gpu: {}, memory for evidence: {mib}", gpu.device());
        Ok(Box::new(self.memory_bytes.into_iter().fold(gpu, Gpu::memory)))
    }

    #[cfg(not(feature = "gpu"))]
    fn gpu(&self) -> Result<Box<dyn Backend + Send>> {
        let what = Issue::left_out("the GPU backend", "gpu");
        Err(what.cure(Words::from("or use ") + Argument("backend").quote("cpu")).into())
    }
}

/// The adapters of this machine; empty without a loader or driver of Vulkan, Metal or DirectX 12, and without the
/// feature `gpu`.
pub fn adapters() -> Vec<AdapterReport> {
    #[cfg(feature = "gpu")]
    return super::gpu::enumerate().into_iter().map(|(report, _)| report).collect();
    #[cfg(not(feature = "gpu"))]
    Vec::new()
}

fn has_hardware() -> bool {
    adapters().iter().any(|adapter| !adapter.software)
}

/// Which backend works, and with how much at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fallback {
    /// The backend of the user's choice.
    None,
    /// The same, opened anew, with less memory and small batches.
    Small,
    /// The CPU.
    Cpu,
}

/// Opens the backends that a run may use.
pub trait BackendFactory: Send {
    /// Opens a backend.
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>>;

    /// Whether the backend of the user's choice is one that may fail or count wrongly: a GPU. Then the CPU
    /// takes over, and checks.
    fn needs_check(&self) -> bool;

    /// Takes the backend of the user's choice back after work that it did well; by default it is closed.
    fn take_back(&mut self, backend: Box<dyn Backend + Send>) {
        drop(backend);
    }

    /// Those of each device, where the user chose several that may work at the same time; none where one works alone.
    fn each_device(&mut self) -> Vec<&mut dyn BackendFactory> {
        Vec::new()
    }
}

impl<B: BackendFactory + ?Sized> BackendFactory for &mut B {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        (**self).open(fallback)
    }

    fn needs_check(&self) -> bool {
        (**self).needs_check()
    }

    fn take_back(&mut self, backend: Box<dyn Backend + Send>) {
        (**self).take_back(backend);
    }

    fn each_device(&mut self) -> Vec<&mut dyn BackendFactory> {
        (**self).each_device()
    }
}
