# What the tests of the engines share: a scratch folder, waiting, holding, comparing. Sourced by bash, after
# `set -euo pipefail`.
# shellcheck shell=bash disable=SC2034

engines=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$engines/../.." && pwd)
program=${PERIROBOT:-$root/target/release/perirobot}
# `tests/install.sh engines` makes it.
venv=${PERIROBOT_ENGINES_VENV:-$root/target/engines}
# Its name is hard to quote, so that every run proves that the scripts do.
scratch=$(mktemp -d "${TMPDIR:-/tmp}/perirobot 50%a' \$(false).XXXXXX")

# What to do at the end, however it ends, last first; the scratch folder goes in any case.
at_end=()
finish() {
    local code=$? step
    trap - EXIT
    set +e
    for step in "${!held[@]}"; do resume "$step" 2>/dev/null; done
    for ((step = ${#at_end[@]} - 1; step >= 0; step--)); do "${at_end[step]}" "$code"; done
    rm -rf "$scratch"
    exit "$code"
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

say() { printf '%s\n' "$*" >&2; }

fail() {
    say "FAILED: $*"
    find "$scratch" -name '*.out' -exec tail -v -n 20 {} + >&2 || true
    exit 1
}

# need COMMAND...: fails where one is missing.
need() {
    local command
    for command in "$@"; do
        command -v "$command" >/dev/null || fail "$command is missing; tests/install.sh engines installs it on Debian"
    done
}

# within SECONDS WHAT COMMAND...: waits until the command succeeds.
within() {
    local limit=$((SECONDS + $1)) what=$2
    shift 2
    until "$@"; do
        ((SECONDS < limit)) || fail "waited in vain: $what"
        sleep 0.1
    done
}

# end PROCESS: asks it to end, and makes it after 10 s.
end() {
    kill "$1" 2>/dev/null || return 0
    for _ in {1..100}; do
        kill -0 "$1" 2>/dev/null || return 0
        sleep 0.1
    done
    kill -9 "$1"
}

# whole STUDY OPTION...: what a quiet run writes, to compare with.
whole() {
    local study=$1
    shift
    "$program" sweep "$study" --out "$scratch/whole" "$@" >"$scratch/whole.out" 2>&1 || fail "the quiet run: $?"
}

# has_rows OUT SHARD SHARDS: whether the journal of that shard has changed since it was first seen to have its head.
has_rows() {
    local journal="$1/shard-$2-of-$3/counts.journal" now
    [[ -s $journal ]] || return 1
    now=$(cksum <"$journal")
    [[ -e $scratch/first-$2 ]] || printf '%s' "$now" >"$scratch/first-$2"
    [[ $now != "$(<"$scratch/first-$2")" ]]
}

# sweeper OUT SHARD SHARDS: the process that has the journal of that shard open, and so holds its lock; none is a failure.
sweeper() {
    local journal found
    journal=$(realpath "$1/shard-$2-of-$3/counts.journal")
    found=$(find /proc/[0-9]*/fd -lname "$journal" -print -quit 2>/dev/null) || true
    found=${found#/proc/}
    [[ -n $found ]] && echo "${found%%/*}"
}

# hold OUT SHARDS: stops the clock for each shard's program as soon as it has its journal, and lets it run by and by until
# it has rows: however fast the machine is, all are then in the middle of their work. Their processes are in `held`;
# `resume SHARD` lets one go on.
held=()
hold() {
    local limit=$((SECONDS + 300)) shard process
    while ((${#held[@]} < $2)); do
        ((SECONDS < limit)) || fail "waited in vain for all shards: only ${!held[*]} began"
        for ((shard = 0; shard < $2; shard++)); do
            [[ -z ${held[shard]-} && -e $1/shard-$shard-of-$2/counts.journal ]] || continue
            process=$(sweeper "$1" "$shard" "$2") || continue
            kill -STOP "$process"
            held[shard]=$process
        done
        sleep 0.05
    done
    for shard in "${!held[@]}"; do
        until has_rows "$1" "$shard" "$2"; do
            ((SECONDS < limit)) || fail "waited in vain for rows of shard $shard"
            resume "$shard"
            sleep 0.05
            kill -STOP "${held[shard]}"
        done
    done
}
resume() { kill -CONT "${held[$1]}"; }

# equal ONE OTHER: fails unless the tables in both folders have the same bytes.
equal() {
    local table folder sum
    for table in results.csv scores.csv poses.csv; do
        for folder in "$1" "$2"; do
            sum=$(sha256sum <"$folder/$table") || fail "$folder has no $table"
            say "${sum%% *}  $(basename "$folder")/$table"
        done
        cmp "$1/$table" "$2/$table" || fail "$table differs"
    done
    say "same bytes: $(($(wc -l <"$1/results.csv") - 1)) rows"
}

[[ -x $program ]] || fail "no program at $program: build it, or set PERIROBOT"
