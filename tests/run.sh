#!/bin/sh
# Runs every test but those marked `ignored`, after it installed what they need on Debian and Ubuntu. `cargo test` alone
# is enough where Vulkan, Python and OctoMap's tools exist. Arguments go to cargo.
set -eu
cd "$(dirname "$0")/.."
sh tests/install.sh
# Mesa's device selection complains on standard error where no desktop session has set this.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-/tmp}"
cargo test --locked --lib --bins --tests "$@"
cargo test --locked --doc
