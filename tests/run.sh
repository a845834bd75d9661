#!/bin/sh
# Installs what the tests need on Debian or Ubuntu (software Vulkan, so that the shaders run without a GPU; Python's venv,
# so that pandas and numpy read what is written; OctoMap's own tools, which read the maps), then runs every test. Without it,
# `cargo test` alone is enough where these exist.
set -eu
cd "$(dirname "$0")/.."
if [ "$(id -u)" = 0 ]; then as_root=; else as_root=sudo; fi
if ! ls /usr/share/vulkan/icd.d/*.json >/dev/null 2>&1 || ! ls /usr/lib/*/libvulkan.so.1 >/dev/null 2>&1; then
    $as_root apt-get update -qq
    $as_root apt-get install -y -qq mesa-vulkan-drivers libvulkan1
fi
if ! python3 -c 'import ensurepip, venv' >/dev/null 2>&1; then
    $as_root apt-get update -qq
    $as_root apt-get install -y -qq python3-venv
fi
if ! command -v convert_octree >/dev/null 2>&1; then
    $as_root apt-get update -qq
    $as_root apt-get install -y -qq octomap-tools
fi
# Mesa's device selection complains on standard error where no desktop session has set this.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-/tmp}"
cargo test --locked --all-targets "$@"
cargo test --locked --doc
