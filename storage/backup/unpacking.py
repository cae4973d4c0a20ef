"""Take an archive apart: only plain files under names of ours, each held against its digest."""

import hashlib
import tarfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, BinaryIO, Final

from storage.atomic import faults_of_the_system
from storage.backup.contents import CAMPAIGN, WORKSPACE, is_of_the_record
from storage.backup.manifest import MANIFEST, ArchiveManifest, manifest_from
from storage.backup.names import is_plain, spelling
from storage.errors import StorageError
from storage.store import Content

BYTES_AT_ONCE: Final = 1 << 20
LARGEST_MANIFEST: Final = 1 << 30
"""A million files need a quarter of this."""


@dataclass(frozen=True, slots=True)
class _Source:
    """The tar, and its name for messages."""

    tar: tarfile.TarFile
    name: str


def unpack(archive: Path, folder: Path) -> ArchiveManifest:
    """Write the files of an archive below a folder; what it says of itself is returned.

    Raises
    ------
    StorageError
        If it is no archive of ours, was cut short, holds anything but plain files below ``campaign`` and ``workspace``,
        or a file that does not have its digest; or if the disk refuses.
    """
    try:
        with archive.open("rb") as file:
            return _unpacked(file, archive, folder)
    except OSError as fault:
        raise StorageError(
            f"cannot read {archive}: {fault.strerror or fault}; check the path and the disk"
        ) from fault


def _unpacked(file: BinaryIO, archive: Path, folder: Path) -> ArchiveManifest:
    found: dict[str, Content] = {}
    try:
        with tarfile.open(fileobj=file, mode="r|") as tar:
            manifest = _take_all(_Source(tar, str(archive)), folder, found)
    except (tarfile.TarError, EOFError, ValueError, OverflowError, RecursionError) as fault:
        raise StorageError(
            f"{archive} is no archive of tiltwatch, or damaged ({fault}); use another copy of it"
        ) from fault
    _hold_against(manifest, found, archive)
    return manifest


def _take_all(source: _Source, folder: Path, found: dict[str, Content]) -> ArchiveManifest:
    spelt: set[str] = set()
    for member in source.tar:
        content = _content_of(source, member)
        if member.name == MANIFEST:
            if member.size > LARGEST_MANIFEST:
                raise StorageError(
                    f"{source.name}: its {MANIFEST} has {member.size} bytes; use another copy of it"
                )
            return manifest_from(content.read(), source.name)
        _check_name(source, member.name)
        if spelling(member.name) in spelt:
            raise StorageError(f"{source.name} holds {member.name!r} twice; use another copy of it")
        spelt.add(spelling(member.name))
        found[member.name] = _written(content, folder / member.name)
    raise StorageError(
        f"{source.name} was cut short: it has no {MANIFEST} at its end; use another copy of it"
    )


def _content_of(source: _Source, member: tarfile.TarInfo) -> IO[bytes]:
    """What a member holds.

    Raises
    ------
    StorageError
        If it is a link, a device, a folder or has holes.
    """
    content = source.tar.extractfile(member) if member.isreg() and not member.issparse() else None
    if content is None:
        raise StorageError(
            f"{source.name} holds {member.name!r}, which is no plain file; it was not written by tiltwatch"
        )
    return content


def _check_name(source: _Source, name: str) -> None:
    top, _, below = name.partition("/")
    if top not in (CAMPAIGN, WORKSPACE) or not is_plain(name) or not below:
        raise StorageError(
            f"{source.name} holds {name!r}, which would lie elsewhere than in the new folder; it was not written by "
            "tiltwatch"
        )
    if top == WORKSPACE and not is_of_the_record(below):
        raise StorageError(
            f"{source.name} holds {name!r}, which is no part of a record; it was not written by tiltwatch"
        )


def _written(content: IO[bytes], path: Path) -> Content:
    digest, size = hashlib.sha256(), 0
    with faults_of_the_system(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        target = path.open("xb")
    with target:
        for piece in _pieces(content):
            digest.update(piece)
            size += len(piece)
            with faults_of_the_system(path):
                target.write(piece)
        with faults_of_the_system(path):
            target.flush()
    return Content(digest.hexdigest(), size)


def _pieces(content: IO[bytes]) -> Iterator[bytes]:
    while piece := content.read(BYTES_AT_ONCE):
        yield piece


def _hold_against(manifest: ArchiveManifest, found: dict[str, Content], archive: Path) -> None:
    missing = sorted(manifest.files.keys() - found.keys())
    strange = sorted(found.keys() - manifest.files.keys())
    changed = sorted(
        name for name in found.keys() & manifest.files.keys() if found[name] != manifest.files[name]
    )
    wrong = (("lacks", missing), ("holds besides", strange), ("holds damaged", changed))
    told = [f"{what} {names[0]!r}{_and_more(names)}" for what, names in wrong if names]
    if told:
        raise StorageError(f"{archive} {'; '.join(told)}; use another copy of it")


def _and_more(names: list[str]) -> str:
    return f" and {len(names) - 1} more" if len(names) > 1 else ""
