//! The script for Slurm: an array job with a task for each shard, and the merge as the job that depends on
//! it. What it does when a task is stopped or fails is in `slurm.sh`.

use super::{Job, NOTICE_S, VisibleWord, shell_head};
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// Slurm's default of `MaxArraySize`.
pub(crate) const MAX_ARRAY_SIZE: u32 = 1001;

/// The least time limit in minutes: the sweep must have begun before it is told to stop, which Slurm may do a
/// minute early.
pub(crate) const LEAST_TIME_LIMIT_MIN: u32 = NOTICE_S / 60 + 3;

/// Settings for Slurm only.
#[derive(Clone, Debug)]
pub(crate) struct SlurmLimits {
    /// How long a task may run before it goes back into the queue, in minutes; the partition's own limit
    /// without.
    pub(crate) time_limit_min: Option<u32>,
    /// How many tasks an array job may have.
    pub(crate) max_array_size: u32,
}

/// The script; refuses more shards than an array job may have, and what Slurm cannot write in the name of a
/// log.
pub(crate) fn script(job: &Job, limits: &SlurmLimits) -> Result<String> {
    let Job { shards, study, out, .. } = job;
    let most = limits.max_array_size;
    if *shards > most {
        return Err(Issue::says(format!(
            "--shards {shards}: an array job of Slurm has at most {most} tasks, {most} shards do the same work; or \
             --max-array-size with what `scontrol show config` says of MaxArraySize"
        )).into());
    }
    if out.text().contains('\\') {
        return Err(
            Issue::says(format!("--out {out}: Slurm takes no backslash in the path of its logs")).into()
        );
    }
    if let Some(minutes) = limits.time_limit_min.filter(|minutes| *minutes < LEAST_TIME_LIMIT_MIN) {
        return Err(Issue::says(format!(
            "--time-limit {minutes}: must be at least {LEAST_TIME_LIMIT_MIN} minutes, as a task is told to stop \
             {NOTICE_S} s before its limit"
        )).into());
    }
    let head = format!(
        "#!/bin/sh\n\
         # Sweeps {study} in {shards} shards through Slurm and merges them into {out}.\n\
         # Save it in a file and run that where sbatch is, in the folder its paths start from: sh FILE\n\
         # It submits two jobs and returns: one with a task for each shard, and one that merges when all have ended.\n\
         # A task that is stopped goes back into the queue and goes on where it was.\n\
         # If the merge's log says that something is missing: run this again; finished shards take a moment.\n\
         # Partition, account, GPUs: set SBATCH_PARTITION, SBATCH_ACCOUNT, SBATCH_GPUS and so on before (man sbatch).\n"
    );
    Ok([&head, &shell_head(job), &submissions(job, limits.time_limit_min), include_str!("slurm.sh")].concat())
}

/// The two calls of `sbatch`, as functions.
fn submissions(job: &Job, time_limit_min: Option<u32>) -> String {
    let Job { name, shards, cpus, .. } = job;
    let logs = format!("{}/logs", job.out.text().replace('%', "%%"));
    let log = |file: &str| VisibleWord::from_known(&format!("--output={logs}/{file}.out")).shell();
    let memory = job.memory_mib.map(|mib| format!(" --mem={mib}M")).unwrap_or_default();
    let time = time_limit_min.map(|minutes| format!(" --time={minutes}")).unwrap_or_default();
    let array = format!(
        "--parsable --job-name={name} --array=0-{} --cpus-per-task={cpus} --requeue --open-mode=append \
         --signal=B:USR1@{NOTICE_S} \\\n        {}{memory}{time}",
        shards - 1,
        log("shard-%a")
    );
    format!(
        "# USR1 comes {NOTICE_S} s before a task's time limit: time to finish its batch.\n\
         submit_array() {{\n    sbatch {array} \\\n        \"$0\" shard\n}}\n\
         # Also after tasks that failed: the merge tells what they lack.\n\
         submit_merge() {{\n    sbatch --parsable --job-name={name}-merge --dependency=\"afterany:$1\" \
         --open-mode=append \\\n        {}{memory} \\\n        \"$0\" merge\n}}\n",
        log("merge")
    )
}
