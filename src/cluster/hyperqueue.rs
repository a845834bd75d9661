//! The script for HyperQueue: an array of tasks, one for each shard, submitted again as long as some fail,
//! then the merge. What it does when a task is stopped or fails is in `hyperqueue.sh`.

use super::{Job, shell_head};

/// The script.
pub(crate) fn script(job: &Job) -> String {
    let Job { name, study, out, shards, cpus, .. } = job;
    // To HyperQueue, 0 is no limit at all.
    let crashes = job.tries.max(1);
    let head = format!(
        "#!/bin/sh\n\
         # Sweeps {study} in {shards} shards through HyperQueue and merges them into {out}.\n\
         # Save it in a file and run that where hq is and its server is known, in the folder its paths start from:\n\
         # sh FILE. It returns when all is merged, or names what is missing; run it again to go on with that.\n"
    );
    let memory = job.memory_mib.map(|mib| format!(" --resource=mem={mib}")).unwrap_or_default();
    let submit = format!(
        "# The tasks write logs of their own, as a task that is tried again would overwrite what HyperQueue writes.\n\
         submit_array() {{\n    hq submit --output-mode=quiet --name={name} --array=\"$1\" --cpus={cpus}{memory} \
         --crash-limit={crashes} \\\n        --stdout=none --stderr=none -- /bin/sh \"$0\" shard\n}}\n"
    );
    [&head, &shell_head(job), &submit, include_str!("hyperqueue.sh")].concat()
}
