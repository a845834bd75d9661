#!/usr/bin/env bash
# Checks the manifest against Kubernetes' own schemas, then runs the containers' commands here as its pods would: each with
# its index in its environment, one stopped and one killed and replaced; compares with one quiet run.
set -euo pipefail
cd "$(dirname "$0")"
# shellcheck source=common.sh
. ./common.sh
cd "$root"
"$venv/bin/python" -c 'import kubernetes_validate, yaml' ||
    fail "no kubernetes-validate in $venv; tests/install.sh engines installs it"

study="study's \$(HOME) \$\$.toml"
options=(--backend cpu --voxel-size "${VOXEL_SIZE:-0.2}" --memory 1MiB)
cp -r scenes/paper "$scratch/volume"
cp scenes/paper/exp3.toml "$scratch/volume/$study"
whole "$scratch/volume/$study" "${options[@]}"

"$program" cluster kubernetes "$study" --shards 3 --out "out \"x\"" --image example.org/perirobot:1 --claim cells \
    --mount "$scratch/volume" --program "$program" --cpus 1 --memory 1GiB --parallelism 2 \
    --script "$scratch/job.yaml" -- "${options[@]}"
"$venv/bin/python" "$engines/pods.py" "$scratch/job.yaml"
equal "$scratch/whole" "$scratch/volume/out \"x\""
say "Kubernetes: the manifest is as its schemas say, and its commands write the same bytes"
