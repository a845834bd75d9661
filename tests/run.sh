#!/bin/sh
# Installs what the tests need on Debian or Ubuntu (software Vulkan, so that the shaders run without a GPU), then runs
# every test. Without it, `cargo test` alone is enough where a Vulkan adapter exists.
set -eu
cd "$(dirname "$0")/.."
if ! ls /usr/share/vulkan/icd.d/*.json >/dev/null 2>&1 || ! ls /usr/lib/*/libvulkan.so.1 >/dev/null 2>&1; then
    if [ "$(id -u)" = 0 ]; then as_root=; else as_root=sudo; fi
    $as_root apt-get update -qq
    $as_root apt-get install -y -qq mesa-vulkan-drivers libvulkan1
fi
# Mesa's device selection complains on standard error where no desktop session has set this.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-/tmp}"
cargo test --locked --all-targets "$@"
cargo test --locked --doc
