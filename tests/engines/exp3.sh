#!/usr/bin/env bash
# Experiment 3 of the paper, whole and in 4 shards through Slurm with one task killed, and the bytes of both. Give options
# of `perirobot sweep` to change it, as in: tests/engines/exp3.sh --voxel-size 0.02
set -euo pipefail
cd "$(dirname "$0")"
# shellcheck source=common.sh
. ./common.sh
# shellcheck source=slurm-here.sh
. ./slurm-here.sh
cd "$root"

study=scenes/paper/exp3.toml
options=("$@")
# Shards that share one machine's GPU would only wait for each other.
[[ $# -gt 0 ]] || options=(--backend cpu)
say "$("$program" --version), $(slurmctld -V), $(date --utc +%F)"
say "whole: perirobot sweep $study ${options[*]}"
whole "$study" "${options[@]}"
grep ' scene-poses in ' "$scratch/whole.out" >&2

start_slurm
"$program" cluster slurm "$study" --shards 4 --out "$scratch/shards" --script "$scratch/job.sh" -- "${options[@]}"
say "in shards: perirobot cluster slurm $study --shards 4 -- ${options[*]}"
submit "$scratch/job.sh"
within 300 "shard 1 has rows" has_rows "$scratch/shards" 1 4
sweep=$(sweeper "$scratch/shards" 1 4) || fail "shard 1 ended before it could be killed"
say "shard 1: kill -9 of process $sweep"
kill -9 "$sweep"
within 3600 "all jobs end" all_ended
for shard in 0 1 2 3; do
    say "shard $shard: put back $(restarts "$shard") times"
    grep -h ' scene-poses' "$scratch/shards/logs/shard-$shard.out" >&2
done
(($(restarts 1) == 1)) || fail "shard 1 was not put back"
equal "$scratch/whole" "$scratch/shards"
