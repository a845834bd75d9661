#!/usr/bin/env bash
# Experiment 3 of the paper, whole and in 4 shards through Slurm with one task killed, and the bytes of both.
# Give options of `perirobot sweep` to change it: tests/engines/exp3.sh --voxel-size 0.025
set -euo pipefail
cd "$(dirname "$0")"
# shellcheck source=common.sh
. ./common.sh
# shellcheck source=slurm-here.sh
. ./slurm-here.sh
cd "$root"

study=scenes/paper/exp3.toml
options=("$@")
[[ $# -gt 0 ]] || options=(--voxel-size 0.02)
say "whole: perirobot sweep $study ${options[*]}"
"$program" sweep "$study" --out "$scratch/whole" "${options[@]}" | tail -n 2 | head -n 1 >&2

start_slurm
"$program" cluster slurm "$study" --shards 4 --out "$scratch/shards" --script "$scratch/job.sh" -- "${options[@]}"
submit "$scratch/job.sh"
within 300 "shard 1 has rows" has_rows "$scratch/shards" 1 4
sweep=$(sweeper "$scratch/shards" 1 4)
say "shard 1: kill -9 of process $sweep"
kill -9 "$sweep"
within 3600 "all jobs end" all_ended
say "Slurm put the tasks back: $(for shard in 0 1 2 3; do printf '%s: %s times; ' "$shard" "$(restarts "$shard")"; done)"
equal "$scratch/whole" "$scratch/shards"
say "same bytes: $(($(wc -l <"$scratch/whole/results.csv") - 1)) rows"
