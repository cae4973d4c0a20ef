"""The note of what a publication is about to rename and remove, so that a crash can be rolled forward."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path, PurePosixPath
from typing import Final

from storage.atomic import TEMP_SUFFIX, clear_place, replace_file, sync_folder, write_atomically
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.workspace import Workspace

PUBLISHED: Final = ("tables", "seals")
"""Folders in which a publication renames and removes files."""


@dataclass(frozen=True, slots=True)
class Rename:
    """A finished temp that shall become a table's file; paths are relative to the workspace."""

    temp: str
    target: str
    sha256: str


@dataclass(frozen=True, slots=True)
class Journal:
    """All renames and removals of one publication."""

    structure: str
    epoch: str
    renames: tuple[Rename, ...]
    removals: tuple[str, ...]


def write_journal(ws: Workspace, journal: Journal) -> None:
    """Note a publication; from here on it will be finished, by whoever comes next if need be."""
    write_atomically(ws.journal, json.dumps(asdict(journal), indent=1).encode())


def read_journal(ws: Workspace) -> Journal | None:
    """The publication that was not finished; None if all were.

    Raises
    ------
    StorageError
        If the note is damaged.
    """
    try:
        content = json.loads(ws.journal.read_bytes())
        renames = tuple(Rename(**entry) for entry in content.pop("renames"))
        journal = Journal(renames=renames, removals=tuple(content.pop("removals")), **content)
        _check_places(journal)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as fault:
        raise StorageError(
            f"{ws.journal} is damaged, so an epoch may be published in part; delete the file and run the newest "
            "epochs again"
        ) from fault
    return journal


def _check_places(journal: Journal) -> None:
    """Let a journal name what a publication writes and nothing else: a workspace may come from others.

    Raises
    ------
    ValueError
        If a path leads elsewhere than to tables and seals.
    """
    temps = [rename.temp for rename in journal.renames]
    targets = [*(rename.target for rename in journal.renames), *journal.removals]
    for path in (*temps, *targets):
        parts = PurePosixPath(path).parts
        if (
            "/".join(parts) != path
            or len(parts) < 3
            or parts[0] not in PUBLISHED
            or ".." in parts
            or _is_odd(path)
        ):
            raise ValueError(f"{path!r} is no place of a publication")
    if not all(temp.endswith(TEMP_SUFFIX) for temp in temps):
        raise ValueError("a temp has another name")


def _is_odd(path: str) -> bool:
    """Whether Windows takes a path for another, or no system takes it."""
    return any(sign in path for sign in "\\:\0")


def remove_journal(ws: Workspace) -> None:
    """Strike the note: the publication is finished or given up."""
    ws.journal.unlink(missing_ok=True)
    sync_folder(ws.root)


def apply_rename(ws: Workspace, rename: Rename) -> None:
    """Do one rename; one that was done before the crash is left alone."""
    temp, target = ws.root / rename.temp, ws.root / rename.target
    if temp.exists():
        clear_place(target)
        replace_file(temp, target)
        sync_folder(target.parent)


def apply_removal(ws: Workspace, removal: str) -> None:
    """Do one removal; one that was done before the crash is left alone."""
    path = ws.root / removal
    clear_place(path)
    path.unlink(missing_ok=True)
    if path.parent.exists():
        sync_folder(path.parent)


def can_finish(ws: Workspace, journal: Journal) -> bool:
    """Whether every rename was done or can still be done with a whole temp."""
    return all(
        _has_digest(ws.root / rename.temp, rename.sha256)
        or _has_digest(ws.root / rename.target, rename.sha256)
        for rename in journal.renames
    )


def has_begun(ws: Workspace, journal: Journal) -> bool:
    """Whether a rename was done already: then the old epoch is no longer whole."""
    return any(
        not (ws.root / rename.temp).exists() and _has_digest(ws.root / rename.target, rename.sha256)
        for rename in journal.renames
    )


def _has_digest(path: Path, sha256: str) -> bool:
    return path.is_file() and file_sha256(path) == sha256
