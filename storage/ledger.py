"""What each run did, and under which settings: append only, one file a run."""

import json
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from storage.atomic import write_our_own
from storage.digests import text_sha256
from storage.errors import StorageError
from storage.locks import publish_lock
from storage.parquet import encode_rows
from storage.records import StageRunRow
from storage.run_record import runs_on_record
from storage.second_copies import keep_second
from storage.tables import RUNS, table_path
from storage.text_parts import PARTS, Known, read_text, write_text
from storage.workspace import Workspace

RUN_TIME: Final = "%Y%m%dT%H%M%SZ"
"""How the time is written with which the id of a run begins."""


def append_run(ws: Workspace, run: str, structure: str, rows: Sequence[StageRunRow]) -> Path:
    """Add the stages of a run to the ledger.

    Raises
    ------
    StorageError
        If the run is in the ledger already, or a row is of another run or structure or may not be stored.
    InputError
        If an id cannot be a file name.
    """
    path = table_path(ws, RUNS, structure, run)
    for number, row in enumerate(rows):
        if (row.run, row.structure) != (run, structure):
            raise StorageError(
                f"table runs, row {number}: needed run {run} of {structure}, got {row.run} of {row.structure}"
            )
    content = encode_rows(RUNS, StageRunRow, rows)
    with publish_lock(ws):
        if path.exists():
            raise StorageError(
                f"run {run} of {structure} is in the ledger already, which is append only: {path}"
            )
        write_our_own(path, content)
        keep_second(ws, path)
    return path


def is_in_ledger(ws: Workspace, run: str, structure: str) -> bool:
    """Whether the ledger has a run.

    Raises
    ------
    InputError
        If an id cannot be a file name.
    """
    return table_path(ws, RUNS, structure, run).exists()


def newest_run_time(ws: Workspace, structure: str) -> datetime | None:
    """Time of the newest run of a structure, or of any that is under way, as the ids of runs say it; None without any.

    Raises
    ------
    InputError
        If the id cannot be a file name.
    """
    folder = table_path(ws, RUNS, structure, "any").parent
    names = [*(path.stem for path in folder.glob("*.parquet")), *runs_on_record(ws)]
    # as they sort, so that of thousands one is read
    return next((time for name in sorted(names, reverse=True) if (time := _run_time(name)) is not None), None)


def _run_time(name: str) -> datetime | None:
    """The time in the id of a run; None where a program gave it another name."""
    try:
        return datetime.strptime(name.partition("-")[0], RUN_TIME).replace(tzinfo=UTC)
    except ValueError:
        return None


def settings_path(ws: Workspace, digest: str) -> Path:
    """Where the filled-in settings with that digest lie or would lie."""
    return ws.runs / "settings" / f"{digest}.json"


def settings_parts(ws: Workspace) -> Path:
    """Where the parts of long settings lie."""
    return ws.runs / PARTS


def store_settings(ws: Workspace, digest: str, text: str) -> Path:
    """Keep filled-in campaign settings, so that the ``campaign_digest`` of a row leads to them.

    Long ones are kept in parts, which those of other runs share (``storage.text_parts``).

    Raises
    ------
    StorageError
        If the digest is not the SHA-256 of the text in UTF-8.
    """
    if digest != text_sha256(text):
        raise StorageError(f"settings need the SHA-256 of their text, {text_sha256(text)}; got {digest!r}")
    path = settings_path(ws, digest)
    with publish_lock(ws):
        for written in write_text(path, settings_parts(ws), text):
            keep_second(ws, written)
    return path


def read_settings(ws: Workspace, digest: str, known: Known | None = None) -> str:
    """The filled-in settings behind a ``campaign_digest``.

    Parameters
    ----------
    known
        Parts of long settings that were read before: who reads the settings of many epochs need not read them again.

    Raises
    ------
    StorageError
        If they are absent or damaged.
    """
    path = settings_path(ws, digest)
    if not path.is_file():
        raise StorageError(f"no settings with digest {digest}: {path} is absent; run the epoch again")
    text = read_text(path, settings_parts(ws), known)
    if text_sha256(text) != digest:
        raise StorageError(
            f"{path} is damaged: its digest is {text_sha256(text)}; delete it and run the epoch again"
        )
    return text


def kept_frame(ws: Workspace, digest: str) -> Mapping[str, Any] | None:
    """The table [frame] of the settings behind a ``campaign_digest``; None where they are not kept or have none.

    Raises
    ------
    StorageError
        If they are damaged.
    """
    if not settings_path(ws, digest).is_file():
        return None
    content = json.loads(read_settings(ws, digest))
    frame = content.get("frame") if isinstance(content, dict) else None
    return frame if isinstance(frame, dict) else None
