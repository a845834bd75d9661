#!/usr/bin/env bash
# Sweeps a real study in 4 shards through a real HyperQueue, stops one shard and kills another, and compares with one
# quiet run. The engine is the one in HyperQueue's wheel; that has no program `hq`, so hq.py takes its place.
set -euo pipefail
cd "$(dirname "$0")"
# shellcheck source=common.sh
. ./common.sh
cd "$root"
need python3
"$venv/bin/python" -c 'import hyperqueue' || fail "no hyperqueue in $venv; tests/install.sh engines installs it"

study=scenes/paper/exp3.toml
options=(--backend cpu --voxel-size "${VOXEL_SIZE:-0.2}" --memory 1MiB)
whole "$study" "${options[@]}"

mkdir "$scratch/bin"
printf '#!/bin/sh\nexec "%s" "%s" "$@"\n' "$venv/bin/python" "$engines/hq.py" >"$scratch/bin/hq"
chmod +x "$scratch/bin/hq"
export PATH="$scratch/bin:$PATH"
export HQ_SERVER_DIR="$scratch/server"
# Its sockets would stay in the common folder.
TMPDIR=$scratch hq server >"$scratch/server.out" 2>&1 &
server=$!
stop_server() { end "$server"; }
at_end+=(stop_server)
within 30 "the server answers" test -e "$HQ_SERVER_DIR/ready"

"$program" cluster hyperqueue "$study" --shards 4 --out "$scratch/shards" --script "$scratch/job.sh" -- "${options[@]}"
sh "$scratch/job.sh" >"$scratch/job.out" 2>&1 &
script=$!
stop_script() { end "$script"; }
at_end+=(stop_script)
hold "$scratch/shards" 4

say "shard 0: TERM to the program; the task goes on at once"
kill -TERM "${held[0]}"
say "shard 1: kill -9 of the program; the task fails, and is submitted again"
kill -9 "${held[1]}"
for shard in 0 2 3; do resume "$shard"; done

wait "$script" || fail "the script ended with $?"
grep '^job' "$scratch/job.out" >&2
[[ $(grep -c '^job' "$scratch/job.out") == 2 ]] || fail "not submitted twice"
grep -q '^job 2 sweeps shards 1 of 4' "$scratch/job.out" || fail "not shard 1 alone was submitted again"
grep -q '^stopped by SIGTERM' "$scratch/shards/logs/shard-0.out" || fail "shard 0 was not stopped"
equal "$scratch/whole" "$scratch/shards"
say "HyperQueue $("$venv/bin/python" -c 'import hyperqueue; print(hyperqueue.get_version())'): same bytes"
