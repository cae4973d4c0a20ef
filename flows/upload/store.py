"""Where unfinished uploads lie, so that each goes on where it stopped: also after a kill of the server or a power cut.

tuspyserver's own store keeps a whole request in memory until it ends, and its older one appends to a file that may hold
more than the offset says after a kill. Here bytes go to the disk as they come, and the offset is noted after what it
counts is on the disk; what lies beyond it is cut off before anything is appended.
"""

import asyncio
import json
import os
import re
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final

from tuspyserver.storage import TusStorage

from storage.atomic import make_folder, write_atomically
from storage.errors import InputError

UID: Final = re.compile(r"[0-9a-f]{32}")
CHECKPOINT_BYTES: Final = 8 * 1024 * 1024
"""At most so much is sent again after a kill."""

WAIT_S: Final = 20.0
FILETYPE: Final = "application/octet-stream"


@dataclass(slots=True)
class _Open:
    file: BinaryIO
    unsaved: int = 0


class UploadStore(TusStorage):
    """Uploads as files ``UID.data`` and ``UID.json`` of a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._open: dict[str, _Open] = {}
        self._locks: dict[str, asyncio.Lock] = {}

    def data(self, uid: str) -> Path:
        """File of the bytes of an upload; it is not there any more where the upload was finished.

        Raises
        ------
        InputError
            If the id is none of ours.
        """
        return self._folder / f"{_checked(uid)}.data"

    def location(self, uid: str) -> str:
        """Path of the bytes."""
        return str(self.data(uid))

    async def create(self, uid: str) -> None:
        """Begin an upload."""
        make_folder(self._folder)
        self.data(uid).touch()

    async def exists(self, uid: str) -> bool:
        """Whether the upload is known, finished or not."""
        return UID.fullmatch(uid) is not None and self._info(uid).is_file()

    async def size(self, uid: str) -> int:
        """Bytes that are safe on the disk."""
        return int((self.info(uid) or {}).get("offset", 0))

    async def append(self, uid: str, chunk: bytes) -> None:
        """Write bytes behind those that are there; only within ``lock``."""
        opened = self._open[uid]
        await asyncio.to_thread(opened.file.write, chunk)
        opened.unsaved += len(chunk)
        if opened.unsaved >= CHECKPOINT_BYTES:
            await asyncio.to_thread(self._checkpoint, uid)

    async def flush(self, uid: str) -> None:
        """Bring all bytes and then their number to the disk."""
        if uid in self._open:
            await asyncio.to_thread(self._checkpoint, uid)

    async def finalize(self, uid: str) -> None:
        """Nothing is left to do when the last byte is on the disk."""

    async def read(self, uid: str) -> bytes | None:
        """All bytes."""
        path = self.data(uid)
        return path.read_bytes() if path.is_file() else None

    async def delete(self, uid: str) -> None:
        """Give an upload up, as its sender asks; a finished one is in the inbox and stays there."""
        self.data(uid).unlink(missing_ok=True)
        self.forget(uid)

    def forget(self, uid: str) -> None:
        """Forget what is known of an upload; its bytes stay."""
        self._info(uid).unlink(missing_ok=True)

    async def read_info(self, uid: str) -> dict[str, Any] | None:
        """What is known of an upload; the library asks for a file type, which not every client sends."""
        info = self.info(uid)
        if info is not None:
            info["metadata"] = {"filetype": FILETYPE, **info["metadata"]}
        return info

    async def write_info(self, uid: str, data: Mapping[str, Any]) -> None:
        """Note what is known of an upload."""
        self._write_info(uid, data)

    async def list_uids(self) -> list[str]:
        """All uploads."""
        return self.uids()

    def uids(self) -> list[str]:
        """All uploads, finished or not."""
        return sorted(path.stem for path in self._folder.glob("*.json") if UID.fullmatch(path.stem))

    def info(self, uid: str) -> dict[str, Any] | None:
        """What is known of an upload; None where nothing is, or the note is damaged."""
        try:
            content = json.loads(self._info(uid).read_bytes())
        except (OSError, ValueError, InputError):
            return None
        return content if isinstance(content, dict) and isinstance(content.get("metadata"), dict) else None

    def is_received(self, uid: str) -> bool:
        """Whether all bytes are there and still wait to be put into the inbox."""
        info = self.info(uid)
        return info is not None and info.get("offset") == info.get("size") and self.data(uid).is_file()

    @asynccontextmanager
    async def lock(self, uid: str) -> AsyncIterator[None]:  # type: ignore[override]  # it means a context manager
        """Hold an upload alone, its file cut to the bytes that count and open at their end."""
        lock = self._locks.setdefault(_checked(uid), asyncio.Lock())
        await asyncio.wait_for(lock.acquire(), WAIT_S)
        try:
            self._open[uid] = _Open(await asyncio.to_thread(self._opened, uid))
            try:
                yield
            finally:
                self._close(uid)
        finally:
            lock.release()

    def _opened(self, uid: str) -> BinaryIO:
        path, offset = self.data(uid), int((self.info(uid) or {}).get("offset", 0))
        if not path.is_file():
            # finished: whatever comes now is refused, because the offset is the size
            return Path(os.devnull).open("r+b")
        file = path.open("r+b")
        file.truncate(offset)
        file.seek(offset)
        return file

    def _close(self, uid: str) -> None:
        try:
            self._checkpoint(uid)
        finally:
            self._open.pop(uid).file.close()

    def _checkpoint(self, uid: str) -> None:
        opened, info = self._open[uid], self.info(uid)
        if opened.unsaved == 0 or info is None:
            return
        opened.file.flush()
        os.fsync(opened.file.fileno())
        opened.unsaved = 0
        self._write_info(uid, {**info, "offset": opened.file.tell()})

    def _write_info(self, uid: str, data: Mapping[str, Any]) -> None:
        write_atomically(self._info(uid), json.dumps(data, default=str).encode())

    def _info(self, uid: str) -> Path:
        return self._folder / f"{_checked(uid)}.json"


def _checked(uid: str) -> str:
    if not UID.fullmatch(uid):
        raise InputError(f"an upload needs an id of 32 hexadecimal digits, got {uid[:80]!r}")
    return uid
