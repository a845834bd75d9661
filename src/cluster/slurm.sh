
# What the journal of this task's shard holds.
rows() { { cksum <"$out/shard-$SLURM_ARRAY_TASK_ID-of-$shards/counts.journal"; } 2>/dev/null || true; }

submit() {
    if [ ! -f "$0" ]; then
        echo "save this script in a file and run that: Slurm takes a copy of it" >&2
        exit 2
    fi
    most=$(scontrol show config | sed -n 's/^MaxArraySize *= *//p')
    if [ "$shards" -gt "${most:-$shards}" ]; then
        echo "$shards shards: an array job has at most $most tasks here; write the script with --shards $most" >&2
        exit 2
    fi
    mkdir -p "$out/logs"
    array=$(submit_array)
    array=${array%%;*}
    merge=$(submit_merge "$array")
    echo "job $array sweeps in $shards tasks, then job ${merge%%;*} merges; logs are in $out/logs"
}

shard() {
    before=$(rows)
    ended=
    task=
    trap 'woken=1; kill -USR1 "$task" 2>/dev/null || :' USR1
    trap 'woken=1; ended=1' TERM # which Slurm sends to the sweep, too
    sweep &
    task=$!
    while :; do
        woken=
        wait "$task" && code=0 || code=$?
        [ -n "$woken" ] || break # else a signal ended the waiting, not the task
    done
    # Whoever sends TERM decides what becomes of the task: Slurm puts back what it preempts, not what is cancelled.
    if [ -n "$ended" ]; then exit "$code"; fi
    case $code in
        0 | 1 | 2) exit "$code" ;; # done, or nothing that another try would change
    esac
    if [ "$(rows)" != "$before" ] || [ "${SLURM_RESTART_COUNT:-0}" -lt "$tries" ]; then
        echo "shard $SLURM_ARRAY_TASK_ID ended with code $code: back into the queue" >&2
        # Not SLURM_JOB_ID: for one of the tasks that is the number of the whole array, and all would be put back.
        scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
    else
        echo "shard $SLURM_ARRAY_TASK_ID ended with code $code: no new rows, and tried again $tries times already" >&2
    fi
    exit "$code"
}

case ${1-submit} in
    submit) submit ;;
    shard) shard ;;
    merge) merge ;;
esac
