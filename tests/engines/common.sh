# What the tests of the engines share: a scratch folder, waiting, comparing. Sourced by bash, after `set -euo pipefail`.
# shellcheck shell=bash disable=SC2034

engines=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$engines/../.." && pwd)
program=${PERIROBOT:-$root/target/release/perirobot}
# Its name is hard to quote, so that every run proves that the scripts do.
scratch=$(mktemp -d "${TMPDIR:-/tmp}/perirobot 50%a' \$(false).XXXXXX")
# Where install.sh puts what comes from PyPI.
venv=${PERIROBOT_ENGINES_VENV:-$root/target/engines}

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
        command -v "$command" >/dev/null || fail "$command is missing; tests/engines/install.sh installs it on Debian"
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

# has_rows OUT SHARD SHARDS: whether that shard has written rows, beyond the head of its journal.
has_rows() {
    local journal="$1/shard-$2-of-$3/counts.journal" now
    now=$({ cksum <"$journal"; } 2>/dev/null) || return 1
    [[ -e $scratch/first-$2 ]] || printf '%s' "$now" >"$scratch/first-$2"
    [[ $now != "$(<"$scratch/first-$2")" ]]
}

# sweeper OUT SHARD SHARDS: the process that has the journal of that shard open, and so holds its lock.
sweeper() {
    local journal link
    journal=$(realpath "$1/shard-$2-of-$3/counts.journal")
    for link in /proc/[0-9]*/fd/*; do
        if [[ $(readlink "$link") == "$journal" ]]; then
            link=${link#/proc/}
            echo "${link%%/*}"
            return
        fi
    done
    fail "no process has $journal open: the shard ended before it could be disturbed"
}

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
}

[[ -x $program ]] || fail "no program at $program: build it, or set PERIROBOT"
