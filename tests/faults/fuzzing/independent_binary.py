"""LAS and E57 read a second time, field by field, with none of the product's code and without checksums."""

import struct
from functools import cache
from xml.etree import ElementTree

import laspy
import numpy as np
from numpy.typing import NDArray

from tests.faults.fuzzing.independent_text import Unsure, number_in
from tests.faults.fuzzing.seeds import Seed

Records = NDArray[np.float64]
SPACE = "{*}"
LASZIP = 128
"""Bit of the point format: compressed, whatever the name of the file says."""


def las(content: bytes) -> Records:
    """x, y, z of all records."""
    count, points_at, width = _las_places(content)
    if content[104] & LASZIP:
        raise Unsure
    scale, offset = _grid(content)
    room = content[points_at : points_at + count * width]
    if len(room) < count * width or width < 12:
        raise ValueError("not so many records")
    table = np.frombuffer(room, np.uint8).reshape(count, width)[:, :12]
    return np.ascontiguousarray(table).view("<i4").astype(np.float64) * scale + offset


def laz(content: bytes, seed: Seed) -> Records:
    """As ``las``, where nothing was touched but the header before the records of LASzip."""
    count, points_at, _ = _las_places(content)
    integers = _seed_integers(seed)
    mark, old_mark = content.find(b"laszip encoded"), seed.content.find(b"laszip encoded")
    (old_at,) = struct.unpack_from("<I", seed.content, 96)
    is_kept = mark == old_mark and content[mark:] == seed.content[old_mark:] and points_at == old_at
    if not is_kept or content[104:107] != seed.content[104:107]:
        raise Unsure
    if count > len(integers):
        raise ValueError("not so many records")
    scale, offset = _grid(content)
    return integers[:count] * scale + offset


@cache
def _seed_integers(seed: Seed) -> Records:
    import io  # noqa: PLC0415

    read = laspy.read(io.BytesIO(seed.content))
    return np.column_stack([read.X, read.Y, read.Z]).astype(np.float64)


def _las_places(content: bytes) -> tuple[int, int, int]:
    (points_at,), (width,) = struct.unpack_from("<I", content, 96), struct.unpack_from("<H", content, 105)
    (count,) = struct.unpack_from("<I", content, 107)
    if content[25] >= 4:
        (count,) = struct.unpack_from("<Q", content, 247)
    if count > len(content):
        raise ValueError("not so many records")
    return count, points_at, width


def _grid(content: bytes) -> tuple[Records, Records]:
    return np.array(struct.unpack_from("<3d", content, 131)), np.array(
        struct.unpack_from("<3d", content, 155)
    )


def e57(file: bytes, part: int | None, *, in_file: bool) -> Records:
    """The scans that are asked for; invalid records are zeros."""
    n_pages = len(file) // 1024
    content = b"".join(file[1024 * page : 1024 * page + 1020] for page in range(n_pages))
    xml_at, n_bytes = struct.unpack_from("<QQ", content, 24)
    at = _logical(xml_at)
    root = ElementTree.fromstring(content[at : at + n_bytes])  # noqa: S314 - our own mutants; what has a DOCTYPE is refused
    data = root.find(f"{SPACE}data3D")
    if data is None:
        raise ValueError("no scans")
    scans = list(data)
    found = [_scan(content, scan, in_file=in_file) for scan in (scans if part is None else [scans[part - 1]])]
    return np.concatenate(found)


def _logical(at: int) -> int:
    return at // 1024 * 1020 + at % 1024


def _scan(content: bytes, scan: ElementTree.Element, *, in_file: bool) -> Records:
    points = scan.find(f"{SPACE}points")
    if points is None:
        raise ValueError("no points")
    count = int(number_in(points.attrib["recordCount"]))
    if count == 0:
        return np.empty((0, 3))
    if not 0 < count < 1_000_000:
        raise ValueError("not so many points")
    prototype = points.find(f"{SPACE}prototype")
    fields = (
        []
        if prototype is None
        else [item for item in prototype.iter() if len(item) == 0 and item is not prototype]
    )
    streams = _streams(content, _logical(int(points.attrib["fileOffset"])), len(fields))
    columns = {
        field.tag.rpartition("}")[2]: _column(field, stream, count)
        for field, stream in zip(fields, streams, strict=True)
        if field.tag.rpartition("}")[2].startswith(("cartesian", "spherical"))
    }
    values = _coordinates(columns)
    return _placed(scan, values) if in_file else values


def _coordinates(columns: dict[str, Records]) -> Records:
    if all(f"cartesian{axis}" in columns for axis in "XYZ"):
        values = np.column_stack([columns[f"cartesian{axis}"] for axis in "XYZ"])
        state = columns.get("cartesianInvalidState", columns.get("sphericalInvalidState"))
    else:
        length, azimuth, elevation = (
            columns[f"spherical{name}"] for name in ("Range", "Azimuth", "Elevation")
        )
        level = length * np.cos(elevation)
        values = np.column_stack(
            [level * np.cos(azimuth), level * np.sin(azimuth), length * np.sin(elevation)]
        )
        state = columns.get("sphericalInvalidState", columns.get("cartesianInvalidState"))
    if state is not None:
        values[state != 0.0] = 0.0
    return values


def _placed(scan: ElementTree.Element, values: Records) -> Records:
    pose = scan.find(f"{SPACE}pose")
    if pose is None:
        return values
    numbers = {
        (part, name): number_in(pose.findtext(f"{SPACE}{part}/{SPACE}{name}") or "0")
        for part, names in (("rotation", "wxyz"), ("translation", "xyz"))
        for name in names
        if pose.find(f"{SPACE}{part}") is not None
    }
    w, vector = (
        numbers.get(("rotation", "w"), 1.0),
        np.array([numbers.get(("rotation", n), 0.0) for n in "xyz"]),
    )
    shift = np.array([numbers.get(("translation", n), 0.0) for n in "xyz"])
    is_there = values.any(axis=1)
    some = values[is_there]
    across = np.cross(vector, some)
    norm = w * w + vector @ vector
    values[is_there] = some + 2.0 * (w * across + np.cross(vector, across)) / norm + shift
    return values


def _streams(content: bytes, at: int, n_fields: int) -> list[bytes]:
    """The byte stream of each field, all packets of the section together."""
    n_section, data_at = struct.unpack_from("<QQ", content, at + 8)
    place, end = _logical(data_at), at + n_section
    streams = [b""] * n_fields
    while place < end:
        kind, n_bytes = content[place], struct.unpack_from("<H", content, place + 2)[0] + 1
        if kind == 1:
            (n_streams,) = struct.unpack_from("<H", content, place + 4)
            if n_streams != n_fields:
                raise ValueError("another number of streams")
            lengths = struct.unpack_from(f"<{n_streams}H", content, place + 6)
            start = place + 6 + 2 * n_streams
            for field, length in enumerate(lengths):
                streams[field] += content[start : start + length]
                start += length
        place += n_bytes
    return streams


def _column(field: ElementTree.Element, stream: bytes, count: int) -> Records:
    kind = field.attrib["type"]
    if kind == "Float":
        code = "<f4" if field.attrib.get("precision") == "single" else "<f8"
        return np.frombuffer(stream, code, count).astype(np.float64)
    if kind not in {"Integer", "ScaledInteger"}:
        raise Unsure
    low, high = int(field.attrib.get("minimum", -(2**63))), int(field.attrib.get("maximum", 2**63 - 1))
    width = (high - low).bit_length()
    bits = np.unpackbits(np.frombuffer(stream, np.uint8), bitorder="little")[: count * width]
    if len(bits) < count * width:
        raise ValueError("not so many values")
    raw = [int("".join(map(str, row[::-1])) or "0", 2) + low for row in bits.reshape(count, width)]
    if max(raw) > high:
        raise Unsure
    values = np.array(raw, dtype=np.float64)
    if kind == "Integer":
        return values
    return values * float(field.attrib.get("scale", 1.0)) + float(field.attrib.get("offset", 0.0))
