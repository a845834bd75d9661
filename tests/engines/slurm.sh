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
options=(--backend cpu --voxel-size "${VOXEL_SIZE:-0.2}" --memory 1MiB)
whole "$study" "${options[@]}"

start_slurm
"$program" cluster slurm "$study" --shards 4 --out "$scratch/shards" --script "$scratch/job.sh" -- "${options[@]}"
submit "$scratch/job.sh"
hold "$scratch/shards" 4

say "shard 0: kill -9 of all that runs it, the node's daemon, too, which comes back; Slurm puts the task back"
script=$(ps -o ppid= -p "${held[0]}")
keeper=$(ps -o ppid= -p "$((script))")
kill -9 "$((keeper))" "$((script))" "${held[0]}" "$(<"$slurm/slurmd.pid")"
sleep 8 # until Slurm believes it, see slurm.conf
slurmd

say "shard 1: kill -9 of the program; the script puts the task back"
kill -9 "${held[1]}"

say "shard 2: USR1 to the script, as Slurm sends it before the time limit"
scancel --signal=USR1 --batch "${job}_2"
resume 2

say "shard 3: put back by hand, as when the node is wanted for something else"
scontrol requeue "${job}_3"
resume 3

within 300 "all jobs end" all_ended
for shard in 0 1 2 3; do
    say "shard $shard: put back $(restarts "$shard") times"
    (($(restarts "$shard") >= 1)) || fail "shard $shard was not put back"
done
equal "$scratch/whole" "$scratch/shards"
say "$(sinfo --version): 4 shards, each disturbed in another way; same bytes"
