"""Hold the record of a workspace fast as it is at one moment, so that it can be written without keeping others waiting."""

import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final
from uuid import uuid4

from storage.atomic import TEMP_SUFFIX, faults_of_the_system, make_folder
from storage.backup.answers import Answers, answers_of
from storage.backup.contents import WORKSPACE, ArchiveRequest, Member, record_members
from storage.catalog import rebuild_catalog
from storage.catalog_parts import stamps_of
from storage.errors import StorageError
from storage.locks import is_writable, lock_to_read
from storage.workspace import Workspace
from storage.writers import is_writer_gone, mark_of_this_process

HELD: Final = "archive"
"""How the names of folders begin in which a record is held."""


@contextmanager
def held_record(ws: Workspace, request: ArchiveRequest) -> Iterator[tuple[Answers, Sequence[Member]]]:
    """Give what the catalog answers and the files of the record, which stay as they are as long as the block lasts.

    Files are hard links where the system can, else copies: whoever publishes replaces files and never changes one. On a
    drive that is read-only nobody does, and nothing has to be held.

    Raises
    ------
    StorageError
        If the catalog cannot be read, a file of the record is not where it belongs, or the disk refuses.
    """
    if not is_writable(ws):
        if ws.journal.exists():
            raise StorageError(
                f"{ws.root} is read-only and a publication in it did not end; copy the folder to a drive that can be "
                "written, and write the archive there"
            )
        yield answers_of(ws), _members(ws, request)
        return
    place = ws.tmp / f"{HELD}.{mark_of_this_process()}.{uuid4().hex}{TEMP_SUFFIX}"
    try:
        with lock_to_read(ws):
            _sweep(ws)
            rebuild_catalog(ws)
            answers, members = answers_of(ws), [_held(member, place) for member in _members(ws, request)]
        yield answers, members
    finally:
        shutil.rmtree(place, ignore_errors=True)


def _members(ws: Workspace, request: ArchiveRequest) -> list[Member]:
    """The files of the record, among which is everything that the catalog is made of."""
    members = list(record_members(ws, request))
    missing = {f"{WORKSPACE}/{name}" for name in stamps_of(ws)} - {member.name for member in members}
    if missing:
        raise StorageError(
            f"{sorted(missing)[0]} would not be in the archive, and the catalog is made of it: a fault of tiltwatch; copy "
            "the folder instead, and report it"
        )
    return members


def _held(member: Member, place: Path) -> Member:
    target = place / member.name
    with faults_of_the_system(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            os.link(member.path.resolve(), target)
        except OSError:  # another drive, or one without links
            shutil.copyfile(member.path, target)
    return Member(member.name, target)


def _sweep(ws: Workspace) -> None:
    """Remove what writers of archives left that were killed."""
    make_folder(ws.tmp)
    for folder in ws.tmp.glob(f"{HELD}.*{TEMP_SUFFIX}"):
        if is_writer_gone(folder):
            shutil.rmtree(folder, ignore_errors=True)
