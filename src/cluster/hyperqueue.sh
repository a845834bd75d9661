
# What the journal of this task's shard holds.
rows() { { cksum <"$out/shard-$HQ_TASK_ID-of-$shards/counts.journal"; } 2>/dev/null || true; }

submit() {
    if [ ! -f "$0" ]; then
        echo "save this script in a file and run that: the tasks run it, too" >&2
        exit 2
    fi
    mkdir -p "$out/logs"
    tasks=0-$((shards - 1))
    tried=0
    while :; do
        job=$(submit_array "$tasks")
        echo "job $job sweeps shards $tasks of $shards; logs are in $out/logs"
        hq job wait "$job" || true
        tasks=$(hq job task-ids "$job" --filter=failed)
        [ -n "$tasks" ] || break
        if [ "$tried" -ge "$tries" ]; then
            echo "shards $tasks failed again; gave up after $tries more tries" >&2
            break
        fi
        tried=$((tried + 1))
    done
    merge
}

# A sweep that was stopped goes on at once, as long as each start adds rows; what fails is for HyperQueue to see.
shard() {
    exec >>"$out/logs/shard-$HQ_TASK_ID.out" 2>&1
    unset SLURM_ARRAY_TASK_ID JOB_COMPLETION_INDEX # where a worker is itself a task: not the number of this shard
    while :; do
        before=$(rows)
        (sweep) && exit 0 || code=$?
        if [ "$code" -ne 75 ] || [ "$(rows)" = "$before" ]; then exit "$code"; fi
    done
}

case ${1-submit} in
    submit) submit ;;
    shard) shard ;;
    merge) merge ;;
esac
