"""The chunk table of a LAZ file, checked before the decoder allocates what it says.

A LAZ file ends in a table of its chunks. A file that was cut short has lost it, and a damaged one disagrees with
the header: either is found here without decoding a point.
"""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO, Final

from storage.errors import InputError
from tasks.ingest.las_header import LasHeader
from tasks.ingest.las_records import LasRecord
from tasks.ingest.laz_decoder import Packed, chunk_table

LASZIP_OWNER: Final = b"laszip encoded"
LASZIP_NUMBER: Final = 22204
POINTWISE_CHUNKED: Final = 2
LAYERED_CHUNKED: Final = 3
VARIABLE: Final = 0xFFFFFFFF
ITEM_BYTES: Final[Mapping[int, int]] = MappingProxyType(
    {6: 20, 7: 8, 8: 6, 9: 29, 10: 30, 11: 6, 12: 8, 13: 29}
)
"""Size by type of item; extra bytes (0 and 14) have any."""

ITEM_LAYERS: Final[Mapping[int, int]] = MappingProxyType({10: 9, 11: 1, 12: 2, 13: 1})
"""Layers by type of item in layered chunks; extra bytes (14) have one a byte."""

EXTRA_BYTES_LAYERED: Final = 14

MOST_POINTS_A_BYTE: Final = 4096
"""Three million points that are all the same take a byte for 630 of them; no scan is near that."""


@dataclass(frozen=True, slots=True)
class _Compression:
    record: bytes
    is_layered: bool
    chunk_points: int
    n_layers: int


@dataclass(frozen=True, slots=True)
class Chunk:
    """A chunk; ``n_points`` is what it can hold, of the last chunk of a fixed size it may hold fewer."""

    at: int
    n_bytes: int
    n_points: int


def packed_points(path: Path, header: LasHeader, records: Sequence[LasRecord]) -> Packed:
    """Where the compressed points of a LAZ file are, and how they are packed.

    Raises
    ------
    InputError
        If they are not packed as this program knows it.
    """
    return Packed(path, header.points_at, _compression(path, header, records).record)


def read_chunks(
    path: Path, file: BinaryIO, header: LasHeader, records: Sequence[LasRecord]
) -> tuple[Chunk, ...]:
    """Chunks of a LAZ file that agree with its header, its size and, where they are layered, with themselves.

    Raises
    ------
    InputError
        If they do not.
    """
    compression = _compression(path, header, records)
    table_at, n_chunks = _table(path, file, header)
    entries = chunk_table(Packed(path, header.points_at, compression.record), n_chunks)
    chunks: list[Chunk] = []
    at = header.points_at + 8
    for n_points, n_bytes in entries:
        chunks.append(Chunk(at, n_bytes, n_points))
        at += n_bytes
    if len(entries) != n_chunks or at != table_at:
        raise _damaged(path, f"{n_chunks} chunks up to byte {table_at}", f"{len(entries)} up to byte {at}")
    if compression.is_layered:
        _check_layers(path, file, header, compression, chunks)
    _check_count(path, header, compression, chunks)
    return tuple(chunks)


def _damaged(path: Path, needed: str, came: str) -> InputError:
    return InputError(
        f"{path}: needs {needed}, came {came}; the file is cut short or damaged, copy or export it again"
    )


def _compression(path: Path, header: LasHeader, records: Sequence[LasRecord]) -> _Compression:
    for record in records:
        if record.owner == LASZIP_OWNER and record.number == LASZIP_NUMBER and len(record.content) >= 34:
            break
    else:
        raise _damaged(path, "a laszip record before compressed points", "none")
    (compressor,) = struct.unpack_from("<H", record.content)
    chunk_points, n_items = struct.unpack_from("<I16xH", record.content, 12)
    if compressor not in {POINTWISE_CHUNKED, LAYERED_CHUNKED}:
        raise InputError(
            f"{path}: needs LAZ compressed in chunks, came compressor {compressor}; export it again with a newer program"
        )
    if len(record.content) < 34 + 6 * n_items or chunk_points == 0:
        raise _damaged(path, f"a laszip record with {n_items} items", f"one of {len(record.content)} bytes")
    items = [struct.unpack_from("<HHH", record.content, 34 + 6 * index) for index in range(n_items)]
    if any(ITEM_BYTES.get(kind, size) != size for kind, size, _ in items) or (
        sum(size for _, size, _ in items) != header.record_bytes
    ):
        raise _damaged(
            path,
            f"items that fill a point record of {header.record_bytes} bytes",
            f"sizes {[i[1] for i in items]}",
        )
    n_layers = sum(
        size if kind == EXTRA_BYTES_LAYERED else ITEM_LAYERS.get(kind, 0) for kind, size, _ in items
    )
    return _Compression(record.content, compressor == LAYERED_CHUNKED, chunk_points, n_layers)


def _table(path: Path, file: BinaryIO, header: LasHeader) -> tuple[int, int]:
    """Where the chunk table is, and how many chunks it has; it may be named at the end of the file instead."""
    for place in (header.points_at, header.size_bytes - 8):
        file.seek(place)
        pointer = file.read(8)
        if len(pointer) == 8 and (table_at := struct.unpack("<q", pointer)[0]) > header.points_at:
            break
    else:
        raise _damaged(path, "a chunk table behind the points", "none")
    if table_at + 8 > header.size_bytes:
        raise _damaged(path, f"a chunk table at byte {table_at}", f"a file of {header.size_bytes} bytes")
    file.seek(table_at)
    (n_chunks,) = struct.unpack("<4xI", file.read(8))
    # a chunk begins with its first point as it is; an empty one may stand at the end
    most = (table_at - header.points_at - 8) // header.record_bytes + 1
    if n_chunks > most:
        raise _damaged(path, f"at most {most} chunks in {table_at - header.points_at} bytes", f"{n_chunks}")
    return table_at, n_chunks


def _check_count(path: Path, header: LasHeader, compression: _Compression, chunks: Sequence[Chunk]) -> None:
    filled = [chunk for chunk in chunks if chunk.n_bytes]
    n_bytes = sum(chunk.n_bytes for chunk in filled)
    if header.n_points > MOST_POINTS_A_BYTE * n_bytes:
        raise _damaged(
            path, f"the {header.n_points} points that its header states", f"{n_bytes} bytes of points"
        )
    most = sum(chunk.n_points for chunk in filled)
    last = filled[-1].n_points if filled else 0
    fewest = most if compression.chunk_points == VARIABLE else most - last + 1
    if not fewest <= header.n_points <= most:
        raise _damaged(
            path,
            f"the {header.n_points} points that its header states",
            f"{len(filled)} chunks that hold {fewest} to {most}"
            if fewest < most
            else f"chunks that hold {most}",
        )


def _check_layers(
    path: Path, file: BinaryIO, header: LasHeader, compression: _Compression, chunks: Sequence[Chunk]
) -> None:
    """A layered chunk is its first point, its count, the sizes of its layers, and these: all must add up."""
    n_points = 0
    head_bytes = header.record_bytes + 4 + 4 * compression.n_layers
    for index, chunk in enumerate(chunk for chunk in chunks if chunk.n_bytes):
        file.seek(chunk.at + header.record_bytes)
        head = file.read(head_bytes - header.record_bytes)
        if chunk.n_bytes < head_bytes or len(head) < head_bytes - header.record_bytes:
            raise _damaged(path, f"{head_bytes} bytes at the head of chunk {index}", f"{chunk.n_bytes}")
        count, *layers = struct.unpack(f"<{1 + compression.n_layers}I", head)
        if head_bytes + sum(layers) != chunk.n_bytes:
            raise _damaged(
                path, f"{chunk.n_bytes} bytes in chunk {index}", f"layers of {head_bytes + sum(layers)}"
            )
        if count > chunk.n_points:
            raise _damaged(path, f"at most {chunk.n_points} points in chunk {index}", f"{count}")
        n_points += count
    if n_points != header.n_points:
        raise _damaged(
            path, f"the {header.n_points} points that its header states", f"chunks that hold {n_points}"
        )
