#!/bin/sh
# Builds the Python package as users get it, a wheel and an sdist, and tests each in an environment of its own: all tests
# with the wheel, and of the sdist that a wheel can be built of it alone. Both are built like the Rust tests, with overflow
# checks, and share what was compiled; of the sdist our own code is not optimised.
set -eu
cd "$(dirname "$0")/../.."
export MATURIN_PEP517_ARGS="--profile dev --locked"
target=$(cargo metadata --locked --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
export CARGO_TARGET_DIR="$target"
work="$target/python"
rm -rf "$work"
mkdir -p "$work"

python3 -m venv "$work/build"
"$work/build/bin/pip" install --quiet --disable-pip-version-check maturin==1.16.0
maturin="$work/build/bin/maturin"
"$maturin" build --locked --profile dev --auditwheel skip --manifest-path src/python/Cargo.toml --out "$work/wheel"
"$maturin" sdist --manifest-path src/python/Cargo.toml --out "$work/sdist"

# Here pip installs what the package says that it needs, and nothing else is there.
python3 -m venv "$work/bare"
"$work/bare/bin/pip" install --quiet --disable-pip-version-check "$work"/wheel/perirobot-*.whl
"$work/bare/bin/python" -c 'import perirobot; assert len(perirobot.Study.load("scenes/tiny.toml").sweep("cpu")) > 0'
"$work/bare/bin/perirobot" --version

python3 -m venv "$work/full"
"$work/full/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: -r tests/python/requirements.txt
"$work/full/bin/pip" install --quiet --disable-pip-version-check --no-deps "$work"/wheel/perirobot-*.whl
"$work/full/bin/mypy" --strict --ignore-missing-imports src/python/perirobot
"$work/full/bin/python" -W error -W ignore::UserWarning -m unittest discover --start-directory tests/python "$@"

# Files of an sdist are as old as its format says: Cargo would take what was compiled above for theirs.
tar -xzf "$work"/sdist/perirobot-*.tar.gz -C "$work/sdist"
find "$work/sdist" -type f -exec touch {} +
# Pip builds with the profile that pyproject.toml names. It must be in the sdist, and a panic must not end Python.
profile=$(sed -n 's/^profile = "\(.*\)"$/\1/p' src/python/pyproject.toml)
(cd "$work"/sdist/perirobot-*/ && cargo build --locked --verbose --profile "$profile" -p perirobot-shaders) >"$work/profile.log" 2>&1 || {
    cat "$work/profile.log"
    exit 1
}
grep -q -- '--crate-name perirobot_shaders' "$work/profile.log"
if grep -- 'panic=abort' "$work/profile.log"; then exit 1; fi
# The build calls `maturin` by that name.
PATH="$work/build/bin:$PATH" CARGO_PROFILE_DEV_OPT_LEVEL=0 "$work/build/bin/pip" wheel \
    --quiet --disable-pip-version-check --no-build-isolation --no-deps --wheel-dir "$work/from-sdist" "$work"/sdist/perirobot-*/
"$work/bare/bin/pip" install --quiet --disable-pip-version-check --force-reinstall --no-deps "$work"/from-sdist/perirobot-*.whl
"$work/bare/bin/perirobot" sweep scenes/tiny.toml --out "$work/out" >/dev/null
