"""Restore an archive: a folder that was not there, with the campaign and its workspace, and the same answers."""

import glob
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from uuid import uuid4

from storage.atomic import TEMP_SUFFIX, faults_of_the_system, make_folder, sync_folder
from storage.backup.answers import Answers, answers_of
from storage.backup.contents import CAMPAIGN, WORKSPACE
from storage.backup.manifest import ArchiveManifest
from storage.backup.unpacking import unpack
from storage.catalog import rebuild_catalog
from storage.errors import StorageError
from storage.workspace import existing_workspace
from storage.writers import is_writer_gone, mark_of_this_process

WORKSPACE_FOLDER: Final = "tiltwatch-data"
"""Where a campaign's workspace lies beside its file unless another is named."""

_UNPACKED: Final = "unpacked"


@dataclass(frozen=True, slots=True)
class RestoredArchive:
    """What was restored, and how its answers compare with those that were archived."""

    folder: Path
    campaign_file: Path
    workspace: Path
    digest: str
    n_files: int
    views_compared: int
    """Views that give the same answer as before; none where their definitions changed since."""
    left_out: tuple[str, ...]
    """What the archive did not hold, in words."""


def restore_archive(archive: Path, folder: Path, digest: str | None = None) -> RestoredArchive:
    """Restore an archive into a new folder, which appears whole and verified or not at all.

    Every file is held against its digest; the catalog is made anew from the tables, and its views are asked for the
    same answers as before.

    Parameters
    ----------
    folder : Path
        The new folder; one that is there must be empty.
    digest : str, optional
        What `export archive` said when the archive was written.

    Raises
    ------
    StorageError
        If the folder is in use, the archive is damaged, not that of ``digest`` or of a newer tiltwatch, its answers
        differ, or the disk refuses.
    """
    target = folder.expanduser().absolute()
    _check_target(target)
    make_folder(target.parent)
    _sweep(target)
    temp = target.with_name(f".{target.name}.{mark_of_this_process()}.{uuid4().hex}{TEMP_SUFFIX}")
    try:
        manifest = unpack(archive, temp / _UNPACKED)
        _check_digest(manifest, digest, archive)
        compared = _prepare(temp, manifest, archive)
        with faults_of_the_system(target):
            _put_in_place(temp / _UNPACKED / CAMPAIGN, target)
    finally:
        shutil.rmtree(temp, ignore_errors=True)
    return RestoredArchive(
        target,
        target / manifest.campaign,
        target / WORKSPACE_FOLDER,
        manifest.digest,
        len(manifest.files),
        compared,
        manifest.left_out,
    )


def _check_target(target: Path) -> None:
    with faults_of_the_system(target):
        in_use = target.exists() and (not target.is_dir() or any(target.iterdir()))
    if in_use:
        raise StorageError(f"{target} is there already and is not emptied; name a new folder with --to")


def _sweep(target: Path) -> None:
    """Remove what restores to the same folder left that were killed."""
    for left in target.parent.glob(f".{glob.escape(target.name)}.*{TEMP_SUFFIX}"):
        if is_writer_gone(left):
            shutil.rmtree(left, ignore_errors=True)


def _check_digest(manifest: ArchiveManifest, digest: str | None, archive: Path) -> None:
    if digest is not None and digest.strip().lower() != manifest.digest:
        raise StorageError(
            f"{archive} has the digest {manifest.digest}, needed is {digest.strip()}: it is another archive, or was "
            "changed; use the right one"
        )


def _prepare(temp: Path, manifest: ArchiveManifest, archive: Path) -> int:
    """Put the workspace beside the campaign file, make the catalog and compare; gives the number of equal views."""
    campaign, record = temp / _UNPACKED / CAMPAIGN, temp / _UNPACKED / WORKSPACE
    place = campaign / WORKSPACE_FOLDER
    is_there = f"{CAMPAIGN}/{manifest.campaign}" in manifest.files and "/" not in manifest.campaign
    if not is_there or not record.is_dir() or place.exists():
        raise StorageError(f"{archive} holds no campaign file with a workspace; use another copy of it")
    with faults_of_the_system(temp):
        record.rename(place)
    workspace = existing_workspace(place)
    rebuild_catalog(workspace)
    return _compared(manifest.answers, answers_of(workspace), archive)


def _compared(before: Answers, now: Answers, archive: Path) -> int:
    if before.definitions != now.definitions:
        return 0
    differing = sorted(view for view in before.views if now.views.get(view) != before.views[view])
    if differing:
        raise StorageError(
            f"{archive}: restored, view {differing[0]} gives {now.views[differing[0]].rows} rows that are not the "
            f"{before.views[differing[0]].rows} that were archived; write the archive again, or restore with the tiltwatch "
            "that wrote it"
        )
    return len(before.views)


def _put_in_place(temp: Path, target: Path) -> None:
    if hasattr(os, "sync"):
        os.sync()
    if target.exists():
        target.rmdir()
    temp.rename(target)
    sync_folder(target.parent)
