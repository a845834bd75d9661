# Sourced by the gate and the nightly: their environment, and steps that print their seconds. When the script ends,
# however it ends, the step that runs ends with it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export CARGO_TERM_COLOR=never CARGO_INCREMENTAL=0 XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-/tmp}"
export PERIROBOT_REQUIRE_GPU=1 PERIROBOT_REQUIRE_PYTHON=1 PERIROBOT_REQUIRE_OCTOMAP=1
# The authors' own scene is not part of the project. It is compared with if it is beside the checkout.
if [ -d ../shared/reference ]; then
    PERIROBOT_REFERENCE=$(cd ../shared/reference && pwd)
    export PERIROBOT_REFERENCE
fi

# need COMMAND HOW: ends the script if a command is missing.
need() {
    command -v "$1" >/dev/null 2>&1 && return
    echo "missing: $1; $2" >&2
    exit 1
}

need cargo "install Rust by rustup"
need python3 "install the Debian package python3"
target=$(cargo metadata --locked --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')

# Each background job gets a process group of its own.
set -m
job='' watcher='' table=''

# step NAME COMMAND...: runs a command, and ends the script if it fails.
step() {
    local name=$1 begin=$SECONDS status=0
    shift
    printf '\n== %s\n' "$name"
    "$@" </dev/null &
    job=$!
    # Ends the job's group if this script was killed and could not do so.
    (
        while kill -0 $$ 2>/dev/null; do sleep 1; done
        kill -TERM -- "-$job"
        sleep 30
        kill -KILL -- "-$job"
    ) >/dev/null 2>&1 &
    watcher=$!
    disown "$watcher"
    wait "$job" || status=$?
    # Children that it left behind.
    kill -KILL -- "-$job" 2>/dev/null || true
    job=''
    kill -KILL -- "-$watcher" 2>/dev/null || true
    watcher=''
    table+=$(printf '%6d s  %s' "$((SECONDS - begin))" "$name")$'\n'
    if [ "$status" != 0 ]; then
        printf '\n%s failed with status %s: %s\n' "$name" "$status" "$*" >&2
        exit "$status"
    fi
}

finish() {
    local status=$?
    trap - EXIT
    for group in "$job" "$watcher"; do
        [ -z "$group" ] || kill -TERM -- "-$group" 2>/dev/null || true
    done
    if [ -n "$job" ]; then
        for _ in {1..30}; do
            kill -0 -- "-$job" 2>/dev/null || break
            sleep 1
        done
        kill -KILL -- "-$job" 2>/dev/null || true
    fi
    printf '\n%s%6d s  in all\n' "$table" "$SECONDS"
    exit "$status"
}
trap finish EXIT
trap 'exit 129' HUP
trap 'exit 130' INT
trap 'exit 143' TERM
