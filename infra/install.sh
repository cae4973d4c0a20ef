#!/bin/sh
# Set up tiltwatch in .venv: the locked packages, the command, and the system libraries that open3d needs.
# Needs Python 3.11 or newer with venv and pip; uses root rights only if it has them and a library is missing.
# May be called again at any time: what is there stays, and a set-up that was interrupted is begun anew.
set -eu
cd "$(dirname "$0")/.."
here=$(pwd -P)
# inherited settings that would leave sources uncompiled or put packages elsewhere
unset PYTHONDONTWRITEBYTECODE PYTHONPATH PYTHONHOME 2>/dev/null || true
export PIP_USER=0 PIP_DISABLE_PIP_VERSION_CHECK=1
say() { printf '%s\n' "set-up: $*" >&2; }
die() { say "$*"; exit 1; }

# asked by running it: a name may be there (pyenv, the shop of Windows) and not run
fits() { "$1" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }

find_python() {
    if [ -n "${PYTHON:-}" ]; then
        fits "$PYTHON" || die "PYTHON=$PYTHON does not run, is older than 3.11, or has no venv (Debian: python3-venv)"
        printf '%s\n' "$PYTHON"
        return
    fi
    for candidate in python3 python3.13 python3.12 python3.11; do
        if fits "$candidate"; then
            printf '%s\n' "$candidate"
            return
        fi
    done
    die "no Python 3.11 or newer with venv found (Debian: apt-get install python3 python3-venv); \
if it lies elsewhere: make PYTHON=/path/to/python3.11"
}

# Only one set-up at a time. The mark stays behind when one is interrupted, and tells the next.
begin() {
    mkdir -p .venv
    if ! (set -C; echo $$ >.venv/unfinished) 2>/dev/null; then
        other=$(cat .venv/unfinished)
        if [ -n "$other" ] && kill -0 "$other" 2>/dev/null; then
            die "process $other sets up .venv at this moment; wait for it (if it is none of ours: make clean)"
        fi
        start_over "the last set-up was interrupted"
    elif [ "$(cat .venv/ready 2>/dev/null)" != "" ] && [ "$(cat .venv/ready)" != "$here" ]; then
        # the scripts in it name the old folder
        start_over "the checkout was moved"
    elif [ -e .venv/bin/python ] || [ -L .venv/bin/python ]; then
        if [ ! -e .venv/ready ] || ! .venv/bin/python -c 'import pip' >/dev/null 2>&1 || ! fits .venv/bin/python; then
            start_over ".venv is not whole"
        fi
    fi
}

start_over() {
    say "$1; making .venv anew"
    rm -rf .venv
    mkdir .venv
    echo $$ >.venv/unfinished
}

install_packages() {
    say "installing the locked packages (about 1.5 GB, by hash; the first time a minute)"
    # uv's own lines of the lock file: its version and hashes
    sed -n '/^uv==/,/[^\\]$/p' requirements.lock >.venv/uv.txt
    if .venv/bin/python -m pip install --quiet --require-hashes -r .venv/uv.txt 2>/dev/null &&
        .venv/bin/uv pip install --quiet --python .venv/bin/python --require-hashes --compile-bytecode \
            -r requirements.lock; then
        return
    fi
    # pip knows settings of its own: mirrors and certificates of a company, for one
    say "uv cannot do it here; pip does the same more slowly"
    .venv/bin/python -m pip install --quiet --require-hashes -r requirements.lock ||
        die "the locked packages cannot be installed: no network, or none are made for this machine; \
there are some for Linux with glibc 2.35 or newer (Debian 12, Ubuntu 22.04), for Windows on x86-64 and for macOS on Apple silicon"
}

load_open3d() {
    .venv/bin/python -c 'from tasks.simulation.raycasting import import_open3d; import_open3d()' 2>&1
}

provide_libraries() {
    if problem=$(load_open3d); then
        return
    fi
    packages="libusb-1.0-0 libegl1 libgl1 libx11-6 libudev1 libidn2-0 libgomp1"
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        say "open3d lacks system libraries; installing $packages"
        if apt-get update -qq >/dev/null &&
            DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages >/dev/null &&
            problem=$(load_open3d); then
            return
        fi
    fi
    say "open3d does not load: $(printf '%s' "$problem" | tail -n 1)"
    say "without it there is no simulation, so no demo; as root: apt-get install $packages"
}

begin
# one that fails by itself leaves what it found: offline the old .venv still serves
trap 'rm -f .venv/unfinished' EXIT
if [ ! -x .venv/bin/python ]; then
    python=$(find_python)
    say "making .venv with $("$python" -V)"
    "$python" -m venv .venv || die "python's venv module failed"
fi
install_packages
.venv/bin/python -m pip install --quiet --no-deps --no-build-isolation -e .
.venv/bin/python -m compileall -q flows tasks storage
provide_libraries
say "compiling the numeric loops, once (half a minute)"
.venv/bin/python -m flows.compile_kernels || true
printf '%s\n' "$here" >.venv/ready
say "ready"
