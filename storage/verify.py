"""Is everything stored whole, and true to its digest."""

import re
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.catalog import is_behind
from storage.errors import StorageError
from storage.fault import Fault, at
from storage.ledger import read_settings
from storage.locks import lock_to_read
from storage.parquet import read_rows
from storage.places import store_of
from storage.publish import stale_temps
from storage.records import TABLES, EpochRow
from storage.run_record import is_at_work
from storage.sqlite_damage import damage_of
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
from storage.text_parts import Known
from storage.verify_catalog import catalog_faults, deep_catalog_faults
from storage.verify_copies import (
    copy_faults,
    seal_faults,
    series_faults,
    set_aside,
    single_copies,
    unmarked_series,
    unsealed_epochs,
)
from storage.verify_records import record_faults
from storage.versions import ARCHIVE_REMEDY, archive_fault, archived_epochs, unfinished_archives
from storage.workspace import Workspace

Check = Callable[[Store, str, Content], bool]
CatalogCheck = Callable[[Workspace], Iterable[Fault | None]]

CATCH_UP_S: Final = 3.0
"""So long a catalog that is older than its tables is waited for: who notes a deed on an alarm is done within that."""

_LOOK_EVERY_S: Final = 0.1

FOLLOWS: Final = Fault(
    "catalog.duckdb",
    "is older than the tables, as a run is under way: it follows the epochs that are published",
    "verify again when the run has ended",
)


@dataclass(frozen=True, slots=True)
class VerifyReport:
    """How many things were checked, what was found wrong, and what is worth a word but is no fault."""

    checked: int
    faults: tuple[Fault, ...]
    notes: tuple[Fault, ...] = ()


def verify_workspace(ws: Workspace) -> VerifyReport:
    """Check everything; artifacts that did not change since they were last hashed are not hashed again.

    Nothing is written, so that a workspace on a read-only drive can be checked, too.

    Raises
    ------
    StorageError
        If another process publishes for longer than the lock's time-out.
    """
    return _verify(ws, lambda store, name, content: store.is_whole(name, content), catalog_faults)


def verify_workspace_deeply(ws: Workspace) -> VerifyReport:
    """Check everything, hash every artifact (about a second per gigabyte), and hold the catalog against a new one.

    Raises
    ------
    StorageError
        If another process publishes for longer than the lock's time-out.
    """
    return _verify(
        ws, lambda store, name, content: store.is_whole_by_hash(name, content), deep_catalog_faults
    )


def _verify(ws: Workspace, is_true: Check, of_catalog: CatalogCheck) -> VerifyReport:
    patient_until = time.monotonic() + CATCH_UP_S
    while True:
        with lock_to_read(ws):
            follows = is_behind(ws)
            under_way = follows and is_at_work(ws)
            if not follows or under_way or time.monotonic() > patient_until:
                found = [*_record_of_results(ws), *(() if under_way else of_catalog(ws))]
                notes = [*_worth_a_word(ws), *((FOLLOWS,) if under_way else ())]
                break
        time.sleep(_LOOK_EVERY_S)
    found += [*_artifacts(ws, is_true), *record_faults(ws)]
    return VerifyReport(len(found), tuple(fault for fault in found if fault is not None), tuple(notes))


def _record_of_results(ws: Workspace) -> Iterator[Fault | None]:
    for faults in (_left_behind, _tables, _epochs, seal_faults, series_faults, _versions, copy_faults):
        yield from faults(ws)


def _worth_a_word(ws: Workspace) -> Iterator[Fault]:
    for notes in (unsealed_epochs, unmarked_series, single_copies, set_aside, _histories):
        yield from notes(ws)


def _left_behind(ws: Workspace) -> Iterator[Fault | None]:
    again = "run the campaign again: the next run finishes or sweeps it"
    yield Fault(at(ws, ws.journal), "a publication did not end", again) if ws.journal.exists() else None
    for temp in (*stale_temps(ws), *unfinished_archives(ws)):
        yield Fault(at(ws, temp), "unfinished file that nobody writes any more", again)


def _tables(ws: Workspace) -> Iterator[Fault | None]:
    for table in TABLES:
        for path in files_of(ws, table):
            yield _table_fault(ws, table, path)


def _table_fault(ws: Workspace, table: str, path: Path) -> Fault | None:
    again = "delete the file or restore it from a backup, and run the epoch again"
    try:
        rows: list[object] = read_rows(path, table, TABLES[table])
    except StorageError as fault:
        return Fault(at(ws, path), str(fault), again)
    part = part_column(table)
    keys = {
        EpochKey(getattr(row, "structure", ""), SERIES if part is None else getattr(row, part))
        for row in rows
    }
    strangers = keys - {key_of(path)}
    if strangers:
        return Fault(at(ws, path), f"holds rows of {', '.join(map(str, sorted(strangers)))}", again)
    return None


def _epochs(ws: Workspace) -> Iterator[Fault | None]:
    known: dict[str, str] = {}  # parts that the settings of many epochs share
    for key in epochs_on_disk(ws):
        paths = [table_path(ws, table, key.structure, key.epoch) for table in EPOCH_TABLES]
        missing = [at(ws, path) for path in paths if not path.exists()]
        what = f"the epoch is not whole: no {', '.join(missing)}"
        yield Fault(str(key), what, "run the epoch again") if missing else None
        yield from _settings(ws, key, known)


def _versions(ws: Workspace) -> Iterator[Fault | None]:
    """Earlier results, by their digests: they cannot be made again."""
    for folder in archived_epochs(ws):
        fault = archive_fault(folder)
        yield None if fault is None else Fault(at(ws, folder), fault, ARCHIVE_REMEDY)


def _settings(ws: Workspace, key: EpochKey, known: Known) -> Iterator[Fault | None]:
    try:
        for row in read_rows(table_path(ws, "epochs", key.structure, key.epoch), "epochs", EpochRow):
            read_settings(ws, row.campaign_digest, known)
    except StorageError as fault:
        yield Fault(str(key), str(fault), "run the epoch again")
    else:
        yield None


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


def _histories(ws: Workspace) -> Iterator[Fault]:
    """Histories of flow runs that the workflow engine keeps: no result rests on them, so they are worth a word only."""
    for path in sorted(ws.prefect.glob("*/*.db")):
        damage = damage_of(path)
        if damage is not None:
            what = f"the history of flow runs is damaged ({damage})"
            yield Fault(at(ws, path), what, "run the campaign again: it is set aside, and a new one begun")


def _digest_in(name: str) -> str | None:
    """SHA-256 in the name of an artifact; None where it is named otherwise."""
    named = re.fullmatch(r"artifacts/([0-9a-f]{2})/(\1[0-9a-f]{62})\.[a-z0-9]{1,16}", name)
    return None if named is None else named[2]
