"""Publish whole epochs: all tables of an epoch change together or not at all, whenever the machine stops."""

import hashlib
import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal
from uuid import uuid4

from storage.atomic import TEMP_SUFFIX, make_folder, replace_file, sync_folder, write_our_own, write_temp
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.ids import check_id
from storage.journal import (
    Journal,
    Rename,
    apply_removal,
    apply_rename,
    can_finish,
    has_begun,
    read_journal,
    remove_journal,
    write_journal,
)
from storage.ledger import kept_frame
from storage.locks import publish_lock
from storage.parquet import encode_rows, read_rows
from storage.records import TABLES, EpochRow
from storage.seals import seal_path, seal_text
from storage.tables import EPOCH_TABLES, EpochKey, table_path
from storage.versions import keep_replaced, unfinished_archives
from storage.workspace import Workspace
from storage.writers import is_writer_gone

Step = Callable[[str], None]

# a temp outside the tables has no lock over it: only one whose writer is gone is swept, or, where nobody can tell
# (a writer on another machine), one that is as old as this
_ABANDONED_S: Final = 24 * 3600.0


@dataclass(frozen=True, slots=True)
class Recovery:
    """What was left of a publication that did not end, and what became of it."""

    outcome: Literal["nothing to do", "finished", "dropped", "set aside"]
    epoch: EpochKey | None
    temps_swept: int


def _no_step(_done: str) -> None:
    """Do nothing between the steps; the tests of crashes do otherwise."""


def publish_epoch(
    ws: Workspace,
    structure: str,
    epoch: str,
    tables: Mapping[str, Sequence[object]],
    *,
    after_step: Step = _no_step,
) -> bool:
    """Replace all tables of an epoch at once.

    An epoch whose rows are the same but for the run that made them, and that run's settings, keeps its old files:
    ``epochs.run`` and ``epochs.campaign_digest`` are those of the run that published the rows, not of the last that
    confirmed them. Only where the settings of the two state another frame is it published again, so that the digest
    leads to the frame in which the results lie. Results that are replaced are kept as a version (``storage.versions``).

    Parameters
    ----------
    tables : mapping of table name to rows
        All tables of ``EPOCH_TABLES``; empty where there is nothing.
    after_step : callable
        Told the name of each step when it is done.

    Returns
    -------
    bool
        False if the epoch is published already with the same content; then nothing is written.

    Raises
    ------
    StorageError
        If a table is missing or unknown, a row is of another epoch or may not be stored, or the disk refuses.
    InputError
        If an id cannot be a file name.
    """
    key = EpochKey(check_id(structure, "a structure"), check_id(epoch, "an epoch"))
    _check_tables(key, tables)
    with publish_lock(ws):
        recover(ws)
        _check_spelling(ws, key)
        contents = {table: encode_rows(table, TABLES[table], tables[table]) for table in EPOCH_TABLES}
        if _is_published(ws, key, contents, tables["epochs"]):
            _seal_if_need_be(ws, key)
            return False
        keep_replaced(ws, key, tables, _run_of(tables))
        journal = _written_temps(ws, key, contents, after_step)
        write_journal(ws, journal)
        after_step("journal")
        _finish(ws, journal, after_step)
    return True


def remove_epoch(ws: Workspace, structure: str, epoch: str, *, after_step: Step = _no_step) -> bool:
    """Remove all tables of an epoch at once; False if it was not there."""
    paths = [table_path(ws, table, structure, epoch) for table in EPOCH_TABLES]
    paths.append(seal_path(ws, EpochKey(structure, epoch)))
    with publish_lock(ws):
        recover(ws)
        there = tuple(_relative(ws, path) for path in paths if path.exists())
        if not there:
            return False
        journal = Journal(structure, epoch, (), there)
        write_journal(ws, journal)
        after_step("journal")
        _finish(ws, journal, after_step)
    return True


def recover(ws: Workspace) -> Recovery:
    """Finish the publication that a crash cut short, and sweep the temps that it left.

    After the journal is written, every temp is whole, so the publication is rolled forward. Should a hand from
    outside have damaged them, the old epoch stays if it is whole; else its files are set aside under ``tmp``,
    because a mixed epoch must never be seen.

    Raises
    ------
    StorageError
        If the journal is damaged, or the disk refuses.
    """
    with publish_lock(ws):
        journal = read_journal(ws)
        if journal is None:
            return Recovery("nothing to do", None, _sweep(ws))
        key = EpochKey(journal.structure, journal.epoch)
        if can_finish(ws, journal):
            _finish(ws, journal, _no_step)
            return Recovery("finished", key, _sweep(ws))
        if not has_begun(ws, journal):
            remove_journal(ws)
            return Recovery("dropped", key, _sweep(ws))
        _set_aside(ws, key)
        remove_journal(ws)
        return Recovery("set aside", key, _sweep(ws))


def stale_temps(ws: Workspace) -> list[Path]:
    """Temps that nobody is writing any more; to be asked under the publish lock."""
    under_lock = [
        *ws.tables.glob(f"*/*/*{TEMP_SUFFIX}"),
        *ws.seals.glob(f"*/*{TEMP_SUFFIX}"),
        *ws.second.rglob(f"*{TEMP_SUFFIX}"),
        *ws.tmp.glob("catalog*"),
        *ws.runs.glob(f"*/*{TEMP_SUFFIX}"),
    ]
    now_s = time.time()
    of_epochs = (*ws.intake.glob("*/"), *ws.previews.glob("*/"))
    folders = (ws.root, ws.artifacts, ws.records, *ws.runs.glob("*/*/"), *of_epochs)
    others = [path for folder in folders for path in folder.glob(f"*{TEMP_SUFFIX}")]
    abandoned = [path for path in others if is_writer_gone(path) or _age_s(path, now_s) > _ABANDONED_S]
    return sorted(path for path in (*under_lock, *abandoned) if path.is_file())


def _age_s(path: Path, now_s: float) -> float:
    """How far the last change of a file is from now, either way: one that is dated ahead is older than the set clock.

    One that was put in place meanwhile is as new as can be.
    """
    try:
        return abs(now_s - path.stat().st_mtime)
    except FileNotFoundError:
        return 0.0


def _sweep(ws: Workspace) -> int:
    temps, folders = stale_temps(ws), unfinished_archives(ws)
    for temp in temps:
        temp.unlink(missing_ok=True)
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)
    return len(temps) + len(folders)


def _written_temps(ws: Workspace, key: EpochKey, contents: Mapping[str, bytes], after_step: Step) -> Journal:
    renames = []
    digests = {table: hashlib.sha256(content).hexdigest() for table, content in contents.items()}
    files = {table: (table_path(ws, table, key.structure, key.epoch), contents[table]) for table in contents}
    files["seal"] = (seal_path(ws, key), seal_text(digests))
    for name, (target, content) in files.items():
        temp = write_temp(target, content)
        sync_folder(temp.parent)
        digest = hashlib.sha256(content).hexdigest()
        renames.append(Rename(_relative(ws, temp), _relative(ws, target), digest))
        after_step(f"temp {name}")
    return Journal(key.structure, key.epoch, tuple(renames), ())


def _finish(ws: Workspace, journal: Journal, after_step: Step) -> None:
    for rename in journal.renames:
        apply_rename(ws, rename)
        after_step(f"rename {rename.target}")
    for removal in journal.removals:
        apply_removal(ws, removal)
        after_step(f"remove {removal}")
    remove_journal(ws)
    after_step("journal removed")


def _set_aside(ws: Workspace, key: EpochKey) -> None:
    place = ws.tmp / f"set-aside-{time.time_ns()}-{uuid4().hex[:8]}"
    paths = [table_path(ws, table, key.structure, key.epoch) for table in EPOCH_TABLES]
    for path in (*paths, seal_path(ws, key)):
        if path.exists():
            aside = place / path.relative_to(ws.root)
            make_folder(aside.parent)
            replace_file(path, aside)


def _is_published(
    ws: Workspace, key: EpochKey, contents: Mapping[str, bytes], epochs: Sequence[object]
) -> bool:
    paths = {table: table_path(ws, table, key.structure, key.epoch) for table in EPOCH_TABLES}
    if not all(path.is_file() for path in paths.values()):
        return False
    if any(_differs(paths[table], contents[table]) for table in EPOCH_TABLES if table != "epochs"):
        return False
    return not _differs(paths["epochs"], _under_old_run(ws, paths["epochs"], epochs))


def _seal_if_need_be(ws: Workspace, key: EpochKey) -> None:
    """Give an epoch its seal that was published before there were any, or whose seal is damaged."""
    paths = {table: table_path(ws, table, key.structure, key.epoch) for table in EPOCH_TABLES}
    text = seal_text({table: file_sha256(path) for table, path in paths.items()})
    place = seal_path(ws, key)
    if not place.is_file() or place.read_bytes() != text:
        write_our_own(place, text)


def _differs(path: Path, content: bytes) -> bool:
    return path.read_bytes() != content


def _under_old_run(ws: Workspace, path: Path, epochs: Sequence[object]) -> bytes:
    """The row of the epoch as the run would have made it that published the old one; nothing if its frame was another."""
    rows = [row for row in epochs if isinstance(row, EpochRow)]
    try:
        old = {(row.run, row.campaign_digest) for row in read_rows(path, "epochs", EpochRow)}
    except StorageError:  # a damaged file differs from any content and is replaced
        return b""
    if any(not _same_frame(ws, row.campaign_digest, digest) for row in rows for _, digest in old):
        return b""
    confirmed = [replace(row, run=run, campaign_digest=digest) for row in rows for run, digest in old]
    return encode_rows("epochs", EpochRow, confirmed)


def _same_frame(ws: Workspace, *digests: str) -> bool:
    frames: list[Mapping[str, object] | None] = []
    for digest in set(digests):
        frames.append(None)
        with suppress(StorageError):  # damaged settings tell of no frame
            frames[-1] = kept_frame(ws, digest)
    return all(frame == frames[0] for frame in frames)


def _run_of(tables: Mapping[str, Sequence[object]]) -> str:
    """Run that publishes; the tables have one row of the epoch."""
    return str(getattr(tables["epochs"][0], "run", ""))


def _check_tables(key: EpochKey, tables: Mapping[str, Sequence[object]]) -> None:
    if set(tables) != set(EPOCH_TABLES):
        raise StorageError(
            f"epoch {key} needs the tables {', '.join(EPOCH_TABLES)} (empty where there is nothing); "
            f"got {', '.join(tables) or 'none'}"
        )
    if len(tables["epochs"]) != 1:
        raise StorageError(f"epoch {key} needs one row in table epochs; got {len(tables['epochs'])}")
    for table, rows in tables.items():
        for number, row in enumerate(rows):
            found = EpochKey(getattr(row, "structure", ""), getattr(row, "epoch", ""))
            if found != key:
                raise StorageError(f"table {table}, row {number}: needed epoch {key}, got {found}")


def _check_spelling(ws: Workspace, key: EpochKey) -> None:
    """Refuse ids that differ from stored ones in capitals only: on Windows and macOS they are one file."""
    folder = ws.tables / "epochs"
    structures = {path.name for path in folder.glob("*")}
    epochs = {path.name.removesuffix(".parquet") for path in (folder / key.structure).glob("*.parquet")}
    for wanted, stored in ((key.structure, structures), (key.epoch, epochs)):
        twins = [name for name in stored if name.casefold() == wanted.casefold() and name != wanted]
        if twins:
            raise StorageError(
                f"id {wanted!r} differs from the stored {twins[0]!r} in capitals only; use that one"
            )


def _relative(ws: Workspace, path: Path) -> str:
    return path.relative_to(ws.root).as_posix()
