//! Which backend runs: chosen once, here, from `--backend`, `--adapter` and `--threads`.

use clap::ValueEnum;
use perirobot::backend::cpu::Cpu;
use perirobot::backend::gpu::{AdapterChoice, Gpu, adapters};
use perirobot::backend::{Backend, oracle::Oracle};
use perirobot::sweep::bench::Contender;
use perirobot::{Error, Result};

#[derive(clap::Args)]
pub(super) struct BackendArgs {
    /// Who computes: auto takes a hardware GPU if there is one, else the CPU
    #[arg(long, value_enum, default_value = "auto")]
    backend: Choice,
    /// A Vulkan adapter for the GPU backend: its number or a part of its name (see `perirobot devices`), or
    /// `software` for one that runs on the processor
    #[arg(long, value_name = "INDEX|NAME|software")]
    adapter: Option<String>,
    /// Threads of the CPU backend [default: all that the process may use]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Choice {
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
    /// Opens the backend.
    pub(super) fn open(&self) -> Result<Box<dyn Backend>> {
        if self.adapter.is_some() && matches!(self.backend, Choice::Cpu | Choice::Oracle) {
            return Err(Error::Input("--adapter belongs to --backend gpu (or auto)".into()));
        }
        match self.backend {
            Choice::Oracle => Ok(Box::new(Oracle::default())),
            Choice::Cpu => Ok(Box::new(Cpu::new(self.threads())?)),
            Choice::Gpu => Ok(Box::new(Gpu::new(&self.adapter())?)),
            Choice::Auto if self.adapter.is_some() => Ok(Box::new(Gpu::new(&self.adapter())?)),
            Choice::Auto if adapters().iter().any(|adapter| !adapter.software) => {
                match Gpu::new(&AdapterChoice::Hardware) {
                    Ok(gpu) => Ok(Box::new(gpu)),
                    Err(reason) => {
                        eprintln!("warning: {reason}; using the CPU instead");
                        Ok(Box::new(Cpu::new(self.threads())?))
                    }
                }
            }
            Choice::Auto => Ok(Box::new(Cpu::new(self.threads())?)),
        }
    }

    /// What `bench` measures besides the oracle: the CPU on one thread without and with SIMD and on all, and the GPU. A
    /// software adapter counts.
    pub(super) fn contenders(&self) -> Result<Vec<Contender>> {
        let all = std::thread::available_parallelism().map_or(1, |n| n.get());
        let mut contenders = Vec::new();
        if matches!(self.backend, Choice::Auto | Choice::Cpu) {
            let most = self.threads().unwrap_or(all);
            contenders.push(Contender {
                name: "cpu, 1 thread, no SIMD".into(),
                backend: Box::new(Cpu::new(Some(1))?.without_simd()),
                threads: 1,
            });
            for threads in if most > 1 { vec![1, most] } else { vec![1] } {
                let cpu = Cpu::new(Some(threads))?;
                let name = format!("cpu, {}", cpu.device());
                contenders.push(Contender { name, backend: Box::new(cpu), threads });
            }
        }
        if matches!(self.backend, Choice::Auto | Choice::Gpu)
            && let Some(gpu) = self.any_gpu("measured")?
        {
            let name = format!("gpu, {}", gpu.device());
            contenders.push(Contender { name, backend: Box::new(gpu), threads: all });
        }
        Ok(contenders)
    }

    /// Every backend that can run here besides the oracle. A software adapter counts.
    pub(super) fn open_all(&self) -> Result<Vec<Box<dyn Backend>>> {
        if self.backend == Choice::Oracle {
            return Err(Error::Input(
                "--backend oracle: every backend is compared with it; name another".into(),
            ));
        }
        if self.backend != Choice::Auto {
            return Ok(vec![self.open()?]);
        }
        let mut all: Vec<Box<dyn Backend>> = vec![Box::new(Cpu::new(self.threads())?)];
        if let Some(gpu) = self.any_gpu("compared")? {
            all.push(Box::new(gpu));
        }
        Ok(all)
    }

    /// The adapter that was asked for, or a hardware GPU, or a software one; none, and a warning, where there is no
    /// adapter at all.
    fn any_gpu(&self, what: &str) -> Result<Option<Gpu>> {
        if self.adapter.is_some() || self.backend == Choice::Gpu {
            return Gpu::new(&self.adapter()).map(Some);
        }
        let found = adapters();
        if found.is_empty() {
            eprintln!("warning: no Vulkan adapter, the GPU backend is not {what} (see `perirobot devices`)");
            return Ok(None);
        }
        let hardware = found.iter().any(|adapter| !adapter.software);
        Gpu::new(if hardware { &AdapterChoice::Hardware } else { &AdapterChoice::Software }).map(Some)
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
