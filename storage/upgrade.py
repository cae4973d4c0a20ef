"""Bring a workspace of an earlier version up to this one: whoever opens it finds it ready."""

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

from storage.atomic import write_atomically
from storage.catalog import make_catalog, rebuild_catalog
from storage.catalog_reading import read_instead
from storage.catalog_sources import catalog_definitions
from storage.errors import StorageError
from storage.identity import SCHEMA_VERSION, note_catalog, read_identity, write_identity
from storage.locks import is_writable, publish_lock
from storage.parquet import encode_rows, read_rows
from storage.publish import recover
from storage.records import TABLES, EpochRow
from storage.tables import EPOCH_TABLES, EpochKey, epochs_on_disk, table_path
from storage.workspace import Workspace, existing_workspace, open_workspace


def ready_workspace(path: Path) -> Workspace:
    """Open a workspace that must be there; one of an earlier version is upgraded first.

    Raises
    ------
    StorageError
        If there is none, it is of a newer version, or it cannot be upgraded.
    """
    ws = existing_workspace(path)
    make_ready(ws)
    return ws


def ready_or_new_workspace(path: Path) -> Workspace:
    """Open a workspace, and make it if it is not there; one of an earlier version is upgraded first.

    Raises
    ------
    StorageError
        If the path is a file, cannot be written, is of a newer version, or cannot be upgraded.
    """
    ws = open_workspace(path)
    make_ready(ws)
    return ws


def make_ready(ws: Workspace) -> bool:
    """Upgrade tables and catalog to this version; True if anything had to be done.

    Results are not changed: tables that the earlier code did not know are there and empty, columns that it did not know
    are NULL, and the views are those of this version. Called again after an interruption it goes on. Of a workspace that
    cannot be written only this process gets a catalog of this version.

    Raises
    ------
    StorageError
        If a table is damaged, or the disk refuses.
    """
    identity = read_identity(ws.identity)
    definitions = catalog_definitions()
    if identity.schema_version == SCHEMA_VERSION and _has_catalog(ws, identity.catalog, definitions):
        return False
    if not is_writable(ws):
        _read_a_catalog_of_this_version(ws)
        return False
    try:
        with publish_lock(ws):
            recover(ws)
            for version in range(identity.schema_version, SCHEMA_VERSION):
                STEPS[version](ws)
                write_identity(ws.identity, replace(read_identity(ws.identity), schema_version=version + 1))
            if epochs_on_disk(ws):
                rebuild_catalog(ws)
                note_catalog(ws.identity, definitions)  # also where the catalog was as it should be
    except StorageError as fault:
        raise StorageError(
            f"workspace {ws.root} was last written by another version of tiltwatch and cannot be made ready for this one: "
            f"{fault}"
        ) from fault
    return True


def _read_a_catalog_of_this_version(ws: Workspace) -> None:
    """Make a catalog for this process alone, of a workspace that may be read and not written: a drive handed over."""
    if ws.root in _FOLDERS or not epochs_on_disk(ws):
        return
    folder = _FOLDERS[ws.root] = tempfile.TemporaryDirectory(prefix="tiltwatch-catalog-")
    place = Path(folder.name) / ws.catalog.name
    make_catalog(ws, place)
    read_instead(ws.catalog, place)


_FOLDERS: Final[dict[Path, "tempfile.TemporaryDirectory[str]"]] = {}
"""Where such catalogs lie; they go with the process."""


def _has_catalog(ws: Workspace, made_with: str | None, definitions: str) -> bool:
    """Whether the catalog has the views of this version, or there is nothing yet to make one of."""
    if made_with == definitions and ws.catalog.is_file():
        return True
    return not epochs_on_disk(ws)


def _fill_in_tables(ws: Workspace) -> None:
    """From 1 to 2: give every epoch the tables that its code did not know, empty.

    A table that another epoch of the same code has was lost and not unknown; it stays missing, and `verify` tells of it.
    """
    known: dict[str, set[str]] = {}
    epochs = [(key, _code_of(ws, key)) for key in epochs_on_disk(ws)]
    for key, code in epochs:
        there = {table for table in EPOCH_TABLES if table_path(ws, table, key.structure, key.epoch).exists()}
        known.setdefault(code, set()).update(there)
    for key, code in epochs:
        for table in _unknown_to(known[code]):
            write_atomically(
                table_path(ws, table, key.structure, key.epoch), encode_rows(table, TABLES[table], [])
            )


def _unknown_to(known: set[str]) -> Iterator[str]:
    yield from (table for table in EPOCH_TABLES if table not in known)


def _code_of(ws: Workspace, key: EpochKey) -> str:
    """Code that published an epoch; of one without a row that can be read nothing is known."""
    try:
        (row,) = read_rows(table_path(ws, "epochs", key.structure, key.epoch), "epochs", EpochRow)
    except (StorageError, ValueError):
        return f"unknown code of {key}"
    return row.code_version


STEPS: Final[Mapping[int, Callable[[Workspace], None]]] = {1: _fill_in_tables}
"""What leads from a version to the next; each may be done twice."""
