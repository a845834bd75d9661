//! Selects the backend and its resources from `--backend`, `--adapter`, `--threads` and `--memory`.

use clap::ValueEnum;
use perirobot_march::backend::Backend;
use perirobot_march::backend::adapter::AdapterChoice;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::factory::{BackendChoice, BackendKind, ChosenBackends};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_sweep::scoring::bench::{self, Contender};

/// Upper limit of threads, above the processors of any current machine.
const MOST_THREADS: i64 = 1024;

#[derive(clap::Args)]
#[command(next_help_heading = "Backend")]
pub(super) struct BackendArgs {
    /// The backend: auto takes a hardware GPU if there is one, else the CPU
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendWord,
    /// A Vulkan adapter for the GPU backend: its number or a part of its name (see `perirobot devices`), or `software`
    /// for one that runs on the processor. Several, separated by commas, share a sweep
    #[arg(long, value_name = "INDEX|NAME|software,...")]
    adapter: Vec<String>,
    /// Give a software adapter the large batches and the kernels of a GPU, for checks without a GPU; without --adapter,
    /// use the first software adapter
    #[arg(long)]
    as_gpu: bool,
    /// Threads that prepare scenes and sensors, and threads of the CPU backend [default: all that the process may use]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
    /// Memory for evidence (half of it) and, on the CPU, for first hits on static objects (a quarter): a number and
    /// KiB, MiB or GiB; the evidence of a few poses is always kept [default: 512MiB; more on a hardware GPU]
    #[arg(long, value_name = "BYTES", value_parser = super::quantity::bytes)]
    memory: Option<u64>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum BackendWord {
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
    /// Starts the threads that prepare scenes and sensors. The CPU backend starts the same number; the two groups work
    /// alternately.
    pub(super) fn start_threads(&self) -> Result<()> {
        start_threads(self.threads.map(usize::from))
    }

    /// Opens the backend.
    pub(super) fn open(&self) -> Result<Box<dyn Backend + Send>> {
        self.check()?.open().map(warn_if_unused)
    }

    /// The backend and its fallbacks. Opens the backend, so that a failure is reported at once.
    pub(super) fn backends(&self) -> Result<ChosenBackends> {
        ChosenBackends::open(&self.check()?).map(warn_if_unused)
    }

    /// Opens the backend on a separate thread while `work` runs. If `work` fails, its error takes precedence. Several
    /// adapters may be named.
    pub(super) fn backends_after<T>(&self, work: impl FnOnce() -> Result<T>) -> Result<(T, ChosenBackends)> {
        let choice = self.choice()?;
        std::thread::scope(|threads| {
            let opening = threads.spawn(|| ChosenBackends::open(&choice));
            let done = work();
            let opened = opening.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            Ok((done?, opened.map(warn_if_unused)?))
        })
    }

    /// The backends that `bench` measures, without the oracle.
    pub(super) fn contenders(&self) -> Result<Vec<Contender>> {
        let contenders = bench::contenders(&self.choice()?.for_one_device()?)?;
        self.warn_without_gpu(
            contenders.iter().any(|contender| contender.backend.name() == "gpu"),
            "measured",
        );
        Ok(contenders)
    }

    /// Every backend that can run here, without the oracle, including software adapters.
    pub(super) fn open_all(&self) -> Result<Vec<Box<dyn Backend>>> {
        if self.backend == BackendWord::Oracle {
            return Err(
                Issue::says("--backend oracle: every backend is compared with it; name another").into()
            );
        }
        let all = self.check()?.open_all()?;
        self.warn_without_gpu(all.iter().any(|backend| backend.name() == "gpu"), "compared");
        Ok(all)
    }

    /// The CPU that recounts poses of a device.
    pub(super) fn cpu_beside(&self) -> Result<Cpu> {
        self.choice()?.cpu()
    }

    /// Bytes for evidence, if given.
    pub(super) fn memory(&self) -> Option<u64> {
        self.memory
    }

    /// Warns if any GPU would do but none is present.
    fn warn_without_gpu(&self, is_there: bool, what: &str) {
        if self.backend == BackendWord::Auto && !is_there {
            say!("warning: no Vulkan adapter, the GPU backend is not {what} (see `perirobot devices`)");
        }
    }

    /// The choice, if its arguments fit each other.
    fn choice(&self) -> Result<BackendChoice> {
        let mut adapters = self.adapter.iter().map(|names| AdapterChoice::parse_list(names));
        let mut adapters =
            adapters.try_fold(Vec::new(), |all, names| Ok::<_, Error>([all, names?].concat()))?;
        if matches!(self.backend, BackendWord::Cpu | BackendWord::Oracle) {
            for (flag, is_given) in [("--adapter", !adapters.is_empty()), ("--as-gpu", self.as_gpu)] {
                if is_given {
                    return Err(Issue::says(format!("{flag} belongs to --backend gpu (or auto)")).into());
                }
            }
        }

        if self.as_gpu && adapters.is_empty() {
            adapters.push(AdapterChoice::Software);
        }
        let kind = match self.backend {
            BackendWord::Auto => BackendKind::Auto,
            BackendWord::Cpu => BackendKind::Cpu,
            BackendWord::Gpu => BackendKind::Gpu,
            BackendWord::Oracle => BackendKind::Oracle,
        };
        let mut adapters = adapters.into_iter();
        Ok(BackendChoice {
            kind,
            adapter: adapters.next(),
            others: adapters.collect(),
            threads: self.threads.map(usize::from),
            memory_bytes: self.memory,
            treat_as_gpu: self.as_gpu,
        })
    }

    /// The choice itself, to be opened later.
    #[cfg(feature = "report")]
    pub(super) fn checked_choice(&self) -> Result<BackendChoice> {
        self.check()
    }

    /// The same for a command that uses a single device.
    fn check(&self) -> Result<BackendChoice> {
        self.choice()?.for_one_device()
    }
}

/// The opened backend; warns if it is not the GPU that is present.
fn warn_if_unused<T>((opened, unused): (T, Option<Error>)) -> T {
    if let Some(reason) = unused {
        say!("warning: {reason}; using the CPU instead");
    }
    opened
}

/// Threads of a command without a backend.
#[derive(clap::Args)]
pub(super) struct ThreadArgs {
    /// The number of threads [default: all that the process may use]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
}

impl ThreadArgs {
    pub(super) fn start(&self) -> Result<()> {
        start_threads(self.threads.map(usize::from))
    }
}

/// Starts the threads that prepare scenes and sensors, before that work begins: all that the process may use unless a
/// number is given.
pub(super) fn start_threads(threads: Option<usize>) -> Result<()> {
    let threads = threads.or_else(|| std::thread::available_parallelism().ok().map(|n| n.get())).unwrap_or(1);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build_global().map_err(|e| Error::device(format!("cannot start {threads} threads: {e}")))
}
