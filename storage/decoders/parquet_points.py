"""Records of a Parquet scan, decoded by Arrow in a child process (decision 0027)."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.decoders import parquet_program
from storage.decoders.pool import DecoderPool
from storage.decoders.process import DecoderProcess, DecoderProgram, Limits

MEMORY_BYTES: Final = 1 << 30
"""For Arrow: three columns with a page of 64 MiB each, packed, unpacked, its dictionary and its values."""

COMPUTING_S: Final = 3.0
WAITING_S: Final = 60.0
RECORD_S: Final = 20e-6
"""More for each record; some tenths of a microsecond are usual."""

PIECE_RECORDS: Final = 1 << 16
NUMBER_BYTES: Final = 8

DECODERS: Final = DecoderPool(DecoderProgram("Parquet", Path(parquet_program.__file__), MEMORY_BYTES))


@dataclass(frozen=True, slots=True)
class FooterLimits:
    """The longest footer, and the most items in one of its lists, that Arrow is to believe."""

    n_bytes: int
    n_items: int


@dataclass(frozen=True, slots=True)
class ToldField:
    """A column as Arrow knows it; ``float_bits`` or ``quantum`` where it holds numbers."""

    name: str
    type_name: str
    float_bits: int | None
    quantum: float | None


@dataclass(frozen=True, slots=True)
class ToldSchema:
    """The paths of all leaves, and the columns at the top."""

    paths: tuple[str, ...]
    fields: tuple[ToldField, ...]


def told_schema(path: Path, limits: FooterLimits) -> ToldSchema:
    """Columns of a Parquet file.

    Raises
    ------
    DecoderFault, DecoderLost
        If its footer is damaged.
    """
    with _opened(path, limits) as (decoder, schema):
        decoder.ask("close", _limits(0))
    return schema


def decoded_columns(
    path: Path, limits: FooterLimits, names: Sequence[str]
) -> Iterator[tuple[NDArray[np.float64], int]]:
    """Numbers (m, k) of some columns, gone when the next are taken, and how many records lack one, which is NaN there.

    Raises
    ------
    DecoderFault, DecoderLost
        If pages are damaged.
    """
    columns = list(names)
    with _opened(path, limits) as (decoder, _):
        decoder.memory.grow(PIECE_RECORDS * len(columns) * NUMBER_BYTES)
        decoder.ask("begin", _limits(0), names=columns, piece_records=PIECE_RECORDS)
        while (told := decoder.ask("decode", _limits(PIECE_RECORDS), names=columns)) is not None:
            count, n_incomplete = told
            seen = decoder.see(0, count * len(columns) * NUMBER_BYTES)
            yield seen.view(np.float64).reshape(-1, len(columns)), n_incomplete
        decoder.ask("close", _limits(0))


@contextmanager
def _opened(path: Path, limits: FooterLimits) -> Iterator[tuple[DecoderProcess, ToldSchema]]:
    place = os.fsencode(os.path.abspath(path)).decode("latin-1")  # noqa: PTH100 - links are followed by who opens it
    with DECODERS.borrowed() as decoder:
        paths, fields = decoder.ask(
            "open", _limits(0), path=place, footer_bytes=limits.n_bytes, items=limits.n_items
        )
        yield decoder, ToldSchema(tuple(paths), tuple(ToldField(**field) for field in fields))


def _limits(n_records: int) -> Limits:
    return Limits(COMPUTING_S + RECORD_S * n_records, WAITING_S + RECORD_S * n_records)
