#!/bin/sh
# Builds a wheel of the Python package, installs it alone into an environment of its own, and sweeps. With `all`, the whole
# suite runs with that wheel, and a wheel is built from the sdist alone. Further arguments go to unittest. The profile is
# that of the tests, overflow checks included; our own code is optimised for the suite only, since a first sweep is short.
set -eu
cd "$(dirname "$0")/../.."
target=$(cargo metadata --locked --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
export CARGO_TARGET_DIR="$target" PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_QUIET=1
work="$target/python"
rm -rf "$work"
mkdir -p "$work"

python3 -m venv "$work/build"
"$work/build/bin/pip" install maturin==1.16.0
maturin="$work/build/bin/maturin"
[ "${1:-}" = all ] || export CARGO_PROFILE_DEV_OPT_LEVEL=0
"$maturin" build --locked --profile dev --auditwheel skip --manifest-path src/python/Cargo.toml --out "$work/wheel"

# Here pip installs what the package declares, and nothing else.
python3 -m venv "$work/bare"
"$work/bare/bin/pip" install "$work"/wheel/perirobot-*.whl
"$work/bare/bin/python" - <<'END'
import importlib.metadata
import perirobot
assert len(perirobot.Study.load("scenes/tiny.toml").sweep("cpu")) > 0
about = importlib.metadata.metadata("perirobot")
assert about["Version"] == perirobot.__version__ and about["Author"] and about.get_all("Classifier"), about
assert "pip install perirobot" in about.get_payload(), about
END
timeout 300 "$work/bare/bin/python" tests/python/processes.py fork cpu
"$work/bare/bin/perirobot" sweep scenes/tiny.toml --out "$work/out" >/dev/null
[ "${1:-}" = all ] || exit 0
shift

python3 -m venv "$work/full"
"$work/full/bin/pip" install --only-binary=:all: -r tests/python/requirements.txt
"$work/full/bin/pip" install --no-deps "$work"/wheel/perirobot-*.whl
"$work/full/bin/mypy" --strict --ignore-missing-imports src/python/perirobot
"$work/full/bin/python" -W error -W ignore::UserWarning -m unittest discover --start-directory tests/python "$@"

"$maturin" sdist --manifest-path src/python/Cargo.toml --out "$work/sdist"
# Files of an sdist are as old as its format says: Cargo would take what was compiled above for theirs.
tar -xzf "$work"/sdist/perirobot-*.tar.gz -C "$work/sdist"
find "$work/sdist" -type f -exec touch {} +
# The build calls `maturin` by that name. Our own code is not optimised: only that it builds is tested here.
PATH="$work/build/bin:$PATH" MATURIN_PEP517_ARGS="--profile dev --locked" CARGO_PROFILE_DEV_OPT_LEVEL=0 \
    "$work/build/bin/pip" wheel \
    --no-build-isolation --no-deps --wheel-dir "$work/from-sdist" "$work"/sdist/perirobot-*/
"$work/bare/bin/pip" install --force-reinstall --no-deps "$work"/from-sdist/perirobot-*.whl
"$work/bare/bin/perirobot" sweep scenes/tiny.toml --out "$work/out-sdist" >/dev/null
