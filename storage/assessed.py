"""Structures that need not be assessed again: no epoch changed since what follows from all of them was made."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path

from storage.atomic import write_our_own
from storage.catalog_parts import stamps_of_structure
from storage.digests import file_sha256, text_sha256
from storage.ids import check_id
from storage.locks import publish_lock
from storage.sealed import sealed, unsealed
from storage.tables import EPOCH_TABLES, SERIES, SERIES_TABLES, table_path
from storage.workspace import Workspace


def basis_of(ws: Workspace, structure: str, inputs: str) -> str:
    """Digest of the published epochs of a structure, known by their stamps, and of what else the assessment rests on.

    To be taken with the publish lock, together with the catalog that the assessment reads.
    """
    return text_sha256(json.dumps([inputs, _stamps(ws, structure, EPOCH_TABLES)]))


def is_assessed(ws: Workspace, structure: str, basis: str) -> bool:
    """Whether what follows from all epochs was made of this basis, and its tables are as they were then."""
    path = _place(ws, structure)
    return path.is_file() and path.read_bytes() == _mark(ws, structure, basis)


def put_down_assessed(ws: Workspace, structure: str, basis: str) -> None:
    """Put down that what follows from all epochs was made of this basis just now.

    Raises
    ------
    StorageError
        If the disk refuses.
    InputError
        If the id cannot be a file name.
    """
    with publish_lock(ws):  # who holds it sweeps unfinished files away
        write_our_own(_place(ws, structure), _mark(ws, structure, basis))


def forget_assessed(ws: Workspace, structure: str) -> None:
    """Take the mark away before a series changes, so that no mark ever speaks of other series than were made with it."""
    _place(ws, structure).unlink(missing_ok=True)


def series_as_assessed(ws: Workspace, structure: str) -> Mapping[str, str | None] | None:
    """SHA-256 of each series as it was made; None where no mark tells: none yet, an old one, or a damaged one."""
    try:
        content = unsealed(_place(ws, structure).read_bytes())
    except OSError:
        return None
    return None if content is None else dict(json.loads(content)["series"])


def _mark(ws: Workspace, structure: str, basis: str) -> bytes:
    told = {"basis": basis, "series": _digests_of_series(ws, structure)}
    return sealed(json.dumps(told, sort_keys=True).encode() + b"\n")


def _digests_of_series(ws: Workspace, structure: str) -> Mapping[str, str | None]:
    """What the series hold: a few small files, in which a flipped bit does not show in their stamps."""
    paths = {table: table_path(ws, table, structure, SERIES) for table in SERIES_TABLES}
    return {table: file_sha256(path) if path.is_file() else None for table, path in paths.items()}


def _stamps(ws: Workspace, structure: str, tables: Iterable[str]) -> list[tuple[str, str]]:
    return sorted(stamps_of_structure(ws, structure, tables).items())


def _place(ws: Workspace, structure: str) -> Path:
    return ws.runs / "assessed" / f"{check_id(structure, 'a structure')}.txt"
