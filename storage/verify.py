"""Is everything stored whole, and true to its digest."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import duckdb

from storage.catalog import is_current, read_catalog
from storage.errors import StorageError
from storage.ledger import read_settings
from storage.locks import publish_lock
from storage.parquet import read_rows, stored_row_count
from storage.places import store_of
from storage.publish import stale_temps
from storage.records import TABLES, EpochRow
from storage.store import Content, Store
from storage.tables import (
    EPOCH_TABLES,
    SERIES,
    EpochKey,
    epochs_on_disk,
    files_of,
    key_of,
    part_column,
    table_path,
)
from storage.versions import archive_fault, archived_epochs, unfinished_archives
from storage.view_definitions import VIEWS
from storage.workspace import Workspace

Check = Callable[[Store, str, Content], bool]


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that is not as it should be."""

    where: str
    what: str
    what_to_do: str


@dataclass(frozen=True, slots=True)
class VerifyReport:
    """How many things were checked, and what was found wrong."""

    checked: int
    faults: tuple[Fault, ...]


def verify_workspace(ws: Workspace) -> VerifyReport:
    """Check everything; artifacts that did not change since they were last hashed are not hashed again.

    Raises
    ------
    StorageError
        If another process publishes for longer than the lock's time-out.
    """
    return _verify(ws, lambda store, name, content: store.is_whole(name, content))


def verify_workspace_deeply(ws: Workspace) -> VerifyReport:
    """Check everything and hash every artifact: about a second per gigabyte.

    Raises
    ------
    StorageError
        If another process publishes for longer than the lock's time-out.
    """
    return _verify(ws, lambda store, name, content: store.is_whole_by_hash(name, content))


def _verify(ws: Workspace, is_true: Check) -> VerifyReport:
    with publish_lock(ws):
        found = [*_left_behind(ws), *_tables(ws), *_epochs(ws), *_versions(ws), *_catalog(ws)]
    found += _artifacts(ws, is_true)
    return VerifyReport(len(found), tuple(fault for fault in found if fault is not None))


def _left_behind(ws: Workspace) -> Iterator[Fault | None]:
    again = "run the campaign again: the next run finishes or sweeps it"
    yield Fault(_at(ws, ws.journal), "a publication did not end", again) if ws.journal.exists() else None
    for temp in (*stale_temps(ws), *unfinished_archives(ws)):
        yield Fault(_at(ws, temp), "unfinished file that nobody writes any more", again)


def _tables(ws: Workspace) -> Iterator[Fault | None]:
    for table in TABLES:
        for path in files_of(ws, table):
            yield _table_fault(ws, table, path)


def _table_fault(ws: Workspace, table: str, path: Path) -> Fault | None:
    again = "delete the file or restore it from a backup, and run the epoch again"
    try:
        rows: list[object] = read_rows(path, table, TABLES[table])
    except StorageError as fault:
        return Fault(_at(ws, path), str(fault), again)
    part = part_column(table)
    keys = {
        EpochKey(getattr(row, "structure", ""), SERIES if part is None else getattr(row, part))
        for row in rows
    }
    strangers = keys - {key_of(path)}
    if strangers:
        return Fault(_at(ws, path), f"holds rows of {', '.join(map(str, sorted(strangers)))}", again)
    return None


def _epochs(ws: Workspace) -> Iterator[Fault | None]:
    for key in epochs_on_disk(ws):
        paths = [table_path(ws, table, key.structure, key.epoch) for table in EPOCH_TABLES]
        missing = [_at(ws, path) for path in paths if not path.exists()]
        what = f"the epoch is not whole: no {', '.join(missing)}"
        yield Fault(str(key), what, "run the epoch again") if missing else None
        yield from _settings(ws, key)


def _versions(ws: Workspace) -> Iterator[Fault | None]:
    """Earlier results, by their digests: they cannot be made again."""
    for folder in archived_epochs(ws):
        fault = archive_fault(folder)
        what_to_do = "restore it from a backup, or move the folder out of the workspace"
        yield None if fault is None else Fault(_at(ws, folder), fault, what_to_do)


def _settings(ws: Workspace, key: EpochKey) -> Iterator[Fault | None]:
    try:
        for row in read_rows(table_path(ws, "epochs", key.structure, key.epoch), "epochs", EpochRow):
            read_settings(ws, row.campaign_digest)
    except StorageError as fault:
        yield Fault(str(key), str(fault), "run the epoch again")
    else:
        yield None


def _catalog(ws: Workspace) -> Iterator[Fault | None]:
    if not ws.catalog.exists() and not any(files_of(ws, table) for table in TABLES):
        return
    again = "delete the catalog and run the campaign again: it is rebuilt from the tables"
    if not is_current(ws):
        yield Fault(ws.catalog.name, "is absent, damaged or older than the tables", again)
    try:
        with read_catalog(ws) as connection:
            for table in TABLES:
                yield _count_fault(ws, connection, table)
            for view in VIEWS:
                connection.execute(f"SELECT count(*) FROM main.{view}").fetchone()  # noqa: S608
                yield None
    except (StorageError, duckdb.Error) as fault:
        yield Fault(ws.catalog.name, str(fault).splitlines()[0], again)


def _count_fault(ws: Workspace, connection: duckdb.DuckDBPyConnection, table: str) -> Fault | None:
    row = connection.execute(f"SELECT count(*) FROM data.{table}").fetchone()  # noqa: S608 - names of our own
    shown = None if row is None else row[0]
    stored = sum(stored_row_count(path) for path in files_of(ws, table))
    if shown == stored:
        return None
    what = f"shows {shown} rows of {table}; the tables hold {stored}"
    return Fault(
        ws.catalog.name, what, "delete the catalog and run the campaign again: it is rebuilt from the tables"
    )


def _artifacts(ws: Workspace, is_true: Check) -> Iterator[Fault | None]:
    store = store_of(ws)
    for name in store.names("artifacts"):
        sha256 = _digest_in(name)
        if name.count("/") == 1:
            continue  # what the store remembers, beside the folders of artifacts
        if sha256 is None:
            yield Fault(name, "is not named as an artifact", "move it out of the workspace")
        elif is_true(store, name, Content(sha256, store.size(name) or 0)):
            yield None
        else:
            what = "its content does not have the digest that its name says"
            yield Fault(name, what, "delete it and run again: it is computed anew")


def _digest_in(name: str) -> str | None:
    """SHA-256 in the name of an artifact; None where it is named otherwise."""
    named = re.fullmatch(r"artifacts/([0-9a-f]{2})/(\1[0-9a-f]{62})\.[a-z0-9]{1,16}", name)
    return None if named is None else named[2]


def _at(ws: Workspace, path: Path) -> str:
    return path.relative_to(ws.root).as_posix()
