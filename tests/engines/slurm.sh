#!/usr/bin/env bash
# Sweeps a real study in 4 shards through a real Slurm, disturbs each shard in another way, and compares with one quiet run.
set -euo pipefail
cd "$(dirname "$0")"
# shellcheck source=common.sh
. ./common.sh
# shellcheck source=slurm-here.sh
. ./slurm-here.sh
cd "$root"

study=scenes/paper/exp3.toml
options=(--backend cpu --voxel-size "${VOXEL_SIZE:-0.05}" --memory 1MiB)
"$program" sweep "$study" --out "$scratch/whole" "${options[@]}" >/dev/null 2>&1

start_slurm
"$program" cluster slurm "$study" --shards 4 --out "$scratch/shards" --script "$scratch/job.sh" -- "${options[@]}"
submit "$scratch/job.sh"

for shard in 0 1 2 3; do
    within 120 "shard $shard has rows" has_rows "$scratch/shards" "$shard" 4
    sweep=$(sweeper "$scratch/shards" "$shard" 4)
    case $shard in
        0)
            say "shard 0: kill -9 of the program; the script puts the task back"
            kill -9 "$sweep"
            ;;
        1)
            say "shard 1: kill -9 of all that runs it, the node's daemon, too, which comes back; Slurm puts the task back"
            script=$(ps -o ppid= -p "$sweep")
            keeper=$(ps -o ppid= -p "$((script))")
            kill -9 "$((keeper))" "$((script))" "$sweep" "$(<"$slurm/slurmd.pid")"
            sleep 10
            slurmd
            ;;
        2)
            say "shard 2: USR1 to the script, as Slurm sends it before the time limit"
            scancel --signal=USR1 --batch "${job}_2"
            ;;
        3)
            say "shard 3: put back by hand, as when the node is wanted for something else"
            scontrol requeue "${job}_3"
            ;;
    esac
done

within 600 "all jobs end" all_ended
for shard in 0 1 2 3; do
    say "shard $shard: put back $(restarts "$shard") times"
    (($(restarts "$shard") >= 1)) || fail "shard $shard was not put back"
done
equal "$scratch/whole" "$scratch/shards"
say "Slurm $(sinfo --version): 4 shards, each disturbed in another way; same bytes"
