//! The script for HyperQueue: an array of tasks, one for each shard, submitted again as long as some fail, then the merge.
//! What it does when a task is stopped or fails is in `hyperqueue.sh`.

use super::{Job, shell_head};

/// The script.
pub fn script(job: &Job) -> String {
    let Job { name, study, out, shards, cpus, tries, .. } = job;
    let head = format!(
        "#!/bin/sh\n\
         # Sweeps {study} in {shards} shards through HyperQueue and merges them into {out}.\n\
         # Save it in a file and run that where hq is and its server is known, in the folder its paths start from:\n\
         # sh FILE. It returns when all is merged. Run it again to go on with what is missing.\n"
    );
    let memory = job.memory_mib.map(|mib| format!(" --resource=mem={mib}")).unwrap_or_default();
    let submit = format!(
        "submit_array() {{ hq submit --output-mode=quiet --name={name} --array=\"$1\" --cpus={cpus}{memory} \
         --crash-limit={tries} --stdout=none --stderr=none -- /bin/sh \"$0\" shard; }}\n"
    );
    [&head, &shell_head(job), &submit, include_str!("hyperqueue.sh")].concat()
}
