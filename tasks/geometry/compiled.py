"""Compile a loop with numba, and keep what was compiled: the next process takes it as it is.

Numba knows a stored function by the file that it stands in alone; one that calls into another file would go on with the
old machine code after a change there. So what is compiled lies in a folder named by the digest of all compiled sources.
What was compiled at the set-up is copied from a tree that can only be read into one that can be written, since numba
needs that. Where there is no such place (a service that is shut in), each process has a copy of its own that ends with it;
where there is nothing to copy either, functions are compiled anew in every process.
"""

import atexit
import hashlib
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

TASKS: Final = Path(__file__).resolve().parents[1]

FOR_OTHERS: Final = stat.S_IXGRP | stat.S_IXOTH
"""A folder that others may enter."""


MADE: Final[list[Any]] = []
"""All compiled functions of the modules that were imported."""


def compiled(function: Function) -> Function:
    """Compile a function at its first call, without the lock of the interpreter."""
    made = numba.njit(cache=FOLDER is not None, nogil=True)(function)
    MADE.append(made)
    return cast("Function", made)


def digest_of_kernels() -> str:
    """Digest of the sources of all compiled functions, with the versions of what compiles them."""
    digest = hashlib.sha256(f"{sys.version} {numba.__version__}".encode())
    for path in sorted([*TASKS.rglob("*kernel.py"), *TASKS.rglob("*kernels.py"), Path(__file__)]):
        digest.update(f"\n{path.relative_to(TASKS).as_posix()}\n".encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def _places() -> Iterator[Path]:
    if named := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(named)
    yield TASKS / "__pycache__"
    caches = os.environ.get("XDG_CACHE_HOME") or (Path.home() / ".cache" if os.environ.get("HOME") else None)
    if caches:
        yield Path(caches) / "tiltwatch"


def _folder() -> Path | None:
    """The first place that can be written, and by nobody else: what lies there is run."""
    ready: Path | None = None
    for place in _places():
        folder = place / f"compiled-{digest_of_kernels()}"
        is_new = not folder.exists()
        if _can_write(folder):
            if not _is_safe(folder):
                continue
            if is_new and ready is not None:
                _copy(ready, folder)
            return folder
        if ready is None and _is_safe(folder):
            ready = folder
    return None if ready is None else _own_copy(ready)


def _can_write(folder: Path) -> bool:
    try:
        # numba makes the folders below as it is used to: where others could write them, they must not get so far
        folder.mkdir(mode=0o755 if _shuts_out_others() else 0o700, parents=True, exist_ok=True)
        trial = folder / f".trial-{os.getpid()}"
        trial.touch()
        trial.unlink()
    except OSError:
        return False
    return True


def _own_copy(ready: Path) -> Path | None:
    """A copy for this process alone; None where not even that can be had."""
    try:
        folder = Path(tempfile.mkdtemp(prefix="tiltwatch-compiled-"))
    except OSError:
        return None
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    _copy(ready, folder)
    return folder


def _copy(ready: Path, folder: Path) -> None:
    """Copy what is compiled, whole or not at all; what cannot be copied is compiled anew."""
    part = folder.with_name(f"{folder.name}.{os.getpid()}.part")
    with suppress(OSError, shutil.Error):
        shutil.copytree(ready, part)
        # the folder is empty still, or another process was faster
        part.rename(folder)
    shutil.rmtree(part, ignore_errors=True)


def _shuts_out_others() -> bool:
    """Whether files of this process can be written by nobody else unless it says so."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask & 0o022 == 0o022


def _is_safe(folder: Path) -> bool:
    """Whether a folder is there, is ours or the system's, and cannot be written by anybody else."""
    try:
        about = folder.stat()
    except OSError:
        return False
    if not hasattr(os, "getuid"):
        return True
    return _is_ours(about) and (not about.st_mode & FOR_OTHERS or all(map(_is_ours, _below(folder))))


def _is_ours(about: os.stat_result) -> bool:
    return about.st_uid in (0, os.getuid()) and not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _below(folder: Path) -> Iterator[os.stat_result]:
    """What is known of all folders and files below one that others may enter."""
    for path in folder.rglob("*"):
        with suppress(OSError):
            yield path.stat()


FOLDER: Final = _folder()
if FOLDER is not None:
    numba.config.CACHE_DIR = str(FOLDER)  # type: ignore[attr-defined]
