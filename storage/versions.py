"""Earlier results of epochs: versions/<structure>/<version>/<epoch>/<table>.parquet with a manifest; never deleted here."""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Final
from uuid import uuid4

from storage.atomic import (
    TEMP_SUFFIX,
    faults_of_the_system,
    make_folder,
    sync_file,
    sync_folder,
    write_atomically,
)
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.ids import check_id
from storage.parquet import is_undamaged, read_rows, stored_row_count
from storage.records import TABLES, EpochRow
from storage.seals import is_as_sealed
from storage.second_copies import keep_second
from storage.tables import EPOCH_TABLES, EpochKey, table_path
from storage.version import VersionRow
from storage.version_manifest import MANIFEST, Manifest, read_manifest
from storage.workspace import Workspace

FOLLOWING_TABLES: Final = ("epochs", "accuracy", "scheme_comparison")
"""Tables that follow from the others of the epoch, or tell of the run: alone they make no result to keep."""

LONGEST_NAME: Final = 60

ARCHIVE_REMEDY: Final = "restore it from a backup, or move the folder out of the workspace"
"""What to do about an archived epoch that is damaged."""

Step = Callable[[str], None]


def _no_step(_done: str) -> None:
    """Do nothing between the steps; the tests of crashes do otherwise."""


def version_folder(ws: Workspace, structure: str, version: str, epoch: str) -> Path:
    """Where an epoch lies or would lie in a version.

    Raises
    ------
    InputError
        If an id cannot be a file name.
    """
    folder = ws.versions / check_id(structure, "a structure") / check_id(version, "a version")
    return folder / check_id(epoch, "an epoch")


def put_aside(
    ws: Workspace, key: EpochKey, version: str, why: str, *, after_step: Step = _no_step
) -> VersionRow | None:
    """Keep the published tables of an epoch under a version; to be called under the publish lock.

    The epoch appears there whole or not at all. Its files are hard links where the system can, else copies: a
    publication replaces files and never changes one. A damaged table is no result and is left out.

    Returns
    -------
    VersionRow or None
        None if the epoch is not published.

    Raises
    ------
    StorageError
        If the version has the epoch already, or the disk refuses.
    """
    folder = version_folder(ws, key.structure, version, key.epoch)
    if folder.exists():
        raise StorageError(f"version {version} of {key} is there already and is never changed: {folder}")
    tables = _whole_tables(ws, key)
    return _put_aside(ws, folder, tables, _row(ws, key, version, why), after_step) if tables else None


def _put_aside(
    ws: Workspace, folder: Path, tables: Mapping[str, Path], row: VersionRow, after_step: Step = _no_step
) -> VersionRow:
    make_folder(folder.parent)
    temp = folder.with_name(f".{folder.name}.{uuid4().hex}{TEMP_SUFFIX}")
    try:
        _fill(temp, tables, row, after_step)
        with faults_of_the_system(folder):
            temp.rename(folder)
        sync_folder(folder.parent)
        keep_second(ws, folder / MANIFEST)
    except BaseException:
        shutil.rmtree(temp, ignore_errors=True)
        raise
    return row


def keep_replaced(ws: Workspace, key: EpochKey, tables: Mapping[str, Sequence[object]], run: str) -> None:
    """Put the published results of an epoch aside if ``tables`` are about to replace or drop any of them.

    The version is named after the run that replaces them. What is kept already, under whatever name, is not kept
    twice. An epoch without an axis has no result to keep; one that only gains rows, as by one scheme more, loses none.
    To be called under the publish lock.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    published = _whole_tables(ws, key)
    if _loses_results(published, tables) and not _is_kept(ws, key, published):
        version = _free_name(ws, key, f"before-{run}")
        folder = version_folder(ws, key.structure, version, key.epoch)
        _put_aside(ws, folder, published, _row(ws, key, version, f"replaced by run {run}"))


def archived_epochs(ws: Workspace) -> Iterator[Path]:
    """Folders of all archived epochs, in the order of structure, version and epoch."""
    yield from sorted(path for path in ws.versions.glob("*/*/*") if not path.name.startswith("."))


def unfinished_archives(ws: Workspace) -> list[Path]:
    """Folders of epochs that were being put aside when the machine stopped; to be asked under the publish lock."""
    return sorted(ws.versions.glob(f"*/*/.*{TEMP_SUFFIX}"))


def archive_fault(folder: Path) -> str | None:
    """What is wrong with an archived epoch; None if every file is there and true to its digest."""
    try:
        manifest = read_manifest(folder)
    except StorageError as fault:
        return str(fault)
    for table, digest in manifest.files.items():
        path = folder / f"{table}.parquet"
        if not path.is_file():
            return f"lacks table {table}"
        if file_sha256(path) != digest:
            return f"table {table} does not have the digest that the manifest says"
    return None


def _whole_tables(ws: Workspace, key: EpochKey) -> dict[str, Path]:
    paths = {table: table_path(ws, table, key.structure, key.epoch) for table in EPOCH_TABLES}
    return {
        table: path
        for table, path in paths.items()
        if path.is_file() and is_undamaged(path) and is_as_sealed(ws, key, table, path)
    }


def _row(ws: Workspace, key: EpochKey, version: str, why: str) -> VersionRow:
    path = table_path(ws, "epochs", key.structure, key.epoch)
    try:
        epoch: EpochRow | None = read_rows(path, "epochs", EpochRow)[0]
    except (StorageError, IndexError):
        epoch = None
    return VersionRow(
        structure=key.structure,
        epoch=key.epoch,
        version=version,
        archived_at=datetime.now(UTC),
        why=why,
        run=None if epoch is None else epoch.run,
        state=None if epoch is None else epoch.state,
        code_version=None if epoch is None else epoch.code_version,
        campaign_digest=None if epoch is None else epoch.campaign_digest,
    )


def _fill(temp: Path, tables: Mapping[str, Path], row: VersionRow, after_step: Step) -> None:
    make_folder(temp)
    digests = {}
    for table, path in tables.items():
        target = temp / f"{table}.parquet"
        _link(path, target)
        digests[table] = file_sha256(target)
        after_step(f"kept {table}")
    write_atomically(temp / MANIFEST, Manifest(row, digests).to_json())
    sync_folder(temp)
    after_step("manifest")


def _link(source: Path, target: Path) -> None:
    try:
        os.link(source, target)
    except OSError:  # a system or a drive without hard links
        with faults_of_the_system(target):
            shutil.copyfile(source, target)
        sync_file(target)


def _free_name(ws: Workspace, key: EpochKey, wanted: str) -> str:
    name, number = wanted[:LONGEST_NAME].rstrip("."), 1
    while version_folder(ws, key.structure, name, key.epoch).exists():
        number += 1
        name = f"{wanted[: LONGEST_NAME - 4].rstrip('.')}.{number}"
    return name


def _is_kept(ws: Workspace, key: EpochKey, published: Mapping[str, Path]) -> bool:
    """Whether a version holds the published tables as they are, under whatever name."""
    digests = {table: file_sha256(path) for table, path in published.items()}
    return any(_holds(folder, digests) for folder in ws.versions.glob(f"{key.structure}/*/{key.epoch}"))


def _holds(folder: Path, digests: Mapping[str, str]) -> bool:
    try:
        return dict(read_manifest(folder).files) == digests
    except StorageError:  # a damaged archive keeps nothing; `verify` tells of it
        return False


def _loses_results(published: Mapping[str, Path], tables: Mapping[str, Sequence[object]]) -> bool:
    if "tilt" not in published or stored_row_count(published["tilt"]) == 0:
        return False
    return any(
        not _stay(table, path, tables[table])
        for table, path in published.items()
        if table not in FOLLOWING_TABLES
    )


def _stay(table: str, path: Path, rows: Sequence[object]) -> bool:
    """Whether all stored rows are among ``rows``; those of an older program that lack a column are not."""
    try:
        return set(read_rows(path, table, TABLES[table])) <= set(rows)
    except StorageError:
        return False
