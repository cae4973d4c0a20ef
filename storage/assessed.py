"""Structures that need not be assessed again: no epoch changed since what follows from all of them was made."""

import json
from collections.abc import Iterable
from pathlib import Path

from storage.atomic import write_atomically
from storage.catalog_parts import stamps_of_structure
from storage.digests import text_sha256
from storage.ids import check_id
from storage.locks import publish_lock
from storage.tables import EPOCH_TABLES, SERIES_TABLES
from storage.workspace import Workspace


def basis_of(ws: Workspace, structure: str, inputs: str) -> str:
    """Digest of the published epochs of a structure, known by their stamps, and of what else the assessment rests on.

    To be taken with the publish lock, together with the catalog that the assessment reads.
    """
    return text_sha256(json.dumps([inputs, _stamps(ws, structure, EPOCH_TABLES)]))


def is_assessed(ws: Workspace, structure: str, basis: str) -> bool:
    """Whether what follows from all epochs was made of this basis, and its tables are as they were then."""
    path = _place(ws, structure)
    return path.is_file() and path.read_text(encoding="ascii") == _mark(ws, structure, basis)


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
        write_atomically(_place(ws, structure), _mark(ws, structure, basis).encode())


def _mark(ws: Workspace, structure: str, basis: str) -> str:
    return text_sha256(json.dumps([basis, _stamps(ws, structure, SERIES_TABLES)]))


def _stamps(ws: Workspace, structure: str, tables: Iterable[str]) -> list[tuple[str, str]]:
    return sorted(stamps_of_structure(ws, structure, tables).items())


def _place(ws: Workspace, structure: str) -> Path:
    return ws.runs / "assessed" / f"{check_id(structure, 'a structure')}.txt"
