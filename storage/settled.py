"""Epochs that were published and need no second look until a scan, a setting or the code changes."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path

from storage.atomic import write_our_own
from storage.digests import text_sha256
from storage.ids import check_id
from storage.parquet import read_rows
from storage.records import EpochRow
from storage.seals import seal_path
from storage.tables import EPOCH_TABLES, EpochKey, table_path
from storage.verified import Stamp, stamp_of, would_show_change
from storage.workspace import Workspace


def settled_by(ws: Workspace, structure: str, epoch: str, inputs: str, scans: Iterable[Path]) -> str | None:
    """Run that published an epoch from these inputs and scans; None where it is another, or its tables changed since.

    Parameters
    ----------
    inputs : str
        Digest of everything beside the scans that the result follows from.
    scans : paths
        Files that it was read from; known by inode, size and time of change, not read.
    """
    try:
        run, put_down = json.loads(_place(ws, structure, epoch).read_bytes())
    except (OSError, ValueError, TypeError):
        return None
    mark = _mark(ws, structure, epoch, inputs, scans)
    return str(run) if mark is not None and mark == put_down else None


def stamps_of(scans: Iterable[Path]) -> dict[Path, Stamp | None]:
    """What tells whether scans change from now on."""
    return {path: stamp_of(path) for path in scans}


def settle(
    ws: Workspace, structure: str, epoch: str, inputs: str, before: Mapping[Path, Stamp | None]
) -> bool:
    """Put down that an epoch was published from these inputs and scans just now.

    Parameters
    ----------
    before : mapping
        ``stamps_of`` the scans from before they were read.

    Returns
    -------
    bool
        False if that cannot be told: a scan is absent, changed since, or so lately that its time says nothing.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    young = [stamp for stamp in before.values() if stamp is not None and not would_show_change(stamp)]
    mark = _mark(ws, structure, epoch, inputs, before)
    if mark is None or young or stamps_of(before) != before:
        return False
    (row,) = read_rows(table_path(ws, "epochs", structure, epoch), "epochs", EpochRow)
    write_our_own(_place(ws, structure, epoch), json.dumps([row.run, mark]).encode())
    return True


def _place(ws: Workspace, structure: str, epoch: str) -> Path:
    folder = ws.runs / "settled" / check_id(structure, "a structure")
    return folder / f"{check_id(epoch, 'an epoch')}.json"


def _mark(ws: Workspace, structure: str, epoch: str, inputs: str, scans: Iterable[Path]) -> str | None:
    """What tells an epoch's inputs and tables apart from others; None where a file is absent."""
    tables = [table_path(ws, table, structure, epoch) for table in EPOCH_TABLES]
    tables.append(seal_path(ws, EpochKey(structure, epoch)))
    stamps = [(str(path), stamp_of(path)) for path in (*scans, *tables)]
    if any(stamp is None for _, stamp in stamps):
        return None
    told = [[path, str(stamp)] for path, stamp in stamps]
    return text_sha256(json.dumps([inputs, told]))
