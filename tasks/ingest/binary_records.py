"""Records of a fixed width whose count a header states: three of their fields, piece by piece."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError

LINE_ENDS: Final = frozenset({b"", b"\n", b"\r", b"\r\n"})
"""What a transfer may put behind the last record."""

PIECE_BYTES: Final = 16 << 20
"""Of records, held at a time."""


@dataclass(frozen=True, slots=True)
class FixedRecords:
    """Where the records of a file are, and their three wanted fields.

    ``types`` are of the kind "<f4"; ``offsets`` and ``record_bytes`` are in bytes, ``at`` from the start of the file.
    """

    n_records: int
    types: tuple[str, str, str]
    offsets: tuple[int, int, int]
    record_bytes: int
    at: int

    @property
    def end(self) -> int:
        """The byte behind the last record."""
        return self.at + self.n_records * self.record_bytes


def size_of(file: BinaryIO) -> int:
    """Bytes of a file; it then stands at its end."""
    return file.seek(0, io.SEEK_END)


def check_room(path: Path, size_bytes: int, records: FixedRecords) -> None:
    """Refuse a count of records for which the file is too short.

    Raises
    ------
    InputError
        With both counts.
    """
    if records.end > size_bytes:
        found = max(0, size_bytes - records.at) // records.record_bytes
        raise InputError(
            f"{path}: needs the {records.n_records} points of {records.record_bytes} bytes that its header states, "
            f"came {found}; the file is cut short or damaged, copy or export it again"
        )


def is_slack(rest: bytes) -> bool:
    """Whether what is behind the last record is a line end, that a transfer may have put there."""
    return rest in LINE_ENDS


def read_records(path: Path, file: BinaryIO, records: FixedRecords) -> NDArray[np.float64]:
    """The three wanted fields (n_records, 3).

    Raises
    ------
    InputError
        If the file is too short.
    """
    check_room(path, size_of(file), records)
    values = np.empty((records.n_records, 3))
    piece = max(1, PIECE_BYTES // records.record_bytes)
    dtype = np.dtype(
        {
            "names": ["x", "y", "z"],
            "formats": list(records.types),
            "offsets": list(records.offsets),
            "itemsize": records.record_bytes,
        }
    )
    file.seek(records.at)
    for start in range(0, records.n_records, piece):
        stop = min(start + piece, records.n_records)
        block = np.frombuffer(file.read((stop - start) * records.record_bytes), dtype)
        if len(block) < stop - start:
            raise InputError(
                f"{path}: needs a finished file, came one that shrank while it was read; try again"
            )
        for column, name in enumerate(("x", "y", "z")):
            values[start:stop, column] = block[name]
    return values


def storage_step(types: Sequence[str], values: NDArray[np.float64]) -> float:
    """Coarsest step of the columns of values (n, 3) in the types that hold them: 1 for whole numbers."""
    steps = []
    for number_type, column in zip(types, values.T, strict=True):
        dtype = np.dtype(number_type)
        if dtype.kind != "f":
            steps.append(1.0)
        else:
            farthest = np.nanmax(np.abs(column), initial=0.0).astype(dtype.newbyteorder("="))
            # what is infinite is refused elsewhere
            steps.append(float(np.spacing(farthest)) if np.isfinite(farthest) else 0.0)
    return max(steps)


def zero_missing(path: Path, values: NDArray[np.float64]) -> tuple[str, ...]:
    """Set records (n, 3) that are NaN in all three to zero, in place, and say how many.

    NaN and (0, 0, 0) both stand for a beam without a return; the latter are counted and left out for all formats.

    Raises
    ------
    InputError
        If all records are NaN.
    """
    if not np.isnan(values[:, 0]).any():
        return ()
    is_missing = np.isnan(values).all(axis=1)
    n_missing = int(np.count_nonzero(is_missing))
    if n_missing == len(values):
        raise InputError(
            f"{path}: needs points, came {n_missing} records that are all NaN; export the scan again"
        )
    values[is_missing] = 0.0
    return (
        (f"{n_missing} of {len(values)} records are NaN, which is taken as (0, 0, 0)",) if n_missing else ()
    )
