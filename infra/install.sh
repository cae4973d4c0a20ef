#!/bin/sh
# Set up tiltwatch in .venv: the locked packages, the command, and the system libraries that open3d needs.
# Needs Python 3.11 or newer with venv and pip; uses root rights only if it has them and a library is missing.
set -eu
cd "$(dirname "$0")/.."
say() { printf '%s\n' "set-up: $*" >&2; }
die() { say "$*"; exit 1; }

python=${PYTHON:-python3}
command -v "$python" >/dev/null 2>&1 || die "no '$python' found; install Python 3.11 or newer, or name it: make PYTHON=/path/to/python"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    die "'$python' is $("$python" -V 2>&1); Python 3.11 or newer is needed: make PYTHON=/path/to/python3.11"

if [ ! -x .venv/bin/python ]; then
    say "making .venv with $("$python" -V)"
    "$python" -m venv .venv || die "python's venv module failed; on Debian: apt-get install python3-venv"
fi

say "installing the locked packages (about 1.5 GB, by hash; the first time a minute)"
if .venv/bin/python -m pip install --quiet --disable-pip-version-check uv 2>/dev/null; then
    VIRTUAL_ENV="$PWD/.venv" .venv/bin/uv pip install --quiet --require-hashes --compile-bytecode -r requirements.lock
else
    say "uv cannot be had; pip does the same more slowly"
    .venv/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
fi
.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
.venv/bin/python -m compileall -q flows tasks storage

load='from tasks.simulation.raycasting import import_open3d; import_open3d()'
if ! problem=$(.venv/bin/python -c "$load" 2>&1); then
    packages="libusb-1.0-0 libegl1 libgl1 libx11-6 libudev1 libidn2-0 libgomp1"
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        say "open3d lacks system libraries; installing $packages"
        apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages >/dev/null
        .venv/bin/python -c "$load" || die "open3d still does not load"
    else
        say "open3d does not load: $(printf '%s' "$problem" | tail -n 1)"
        say "without it there is no simulation, so no demo; as root: apt-get install $packages"
    fi
fi
say "ready"
