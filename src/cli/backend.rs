//! Which backend runs and what it may use: chosen once, here, from `--backend`, `--adapter`, `--threads` and
//! `--memory`.

use clap::ValueEnum;
use perirobot::backend::cpu::Cpu;
use perirobot::backend::gpu::{AdapterChoice, Gpu, adapters};
use perirobot::backend::{Backend, MEMORY_BYTES, oracle::Oracle};
use perirobot::error::Issue;
use perirobot::sweep::bench::Contender;
use perirobot::sweep::{BackendFactory, Fallback};
use perirobot::{Error, Result};

/// Most threads; no machine of today has as many processors.
const MOST_THREADS: i64 = 1024;

#[derive(clap::Args)]
#[command(next_help_heading = "Backend")]
pub(super) struct BackendArgs {
    /// Who computes: auto takes a hardware GPU if there is one, else the CPU
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendChoice,
    /// A Vulkan adapter for the GPU backend: its number or a part of its name (see `perirobot devices`), or
    /// `software` for one that runs on the processor
    #[arg(long, value_name = "INDEX|NAME|software")]
    adapter: Option<String>,
    /// Threads that prepare scenes and sensors, and of the CPU backend [default: all that the process may
    /// use]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
    /// Memory for evidence (half of it) and, on the CPU, for first hits in what stands still (a quarter): a
    /// number and KiB, MiB or GiB; a few poses' evidence is kept in any case [default: 512MiB; more on a
    /// hardware GPU]
    #[arg(long, value_name = "BYTES", value_parser = super::quantity::bytes)]
    memory: Option<u64>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum BackendChoice {
    /// A hardware GPU if there is one, else the CPU
    Auto,
    /// All cores
    Cpu,
    /// Vulkan compute shaders
    Gpu,
    /// The plain reference, one thread
    Oracle,
}

impl BackendArgs {
    /// Starts the threads that prepare scenes and sensors. The CPU backend has as many of its own, and while
    /// those work these wait.
    pub(super) fn start_threads(&self) -> Result<()> {
        start_threads(self.threads())
    }

    /// Opens the backend.
    pub(super) fn open(&self) -> Result<Box<dyn Backend + Send>> {
        if self.adapter.is_some() && matches!(self.backend, BackendChoice::Cpu | BackendChoice::Oracle) {
            return Err(Issue::says("--adapter belongs to --backend gpu (or auto)").into());
        }
        match self.backend {
            BackendChoice::Oracle => Ok(Box::new(Oracle::default())),
            BackendChoice::Cpu => Ok(Box::new(self.cpu(self.threads())?)),
            BackendChoice::Gpu => Ok(Box::new(self.gpu(&self.adapter())?)),
            BackendChoice::Auto if self.adapter.is_some() => Ok(Box::new(self.gpu(&self.adapter())?)),
            BackendChoice::Auto if adapters().iter().any(|adapter| !adapter.software) => {
                match self.gpu(&AdapterChoice::Hardware) {
                    Ok(gpu) => Ok(Box::new(gpu)),
                    Err(reason) => {
                        say!("warning: {reason}; using the CPU instead");
                        Ok(Box::new(self.cpu(self.threads())?))
                    }
                }
            }
            BackendChoice::Auto => Ok(Box::new(self.cpu(self.threads())?)),
        }
    }

    /// What `bench` measures besides the oracle: the CPU on one thread without and with SIMD and on all, and
    /// the GPU. A software adapter counts.
    pub(super) fn contenders(&self) -> Result<Vec<Contender>> {
        let all = std::thread::available_parallelism().map_or(1, |n| n.get());
        let mut contenders = Vec::new();
        if matches!(self.backend, BackendChoice::Auto | BackendChoice::Cpu) {
            let most = self.threads().unwrap_or(all);
            contenders.push(Contender {
                name: "cpu, 1 thread, no SIMD".into(),
                backend: Box::new(self.cpu(Some(1))?.without_simd()),
                threads: 1,
            });
            for threads in if most > 1 { vec![1, most] } else { vec![1] } {
                let cpu = self.cpu(Some(threads))?;
                let name = format!("cpu, {}", cpu.device());
                contenders.push(Contender { name, backend: Box::new(cpu), threads });
            }
        }
        if matches!(self.backend, BackendChoice::Auto | BackendChoice::Gpu)
            && let Some(gpu) = self.any_gpu("measured")?
        {
            let name = format!("gpu, {}", gpu.device());
            contenders.push(Contender { name, backend: Box::new(gpu), threads: all });
        }
        Ok(contenders)
    }

    /// Every backend that can run here besides the oracle. A software adapter counts.
    pub(super) fn open_all(&self) -> Result<Vec<Box<dyn Backend>>> {
        if self.backend == BackendChoice::Oracle {
            return Err(
                Issue::says("--backend oracle: every backend is compared with it; name another").into()
            );
        }
        if self.backend != BackendChoice::Auto {
            return Ok(vec![self.open()?]);
        }
        let mut all: Vec<Box<dyn Backend>> = vec![Box::new(self.cpu(self.threads())?)];
        if let Some(gpu) = self.any_gpu("compared")? {
            all.push(Box::new(gpu));
        }
        Ok(all)
    }

    /// The adapter that was asked for, or a hardware GPU, or a software one; none, and a warning, where there
    /// is no adapter at all.
    fn any_gpu(&self, what: &str) -> Result<Option<Gpu>> {
        if self.adapter.is_some() || self.backend == BackendChoice::Gpu {
            return self.gpu(&self.adapter()).map(Some);
        }
        let found = adapters();
        if found.is_empty() {
            say!("warning: no Vulkan adapter, the GPU backend is not {what} (see `perirobot devices`)");
            return Ok(None);
        }
        let hardware = found.iter().any(|adapter| !adapter.software);
        self.gpu(if hardware { &AdapterChoice::Hardware } else { &AdapterChoice::Software }).map(Some)
    }

    fn cpu(&self, threads: Option<usize>) -> Result<Cpu> {
        let cpu = Cpu::new(threads)?;
        let mib = self.memory.unwrap_or(MEMORY_BYTES) >> 20;
        tracing::info!("opened cpu: {}, {mib} MiB of memory for evidence and first hits", cpu.device());
        Ok(self.memory.into_iter().fold(cpu, Cpu::memory))
    }

    /// The CPU that checks what a device counts.
    pub(super) fn cpu_beside(&self) -> Result<Cpu> {
        self.cpu(self.threads())
    }

    fn gpu(&self, choice: &AdapterChoice) -> Result<Gpu> {
        let gpu = Gpu::new(choice)?;
        let mib = self.memory.map_or("as the adapter has it".into(), |bytes| format!("{} MiB", bytes >> 20));
        tracing::info!("opened gpu: {}, memory for evidence: {mib}", gpu.device());
        Ok(self.memory.into_iter().fold(gpu, Gpu::memory))
    }

    /// Bytes for evidence, if the user said how many.
    pub(super) fn memory(&self) -> Option<u64> {
        self.memory
    }

    fn threads(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }

    fn adapter(&self) -> AdapterChoice {
        match &self.adapter {
            Some(name) => name.parse().unwrap_or(AdapterChoice::Hardware),
            None => AdapterChoice::Hardware,
        }
    }
}

/// Starts the threads that prepare scenes and sensors, before any of that begins: as many as the process may
/// use unless a number is given.
pub(super) fn start_threads(threads: Option<usize>) -> Result<()> {
    let threads = threads.or_else(|| std::thread::available_parallelism().ok().map(|n| n.get())).unwrap_or(1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build_global().map_err(|e| Error::device(format!("cannot start {threads} threads: {e}")))
}

/// The backend of a sweep and who steps in for it.
pub(super) struct SweepBackends<'a> {
    args: &'a BackendArgs,
    is_gpu: bool,
    /// The backend that was opened first, until it is asked for.
    ready: Option<Box<dyn Backend + Send>>,
}

impl BackendArgs {
    /// Who sweeps. The backend of the user's choice is opened, so that what is wrong with it is known at
    /// once.
    pub(super) fn backends(&self) -> Result<SweepBackends<'_>> {
        let backend = self.open()?;
        Ok(SweepBackends { args: self, is_gpu: backend.name() == "gpu", ready: Some(backend) })
    }
}

impl BackendFactory for SweepBackends<'_> {
    fn open(&mut self, fallback: Fallback) -> Result<Box<dyn Backend + Send>> {
        match fallback {
            Fallback::None => {
                // Once it was a GPU, it is one: what steps in for it is known by its own name.
                let again = || Ok(Box::new(self.args.gpu(&self.args.adapter())?) as Box<dyn Backend + Send>);
                let anew = || if self.is_gpu { again() } else { self.args.open() };
                let backend = self.ready.take().map_or_else(anew, Ok)?;
                say!("running on {}: {}", backend.name(), backend.device());
                Ok(backend)
            }
            Fallback::Small => {
                let memory = self.args.memory.unwrap_or(MEMORY_BYTES).min(MEMORY_BYTES) / 4;
                Ok(Box::new(self.args.gpu(&self.args.adapter())?.memory(memory)))
            }
            Fallback::Cpu => Ok(Box::new(self.args.cpu(self.args.threads())?)),
        }
    }

    fn needs_check(&self) -> bool {
        self.is_gpu
    }
}
