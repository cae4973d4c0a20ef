"""The header of a PCD file, version 0.6 or 0.7."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from storage.errors import InputError
from tasks.ingest.file_pose import pose_of_quaternion
from tasks.ingest.scan import FilePose
from tasks.ingest.text_layout import is_number
from tasks.ingest.text_rows import count_in, next_line

VERSIONS: Final = frozenset({"0.6", ".6", "0.7", ".7"})
ENCODINGS: Final = ("ascii", "binary", "binary_compressed")
SIZES: Final = {"F": ("4", "8"), "I": ("1", "2", "4", "8"), "U": ("1", "2", "4", "8")}
KEYS: Final = frozenset(
    {"VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"}
)
MOST_LINES: Final = 100
"""Of a header, comments among them."""

IDENTITY: Final = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
"""What programs write for VIEWPOINT that know none."""


@dataclass(frozen=True, slots=True)
class PcdField:
    """``count`` numbers of a record; ``type`` is numpy's, little endian."""

    name: str
    type: str
    count: int

    @property
    def width(self) -> int:
        """Bytes of a record that the field takes."""
        return self.count * np.dtype(self.type).itemsize


@dataclass(frozen=True, slots=True)
class PcdHeader:
    """``viewpoint`` is None where it is the identity; ``first_line`` is that of the points in a text."""

    version: str
    fields: tuple[PcdField, ...]
    n_points: int
    viewpoint: FilePose | None
    encoding: str
    body_at: int
    first_line: int

    @property
    def record_bytes(self) -> int:
        """Bytes of a point in binary data."""
        return sum(field.width for field in self.fields)


def read_pcd_header(path: Path, file: BinaryIO) -> PcdHeader:
    """Read the header of a PCD file, which then stands at the first byte behind it.

    Raises
    ------
    InputError
        If it is none, or contradicts itself.
    """
    entries, n_lines = _entries(path, file)
    version = " ".join(entries["VERSION"])
    if version not in VERSIONS:
        raise InputError(f"{path}: needs PCD of version 0.6 or 0.7, came {version[:30]!r}; export again")
    encoding = " ".join(entries["DATA"])
    if encoding not in ENCODINGS:
        raise InputError(f"{path}: needs DATA {', '.join(ENCODINGS)}, came {encoding[:30]!r}; export again")
    return PcdHeader(
        version,
        _fields(path, entries),
        _n_points(path, entries),
        _viewpoint(path, entries),
        encoding,
        file.tell(),
        n_lines + 1,
    )


def _entries(path: Path, file: BinaryIO) -> tuple[dict[str, list[str]], int]:
    """Words of each line of the header by its first word, and the number of lines."""
    entries: dict[str, list[str]] = {}
    for number in range(1, MOST_LINES + 1):
        line = next_line(path, file)
        words = (line or "").split()
        if line is None or (words and words[0] not in KEYS and not words[0].startswith("#")):
            raise InputError(
                f"{path}: needs the header of a PCD file, VERSION to DATA, came "
                f"{'its end' if line is None else repr(line[:60])} in line {number}; "
                "export again, or rename a list of points without a header to .xyz"
            )
        if words and words[0] in KEYS:
            if words[0] in entries:
                raise InputError(
                    f"{path}: needs one line {words[0]}, came another in line {number}; export again"
                )
            entries[words[0]] = words[1:]
        if "DATA" in entries:
            missing = sorted({"VERSION", "FIELDS", "SIZE", "TYPE", "WIDTH"} - entries.keys())
            if missing:
                raise InputError(f"{path}: needs {', '.join(missing)} in its header, came none; export again")
            return entries, number
    raise InputError(
        f"{path}: needs a header that ends with DATA, came none in {MOST_LINES} lines; export again"
    )


def _fields(path: Path, entries: dict[str, list[str]]) -> tuple[PcdField, ...]:
    names, sizes, types = entries["FIELDS"], entries["SIZE"], entries["TYPE"]
    counts = [count_in(word) for word in entries.get("COUNT", ["1"] * len(names))]
    if not (names and len(names) == len(sizes) == len(types) == len(counts)):
        raise InputError(
            f"{path}: needs as many SIZE, TYPE and COUNT as FIELDS, came {len(sizes)}, {len(types)}, {len(counts)} for "
            f"{len(names)}; export again"
        )
    fields = []
    for name, size, kind, count in zip(names, sizes, types, counts, strict=True):
        if size not in SIZES.get(kind, ()) or not count:
            raise InputError(
                f"{path}: needs F of 4 or 8 bytes, I or U of 1, 2, 4 or 8, and a COUNT from 1, came TYPE {kind}, "
                f"SIZE {size} in field {name[:30]!r}; export again"
            )
        fields.append(PcdField(name, f"<{kind.lower()}{size}", count))
    return tuple(fields)


def _n_points(path: Path, entries: dict[str, list[str]]) -> int:
    words = {key: " ".join(entries.get(key, [])) for key in ("WIDTH", "HEIGHT", "POINTS")}
    width, height = count_in(words["WIDTH"]), count_in(words["HEIGHT"] or "1")
    n_points = None if width is None or height is None else width * height
    if n_points is None or (words["POINTS"] and count_in(words["POINTS"]) != n_points):
        stated = ", ".join(f"{key} {word[:20] or 'missing'}" for key, word in words.items())
        raise InputError(f"{path}: needs POINTS = WIDTH * HEIGHT, came {stated}; export again")
    if n_points == 0:
        raise InputError(f"{path}: needs points, came a file that holds no points; export the scan again")
    return n_points


def _viewpoint(path: Path, entries: dict[str, list[str]]) -> FilePose | None:
    words = entries.get("VIEWPOINT")
    if words is None:
        return None
    numbers = [float(word) if is_number(word) else math.nan for word in words]
    if len(numbers) != len(IDENTITY):
        raise InputError(f"{path}: needs seven numbers in VIEWPOINT, came {len(numbers)}; export again")
    if tuple(numbers) == IDENTITY:
        return None
    return pose_of_quaternion(path, "VIEWPOINT", np.array(numbers[3:]), np.array(numbers[:3]))
