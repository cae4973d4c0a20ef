"""Columns of Arrow from plain Python values, made from buffers.

``pyarrow.array`` asks whether a list is one of pandas', and imports pandas for that where it is installed: a third of a
second, which no command here needs.
"""

from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from itertools import accumulate
from typing import Any, Final

import numpy as np
import pyarrow as pa

MICROSECONDS: Final = pa.timestamp("us", tz="UTC")

START_OF_TIME: Final = datetime(1970, 1, 1, tzinfo=UTC)
MICROSECOND: Final = timedelta(microseconds=1)

MOST_TEXT_BYTES: Final = 2**31 - 1
"""Of one column: offsets into its text are of 32 bits."""


def arrow_column(values: Sequence[Any], kind: pa.DataType) -> pa.Array:
    """Arrow array of values that fit the type: bool, int64, float64, text, or instants in microseconds; None is NULL."""
    there = np.fromiter((value is not None for value in values), dtype=np.bool_, count=len(values))
    made = _MAKERS.get(kind)
    buffers = None if made is None else made(values)
    if buffers is None:
        return pa.array(values, type=kind)
    nulls = len(values) - int(there.sum())
    validity = None if nulls == 0 else _bits(there)
    return pa.Array.from_buffers(kind, len(values), [validity, *buffers], nulls)


def _bits(flags: Any) -> pa.Buffer:
    return pa.py_buffer(np.packbits(flags, bitorder="little").tobytes())


def _bools(values: Sequence[bool | None]) -> list[pa.Buffer] | None:
    return [_bits(np.fromiter((value is True for value in values), dtype=np.bool_, count=len(values)))]


def _ints(values: Sequence[int | None]) -> list[pa.Buffer] | None:
    return [pa.py_buffer(np.array([0 if value is None else value for value in values], np.int64).tobytes())]


def _floats(values: Sequence[float | None]) -> list[pa.Buffer] | None:
    return [pa.py_buffer(np.array([0.0 if value is None else value for value in values], float).tobytes())]


def _texts(values: Sequence[str | None]) -> list[pa.Buffer] | None:
    encoded = [b"" if value is None else value.encode() for value in values]
    ends = list(accumulate(map(len, encoded), initial=0))
    if ends[-1] > MOST_TEXT_BYTES:
        return None
    return [pa.py_buffer(np.array(ends, np.int32).tobytes()), pa.py_buffer(b"".join(encoded))]


def _instants(values: Sequence[datetime | None]) -> list[pa.Buffer] | None:
    return _ints([None if value is None else (value - START_OF_TIME) // MICROSECOND for value in values])


_MAKERS: Final[Mapping[pa.DataType, Callable[[Any], list[pa.Buffer] | None]]] = {
    pa.bool_(): _bools,
    pa.int64(): _ints,
    pa.float64(): _floats,
    pa.string(): _texts,
    MICROSECONDS: _instants,
}
