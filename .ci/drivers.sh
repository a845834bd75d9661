#!/bin/sh
# Every shipped study on every software Vulkan driver: at least 200 poses of each a driver, in the batches that a sweep makes,
# every count held against the oracle's; other poses every day. SwiftShader, which Chromium brings, takes seconds for a camera:
# it gets the paper's experiments in turn, one a day. `sh .ci/drivers.sh all` does all poses of exp1 on both drivers.
set -eu
cd "$(dirname "$0")/.."
# What the tests were built with, unless another is named.
perirobot=${PERIROBOT:-target/debug/perirobot}
day=$(($(date +%s) / 86400))
lavapipe=$(ls /usr/share/vulkan/icd.d/lvp_icd*.json)
swiftshader=/usr/lib/chromium/vk_swiftshader_icd.json
small='scenes/tiny.toml scenes/quick.toml scenes/sensors.toml scenes/tutorial/study.toml scenes/paper/lidar.toml'
large='scenes/paper/exp1.toml scenes/paper/exp2.toml scenes/paper/exp3.toml'
verify() {
    driver=$1 study=$2
    shift 2
    printf '\n%s on %s\n' "$study" "$driver"
    VK_ICD_FILENAMES=$driver "$perirobot" verify-backends "$study" --backend gpu --adapter software --counts "$@"
}
if [ "${1:-}" = all ]; then
    for driver in "$lavapipe" "$swiftshader"; do verify "$driver" scenes/paper/exp1.toml --all; done
    exit
fi
for study in $small; do verify "$lavapipe" "$study" --poses 200 --turn "$day"; done
for study in $large; do verify "$lavapipe" "$study" --poses 70 --turn "$day"; done
today=$(echo $large | cut -d' ' -f$((day % 3 + 1)))
for study in $small; do verify "$swiftshader" "$study" --poses 200 --turn "$day"; done
verify "$swiftshader" "$today" --poses 70 --turn "$day"
