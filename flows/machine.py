"""What a run needs of the machine, looked at one by one."""

import importlib
import importlib.metadata
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

OLDEST_PYTHON: Final = (3, 11)
LEAST_MEMORY_GB: Final = 1.5
LEAST_DISK_GB: Final = 2.0
FASTAPI_FIRST, FASTAPI_END = (0, 139), (0, 151)
"""prefect 3.8.8 does not start with a newer fastapi."""

PACKAGES: Final = (
    "cyclopts",
    "duckdb",
    "filelock",
    "laspy",
    "lazrs",
    "numpy",
    "prefect",
    "pyarrow",
    "pydantic",
    "rich",
    "scikit-image",
    "scipy",
)
OPEN3D: Final = ("open3d-cpu", "open3d")
OPEN3D_TIMEOUT_S: Final = 120.0
LOAD_OPEN3D: Final = "from tasks.open3d_import import import_open3d; import_open3d()"
REINSTALL: Final = "run `make setup` or install from requirements.lock"


@dataclass(frozen=True, slots=True)
class Finding:
    """What was looked at, what was found, and what to do; a hint stands in ``todo`` even where all is well."""

    name: str
    ok: bool
    found: str
    todo: str = ""


def examine_machine(workspace: Path | None) -> list[Finding]:
    """Look at everything that a run needs; a look that fails is a finding too."""
    place = _existing_parent(workspace or Path(tempfile.gettempdir()))
    looks: tuple[Callable[[], Finding], ...] = (
        _python,
        *(partial(_package, name) for name in PACKAGES),
        _fastapi,
        _open3d,
        _cores,
        _memory,
        lambda: _disk(place),
        lambda: _write_test(place),
        _bytecode,
        _time_zones,
    )
    return list(_findings(looks))


def _findings(looks: tuple[Callable[[], Finding], ...]) -> Iterator[Finding]:
    for look in looks:
        try:
            yield look()
        except Exception as error:
            name = getattr(look, "__name__", "package").strip("_")
            yield Finding(name, ok=False, found=f"{type(error).__name__}: {error}")


def _existing_parent(folder: Path) -> Path:
    here = folder.expanduser().absolute()
    return next(place for place in (here, *here.parents) if place.exists())


def _python() -> Finding:
    found = f"{platform.python_version()} on {platform.platform()}"
    ok = sys.version_info >= OLDEST_PYTHON
    return Finding("python", ok, found, "" if ok else "install Python 3.11 or newer")


def _package(name: str) -> Finding:
    version = _version(name)
    return Finding(name, version is not None, version or "missing", "" if version else REINSTALL)


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _fastapi() -> Finding:
    version = _version("fastapi")
    if version is None:
        return Finding("fastapi", ok=False, found="missing", todo=REINSTALL)
    major, minor, *_ = (int(part) for part in version.split(".")[:2])
    ok = FASTAPI_FIRST <= (major, minor) < FASTAPI_END
    wanted = "prefect 3.8 needs fastapi >= 0.139, < 0.151; install 'fastapi>=0.139,<0.151'"
    return Finding("fastapi", ok, version, "" if ok else wanted)


def _open3d() -> Finding:
    """Load open3d in a process of its own, the way the simulation does: a missing library may kill the process."""
    installed = [f"{name} {version}" for name in OPEN3D if (version := _version(name))]
    if not installed:
        return Finding(
            "open3d", ok=False, found="missing", todo=f"the simulation and demo need it; {REINSTALL}"
        )
    if len(installed) > 1:
        return Finding("open3d", ok=False, found=" and ".join(installed), todo="uninstall one of the two")
    loaded = subprocess.run(
        [sys.executable, "-c", LOAD_OPEN3D],
        capture_output=True,
        text=True,
        timeout=OPEN3D_TIMEOUT_S,
        check=False,
        cwd=Path(__file__).parents[1],
    )
    if loaded.returncode == 0:
        return Finding("open3d", ok=True, found=f"{installed[0]} loads")
    last = (loaded.stderr.strip().splitlines() or [f"exit code {loaded.returncode}"])[-1]
    todo = "install the system's libusb-1.0 (Debian: apt install libusb-1.0-0) or the package libusb-package"
    return Finding("open3d", ok=False, found=f"{installed[0]} does not load: {last}", todo=todo)


def _cores() -> Finding:
    return Finding("cores", ok=True, found=str(os.cpu_count() or 1))


def _memory() -> Finding:
    try:
        memory = importlib.import_module("psutil").virtual_memory()
    except ImportError:
        return Finding("memory", ok=True, found="unknown", todo=f"a run needs about {LEAST_MEMORY_GB:g} GB")
    total, free = memory.total / 1e9, memory.available / 1e9
    ok = free >= LEAST_MEMORY_GB
    todo = "" if ok else f"a run needs about {LEAST_MEMORY_GB:g} GB; close other programs"
    return Finding("memory", ok, f"{total:.1f} GB, {free:.1f} GB free", todo)


def _disk(place: Path) -> Finding:
    usage = shutil.disk_usage(place)
    ok = usage.free / 1e9 >= LEAST_DISK_GB
    todo = "" if ok else f"free {LEAST_DISK_GB:g} GB, or name another disk with --workspace"
    return Finding("disk", ok, f"{usage.free / 1e9:.1f} GB free at {place}", todo)


def _write_test(place: Path) -> Finding:
    """Write a file and move it over another, as every result is published."""
    try:
        with tempfile.TemporaryDirectory(dir=place, prefix="tiltwatch-doctor-") as folder:
            new, old = Path(folder) / "new", Path(folder) / "old"
            old.write_bytes(b"old")
            new.write_bytes(b"new")
            new.replace(old)
    except OSError as error:
        todo = "name a folder that you may write with --workspace"
        return Finding("write test", ok=False, found=f"{place}: {error.strerror}", todo=todo)
    return Finding("write test", ok=True, found=f"{place} can be written")


def _bytecode() -> Finding:
    if sys.dont_write_bytecode:
        todo = "every start compiles all sources again: unset PYTHONDONTWRITEBYTECODE"
        return Finding("bytecode", ok=True, found="not written", todo=todo)
    return Finding("bytecode", ok=True, found="written")


def _time_zones() -> Finding:
    try:
        ZoneInfo("Europe/Berlin")
    except ZoneInfoNotFoundError:
        return Finding("time zones", ok=False, found="no database", todo="install the package tzdata")
    return Finding("time zones", ok=True, found="database found")
