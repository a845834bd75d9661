#!/bin/sh
# Installs on Debian and Ubuntu what tests need. Without arguments this is what `tests/run.sh` needs. If nothing can
# be installed, each missing tool is named in one line, with the package that has it.
#
#   vulkan    software Vulkan (lavapipe), so that the shaders run without a GPU
#   python    an interpreter with venv: pandas and numpy read what is written; also for the Python package
#   octomap   OctoMap's own tools, which read the maps
#   compiler  a C compiler, for the Vulkan layer of tests/sweep/lost_device.rs
#   browser   Chromium and its driver, for tests/documents/browser.rs; Chromium also contains SwiftShader
#   engines   Slurm and munge; from PyPI HyperQueue's engine and Kubernetes' schemas, into target/engines
#             (or PERIROBOT_ENGINES_VENV)
#   debian    debootstrap, by which tests/release.sh tries an older Debian
set -eu
cd "$(dirname "$0")/.."

lacks() {
    case $1 in
    vulkan) ! ls /usr/share/vulkan/icd.d/lvp_icd*.json >/dev/null 2>&1 || ! ls /usr/lib/*/libvulkan.so.1 >/dev/null 2>&1 ;;
    python) ! python3 -c 'import ensurepip, venv' >/dev/null 2>&1 ;;
    octomap) ! command -v convert_octree >/dev/null 2>&1 ;;
    compiler) ! command -v cc >/dev/null 2>&1 ;;
    browser) ! command -v chromium >/dev/null 2>&1 || ! command -v chromedriver >/dev/null 2>&1 ;;
    engines) ! { command -v slurmctld && command -v slurmd && command -v sbatch && command -v munged && command -v ps; } >/dev/null 2>&1 ;;
    debian) ! command -v debootstrap >/dev/null 2>&1 ;;
    *)
        echo "tests/install.sh: unknown tool $1; expected one of: vulkan python octomap compiler browser engines debian" >&2
        exit 2
        ;;
    esac
}
packages() {
    case $1 in
    vulkan) echo mesa-vulkan-drivers libvulkan1 ;;
    python) echo python3 python3-venv ;;
    octomap) echo octomap-tools ;;
    compiler) echo gcc libc6-dev ;;
    browser) echo chromium chromium-driver fonts-dejavu-core ;;
    engines) echo slurm-wlm munge procps ;;
    debian) echo debootstrap ;;
    esac
}

[ $# -gt 0 ] || set -- vulkan python octomap compiler
wanted=
for tool; do
    if lacks "$tool"; then wanted="$wanted $(packages "$tool")"; fi
done
if [ -n "$wanted" ] && command -v apt-get >/dev/null 2>&1; then
    if [ "$(id -u)" = 0 ]; then as_root=; else as_root='sudo -n'; fi
    export DEBIAN_FRONTEND=noninteractive
    # shellcheck disable=SC2086
    { $as_root apt-get update -qq && $as_root apt-get install -y -qq --no-install-recommends $wanted; } >&2 || true
fi
missing=
for tool; do
    if lacks "$tool"; then
        echo "missing: $tool; install the Debian packages $(packages "$tool"), or what corresponds to them" >&2
        missing=1
    fi
done
[ -z "$missing" ] || exit 1

for tool; do
    if [ "$tool" = engines ]; then
        venv=${PERIROBOT_ENGINES_VENV:-target/engines}
        wanted='hyperqueue==0.27.0 kubernetes-validate==1.37.0 PyYAML==6.0.3'
        if [ "$(cat "$venv/wanted" 2>/dev/null)" != "$wanted" ]; then
            rm -rf "$venv"
            python3 -m venv "$venv"
            # shellcheck disable=SC2086
            "$venv/bin/pip" install --quiet --disable-pip-version-check $wanted
            echo "$wanted" >"$venv/wanted"
        fi
    fi
done
