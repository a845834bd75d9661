#!/bin/sh
# Installs what the tests need on Debian or Ubuntu (software Vulkan, so that the shaders run without a GPU), then runs
# every test. Without it, `cargo test` alone is enough where a Vulkan adapter exists.
set -eu
cd "$(dirname "$0")/.."
if ! ls /usr/share/vulkan/icd.d/lvp_icd*.json >/dev/null 2>&1 || ! ldconfig -p | grep -q libvulkan.so.1; then
    as_root=$(command -v sudo || true)
    $as_root apt-get update -qq
    $as_root apt-get install -y -qq mesa-vulkan-drivers libvulkan1
fi
cargo test --locked --all-targets "$@"
cargo test --locked --doc
