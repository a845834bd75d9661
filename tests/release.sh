#!/bin/sh
# Builds what a release page offers for Linux on x86-64, and tries it: the program in an archive, a wheel for every Python
# from 3.9 on, an sdist, checksums. Program and wheel need glibc 2.28 and no compiler; they load Vulkan at run time.
#
#     sh tests/release.sh [--old-debian] [FOLDER]
#
# FOLDER (target/dist by default) gets the files when all checks have passed. --old-debian, as root, also tries program and
# wheel in Debian 11 (glibc 2.31, Python 3.9), which debootstrap installs into a temporary folder.
set -eu
cd "$(dirname "$0")/.."

triple=x86_64-unknown-linux-gnu
glibc=2.28
debian=bullseye

fail() {
    printf 'release: %s\n' "$1" >&2
    exit 2
}
step() { printf '\n== %s (after %s s)\n' "$1" "$(($(date +%s) - started))"; }
started=$(date +%s)

old_debian= out=
for argument; do
    case $argument in
        --old-debian) old_debian=yes ;;
        -*) fail "unknown flag $argument; expected --old-debian" ;;
        *) out=$argument ;;
    esac
done

# What must be installed, and the Debian package that has it.
need() { command -v "$1" >/dev/null 2>&1 || fail "$1 is missing: install $2"; }
need cargo "Rust (https://rustup.rs)"
need git git
need python3 python3
need objdump binutils
need setsid util-linux
need sha256sum coreutils
python3 -c 'import ensurepip, venv' 2>/dev/null || fail "Python's venv is missing: install python3-venv"
need tar tar
rustc -vV | grep -q "^host: $triple$" || fail "this script builds for $triple and must run there"
if [ "$old_debian" ]; then
    need debootstrap debootstrap
    [ "$(id -u)" = 0 ] || fail "--old-debian must run as root"
fi
git rev-parse --verify --quiet HEAD >/dev/null || fail "not a git clone: dates of files are those of the commit"
[ -z "$(git status --porcelain)" ] || fail "the clone has changes: commit or remove them (git status)"

metadata=$(cargo metadata --locked --no-deps --format-version 1)
target=$(printf %s "$metadata" | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
version=$(sed -n '/^\[workspace.package\]/,/^\[package\]/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
if [ -z "$out" ]; then
    out=$target/dist
    rm -rf "$out"
elif [ -n "$(ls -A "$out" 2>/dev/null)" ]; then
    fail "$out is not empty: name another folder"
fi
mkdir -p "$out" "$target"
out=$(cd "$out" && pwd)
work=$(mktemp -d "$target/release-XXXXXX")
notices=src/python/licences/LICENSE-THIRD-PARTY

# Each long command is in a process group, which ends with the script.
group=
run() {
    setsid "$@" &
    group=$!
    status=0
    wait "$group" || status=$?
    group=
    return "$status"
}
finish() {
    code=$?
    trap '' INT TERM HUP
    if [ "$group" ]; then
        kill -s TERM -- "-$group" 2>/dev/null || true
        for _ in 1 2 3 4 5; do
            kill -s 0 -- "-$group" 2>/dev/null || break
            sleep 1
        done
        kill -s KILL -- "-$group" 2>/dev/null || true
    fi
    # debootstrap mounts this.
    if [ -d "$work/$debian/proc" ]; then umount -l "$work/$debian/proc" 2>/dev/null || true; umount -l "$work/$debian/sys" 2>/dev/null || true; fi
    rm -rf --one-file-system "$work" "$notices"
    exit "$code"
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

step tools
# Zig is the linker: it has the symbols of old glibc versions. rustc passes flags for a C compiler because its name ends in cc.
wanted='abi3audit==0.0.26 auditwheel==6.8.2 cargo-zigbuild==0.24.0 maturin==1.16.0 ziglang==0.17.1'
tools=$target/release-tools
if [ "$(cat "$tools/wanted" 2>/dev/null)" != "$wanted" ]; then
    rm -rf "$tools"
    run python3 -m venv "$tools"
    # shellcheck disable=SC2086
    run "$tools/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: $wanted
    echo "$wanted" >"$tools/wanted"
fi
cat >"$tools/zigcc" <<END
#!/bin/sh
exec "$tools/bin/cargo-zigbuild" zig cc -- -g -fno-sanitize=all -target x86_64-linux-gnu.$glibc "\$@"
END
chmod +x "$tools/zigcc"

# No dates of today and no paths of this machine in what is built.
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
cargo_home=${CARGO_HOME:-$HOME/.cargo}
flags="--remap-path-prefix=$cargo_home=cargo$(printf '\037')--remap-path-prefix=$target=target"
export SOURCE_DATE_EPOCH
export CARGO_TARGET_DIR="$target" CARGO_INCREMENTAL=0
export CARGO_ENCODED_RUSTFLAGS="$flags"
export CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_LINKER="$tools/zigcc"
export CARGO_ZIGBUILD_ZIG_COMMAND="$tools/bin/python3" CARGO_ZIGBUILD_ZIG_COMMAND_ARGS='-m ziglang'
export CARGO_ZIGBUILD_CACHE_DIR="$tools/cache" ZIG_GLOBAL_CACHE_DIR="$tools/zig"
umask 022

step "wheel and sdist"
run python3 tests/release/notices.py "$notices" "$triple"
run "$tools/bin/maturin" build --profile release --locked --target "$triple" --compatibility "manylinux_$(echo $glibc | tr . _)" \
    --manifest-path src/python/Cargo.toml --out "$work/dist"
run "$tools/bin/maturin" sdist --manifest-path src/python/Cargo.toml --out "$work/dist"
wheel=$(ls "$work"/dist/*.whl)

step program
# Both packages are named so that dependencies have the features that they have in the wheel, and are not compiled again.
run cargo build --release --locked --target "$triple" -p perirobot -p perirobot-python --bin perirobot
name=perirobot-$version-x86_64-linux
run python3 tests/release/archive.py "$target/$triple/release/perirobot" "$notices" "$name" "$work/dist"
(cd "$work/dist" && sha256sum -- * >"$work/SHA256SUMS" && mv "$work/SHA256SUMS" .)

step "what they need of a system"
# Nothing but glibc: no version of it after $glibc, no Vulkan, no compiler's library.
check_library() {
    newest=$(objdump -T "$1" | grep -o 'GLIBC_[0-9.]*' | sed s/GLIBC_// | sort -uV | tail -1)
    printf '%s: glibc %s, %s bytes\n' "${1##*/}" "$newest" "$(wc -c <"$1")"
    [ -n "$newest" ] || fail "${1##*/} has no symbols of glibc"
    [ "$(printf '%s\n' "$newest" "$glibc" | sort -V | tail -1)" = "$glibc" ] || fail "${1##*/} needs glibc $newest"
    others=$(objdump -p "$1" | sed -n 's/^ *NEEDED *//p' | grep -vxE 'lib(c|m|dl|pthread|rt)\.so\.[0-9]+|ld-linux-x86-64\.so\.2' || true)
    [ -z "$others" ] || fail "${1##*/} needs $others"
    # Paths of this machine would make the bytes differ from one folder to another.
    if grep -qF -e "$cargo_home" -e "$target" -- "$1"; then fail "${1##*/} contains paths of this machine"; fi
}
python3 -m zipfile -e "$wheel" "$work/wheel"
check_library "$target/$triple/release/perirobot"
check_library "$work/wheel/perirobot/_perirobot.abi3.so"
"$tools/bin/auditwheel" show "$wheel" >"$work/auditwheel"
tr '\n' ' ' <"$work/auditwheel" | grep -q 'constrains the platform tag to "manylinux_2_28_x86_64"' || {
    cat "$work/auditwheel"
    fail "auditwheel expects another tag"
}
run "$tools/bin/abi3audit" --strict "$wheel"

# The README's first result, by the program and by the wheel, in folders where no compiler is on the path.
result=$(grep -m1 '^  camera  .* EUR ' README.md) || fail "README.md has no first result"
check_result() { grep -qxF -- "$result" "$1" || fail "$2 does not print the README's first result: see $(cat "$1")"; }

step "a fresh folder and a fresh virtual environment"
mkdir "$work/fresh"
tar -xzf "$work/dist/$name.tar.gz" -C "$work/fresh"
(cd "$work/fresh/$name" && env -i HOME="$work/fresh" PATH= ./perirobot choose scenes/cheapest.toml --backend cpu --out "$work/fresh/program") \
    >"$work/printed" 2>&1 || fail "the program fails: $(cat "$work/printed")"
check_result "$work/printed" "the program"
run python3 -m venv "$work/venv"
from=$(date +%s%N)
run env PATH="$work/venv/bin" pip install --quiet --disable-pip-version-check --only-binary=:all: "$wheel"
installed=$(date +%s%N)
PATH="$work/venv/bin" perirobot choose scenes/cheapest.toml --backend cpu --out "$work/fresh/wheel" >"$work/printed" 2>&1 ||
    fail "the wheel's command fails: $(cat "$work/printed")"
printf 'pip install: %s ms; from there to the first result: %s ms\n' $(((installed - from) / 1000000)) $((($(date +%s%N) - installed) / 1000000))
check_result "$work/printed" "the wheel's command"
(cd "$work/fresh" && "$work/venv/bin/perirobot" init first && "$work/venv/bin/perirobot" sweep first/study.toml --backend cpu --out first/out) \
    >"$work/printed" 2>&1 || fail "a first study fails: $(cat "$work/printed")"

if [ "$old_debian" ]; then
    step "Debian $debian"
    root=$work/$debian
    run debootstrap --variant=minbase --include=python3-venv "$debian" "$root" >"$work/debootstrap.log" 2>&1 ||
        fail "debootstrap fails: $(tail -3 "$work/debootstrap.log")"
    mkdir "$root/release"
    cp -r "$work/dist/." "$root/release/"
    # pip in there needs no network: what the wheel depends on is put beside it.
    run "$work/venv/bin/pip" download --quiet --disable-pip-version-check --only-binary=:all: --python-version 3.9 \
        --platform manylinux_2_28_x86_64 --platform manylinux2014_x86_64 --dest "$root/release" "$wheel"
    cat >"$root/release/try" <<'END'
set -eu
cd /release
tar -xzf perirobot-*-x86_64-linux.tar.gz
cd perirobot-*-x86_64-linux
ldd --version | head -1
python3 --version
for compiler in cc gcc cargo; do if command -v $compiler; then exit 1; fi; done
./perirobot choose scenes/choose.toml --backend cpu --out /tmp/program
python3 -m venv /tmp/venv
/tmp/venv/bin/pip install --quiet --disable-pip-version-check --no-index --find-links /release perirobot
/tmp/venv/bin/perirobot choose scenes/choose.toml --backend cpu --out /tmp/wheel
cmp /tmp/program/sets.csv /tmp/wheel/sets.csv
END
    run chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp sh /release/try >"$work/printed" 2>&1 ||
        fail "in Debian $debian: $(cat "$work/printed")"
    check_result "$work/printed" "Debian $debian"
    grep -m1 GLIBC "$work/printed"
else
    printf '\nNot tried in an older Debian: --old-debian does that.\n'
fi

step "crates"
# Everything that crates.io would check, and each package compiled from what would be uploaded.
unset CARGO_ENCODED_RUSTFLAGS CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_LINKER
rm -f "$notices"
export CARGO_PROFILE_DEV_OPT_LEVEL=0 CARGO_PROFILE_DEV_DEBUG=false
# In a folder of its own: Cargo neither unpacks nor compiles a version again that it knows from another state of these
# sources.
run cargo publish --workspace --dry-run --locked --target-dir "$work/crates"

mv "$work"/dist/* "$out/"
step "done: $out"
(cd "$out" && sha256sum --check --quiet SHA256SUMS && ls -l)
