#!/bin/sh
# Fuzzes every target, or those named, for PERIROBOT_FUZZ_S seconds each (60 by default), two at a time. Needs cargo-fuzz.
# What is found stays in out/fuzz/found, and ends this with status 1.
set -eu
cd "$(dirname "$0")/../.."
if ! cargo fuzz --version >/dev/null 2>&1; then
    echo "missing: cargo-fuzz; install it by: cargo install --locked cargo-fuzz" >&2
    exit 1
fi
[ $# -gt 0 ] || set -- $(sed -n '/^\[\[bin\]\]/{n;s/^name = "\(.*\)"$/\1/p}' tests/fuzz/Cargo.toml)
seconds=${PERIROBOT_FUZZ_S:-60}
target=$(cargo metadata --locked --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/fuzz
# The stable compiler instruments if this is set. There is no unsafe code of ours to sanitize.
export RUSTC_BOOTSTRAP=1
cargo fuzz build --fuzz-dir tests/fuzz --target-dir "$target" --sanitizer none
built=$(dirname "$(find "$target" -path '*/release/study' -type f | head -n 1)")
[ -x "$built/study" ] || { echo "no fuzz target was built" >&2; exit 1; }
mkdir -p out/fuzz/found
[ -d /dev/shm ] && export TMPDIR=/dev/shm
export built seconds
printf '%s\n' "$@" | xargs -P 2 -I NAME sh -euc '
    mkdir -p out/fuzz/NAME
    dictionary=tests/fuzz/dictionaries/NAME
    [ -f "$dictionary" ] && dictionary="-dict=$dictionary" || dictionary=
    if "$built/NAME" out/fuzz/NAME tests/fuzz/corpus/NAME -max_total_time="$seconds" -timeout=10 -rss_limit_mb=3072 \
        -max_len=8192 -print_final_stats=1 -artifact_prefix=out/fuzz/found/NAME- $dictionary >out/fuzz/NAME.log 2>&1; then
        echo "NAME: $(sed -n "s/^stat::number_of_executed_units: *//p" out/fuzz/NAME.log) runs"
    else
        tail -n 40 out/fuzz/NAME.log
        echo "NAME: FOUND; see out/fuzz/NAME.log" >&2
        exit 1
    fi' || exit 1
