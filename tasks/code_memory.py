"""Versions of code that were found before: to find them anew, all sources are parsed, which takes seconds."""

import hashlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Final

from storage.sealed import sealed, unsealed

ROOT: Final = Path(__file__).resolve().parents[1]

OURS: Final = ("tasks", "storage")
"""Packages whose code a stage may reach."""


@dataclass(slots=True)
class _Memory:
    """Versions by the name of the function, all of the same sources."""

    sources: str
    versions: dict[str, str] = field(default_factory=dict)
    grown: bool = False


_present: list[_Memory] = []
"""The memory in use: at most one."""


@contextmanager
def remembered_versions(file: Path, libraries: Iterable[str]) -> Iterator[None]:
    """Take versions from a file as long as the block lasts, and put new ones there; inside another, that one serves.

    They hold for the same sources, byte by byte, the same libraries and the same Python only; otherwise the file is as
    good as empty. So is one that cannot be read or written: it saves time, and nothing else.

    Parameters
    ----------
    file : path
        Where they are kept, as JSON.
    libraries : texts
        Libraries that count, with their versions.
    """
    if _present:
        yield
        return
    memory = _read(file, _digest_of_sources(tuple(libraries), sources_read()))
    _present.append(memory)
    try:
        yield
    finally:
        _present.remove(memory)
        # a source that was edited meanwhile may be in versions that were found of the old one
        if memory.grown and _sources_now() == sources_read():
            _write(file, memory)


def remembered(function: Callable[..., object], find: Callable[[], str]) -> str:
    """The version of a function: from the memory in use if it is known there, or else what ``find`` gives."""
    if not _present or function.__module__.split(".")[0] not in OURS:
        return find()
    memory, name = _present[0], f"{function.__module__}.{function.__qualname__}"
    if name not in memory.versions:
        memory.versions[name] = find()
        memory.grown = True
    return memory.versions[name]


@cache
def sources_read() -> str:
    """Digest of all sources as they were when this process first asked; to be asked before any is parsed.

    What a process found of them once it keeps, and so what it puts down must be put down for these.
    """
    return _sources_now()


def _digest_of_sources(libraries: Iterable[str], sources: str) -> str:
    return hashlib.sha256("\n".join([sys.version, *libraries, sources]).encode()).hexdigest()


def _sources_now() -> str:
    digest = hashlib.sha256()
    for package in OURS:
        for path in sorted((ROOT / package).rglob("*.py")):
            content = path.read_bytes()
            digest.update(f"\n{path.relative_to(ROOT).as_posix()} {len(content)}\n".encode() + content)
    return digest.hexdigest()


def _read(file: Path, sources: str) -> _Memory:
    try:
        # a flipped bit in a version would make every key another one
        content = json.loads(unsealed(file.read_bytes()) or b"")
        if content["sources"] == sources:
            return _Memory(sources, {str(name): str(known) for name, known in content["versions"].items()})
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    return _Memory(sources)


def _write(file: Path, memory: _Memory) -> None:
    temp = file.with_name(f".{file.name}.{os.getpid()}")
    with suppress(OSError):
        file.parent.mkdir(exist_ok=True)  # a workspace whose drive is gone is not made anew for it
        text = json.dumps({"sources": memory.sources, "versions": memory.versions})
        temp.write_bytes(sealed(text.encode()))
        temp.replace(file)
