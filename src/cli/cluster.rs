//! `perirobot cluster`: a sweep as a script for what a cluster already runs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::cluster::{Job, VisibleWord, hyperqueue, kubernetes, label, slurm};
use clap::{Parser, Subcommand};
use perirobot_march::error::{Issue, Site};
use perirobot_march::{Error, Result};
use perirobot_study::input::{Overrides, Study};
use perirobot_sweep::results::files::write_whole;

use super::outcome::OutcomeArgs;

/// Write a script that sweeps in shards on a cluster
///
/// A cluster's own engine does the work: the script gives each shard to one of its tasks, a task that is
/// stopped goes on where it was, and at the end the shards are merged into what a single run would have
/// written, byte for byte. Nothing is submitted before you run the script. What follows `--` is handed to
/// `perirobot sweep`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot cluster slurm my.toml --shards 100 --cpus 8 --time-limit 240 \\
    --script my.sh
      then, where sbatch is: sh my.sh
  perirobot cluster hyperqueue my.toml --shards 100 --script my.sh -- \\
    --backend cpu
      then, where hq is: sh my.sh
  perirobot cluster kubernetes my.toml --shards 100 --image IMAGE \\
    --claim CLAIM --script my.yaml
      then: kubectl apply -f my.yaml

Each engine's --help says what happens when a task is stopped or fails.")]
pub(super) struct Args {
    #[command(subcommand)]
    engine: Engine,
}

#[derive(Subcommand)]
enum Engine {
    /// A shell script: an array job of Slurm, and the merge as the job that depends on it
    ///
    /// `sh FILE` submits both and returns. A task whose time is up, whose node is lost or whose program fails
    /// goes back into the queue and goes on where it was; bad input and wrong counts end it for good, as
    /// another try would not help. When all tasks have ended, the merge writes the tables into --out, or its
    /// log names the shards that lack rows: `sh FILE` again goes on with them. Logs are in OUT/logs.
    Slurm {
        #[command(flatten)]
        job: JobArgs,
        /// Where the program is on the nodes [default: where this one is]
        #[arg(long, value_name = "PATH")]
        program: Option<VisibleWord>,
        /// How long a task may run before it goes back into the queue [default: the partition's limit]
        #[arg(long, value_name = "MINUTES")]
        time_limit: Option<u32>,
        /// How many tasks an array job may have (MaxArraySize in `scontrol show config`)
        #[arg(long, value_name = "N", default_value_t = slurm::MAX_ARRAY_SIZE)]
        max_array_size: u32,
    },
    /// A shell script: an array of HyperQueue's tasks, then the merge
    ///
    /// `sh FILE` submits the tasks, waits for them, and merges. A task that is stopped goes on at once where
    /// it was; tasks that fail are submitted again, --tries times at most. If shards still lack rows, the
    /// merge names them: `sh FILE` again goes on with them. Logs are in OUT/logs.
    Hyperqueue {
        #[command(flatten)]
        job: JobArgs,
        /// Where the program is on the nodes [default: where this one is]
        #[arg(long, value_name = "PATH")]
        program: Option<VisibleWord>,
    },
    /// A manifest: an Indexed Job of Kubernetes, and the merge as a second Job
    ///
    /// All paths are those in the container, so the study is not looked at here. A pod that is stopped is
    /// replaced by one that goes on where it was; one that fails, --tries times at most; bad input and wrong
    /// counts end the Job. The merge is started by hand when all pods have ended; the manifest's first lines
    /// say how.
    Kubernetes {
        #[command(flatten)]
        job: JobArgs,
        /// The program in the image
        #[arg(long, value_name = "PATH", default_value = "perirobot")]
        program: VisibleWord,
        /// The container image
        #[arg(long)]
        image: VisibleWord,
        /// The volume claim with the study, which takes the results
        #[arg(long)]
        claim: VisibleWord,
        /// Where the volume is mounted; relative paths start there
        #[arg(long, value_name = "PATH", default_value = "/data")]
        mount: VisibleWord,
        /// How many pods run at a time [default: all]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
        parallelism: Option<u32>,
    },
}

#[derive(clap::Args)]
struct JobArgs {
    /// The study file (TOML)
    study: VisibleWord,
    /// How many shards: as many as may run at a time, or a few times that
    #[arg(long, value_name = "N")]
    shards: u32,
    /// Folder for the results, shared by all nodes [default: out/ and the study's name]
    #[arg(long, value_name = "DIR")]
    out: Option<VisibleWord>,
    /// What the engine calls it [default: perirobot- and the study's name]
    #[arg(long)]
    name: Option<VisibleWord>,
    /// Processors of each task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    cpus: u16,
    /// Memory that the engine gives to each task, a number and KiB, MiB or GiB [default: the engine's]
    #[arg(long, value_name = "BYTES", value_parser = super::quantity::bytes)]
    memory: Option<u64>,
    /// How often a shard that fails is tried again; one that is stopped and has new rows goes on in any case
    #[arg(long, value_name = "N", default_value_t = 5)]
    tries: u32,
    /// Write the script there instead of to standard output
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    #[command(flatten)]
    outcome: OutcomeArgs,
    /// What `perirobot sweep` is told besides, as in -- --backend cpu --memory 1GiB
    #[arg(last = true)]
    sweep_arguments: Vec<VisibleWord>,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let (given, text) = match &args.engine {
        Engine::Slurm { job: given, program, time_limit, max_array_size } => {
            let job = given.job_here(program)?;
            let limits = slurm::SlurmLimits { time_limit_min: *time_limit, max_array_size: *max_array_size };
            (given, slurm::script(&job, &limits)?)
        }
        Engine::Hyperqueue { job: given, program } => (given, hyperqueue::script(&given.job_here(program)?)),
        Engine::Kubernetes { job: given, program, image, claim, mount, parallelism } => {
            let (image, claim, mount) = (image.clone(), claim.clone(), mount.clone());
            let pods = kubernetes::Pods { image, claim, mount, parallelism: *parallelism };
            (given, kubernetes::manifest(&given.job(program.clone())?, &pods))
        }
    };
    match &given.script {
        Some(file) => {
            write_whole(file, text.as_bytes())?;
            let run = match args.engine {
                Engine::Kubernetes { .. } => "kubectl apply -f",
                _ => "sh",
            };
            say!("wrote {0}; to run it: {run} {0}", file.display());
        }
        None => super::print(&text)?,
    }
    Ok(ExitCode::SUCCESS)
}

impl JobArgs {
    /// The job on machines that share their files with this one, so that the study can be looked at.
    fn job_here(&self, program: &Option<VisibleWord>) -> Result<Job> {
        let program = match program {
            Some(program) => program.clone(),
            None => this_program()?,
        };
        let job = self.job(program)?;
        let study = Study::load(Path::new(self.study.text()), &Overrides::default())?;
        let choices: usize = study.combinations.iter().map(|combination| combination.choices()).sum();
        if self.shards as usize > choices {
            return Err(Issue::says(format!(
                "--shards {}: {} has {choices} choices of poses; write {choices} or less",
                self.shards, self.study
            ))
            .into());
        }
        Ok(job)
    }

    /// The job, as far as its words tell.
    fn job(&self, program: VisibleWord) -> Result<Job> {
        let stem = Path::new(self.study.text()).file_stem().unwrap_or_default().to_string_lossy();
        let word = |text: String| text.parse::<VisibleWord>().map_err(|e| e.with_place("STUDY").into());
        let job = Job {
            name: self.name.clone().map_or_else(|| word(label(&format!("perirobot-{stem}"))), Ok)?,
            program,
            study: self.study.clone(),
            out: self.out.clone().map_or_else(|| word(format!("out/{stem}")), Ok)?,
            shards: self.shards,
            sweep_arguments: self.sweep_arguments.clone(),
            merge_arguments: self.outcome.words().into_iter().map(word).collect::<Result<_>>()?,
            cpus: self.cpus,
            memory_mib: self.memory.map(|bytes| bytes.div_ceil(1 << 20)),
            tries: self.tries,
        };
        let job = job.check()?;
        let fixed = ["perirobot", "sweep", job.study.text(), "--out", job.out.text()];
        let sweep = fixed.into_iter().chain(job.sweep_arguments.iter().map(VisibleWord::text));
        super::Cli::try_parse_from(sweep).map_err(|e| {
            let said = e.to_string();
            let first = said.lines().next().unwrap_or_default();
            Error::input("after `--`", first.trim_start_matches("error: "))
        })?;
        Ok(job)
    }
}

/// Where the running program is.
fn this_program() -> Result<VisibleWord> {
    let needed = "--program is needed here";
    let path = std::env::current_exe().map_err(|e| Error::input(needed, e.to_string()))?;
    let word = path.to_str().ok_or(Issue::says("is no text")).and_then(str::parse);
    word.map_err(|e: Issue| e.with_place(Site::Subject(path.display().to_string())).with_place(needed).into())
}
