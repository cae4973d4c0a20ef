"""LAZ decoded in a child process: a damaged chunk may make the decoder crash, loop or fill the memory (decision 0027)."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import lazrs
import numpy as np
from numpy.typing import NDArray

from storage.decoders.pool import DecoderPool
from storage.decoders.process import DecoderProcess, DecoderProgram, Limits
from tasks.ingest import laz_program
from tasks.ingest.third_party import decoding

MEMORY_BYTES: Final = 768 << 20
"""For the decoder besides the records: the chunks of a piece, packed; at most 32 MiB where they are not."""

COMPUTING_S: Final = 3.0
COMPUTING_A_POINT_S: Final = 20e-6
"""Of all cores together; some tenths of a microsecond are usual."""

WAITING_S: Final = 60.0
WAITING_A_POINT_S: Final = 100e-6
"""For disks and networks that are slow, and machines that are busy."""

ENTRY_BYTES: Final = 16
"""Of a chunk in the chunk table as it is handed over: how many points and bytes it has."""

COORDINATES: Final = lazrs.SELECTIVE_DECOMPRESS_XY_RETURNS_CHANNEL | lazrs.SELECTIVE_DECOMPRESS_Z
"""The point formats before 6 cannot be decoded in part and ignore what is asked for."""

EXTRA: Final = lazrs.SELECTIVE_DECOMPRESS_XY_RETURNS_CHANNEL | lazrs.SELECTIVE_DECOMPRESS_ALL_EXTRA_BYTES

DECODERS: Final = DecoderPool(DecoderProgram("LAZ", Path(laz_program.__file__), MEMORY_BYTES))


@dataclass(frozen=True, slots=True)
class Packed:
    """The compressed points of a file: where they begin, and the record that says how they are packed."""

    path: Path
    points_at: int
    record: bytes

    @property
    def words(self) -> dict[str, str | int]:
        """The same for the child."""
        place = os.path.abspath(self.path)  # noqa: PTH100 - links are followed by who opens it
        return {
            "path": os.fsencode(place).decode("latin-1"),
            "points_at": self.points_at,
            "record": self.record.decode("latin-1"),
        }


def chunk_table(packed: Packed, n_chunks: int) -> list[tuple[int, int]]:
    """Points and bytes of each chunk; more or fewer than ``n_chunks``, where the file says so.

    Raises
    ------
    InputError
        If the table cannot be decoded.
    """
    with decoding(packed.path), DECODERS.borrowed() as decoder:
        decoder.memory.grow(ENTRY_BYTES * max(1, n_chunks))
        count = decoder.ask("chunk_table", _limits(n_chunks), **packed.words)
        pairs = decoder.see(0, ENTRY_BYTES * min(count, n_chunks)).view(np.uint64).reshape(-1, 2).tolist()
    return [(n_points, n_bytes) for n_points, n_bytes in pairs] + [(0, 0)] * (count - n_chunks)


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to decode of a file, and how: records of so many bytes, so many at a time."""

    n_points: int
    record_bytes: int
    piece_points: int
    selection: int
    in_parallel: bool


def decoded_records(packed: Packed, wanted: Wanted) -> Iterator[NDArray[np.uint8]]:
    """Records (m, bytes of a record) of a file; a piece is gone when the next is taken.

    While a piece is looked at here, the next is decoded there.

    Raises
    ------
    InputError
        If they cannot be decoded.
    """
    piece = min(wanted.piece_points, wanted.n_points)
    counts = [min(piece, wanted.n_points - done) for done in range(0, wanted.n_points, piece)]
    with decoding(packed.path), DECODERS.borrowed() as decoder:
        decoder.memory.grow(min(2, len(counts)) * piece * wanted.record_bytes)
        decoder.ask(
            "open", _limits(0), **packed.words, selection=wanted.selection, in_parallel=wanted.in_parallel
        )
        places = [
            (index % 2 * piece * wanted.record_bytes, count * wanted.record_bytes)
            for index, count in enumerate(counts)
        ]
        yield from _one_ahead(decoder, places, wanted.record_bytes)
        decoder.ask("close", _limits(0))


def _one_ahead(
    decoder: DecoderProcess, places: Sequence[tuple[int, int]], record_bytes: int
) -> Iterator[NDArray[np.uint8]]:
    """Have each place, its start and its bytes, filled while the one before is looked at."""
    for place, following in pairwise((None, *places, None)):
        if place is not None:
            decoder.answer()
        if following is not None:
            start, n_bytes = following
            decoder.send("decode", _limits(n_bytes // record_bytes), start=start, n_bytes=n_bytes)
        if place is not None:
            yield decoder.see(*place).reshape(-1, record_bytes)


def _limits(n_points: int) -> Limits:
    return Limits(COMPUTING_S + COMPUTING_A_POINT_S * n_points, WAITING_S + WAITING_A_POINT_S * n_points)
