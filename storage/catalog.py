"""The catalog: one DuckDB file that holds all rows and the views of the contract, made anew from the Parquet."""

import json
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import duckdb

from storage.atomic import (
    clear_place,
    faults_of_the_system,
    make_folder,
    replace_file,
    sync_file,
    sync_folder,
    temp_beside,
)
from storage.catalog_content import (
    copy_rows,
    create_table,
    create_view,
    fill_dictionary,
    read_rows_in,
    remove_rows,
)
from storage.catalog_damage import readable_stamps, why_unreadable
from storage.catalog_parts import CATALOG_TABLES, Part, part_of, stamps_of
from storage.catalog_reading import CLOSED, attach, read_catalog, shut_in
from storage.catalog_sources import Difference, Sources, difference_of, sources_of
from storage.errors import StorageError
from storage.identity import note_catalog
from storage.locks import publish_lock
from storage.publish import recover
from storage.view_definitions import VIEWS
from storage.workspace import Workspace

# a file of DuckDB 2's own default is refused by every 1.x client
STORAGE_VERSION: Final = "v1.0.0"

# rows that were replaced in a copy of a catalog leave holes: of more files than so many, or than this share of all,
# it is made anew
_FEW_FILES: Final = 1000
_MOST_REPLACED: Final = 0.25

_LITTLE_MB: Final = 100.0
"""With less free than this a catalog that cannot be made may have wanted room, megabytes."""


@dataclass(frozen=True, slots=True)
class _Stored:
    """What the present catalog was made of, and how many files were replaced in it since it was made anew."""

    sources: Sources
    replaced: int


def rebuild_catalog(ws: Workspace) -> bool:
    """Make the catalog anew from the tables and put it in place at once; readers keep what they have open.

    Rows of files that did not change are taken over from the old catalog: reading a thousand epochs takes long. An epoch
    with a damaged table is shown as the old catalog knew it, or else left out (``files_left_out``).

    Returns
    -------
    bool
        False if nothing changed since the last time; then nothing is written.

    Raises
    ------
    StorageError
        If the disk refuses, or (on Windows) a reader holds the old catalog open for long.
    """
    with publish_lock(ws):
        recover(ws)
        old, new = _stored(ws), sources_of(ws)
        if old is not None and old.sources == new:
            return False
        make_folder(ws.tmp)
        temp = temp_beside(ws.tmp / ws.catalog.name)
        try:
            _build_of_readable(ws, temp, old, new)
            sync_file(temp)
            _put_in_place(ws, temp)
        finally:
            _remove_database(temp)
        note_catalog(ws.identity, new.definitions)
    return True


def is_current(ws: Workspace) -> bool:
    """Whether the catalog can be read and was made of the tables as they are."""
    stored = _stored(ws)
    return stored is not None and stored.sources == sources_of(ws)


def is_behind(ws: Workspace) -> bool:
    """Whether the catalog is whole and its tables have changed since: whoever publishes brings it up to date afterwards."""
    stored = _stored(ws)
    return stored is not None and stored.sources != sources_of(ws)


def make_catalog(ws: Workspace, place: Path) -> None:
    """Make a catalog of the Parquet alone in a file that is not there yet; the one of the workspace stays as it is.

    Raises
    ------
    StorageError
        If a table is damaged, or the disk refuses.
    """
    with _faults_told(ws):
        _make(ws, place, None, sources_of(ws))


def files_left_out(ws: Workspace) -> dict[str, str | None]:
    """Files that the catalog does not show as they are, and why where it is the file; those beside it are whole."""
    stored = _stored(ws)
    known = {} if stored is None else stored.sources.stamps
    changed = [name for name, stamp in stamps_of(ws).items() if known.get(name) != stamp]
    return {name: why_unreadable(ws, name) for name in changed}


def _stored(ws: Workspace) -> _Stored | None:
    """What the present catalog was made of; None if there is no catalog that can be read."""
    try:
        with read_catalog(ws) as connection:
            row = connection.execute(
                "SELECT definitions, columns, stamps, replaced FROM data.made_of"
            ).fetchone()
    except (StorageError, duckdb.Error):
        return None
    return None if row is None else _Stored(Sources(row[0], json.loads(row[1]), json.loads(row[2])), row[3])


def _build_of_readable(ws: Workspace, temp: Path, old: _Stored | None, new: Sources) -> None:
    """Make the catalog; what is damaged must not keep the rest from being shown."""
    known = {} if old is None else old.sources.stamps
    for stamps in (known, {}):
        try:
            return _build(ws, temp, old, new)
        except StorageError:
            readable = replace(new, stamps=readable_stamps(ws, stamps, new.stamps))
            if readable == new:
                raise
            new = readable
            _remove_database(temp)
    return _build(ws, temp, old, new)


def _build(ws: Workspace, temp: Path, old: _Stored | None, new: Sources) -> None:
    """Make the catalog in the cheapest way; a damaged old one is found out only when its rows are taken."""
    try:
        if old is not None and _may_be_changed(old, new):
            _change_a_copy(ws, temp, old, new)
        else:
            _make(ws, temp, old, new)
    except duckdb.Error:
        _remove_database(temp)
        with _faults_told(ws):
            _make(ws, temp, None, new)


@contextmanager
def _faults_told(ws: Workspace) -> Iterator[None]:
    try:
        yield
    except duckdb.Error as fault:
        raise StorageError(
            f"cannot make {ws.catalog}: {str(fault).splitlines()[0]}; put that right (free space, a writable folder"
            f"{_room(ws)}) and run again; the old catalog stays as it is"
        ) from fault


def _room(ws: Workspace) -> str:
    """What is free on the drive, where that may be the fault: DuckDB does not always say so."""
    try:
        free_mb = shutil.disk_usage(ws.root).free / 1e6
    except OSError:
        return ""
    return f"; {free_mb:.1f} MB are free" if free_mb < _LITTLE_MB else ""


def _may_be_changed(old: _Stored, new: Sources) -> bool:
    """Whether a copy of the old catalog is nearly what is wanted."""
    if old.sources.definitions != new.definitions:
        return False
    replaced = old.replaced + len(difference_of(old.sources, new).gone)
    return replaced <= max(_FEW_FILES, _MOST_REPLACED * len(new.stamps))


def _change_a_copy(ws: Workspace, temp: Path, old: _Stored, new: Sources) -> None:
    """Copy the old catalog and change the rows of the files that changed: most of a large one stays as it is."""
    difference = difference_of(old.sources, new)
    gone, incoming = _by_table(ws, difference.gone), _by_table(ws, difference.new)
    with faults_of_the_system(temp):
        shutil.copyfile(ws.catalog, temp)
    with _building(temp) as connection:
        shut_in(connection)
        for table in CATALOG_TABLES:
            if table in gone:
                remove_rows(connection, table, gone[table])
            if table in incoming:
                read_rows_in(connection, table, incoming[table])
        connection.execute("DELETE FROM data.made_of")
        _note(connection, new, old.replaced + len(difference.gone))


def _make(ws: Workspace, temp: Path, old: _Stored | None, new: Sources) -> None:
    """Make a catalog anew; rows of unchanged files come from the old one where a table has the same columns."""
    difference = Difference((), tuple(new.stamps), ()) if old is None else difference_of(old.sources, new)
    same = frozenset() if old is None else old.sources.columns.items() & new.columns.items()
    kept, incoming = _by_table(ws, difference.kept), _by_table(ws, difference.new)
    with _building(temp) as connection:
        if old is not None:
            attach(connection, ws.catalog, "old", "READ_ONLY")
        shut_in(connection)
        connection.execute("CREATE SCHEMA data")
        for table in CATALOG_TABLES:
            create_table(connection, table)
            known = kept.get(table, []) if (table, new.columns[table]) in same else []
            if known:
                copy_rows(connection, table, known)
            others = [] if known else kept.get(table, [])
            read_rows_in(connection, table, [*others, *incoming.get(table, [])])
        for view in VIEWS:
            create_view(connection, view)
        fill_dictionary(connection)
        connection.execute(
            "CREATE TABLE data.made_of (definitions VARCHAR, columns VARCHAR, stamps VARCHAR, replaced BIGINT)"
        )
        _note(connection, new, 0)


@contextmanager
def _building(temp: Path) -> Iterator[duckdb.DuckDBPyConnection]:
    connection = duckdb.connect(config=CLOSED)
    try:
        attach(connection, temp, "catalog", f"STORAGE_VERSION '{STORAGE_VERSION}'")
        connection.execute("USE catalog")
        connection.execute("BEGIN")  # else each of some hundred comments is brought to the disk by itself
        yield connection
        connection.execute("COMMIT")
        connection.execute("USE memory")
        connection.execute("DETACH catalog")  # writes everything into the one file
    finally:
        connection.close()


def _by_table(ws: Workspace, files: Sequence[str]) -> dict[str, list[Part]]:
    parts: dict[str, list[Part]] = {}
    for file in files:
        part = part_of(ws, file)
        parts.setdefault(part.table, []).append(part)
    return parts


def _note(connection: duckdb.DuckDBPyConnection, made_of: Sources, replaced: int) -> None:
    columns, stamps = json.dumps(dict(made_of.columns)), json.dumps(dict(made_of.stamps))
    row = [made_of.definitions, columns, stamps, replaced]
    connection.execute("INSERT INTO data.made_of VALUES (?, ?, ?, ?)", row)


def _put_in_place(ws: Workspace, temp: Path) -> None:
    with faults_of_the_system(ws.catalog):
        # left by someone who opened the old file for writing; DuckDB would replay it into the new one
        ws.catalog.with_name(f"{ws.catalog.name}.wal").unlink(missing_ok=True)
    clear_place(ws.catalog)
    replace_file(temp, ws.catalog)
    sync_folder(ws.root)


def _remove_database(temp: Path) -> None:
    temp.unlink(missing_ok=True)
    temp.with_name(f"{temp.name}.wal").unlink(missing_ok=True)
