"""Small E57 files, written byte by byte, so that every lie can be told: one packet a scan."""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tasks.ingest.e57_pages import CONTENT_BYTES, HEADER_BYTES, PAGE_BYTES, checksums

CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")


@dataclass(frozen=True, slots=True)
class Column:
    """A field: its element in the prototype, and its packed values."""

    element: str
    content: bytes


@dataclass(frozen=True, slots=True)
class Source:
    """A scan to write; ``about`` is XML before its points, ``n_stated`` replaces the count of points."""

    columns: tuple[Column, ...]
    n_points: int
    about: str = ""
    n_stated: int | None = None


def doubles(name: str, values: NDArray[np.float64]) -> Column:
    return Column(f'<{name} type="Float"/>', values.astype("<f8").tobytes())


def singles(name: str, values: NDArray[np.float64]) -> Column:
    return Column(f'<{name} type="Float" precision="single"/>', values.astype("<f4").tobytes())


def integers(
    name: str, values: NDArray[np.float64], low: int, high: int, scale: float | None = None
) -> Column:
    raw = np.round(values / (scale or 1.0)).astype(np.int64) - low
    bits = (raw[:, np.newaxis] >> np.arange((high - low).bit_length())) & 1
    kind = "Integer" if scale is None else "ScaledInteger"
    attribute = "" if scale is None else f' scale="{scale!r}"'
    return Column(
        f'<{name} type="{kind}" minimum="{low}" maximum="{high}"{attribute}/>',
        np.packbits(bits.astype(np.uint8).reshape(-1), bitorder="little").tobytes(),
    )


def cloud(points: NDArray[np.float64], about: str = "", *more: Column) -> Source:
    """Write points (n, 3) as Cartesian float64."""
    columns = tuple(doubles(name, column) for name, column in zip(CARTESIAN, points.T, strict=True))
    return Source((*columns, *more), len(points), about)


def named(name: str) -> str:
    return f'<name type="String"><![CDATA[{name}]]></name>'


def posed(quaternion: Sequence[float], translation: Sequence[float]) -> str:
    parts = (("rotation", "wxyz", quaternion), ("translation", "xyz", translation))
    inside = "".join(
        f'<{part} type="Structure">'
        + "".join(f'<{n} type="Float">{v!r}</{n}>' for n, v in zip(names, values, strict=True))
        + f"</{part}>"
        for part, names, values in parts
    )
    return f'<pose type="Structure">{inside}</pose>'


def boxed(low: Sequence[float], high: Sequence[float]) -> str:
    inside = "".join(
        f'<{axis}{end} type="Float">{value!r}</{axis}{end}>'
        for end, corner in (("Minimum", low), ("Maximum", high))
        for axis, value in zip("xyz", corner, strict=True)
    )
    return f'<cartesianBounds type="Structure">{inside}</cartesianBounds>'


def write_e57(
    path: Path,
    *sources: Source,
    system: str = "",
    edit: Callable[[str], str] = lambda xml: xml,
) -> Path:
    """Write a file; ``edit`` changes its description."""
    content = bytes(HEADER_BYTES)
    scans = ""
    for source in sources:
        at = _physical(len(content))
        content += _section(source, len(content))
        count = source.n_points if source.n_stated is None else source.n_stated
        prototype = "".join(column.element for column in source.columns)
        scans += (
            f'<vectorChild type="Structure">{source.about}<points type="CompressedVector" fileOffset="{at}" '
            f'recordCount="{count}"><prototype type="Structure">{prototype}</prototype>'
            '<codecs type="Vector" allowHeterogeneousChildren="1"/></points></vectorChild>'
        )
    xml = edit(
        '<?xml version="1.0" encoding="UTF-8"?>'
        '<e57Root type="Structure" xmlns="http://www.astm.org/COMMIT/E57/2010-e57-v1.0">'
        '<formatName type="String">ASTM E57 3D Imaging Data File</formatName><guid type="String">a</guid>'
        '<versionMajor type="Integer">1</versionMajor><versionMinor type="Integer">0</versionMinor>'
        f'<coordinateMetadata type="String"><![CDATA[{system}]]></coordinateMetadata>'
        f'<data3D type="Vector" allowHeterogeneousChildren="1">{scans}</data3D></e57Root>'
    ).encode()
    xml_at = _physical(len(content))
    content += xml
    content += bytes(-len(content) % CONTENT_BYTES)
    n_bytes = len(content) // CONTENT_BYTES * PAGE_BYTES
    head = struct.pack("<8sIIQQQQ", b"ASTM-E57", 1, 0, n_bytes, xml_at, len(xml), PAGE_BYTES)
    path.write_bytes(_paged(head + content[HEADER_BYTES:]))
    return path


def mend_checksums(content: bytes) -> bytes:
    """Content of a file with every checksum made to agree, so that a lie is believed."""
    pages = np.frombuffer(content, np.uint8).reshape(-1, PAGE_BYTES)
    return _paged(np.ascontiguousarray(pages[:, :CONTENT_BYTES]).tobytes())


def _section(source: Source, start: int) -> bytes:
    lengths = [len(column.content) for column in source.columns]
    payload = b"".join(column.content for column in source.columns)
    n_bytes = 6 + 2 * len(lengths) + len(payload)
    padding = -n_bytes % 4
    assert n_bytes + padding <= 1 << 16, "one packet a scan: write fewer points"
    packet = struct.pack(f"<BBHH{len(lengths)}H", 1, 0, n_bytes + padding - 1, len(lengths), *lengths)
    head = struct.pack("<B7xQQQ", 1, 32 + n_bytes + padding, _physical(start + 32), 0)
    return head + packet + payload + bytes(padding)


def _physical(at: int) -> int:
    page, start = divmod(at, CONTENT_BYTES)
    return page * PAGE_BYTES + start


def _paged(content: bytes) -> bytes:
    pages = np.frombuffer(content, np.uint8).reshape(-1, CONTENT_BYTES)
    stored = checksums(pages).astype(">u4").view(np.uint8).reshape(-1, PAGE_BYTES - CONTENT_BYTES)
    return np.hstack([pages, stored]).tobytes()
