//! `perirobot cluster`: a sweep as a script for what a cluster already runs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use perirobot::cluster::{Job, Word, hyperqueue, kubernetes, label, slurm};
use perirobot::study::{Overrides, Study};
use perirobot::sweep::files::write_whole;
use perirobot::{Error, Result};

/// Write a script that runs a sweep in shards on a cluster and merges them
///
/// The script gives each shard to a task of the cluster's own engine, lets it go on when it is stopped, and merges the
/// shards into what one run would have written. What follows `--` is handed to `perirobot sweep`.
#[derive(clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    engine: Engine,
}

#[derive(Subcommand)]
enum Engine {
    /// A shell script: an array job of Slurm, and the merge as the job that depends on it
    Slurm {
        #[command(flatten)]
        job: JobArgs,
        /// Where the program is on the nodes [default: where this one is]
        #[arg(long, value_name = "PATH")]
        program: Option<Word>,
        /// How long a task may run before it goes back into the queue [default: the partition's limit]
        #[arg(long, value_name = "MINUTES")]
        time_limit: Option<u32>,
        /// How many tasks an array job may have (MaxArraySize in `scontrol show config`)
        #[arg(long, value_name = "N", default_value_t = slurm::MAX_ARRAY_SIZE)]
        max_array_size: u32,
    },
    /// A shell script: an array of HyperQueue's tasks, then the merge
    Hyperqueue {
        #[command(flatten)]
        job: JobArgs,
        /// Where the program is on the nodes [default: where this one is]
        #[arg(long, value_name = "PATH")]
        program: Option<Word>,
    },
    /// A manifest: an Indexed Job of Kubernetes, and the merge as a second Job. Paths are those in the container
    Kubernetes {
        #[command(flatten)]
        job: JobArgs,
        /// The program in the image
        #[arg(long, value_name = "PATH", default_value = "perirobot")]
        program: Word,
        /// The container image
        #[arg(long)]
        image: Word,
        /// The volume claim with the study, which takes the results
        #[arg(long)]
        claim: Word,
        /// Where the volume is mounted; relative paths start there
        #[arg(long, value_name = "PATH", default_value = "/data")]
        mount: Word,
        /// How many pods run at a time [default: all]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
        parallelism: Option<u32>,
    },
}

#[derive(clap::Args)]
struct JobArgs {
    /// The study file (TOML)
    study: Word,
    /// How many shards
    #[arg(long, value_name = "N")]
    shards: u32,
    /// Folder for the results, seen by all tasks [default: out/ and the study's name]
    #[arg(long, value_name = "DIR")]
    out: Option<Word>,
    /// What the engine calls it [default: perirobot- and the study's name]
    #[arg(long)]
    name: Option<Word>,
    /// Processors of each task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    cpus: u16,
    /// Memory of each task, a number and KiB, MiB or GiB [default: the engine's]
    #[arg(long, value_name = "BYTES", value_parser = super::quantity::bytes)]
    memory: Option<u64>,
    /// How often a shard that fails is tried again; one that is stopped and has new rows goes on in any case
    #[arg(long, value_name = "N", default_value_t = 5)]
    tries: u32,
    /// Write the script there instead of to standard output
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    /// What `perirobot sweep` is told besides
    #[arg(last = true)]
    sweep_arguments: Vec<Word>,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let (given, text) = match &args.engine {
        Engine::Slurm { job: given, program, time_limit, max_array_size } => {
            let job = given.job_here(program)?;
            let limits = slurm::Limits { time_limit_min: *time_limit, max_array_size: *max_array_size };
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
        Some(file) => write_whole(file, text.as_bytes())?,
        None => super::print(&text)?,
    }
    Ok(ExitCode::SUCCESS)
}

impl JobArgs {
    /// The job on machines that share their files with this one, so that the study can be looked at.
    fn job_here(&self, program: &Option<Word>) -> Result<Job> {
        let program = match program {
            Some(program) => program.clone(),
            None => this_program()?,
        };
        let job = self.job(program)?;
        let study = Study::load(Path::new(self.study.text()), &Overrides::default())?;
        let choices: usize = study.combinations.iter().map(|combination| combination.choices()).sum();
        if self.shards as usize > choices {
            return Err(Error::Input(format!(
                "--shards {}: {} has {choices} choices of poses, at most so many shards have work",
                self.shards, self.study
            )));
        }
        Ok(job)
    }

    /// The job, as far as its words tell.
    fn job(&self, program: Word) -> Result<Job> {
        let stem = Path::new(self.study.text()).file_stem().unwrap_or_default().to_string_lossy();
        let word = |text: String| text.parse::<Word>().map_err(|e| Error::input("STUDY", e));
        let job = Job {
            name: self.name.clone().map_or_else(|| word(label(&format!("perirobot-{stem}"))), Ok)?,
            program,
            study: self.study.clone(),
            out: self.out.clone().map_or_else(|| word(format!("out/{stem}")), Ok)?,
            shards: self.shards,
            sweep_arguments: self.sweep_arguments.clone(),
            cpus: self.cpus,
            memory_mib: self.memory.map(|bytes| bytes.div_ceil(1 << 20)),
            tries: self.tries,
        };
        let job = job.checked()?;
        let fixed = ["perirobot", "sweep", job.study.text(), "--out", job.out.text()];
        let sweep = fixed.into_iter().chain(job.sweep_arguments.iter().map(Word::text));
        super::Cli::try_parse_from(sweep).map_err(|e| {
            let said = e.to_string();
            let first = said.lines().next().unwrap_or_default();
            Error::input("after `--`", first.trim_start_matches("error: "))
        })?;
        Ok(job)
    }
}

/// Where the running program is.
fn this_program() -> Result<Word> {
    let path = std::env::current_exe().map_err(|e| Error::Input(format!("--program is needed here: {e}")))?;
    let text = path.to_str().ok_or("is no text".to_string()).and_then(str::parse);
    text.map_err(|e| Error::Input(format!("--program is needed here: {} {e}", path.display())))
}
