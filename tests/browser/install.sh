#!/bin/sh
# Installs what tests/documents/browser.rs needs on Debian: Chromium, its driver, and fonts to look at.
set -eu
if [ "$(id -u)" = 0 ]; then as_root=; else as_root=sudo; fi
if ! command -v chromium >/dev/null 2>&1 || ! command -v chromedriver >/dev/null 2>&1; then
    $as_root apt-get update -qq
    $as_root apt-get install -y -qq --no-install-recommends chromium chromium-driver fonts-dejavu-core python3
fi
