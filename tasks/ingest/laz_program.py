"""What a decoder of LAZ does in its child process: lazrs, and nothing else that is not in Python itself.

It is run by its path (``storage/decoders``); nobody imports it for its functions.
"""

import mmap
from typing import Any, Final

import lazrs


def _chunk_table(memory: mmap.mmap, path: str, points_at: int, record: str) -> int:
    """Write points and bytes of each chunk into the memory, and tell how many there are; what has no room stays out."""
    with open(_place(path), "rb") as file:  # noqa: PTH123 - a place in bytes
        file.seek(points_at)
        entries = lazrs.read_chunk_table(file, lazrs.LazVlr(record.encode("latin-1")))
    room = memoryview(memory)[: len(memory) // 16 * 16].cast("Q")
    for index, (n_points, n_bytes) in enumerate(entries[: len(room) // 2]):
        room[2 * index], room[2 * index + 1] = n_points, n_bytes
    return len(entries)


class _Scan:
    """The scan that is being decoded."""

    decoder: Any = None
    file: Any = None

    def open(
        self,
        _memory: mmap.mmap | None,
        path: str,
        points_at: int,
        record: str,
        selection: int,
        in_parallel: bool,
    ) -> None:
        """Begin with a scan."""
        self.close(None)
        self.file = open(_place(path), "rb")  # noqa: PTH123, SIM115 - a place in bytes, closed by the next
        self.file.seek(points_at)
        kind = lazrs.ParLasZipDecompressor if in_parallel else lazrs.LasZipDecompressor
        chosen = lazrs.DecompressionSelection(selection)
        self.decoder = kind(self.file, record.encode("latin-1"), chosen)

    def decode(self, memory: mmap.mmap, start: int, n_bytes: int) -> None:
        """Write the next records of the scan into the memory."""
        self.decoder.decompress_many(memoryview(memory)[start : start + n_bytes])

    def close(self, _memory: mmap.mmap | None) -> None:
        """Let go of the scan."""
        self.decoder = None
        if self.file is not None:
            self.file.close()


def _place(path: str) -> bytes:
    """The path as the parent's system has it, whatever the words of this process's."""
    return path.encode("latin-1")


_SCAN: Final = _Scan()
HANDLERS: Final = {
    "chunk_table": _chunk_table,
    "open": _SCAN.open,
    "decode": _SCAN.decode,
    "close": _SCAN.close,
}
