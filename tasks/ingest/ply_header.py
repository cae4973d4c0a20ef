"""The header of a PLY file: elements and their properties, in the order in which they are stored."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO, Final

import numpy as np

from storage.errors import InputError
from tasks.ingest.text_rows import count_in, next_line

TYPES: Final[Mapping[str, str]] = MappingProxyType(
    {
        **dict.fromkeys(("char", "int8"), "i1"),
        **dict.fromkeys(("uchar", "uint8"), "u1"),
        **dict.fromkeys(("short", "int16"), "i2"),
        **dict.fromkeys(("ushort", "uint16"), "u2"),
        **dict.fromkeys(("int", "int32"), "i4"),
        **dict.fromkeys(("uint", "uint32"), "u4"),
        **dict.fromkeys(("float", "float32"), "f4"),
        **dict.fromkeys(("double", "float64"), "f8"),
        "int64": "i8",
        "uint64": "u8",
    }
)
"""Numpy's codes for the types of PLY; the last two are not of the format, but are met."""

ENCODINGS: Final[Mapping[str, str]] = MappingProxyType(
    {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
)
"""Byte order by the name of the encoding; a text has none."""

MOST_LINES: Final = 10_000
"""Of a header; what has more is no PLY."""


LARGEST_BYTES: Final = 4 << 20
"""Of a header, comments among them."""


@dataclass(frozen=True, slots=True)
class PlyProperty:
    """A number of each record, or a list of numbers if ``length_type`` is not None; types with their byte order."""

    name: str
    type: str
    length_type: str | None


@dataclass(frozen=True, slots=True)
class PlyElement:
    """A table of a PLY file."""

    name: str
    count: int
    properties: tuple[PlyProperty, ...]

    @property
    def has_lists(self) -> bool:
        """Whether the width of its records may vary."""
        return any(known.length_type is not None for known in self.properties)

    @property
    def least_bytes(self) -> int:
        """Bytes of a record whose lists are empty."""
        return sum(np.dtype(known.length_type or known.type).itemsize for known in self.properties)


@dataclass(frozen=True, slots=True)
class PlyHeader:
    """``byte_order`` is empty for text; ``vertex`` is the place of the points among the elements."""

    byte_order: str
    elements: tuple[PlyElement, ...]
    vertex: int
    body_at: int
    first_line: int


def read_ply_header(path: Path, file: BinaryIO) -> PlyHeader:
    """Read the header of a PLY file, which then stands at the first byte behind it.

    Raises
    ------
    InputError
        If it is none, or states no vertices.
    """
    if next_line(path, file) != "ply":
        raise InputError(
            f"{path}: needs a PLY file, came one that does not begin with the line 'ply'; export again"
        )
    lines: list[str] = []
    while (line := next_line(path, file)) != "end_header":
        if line is None or len(lines) == MOST_LINES or file.tell() > LARGEST_BYTES:
            raise InputError(
                f"{path}: needs a header that ends with 'end_header', came none; the file is cut short"
            )
        lines.append(line)
    byte_order = _byte_order(path, lines)
    elements = _elements(path, byte_order, lines)
    places = [place for place, element in enumerate(elements) if element.name == "vertex"]
    if len(places) != 1:
        known = ", ".join(element.name for element in elements[:20]) or "no elements"
        raise InputError(
            f"{path}: needs one element 'vertex', came {len(places)} among {known}; export points again"
        )
    if elements[places[0]].count == 0:
        raise InputError(f"{path}: needs points, came a file that holds no points; export the scan again")
    return PlyHeader(byte_order, elements, places[0], file.tell(), len(lines) + 3)


def _byte_order(path: Path, lines: list[str]) -> str:
    words = next((line.split() for line in lines if line.startswith("format ")), [])
    if len(words) != 3 or words[1] not in ENCODINGS or words[2] != "1.0":
        raise InputError(
            f"{path}: needs a line 'format' of {', '.join(ENCODINGS)} and version 1.0, came "
            f"{' '.join(words)[:60] or 'none'!r}; export again"
        )
    return ENCODINGS[words[1]]


def _elements(path: Path, byte_order: str, lines: list[str]) -> tuple[PlyElement, ...]:
    elements: list[PlyElement] = []
    for number, line in enumerate(lines, start=2):
        words = line.split()
        match words[:1]:
            case [] | ["comment" | "obj_info" | "format"]:
                continue
            case ["element"] if len(words) == 3 and (count := count_in(words[2])) is not None:
                elements.append(PlyElement(words[1], count, ()))
            case ["property"] if elements and (found := _property(byte_order, words)):
                last = elements[-1]
                elements[-1] = PlyElement(last.name, last.count, (*last.properties, found))
            case _:
                raise InputError(
                    f"{path}: needs elements and their properties, came {line[:60]!r} in line {number} of the header; "
                    "export again"
                )
    return tuple(elements)


def _property(byte_order: str, words: list[str]) -> PlyProperty | None:
    """The property that a line states; None if it is none."""
    if len(words) == 3 and words[1] in TYPES:
        return PlyProperty(words[2], byte_order + TYPES[words[1]], None)
    if len(words) == 5 and words[1] == "list" and words[3] in TYPES and TYPES.get(words[2], "f")[0] != "f":
        return PlyProperty(words[4], byte_order + TYPES[words[3]], byte_order + TYPES[words[2]])
    return None
