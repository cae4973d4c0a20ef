"""A store in a folder of this machine, or of a drive that several machines share."""

import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

from storage.atomic import (
    TEMP_SUFFIX,
    clear_place,
    faults_of_the_system,
    make_folder,
    replace_file,
    sync_folder,
    write_our_own,
    write_temp,
)
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.store import Content
from storage.verified import forget, is_remembered, remember
from storage.workspace import Workspace

# a file is dated back, so that a change in the same tick of the clock still changes its time
_DATED_BACK_NS: Final = 10_000_000_000


@dataclass(frozen=True, slots=True)
class FolderStore:
    """Files below a folder; what was found whole is remembered in it."""

    root: Path

    @property
    def place(self) -> str:
        """The folder."""
        return str(self.root)

    @property
    def incoming(self) -> Path:
        """A file in the folder of the artifacts: a temp beside it is moved by a rename alone."""
        return self._workspace.artifacts / "incoming"

    def put(self, name: str, content: bytes) -> None:
        """Keep bytes under a name."""
        write_our_own(self._path(name), content)

    def take(self, name: str, temp: Path, content: Content) -> None:
        """Keep a finished temp under the name of its content."""
        if self.is_whole(name, content):
            temp.unlink()
            return
        path = self._path(name)
        with faults_of_the_system(path):
            stat = temp.stat()
            os.utime(temp, ns=(stat.st_atime_ns, stat.st_mtime_ns - _DATED_BACK_NS))
        make_folder(path.parent)
        clear_place(path)
        replace_file(temp, path)
        sync_folder(path.parent)
        remember(self._workspace, path)

    def put_file(self, name: str, source: Path, content: Content) -> None:
        """Keep a copy of a file under the name of its content."""
        if self.is_whole(name, content):
            return

        def write(file: BinaryIO) -> None:
            with source.open("rb") as read:
                shutil.copyfileobj(read, file, 1 << 20)

        temp = write_temp(self.incoming, write)
        if file_sha256(temp) != content.sha256:
            temp.unlink()
            raise StorageError(f"{source} changed while it was copied to {self.place}; run again")
        self.take(name, temp, content)

    def get(self, name: str) -> bytes | None:
        """Read what is under a name; None where there is nothing."""
        path = self._path(name)
        try:
            return path.read_bytes()
        except (FileNotFoundError, IsADirectoryError):
            return None
        except OSError as fault:
            raise StorageError(f"cannot read {path}: {fault.strerror}") from fault

    def local_path(self, name: str, content: Content) -> Path:
        """Give the file itself; its size is looked at, its digest was when its record was."""
        path = self._path(name)
        if not path.is_file():
            raise StorageError(f"no {path}; run again to compute it anew")
        size = path.stat().st_size
        if size != content.size:
            raise StorageError(
                f"{path} is damaged (needed {content.size} bytes, it has {size}); delete it and run again to compute it "
                "anew"
            )
        return path

    def size(self, name: str) -> int | None:
        """Bytes under a name; None where there is nothing."""
        path = self._path(name)
        return path.stat().st_size if path.is_file() else None

    def names(self, folder: str) -> Iterator[str]:
        """All names in a folder and below it, sorted."""
        files = (
            path for path in self._path(folder).rglob("*") if path.is_file() and path.suffix != TEMP_SUFFIX
        )
        yield from sorted(path.relative_to(self.root).as_posix() for path in files)

    def remove(self, name: str) -> None:
        """Forget a name."""
        path = self._path(name)
        with faults_of_the_system(path):
            path.unlink(missing_ok=True)

    def is_whole(self, name: str, content: Content) -> bool:
        """Whether the content is there; an unchanged file is not hashed again."""
        path = self._path(name)
        if self.size(name) != content.size:
            return False
        return is_remembered(self._workspace, path) or self.is_whole_by_hash(name, content)

    def is_whole_by_hash(self, name: str, content: Content) -> bool:
        """Whether the content is there by its digest."""
        path = self._path(name)
        if self.size(name) != content.size:
            return False
        if file_sha256(path) != content.sha256:
            forget(self._workspace, path)
            return False
        if not is_remembered(self._workspace, path):
            remember(self._workspace, path)
        return True

    @property
    def _workspace(self) -> Workspace:
        return Workspace(self.root)

    def _path(self, name: str) -> Path:
        return self.root / name
