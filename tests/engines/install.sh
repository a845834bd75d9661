#!/bin/sh
# Installs what the tests of the engines need on Debian: Slurm and munge, and from PyPI HyperQueue's engine and Kubernetes'
# schemas, the latter into target/engines (or PERIROBOT_ENGINES_VENV).
set -eu
cd "$(dirname "$0")/../.."
venv=${PERIROBOT_ENGINES_VENV:-target/engines}
missing=
for command in slurmctld slurmd sbatch munged ps python3; do
    command -v "$command" >/dev/null || missing="$missing $command"
done
python3 -c 'import ensurepip' 2>/dev/null || missing="$missing python3-venv"
if [ -n "$missing" ]; then
    if [ "$(id -u)" = 0 ]; then as_root=; else as_root=sudo; fi
    export DEBIAN_FRONTEND=noninteractive
    $as_root apt-get update -qq
    $as_root apt-get install -y -qq --no-install-recommends slurm-wlm munge procps python3 python3-venv
fi
wanted='hyperqueue==0.27.0 kubernetes-validate==1.37.0 PyYAML==6.0.3'
if [ "$(cat "$venv/wanted" 2>/dev/null)" != "$wanted" ]; then
    rm -rf "$venv"
    python3 -m venv "$venv"
    # shellcheck disable=SC2086
    "$venv/bin/pip" install --quiet $wanted
    echo "$wanted" >"$venv/wanted"
fi
