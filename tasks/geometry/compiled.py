"""Compile a loop with numba, and keep what was compiled: the next process takes it as it is.

Numba knows a stored function by the file that it stands in alone; one that calls into another file would go on with the
old machine code after a change there. So what is compiled lies in a folder named by the digest of all compiled sources.
Where no folder can be written (a service that is shut in), functions are compiled anew in every process.
"""

import hashlib
import os
import stat
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

TASKS: Final = Path(__file__).resolve().parents[1]


def compiled(function: Function) -> Function:
    """Compile a function at its first call, without the lock of the interpreter."""
    made = numba.njit(cache=_FOLDER is not None, nogil=True)(function)
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
    for place in _places():
        folder = place / f"compiled-{digest_of_kernels()}"
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            trial = folder / f".trial-{os.getpid()}"
            trial.touch()
            trial.unlink()
        except OSError:
            continue
        if _is_ours(folder):
            return folder
    return None


def _is_ours(folder: Path) -> bool:
    if not hasattr(os, "getuid"):
        return True
    about = folder.stat()
    return about.st_uid == os.getuid() and not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


_FOLDER: Final = _folder()
if _FOLDER is not None:
    numba.config.CACHE_DIR = str(_FOLDER)  # type: ignore[attr-defined]
