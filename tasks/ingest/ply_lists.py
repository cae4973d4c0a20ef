"""Records of a binary PLY element that hold lists: where each of their properties is.

Mostly all lists are of one length (triangles); then the records have a fixed width after all. Else each record tells
where the next one begins, and they are walked one by one.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.ply_header import PlyElement

PIECE: Final = 1 << 18
"""Numbers, gathered at a time."""


@dataclass(frozen=True, slots=True)
class PlyRecords:
    """Offsets (count, k) of the k wanted properties from the start of the file, and the byte behind the last record."""

    offsets: NDArray[np.int64]
    end: int


def locate_records(
    path: Path, content: NDArray[np.uint8], at: int, element: PlyElement, wanted: tuple[int, ...]
) -> PlyRecords:
    """Where the wanted properties of the records are that begin at byte ``at`` of content (size,).

    Raises
    ------
    InputError
        If the records do not fit into the file.
    """
    # an element without properties takes no bytes, however many it states
    if element.count == 0 or not element.properties:
        return PlyRecords(np.empty((0, len(wanted)), np.int64), at)
    if at + element.count * element.least_bytes > len(content):
        raise _cut(path, element)
    first, stride = _walk(path, content, at, element)
    if at + element.count * stride <= len(content) and _is_regular(content, at, element, first, stride):
        starts = np.arange(element.count, dtype=np.int64)[:, None] * stride
        return PlyRecords(starts + first[list(wanted)], at + element.count * stride)
    offsets, start = np.empty((element.count, len(wanted)), np.int64), at
    for row in range(element.count):
        places, width = _walk(path, content, start, element)
        offsets[row] = places[list(wanted)]
        start += width
    return PlyRecords(offsets, start)


def gather(content: NDArray[np.uint8], offsets: NDArray[np.int64], number_type: str) -> NDArray[np.float64]:
    """The numbers (n,) that begin at offsets (n,)."""
    dtype = np.dtype(number_type)
    numbers = np.empty(len(offsets))
    for start in range(0, len(offsets), PIECE):
        piece = offsets[start : start + PIECE, None] + np.arange(dtype.itemsize)
        numbers[start : start + PIECE] = content[piece].view(dtype)[:, 0]
    return numbers


def _walk(
    path: Path, content: NDArray[np.uint8], at: int, element: PlyElement
) -> tuple[NDArray[np.int64], int]:
    """Places of the properties of the record at byte ``at``, and its width."""
    places, place = [], at
    for known in element.properties:
        places.append(place)
        if known.length_type is None:
            place += np.dtype(known.type).itemsize
        else:
            dtype = np.dtype(known.length_type)
            if place + dtype.itemsize > len(content):
                raise _cut(path, element)
            length = int(content[place : place + dtype.itemsize].view(dtype)[0])
            if length < 0:
                raise InputError(
                    f"{path}: needs lists of 0 and more numbers, came one of {length} in element {element.name!r}; "
                    "the file is damaged, export it again"
                )
            place += dtype.itemsize + length * np.dtype(known.type).itemsize
    if place > len(content):
        raise _cut(path, element)
    return np.array(places, np.int64), place - at


def _is_regular(
    content: NDArray[np.uint8], at: int, element: PlyElement, first: NDArray[np.int64], stride: int
) -> bool:
    """Whether the lists of all records are as long as those of the first one."""
    records = content[at : at + element.count * stride].reshape(element.count, stride)
    return all(
        bool((lengths == lengths[0]).all())
        for place, known in zip(first - at, element.properties, strict=True)
        if known.length_type is not None
        for lengths in records[:, place : place + np.dtype(known.length_type).itemsize].T
    )


def _cut(path: Path, element: PlyElement) -> InputError:
    return InputError(
        f"{path}: needs the {element.count} records of element {element.name!r} that its header states, came the end of "
        "the file within them; it is cut short or damaged, copy or export it again"
    )
