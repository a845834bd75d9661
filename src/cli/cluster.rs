//! `perirobot cluster`: a sweep as a script for the workload manager of a cluster.

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
/// The cluster's workload manager does the work: the script assigns each shard to one task, a stopped task resumes, and
/// at the end the shards are merged into the results of a single run, byte for byte. Nothing is submitted before you
/// run the script. Arguments after `--` are passed to `perirobot sweep`.
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

Each engine's --help describes how stopped and failed tasks resume.")]
pub(super) struct Args {
    #[command(subcommand)]
    engine: Engine,
}

#[derive(Subcommand)]
enum Engine {
    /// A shell script: an array job of Slurm, and the merge as a dependent job
    ///
    /// `sh FILE` submits both and returns. A task that runs out of time, loses its node or fails is requeued and
    /// resumes; bad input and wrong counts end it for good, since another try would not help. When all tasks have
    /// ended, the merge writes the tables into --out, or its log names the incomplete shards: run `sh FILE` again to
    /// finish them. Logs are in OUT/logs.
    Slurm {
        #[command(flatten)]
        job: JobArgs,
        /// Path of the program on the nodes [default: this program's path]
        #[arg(long, value_name = "PATH")]
        program: Option<VisibleWord>,
        /// Time limit of a task before it is requeued [default: the partition's limit]
        #[arg(long, value_name = "MINUTES")]
        time_limit: Option<u32>,
        /// The most tasks of an array job (MaxArraySize in `scontrol show config`)
        #[arg(long, value_name = "N", default_value_t = slurm::MAX_ARRAY_SIZE)]
        max_array_size: u32,
    },
    /// A shell script: an array of HyperQueue's tasks, then the merge
    ///
    /// `sh FILE` submits the tasks, waits for them, and merges. A stopped task resumes at once; failed tasks are
    /// submitted again, at most --tries times. If shards are still incomplete, the merge names them: run `sh FILE`
    /// again to finish them. Logs are in OUT/logs.
    Hyperqueue {
        #[command(flatten)]
        job: JobArgs,
        /// Path of the program on the nodes [default: this program's path]
        #[arg(long, value_name = "PATH")]
        program: Option<VisibleWord>,
    },
    /// A manifest: an Indexed Job of Kubernetes, and the merge as a second Job
    ///
    /// All paths are those in the container, so the study is not read here. A stopped pod is replaced by one that
    /// resumes; a failed pod also, at most --tries times; bad input and wrong counts end the Job. Start the merge by
    /// hand when all pods have ended; the first lines of the manifest describe how.
    Kubernetes {
        #[command(flatten)]
        job: JobArgs,
        /// Path of the program in the image
        #[arg(long, value_name = "PATH", default_value = "perirobot")]
        program: VisibleWord,
        /// The container image
        #[arg(long)]
        image: VisibleWord,
        /// The volume claim with the study; the results go there, too
        #[arg(long)]
        claim: VisibleWord,
        /// Mount point of the volume; relative paths start there
        #[arg(long, value_name = "PATH", default_value = "/data")]
        mount: VisibleWord,
        /// The most pods at a time [default: all]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
        parallelism: Option<u32>,
    },
}

#[derive(clap::Args)]
struct JobArgs {
    /// The study file (TOML)
    study: VisibleWord,
    /// The number of shards: that of simultaneous tasks, or a few times that
    #[arg(long, value_name = "N")]
    shards: u32,
    /// Folder for the results, shared by all nodes [default: out/ and the study's name]
    #[arg(long, value_name = "DIR")]
    out: Option<VisibleWord>,
    /// The job's name [default: perirobot- and the study's name]
    #[arg(long)]
    name: Option<VisibleWord>,
    /// Processors of each task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    cpus: u16,
    /// Memory of each task, a number and KiB, MiB or GiB [default: the workload manager's]
    #[arg(long, value_name = "BYTES", value_parser = super::quantity::bytes)]
    memory: Option<u64>,
    /// How often a failed shard is tried again; a stopped shard with new rows always resumes
    #[arg(long, value_name = "N", default_value_t = 5)]
    tries: u32,
    /// Write the script to this file instead of standard output
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    #[command(flatten)]
    outcome: OutcomeArgs,
    /// Further arguments of `perirobot sweep`, as in -- --backend cpu --memory 1GiB
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
    /// The job for machines that share files with this one, so that the study can be read.
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
                "--shards {}: {} has only {choices} choices of poses: write {choices} or less",
                self.shards, self.study
            ))
            .into());
        }
        Ok(job)
    }

    /// The job from the arguments alone.
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
            let message = e.to_string();
            let first = message.lines().next().unwrap_or_default();
            Error::input("after `--`", first.trim_start_matches("error: "))
        })?;
        Ok(job)
    }
}

/// Path of the running program.
fn this_program() -> Result<VisibleWord> {
    let needed = "--program is needed here";
    let path = std::env::current_exe().map_err(|e| Error::input(needed, e.to_string()))?;
    let word = path.to_str().ok_or(Issue::says("is not valid text")).and_then(str::parse);
    word.map_err(|e: Issue| e.with_place(Site::Subject(path.display().to_string())).with_place(needed).into())
}
