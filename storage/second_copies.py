"""Small files that no run can make again are kept twice: second/<path in the workspace>, behind their own SHA-256.

They are the events of alarms with who acknowledged them, the ledger of runs, the epochs that came through an inbox, the
settings of runs, the manifests of earlier results, and what the workspace says of itself. Whichever of two copies is whole
mends the other.
"""

import errno
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from typing import Final, Literal

from storage.atomic import faults_of_the_system, write_our_own
from storage.digests import file_sha256, text_sha256
from storage.errors import StorageError
from storage.identity import identity_in
from storage.locks import publish_lock
from storage.parquet import read_rows
from storage.records import TABLES
from storage.sealed import sealed, unsealed
from storage.tables import ALARM_EVENTS, LEDGERS, RUNS
from storage.text_parts import PARTS, read_text
from storage.version_manifest import MANIFEST, manifest_in
from storage.workspace import Workspace

State = Literal["gone", "altered", "edited", "lost", "single", "second damaged"]
"""Gone or altered: the second copy is whole. Edited: by hand, and readable. Lost: neither is whole. Single, or second
damaged: the first is whole."""


@dataclass(frozen=True, slots=True)
class Discord:
    """A file and its second copy that are not both whole and the same."""

    path: Path
    state: State


@dataclass(frozen=True, slots=True)
class _Kind:
    """Files that are kept twice: where, and what tells whether one of them is whole."""

    pattern: str
    is_whole: Callable[[Path, Path], bool]
    """Whether a file holds what one at a path, the second argument, is to hold."""
    by_hand: bool = False
    """Whether people may edit them."""


def second_path(ws: Workspace, path: Path) -> Path:
    """Where the second copy of a file lies or would lie."""
    return ws.second / path.relative_to(ws.root)


def keep_second(ws: Workspace, path: Path) -> None:
    """Keep a file that was just written a second time.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    with publish_lock(ws):  # who holds it sweeps unfinished files away
        write_our_own(second_path(ws, path), sealed(path.read_bytes()))


def discords(ws: Workspace) -> Iterator[Discord]:
    """Files that are kept twice and are not both whole and the same, by kind and name."""
    for kind in _KINDS:
        first = set(ws.root.glob(kind.pattern))
        second = {ws.root / path.relative_to(ws.second) for path in ws.second.glob(kind.pattern)}
        for path in sorted(first | second):
            state = _state(ws, kind, path)
            if state is not None:
                yield Discord(path, state)


def _state(ws: Workspace, kind: _Kind, path: Path) -> State | None:
    first, stored = _content(path), _content(second_path(ws, path))
    if first is not None and stored is not None and stored == sealed(first):
        return None
    second = None if stored is None else unsealed(stored)
    if second is None or not _is_of(kind, path, second):
        if first is None or not _judged(kind, path, path):
            return "lost"
        return "single" if stored is None else "second damaged"
    if first is None:
        return "altered" if path.exists() else "gone"
    return "edited" if kind.by_hand and _judged(kind, path, path) else "altered"


def _is_of(kind: _Kind, path: Path, content: bytes) -> bool:
    """Whether a content is one of that path: the second copy of another file, under this name, would take its place."""
    with faults_of_the_system(Path(gettempdir())), TemporaryDirectory() as folder:
        file = Path(folder) / path.name
        file.write_bytes(content)
        return _judged(kind, file, path)


def _content(path: Path) -> bytes | None:
    """What a file holds; None where there is none.

    Raises
    ------
    StorageError
        If the system refuses to read it, which says nothing of what it holds.
    """
    try:
        return path.read_bytes()
    except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
        return None
    except OSError as fault:
        raise _refused(path, fault) from fault


def _refused(path: Path, fault: OSError) -> StorageError:
    return StorageError(
        f"cannot read {path}: {fault.strerror}; look at the drive and the rights of the file, and run again: it is kept "
        "twice and nothing of it was touched"
    )


def _judged(kind: _Kind, file: Path, path: Path) -> bool:
    """Whether a file holds what one of a kind at ``path`` is to hold; one that cannot be parsed does not.

    Raises
    ------
    StorageError
        If the system refuses to read it.
    """
    try:
        return kind.is_whole(file, path)
    except (OSError, ValueError, StorageError) as fault:
        behind = fault if isinstance(fault, OSError) else fault.__cause__
        # a library that cannot parse raises OSError, too, and without a number
        if isinstance(behind, OSError) and behind.errno not in (
            None,
            errno.ENOENT,
            errno.EISDIR,
            errno.ENOTDIR,
        ):
            raise _refused(path, behind) from fault
        return False


def _is_ledger(table: str) -> Callable[[Path, Path], bool]:
    column = LEDGERS[table]

    def is_whole(file: Path, path: Path) -> bool:
        rows: list[object] = read_rows(file, table, TABLES[table])
        named = {(getattr(row, "structure", ""), getattr(row, column)) for row in rows}
        return named <= {(path.parent.name, path.name.removesuffix(".parquet"))}

    return is_whole


def _is_intake(file: Path, path: Path) -> bool:
    return tomllib.loads(file.read_text(encoding="utf-8")).get("epoch") == path.stem


def _is_settings(file: Path, path: Path) -> bool:
    return text_sha256(read_text(file, path.parents[1] / PARTS)) == path.stem


def _is_part(file: Path, path: Path) -> bool:
    return file_sha256(file) == path.stem


def _is_manifest(file: Path, path: Path) -> bool:
    manifest_in(file.read_bytes(), path)
    return True


def _is_identity(file: Path, _path: Path) -> bool:
    identity_in(file.read_bytes())
    return True


_KINDS: Final = (
    _Kind("workspace.json", _is_identity),
    _Kind(f"tables/{ALARM_EVENTS}/*/*.parquet", _is_ledger(ALARM_EVENTS)),
    _Kind(f"tables/{RUNS}/*/*.parquet", _is_ledger(RUNS)),
    # parts first: settings are whole when theirs are
    _Kind(f"runs/{PARTS}/*.txt", _is_part),
    _Kind("runs/settings/*.json", _is_settings),
    _Kind(f"versions/*/*/[!.]*/{MANIFEST}", _is_manifest),
    _Kind("intake/*/*.toml", _is_intake, by_hand=True),
)
