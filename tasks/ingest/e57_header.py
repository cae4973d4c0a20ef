"""The scans that the description of an E57 file lists, checked against the size of the file."""

import re
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from storage.errors import InputError
from tasks.ingest.e57_packets import check_first_packet
from tasks.ingest.e57_pages import (
    CONTENT_BYTES,
    PAGE_BYTES,
    E57Pages,
    check_place,
    cut_short,
    open_pages,
    read_content,
)
from tasks.ingest.e57_pose import StatedPose, number_in, plain_number, read_pose
from tasks.ingest.e57_xml import Element, parse_description
from tasks.ingest.scan import Bounds, FilePose
from tasks.ingest.soundness import LARGEST_NUMBER

SECTION_HEADER: Final = struct.Struct("<B7xQQQ")
POINTS_SECTION: Final = 1
WHOLE_NUMBER: Final = re.compile(r"\s*[+-]?[0-9]{1,25}\s*", re.ASCII)
INT64_LOW: Final = -(2**63)
INT64_HIGH: Final = 2**63 - 1


@dataclass(frozen=True, slots=True)
class E57Field:
    """A field of the records of a scan.

    ``step`` is the scale of an integer, and 0 for a floating point number; ``is_single`` marks float32.
    """

    name: str
    n_bits: int
    step: float
    is_single: bool


@dataclass(frozen=True, slots=True)
class E57Scan:
    """A scan of the file: its number from 1, what it states, its fields, and its box if that is one."""

    number: int
    name: str | None
    n_points: int
    stated_pose: StatedPose | None
    fields: tuple[E57Field, ...]
    bounds: Bounds | None

    @property
    def place(self) -> str:
        """How messages call it."""
        return f"scan {self.number}" if self.name is None else f"scan {self.number} {self.name[:40]!r}"

    @property
    def pose(self) -> FilePose | None:
        """The pose, where the file states one."""
        return None if self.stated_pose is None else self.stated_pose.pose


@dataclass(frozen=True, slots=True)
class E57Header:
    """What a file says without its points; ``coordinate_system`` is text of any kind, or empty."""

    size_bytes: int
    scans: tuple[E57Scan, ...]
    coordinate_system: str


def read_e57_header(path: Path, file: BinaryIO) -> E57Header:
    """The scans of an E57 file, each with no more points than its section can hold.

    Raises
    ------
    InputError
        If the file is cut short or damaged as far as that can be seen without decoding points.
    """
    pages = open_pages(path, file)
    root = parse_description(path, read_content(pages, pages.xml_at, pages.xml_bytes))
    listed = root.child("data3D")
    system = root.child("coordinateMetadata")
    return E57Header(
        pages.size_bytes,
        tuple(_scan(pages, number, scan) for number, scan in enumerate(listed.children if listed else (), 1)),
        system.text if system else "",
    )


def _scan(pages: E57Pages, number: int, scan: Element) -> E57Scan:
    name = scan.child("name")
    label = name.text if name and name.text else None
    place = f"scan {number}"
    points = scan.child("points")
    if points is None or points.attributes.get("type") != "CompressedVector":
        raise _damaged(pages.path, "points", "none", place)
    n_points = _integer(pages.path, place, points, "recordCount", None)
    if n_points < 0:
        raise _damaged(pages.path, "a count of points", str(n_points), place)
    prototype = points.child("prototype")
    fields = tuple(_fields(pages.path, place, prototype)) if prototype else ()
    if n_points:
        _check_room(pages, place, points, n_points, fields)
    return E57Scan(number, label, n_points, read_pose(pages.path, place, scan), fields, _bounds(scan))


def _fields(path: Path, place: str, parent: Element) -> Iterator[E57Field]:
    for element in parent.children:
        kind = element.attributes.get("type")
        if kind == "Structure":
            yield from _fields(path, place, element)
        elif kind == "Float":
            is_single = element.attributes.get("precision") == "single"
            yield E57Field(element.name, 32 if is_single else 64, 0.0, is_single)
        elif kind == "String":
            # a string takes at least the byte of its length
            yield E57Field(element.name, 8, 0.0, False)
        elif kind in {"Integer", "ScaledInteger"}:
            yield _integer_field(path, place, element, kind == "ScaledInteger")
        else:
            raise _damaged(path, "fields of known types", f"{element.name[:40]} of type {kind!r}", place)


def _integer_field(path: Path, place: str, element: Element, is_scaled: bool) -> E57Field:
    low = _integer(path, place, element, "minimum", INT64_LOW)
    high = _integer(path, place, element, "maximum", INT64_HIGH)
    step = abs(plain_number(element.attributes.get("scale", "1"))) if is_scaled else 1.0
    if not INT64_LOW <= low <= high <= INT64_HIGH or not 0.0 < step < LARGEST_NUMBER:
        raise _damaged(
            path, f"a range and a scale of {element.name[:40]}", f"{low} to {high} and {step}", place
        )
    return E57Field(element.name, (high - low).bit_length(), step, False)


def _integer(path: Path, place: str, element: Element, name: str, otherwise: int | None) -> int:
    text = element.attributes.get(name)
    if text is None and otherwise is not None:
        return otherwise
    if text is None or not WHOLE_NUMBER.fullmatch(text):
        raise _damaged(path, f"a whole number {name} in {element.name[:40]}", repr(text)[:40], place)
    return int(text)


def _check_room(
    pages: E57Pages, place: str, points: Element, n_points: int, fields: Sequence[E57Field]
) -> None:
    """Compare the records that a scan claims with the section that should hold them."""
    at = _integer(pages.path, place, points, "fileOffset", None)
    check_place(pages, at, SECTION_HEADER.size, f"the section of {place}")
    kind, section_bytes, data_at, index_at = SECTION_HEADER.unpack(
        read_content(pages, at, SECTION_HEADER.size)
    )
    if kind != POINTS_SECTION:
        raise _damaged(pages.path, "a section of points", f"one of kind {kind}", place)
    check_place(pages, at, section_bytes, f"the section of {place}")
    data_bytes = _logical(at) + section_bytes - _logical(data_at)
    if not SECTION_HEADER.size <= section_bytes - data_bytes <= section_bytes:
        raise _damaged(pages.path, "points inside their section", f"points from byte {data_at}", place)
    if index_at >= pages.size_bytes:
        raise _damaged(pages.path, "an index inside the file", f"one at byte {index_at}", place)
    n_bits = n_points * sum(field.n_bits for field in fields)
    if 8 * data_bytes < n_bits:
        raise cut_short(
            pages.path, f"the {n_bits // 8} bytes of points that {place} states", f"room for {data_bytes}"
        )
    check_first_packet(pages, place, data_at, len(fields), data_bytes)


def _logical(at: int) -> int:
    """Place in the content of a place in the file."""
    page, start = divmod(at, PAGE_BYTES)
    return page * CONTENT_BYTES + start


def _bounds(scan: Element) -> Bounds | None:
    box = scan.child("cartesianBounds")
    if box is None:
        return None
    low, high = (
        np.array([number_in(box.child(f"{axis}{end}")) for axis in "xyz"]) for end in ("Minimum", "Maximum")
    )
    is_box = (low <= high).all() and (low > -LARGEST_NUMBER).all() and (high < LARGEST_NUMBER).all()
    return Bounds(low, high) if is_box else None


def _damaged(path: Path, needed: str, came: str, place: str) -> InputError:
    return InputError(
        f"{path}: needs {needed}, came {came} in {place}; the file is damaged, copy or export it again"
    )
