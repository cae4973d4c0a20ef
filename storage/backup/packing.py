"""Write an archive: a plain tar, which any program opens, the same bytes for the same content."""

import hashlib
import io
import tarfile
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import BinaryIO

from storage.backup.contents import ArchiveRequest, Member, cache_members, campaign_members
from storage.backup.holding import held_record
from storage.backup.manifest import MANIFEST, ArchiveManifest
from storage.backup.names import is_plain, spelling
from storage.errors import StorageError
from storage.identity import SCHEMA_VERSION
from storage.named_files import write_named_file
from storage.store import Content
from storage.workspace import Workspace


@dataclass(frozen=True, slots=True)
class WrittenArchive:
    """What was written."""

    digest: str
    """SHA-256 of the manifest: put it down beside the archive, and hold the restored one against it."""
    n_files: int
    n_bytes: int
    epochs: int


def write_archive(
    ws: Workspace, request: ArchiveRequest, out: Path | BinaryIO, left_out: Iterable[str] = ()
) -> WrittenArchive:
    """Write the record of a workspace, and what else is asked for, as one tar.

    While the record is held fast nothing is published, which takes seconds; it is written afterwards, however slowly.
    Nothing is compressed: Parquet and LAZ are, and a member can be no larger than the file that holds it.

    Parameters
    ----------
    out : Path or binary file
        Where to; a file at a path appears whole or not at all.
    left_out : strings
        What the campaign needs and the archive does not hold, in words; told by the manifest.

    Raises
    ------
    StorageError
        If a file cannot be read or changes meanwhile, the catalog cannot be read, or the disk refuses.
    UsageError
        If what stages made is asked for and lies in a store elsewhere.
    """
    made: list[ArchiveManifest] = []

    def write(file: BinaryIO) -> None:
        made.append(_pack(ws, request, file, tuple(left_out)))

    if isinstance(out, Path):
        write_named_file(out, write)
    else:
        write(out)
    (manifest,) = made
    n_bytes = sum(content.size for content in manifest.files.values())
    epochs = manifest.answers.views["epochs"].rows
    return WrittenArchive(manifest.digest, len(manifest.files), n_bytes, epochs)


def _pack(
    ws: Workspace, request: ArchiveRequest, out: BinaryIO, left_out: tuple[str, ...]
) -> ArchiveManifest:
    files: dict[str, Content] = {}
    with (
        tarfile.open(fileobj=out, mode="w|", format=tarfile.PAX_FORMAT) as tar,
        held_record(ws, request) as (answers, members),
    ):
        spelt: set[str] = set()
        cache = cache_members(ws) if request.cache else ()
        for member in chain(members, campaign_members(request), cache):
            _check_name(member, spelt)
            files[member.name] = _add(tar, member)
        manifest = ArchiveManifest(request.campaign.name, SCHEMA_VERSION, files, answers, left_out)
        text = manifest.to_json()
        tar.addfile(_header(MANIFEST, len(text)), io.BytesIO(text))
    return manifest


def _check_name(member: Member, spelt: set[str]) -> None:
    if not is_plain(member.name) or spelling(member.name) in spelt:
        raise StorageError(
            f"{member.name!r} would be another file on other systems (a sign, a device, or the same name but for "
            "capitals); give it another name and write the archive again"
        )
    spelt.add(spelling(member.name))


def _add(tar: tarfile.TarFile, member: Member) -> Content:
    with _opened(member.path) as file:
        size = file.seek(0, io.SEEK_END)
        file.seek(0)
        hashed = _Hashed(file, member.path)
        try:
            tar.addfile(_header(member.name, size), hashed)
        except OSError as fault:
            if fault.errno is not None:  # the archive cannot be written, which is told above
                raise
            raise _changed(member.path) from fault
    return Content(hashed.sha.hexdigest(), size)


def _opened(path: Path) -> BinaryIO:
    try:
        return path.open("rb")
    except OSError as fault:
        raise StorageError(
            f"cannot read {path}: {fault.strerror}; put that right and write the archive again"
        ) from fault


def _changed(path: Path) -> StorageError:
    return StorageError(f"{path} became shorter while it was read; write the archive again")


def _header(name: str, size: int) -> tarfile.TarInfo:
    header = tarfile.TarInfo(name)
    header.size, header.mode, header.mtime = size, 0o644, 0
    return header


class _Hashed(io.RawIOBase):
    """A file that is hashed as it is read."""

    def __init__(self, file: BinaryIO, path: Path) -> None:
        super().__init__()
        self._file, self._path = file, path
        self.sha = hashlib.sha256()

    def read(self, size: int = -1) -> bytes:
        try:
            content = self._file.read(size)
        except OSError as fault:
            raise StorageError(
                f"cannot read {self._path}: {fault.strerror}; restore that file from a backup and write the archive again"
            ) from fault
        self.sha.update(content)
        return content
