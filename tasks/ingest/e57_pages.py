"""The pages of an E57 file: 1020 bytes of content and a checksum each (ASTM E2807, 7.1)."""

import struct
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError

SIGNATURE: Final = b"ASTM-E57"
HEADER_BYTES: Final = 48
PAGE_BYTES: Final = 1024
CONTENT_BYTES: Final = 1020
MAJOR_VERSION: Final = 1

LARGEST_XML_BYTES: Final = 16 << 20
"""A scan takes 3 kB of it and an image 2 kB; pictures and points are not in it."""

PAGES_AT_ONCE: Final = 1024
"""Whose checksums are looked up together: 4 MB."""

CASTAGNOLI: Final = 0x82F63B78
"""The polynomial of CRC-32C, bits reversed."""


@dataclass(frozen=True, slots=True)
class E57Pages:
    """An open file whose header agrees with its size; ``size_bytes`` counts the checksums too.

    ``xml_at`` is a place in the file, ``xml_bytes`` a length without checksums.
    """

    path: Path
    file: BinaryIO
    size_bytes: int
    xml_at: int
    xml_bytes: int


def open_pages(path: Path, file: BinaryIO) -> E57Pages:
    """Check the header of an E57 file against its size.

    Raises
    ------
    InputError
        If it is no E57 file, or cut short.
    """
    size_bytes = file.seek(0, 2)
    file.seek(0)
    head = file.read(HEADER_BYTES)
    if not head.startswith(SIGNATURE):
        raise InputError(
            f"{path}: needs an E57 file, which begins with 'ASTM-E57', came "
            f"{'an empty file' if not head else repr(head[:8])}; check the file, or export it again"
        )
    if len(head) < HEADER_BYTES:
        raise cut_short(path, f"a header of {HEADER_BYTES} bytes", f"a file of {size_bytes} bytes")
    major, minor, stated_bytes, xml_at, xml_bytes, page_bytes = struct.unpack_from("<IIQQQQ", head, 8)
    if major != MAJOR_VERSION or page_bytes != PAGE_BYTES:
        raise InputError(
            f"{path}: needs E57 1.0 with pages of {PAGE_BYTES} bytes, came version {major}.{minor} with pages of "
            f"{page_bytes}; the header is damaged, copy or export the file again"
        )
    if stated_bytes != size_bytes or size_bytes % PAGE_BYTES:
        raise cut_short(
            path, f"the {stated_bytes} bytes that its header states", f"a file of {size_bytes} bytes"
        )
    pages = E57Pages(path, file, size_bytes, xml_at, xml_bytes)
    check_place(pages, xml_at, xml_bytes, "a description (XML)")
    if xml_bytes > LARGEST_XML_BYTES:
        raise InputError(
            f"{path}: needs a description (XML) of at most {LARGEST_XML_BYTES} bytes, came {xml_bytes}; "
            "export fewer scans a file, without images"
        )
    # the header itself is under the checksum of the first page
    read_content(pages, 0, HEADER_BYTES)
    return pages


def cut_short(path: Path, needed: str, came: str) -> InputError:
    """The error for a file that is not whole."""
    return InputError(
        f"{path}: needs {needed}, came {came}; the file is cut short or damaged, copy or export it again"
    )


def check_place(pages: E57Pages, at: int, n_bytes: int, what: str) -> None:
    """Refuse content that would begin in the header or in a checksum, or end outside the file.

    Raises
    ------
    InputError
        If it does.
    """
    first, start = divmod(at, PAGE_BYTES)
    content_bytes = pages.size_bytes // PAGE_BYTES * CONTENT_BYTES
    if (
        at < HEADER_BYTES
        or start >= CONTENT_BYTES
        or n_bytes <= 0
        or first * CONTENT_BYTES + start + n_bytes > content_bytes
    ):
        raise cut_short(
            pages.path, f"{what} of {n_bytes} bytes from byte {at}", f"a file of {pages.size_bytes} bytes"
        )


def read_content(pages: E57Pages, at: int, n_bytes: int) -> bytes:
    """Content from a place in the file, its checksums verified and taken out.

    Raises
    ------
    InputError
        If a checksum disagrees.
    """
    first, start = divmod(at, PAGE_BYTES)
    n_pages = -(-(start + n_bytes) // CONTENT_BYTES)
    pages.file.seek(first * PAGE_BYTES)
    raw = pages.file.read(n_pages * PAGE_BYTES)
    if len(raw) != n_pages * PAGE_BYTES:
        raise cut_short(pages.path, f"{n_pages} pages from byte {first * PAGE_BYTES}", f"{len(raw)} bytes")
    table = np.frombuffer(raw, np.uint8).reshape(n_pages, PAGE_BYTES)
    content = table[:, :CONTENT_BYTES]
    stated = np.ascontiguousarray(table[:, CONTENT_BYTES:]).view(">u4")[:, 0]
    is_bad = checksums(content) != stated
    if is_bad.any():
        raise InputError(
            f"{pages.path}: needs pages that agree with their checksums, came {int(is_bad.sum())} that do not, the first "
            f"at byte {(first + int(is_bad.argmax())) * PAGE_BYTES}; the file is damaged, copy or export it again"
        )
    return content.tobytes()[start : start + n_bytes]


def checksums(content: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """CRC-32C of every row (n, CONTENT_BYTES).

    The remainder is linear in the bytes: each adds what its place makes of it, so that all are looked up at once.
    """
    tables = _tables()
    found = np.empty(len(content), dtype=np.uint32)
    for start in range(0, len(content), PAGES_AT_ONCE):
        rows = content[start : start + PAGES_AT_ONCE]
        found[start : start + len(rows)] = np.bitwise_xor.reduce(
            tables.of_byte[np.arange(CONTENT_BYTES), rows], axis=1
        )
    return found ^ tables.of_none


@dataclass(frozen=True, slots=True)
class _Tables:
    """What each byte (CONTENT_BYTES, 256) in its place adds to the checksum, and the checksum of zeros."""

    of_byte: NDArray[np.uint32]
    of_none: np.uint32


@cache
def _tables() -> _Tables:
    last = np.array([_remainder(byte) for byte in range(256)], dtype=np.uint32)
    of_byte = np.empty((CONTENT_BYTES, 256), dtype=np.uint32)
    of_byte[-1] = last
    none = np.full(1, 0xFFFFFFFF, dtype=np.uint32)
    for place in range(CONTENT_BYTES - 2, -1, -1):
        of_byte[place] = last[of_byte[place + 1] & 0xFF] ^ (of_byte[place + 1] >> 8)
    for _ in range(CONTENT_BYTES):
        none = last[none & 0xFF] ^ (none >> 8)
    return _Tables(of_byte, ~none[0])


def _remainder(byte: int) -> int:
    for _ in range(8):
        byte = (byte >> 1) ^ (CASTAGNOLI if byte & 1 else 0)
    return byte
