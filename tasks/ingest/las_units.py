"""The units that the coordinate system of a LAS file states, as WKT or as GeoTIFF keys."""

import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final

from storage.errors import InputError
from tasks.ingest.las_records import LasRecord
from tasks.ingest.scan import METRES_PER_UNIT, LengthUnit

PROJECTION: Final = (b"LASF_Projection", b"liblas")
WKT_NUMBER: Final = 2112
GEO_KEYS_NUMBER: Final = 34735
MODEL_KEY: Final = 1024
LINEAR_UNIT_KEYS: Final = (3076, 4099)
GEO_MODELS: Final[Mapping[int, str]] = MappingProxyType({2: "geographic", 3: "geocentric"})
EPSG_UNITS_M: Final[Mapping[int, float]] = MappingProxyType(
    {
        9001: 1.0,
        9002: 0.3048,
        9003: 1200.0 / 3937.0,
        9005: 0.3047972654,
        9014: 1.8288,
        9036: 1000.0,
        9096: 0.9144,
    }
)
WKT_UNIT: Final = re.compile(
    r'\b(?:LENGTH)?UNIT\s*[\[(]\s*"([^"]{0,80})"\s*,\s*([0-9.eE+-]{1,30})', re.IGNORECASE
)
WKT_PLANE: Final = re.compile(
    r"\b(?:PROJCS|PROJCRS|PROJECTEDCRS|LOCAL_CS|ENGCRS|ENGINEERINGCRS)\s*[\[(]", re.IGNORECASE
)
WKT_GLOBE: Final = re.compile(
    r"\b(?:GEOGCS|GEOGCRS|GEOGRAPHICCRS|GEODCRS|GEODETICCRS|GEOCCS)\s*[\[(]", re.IGNORECASE
)
ANGLE: Final = re.compile(r"deg|rad|gon|arc|minute|second", re.IGNORECASE)
FOOT: Final = re.compile(r"foot|feet|\bft|ftus", re.IGNORECASE)
SURVEY: Final = re.compile(r"us|survey", re.IGNORECASE)
SAME_UNIT: Final = 5e-7
"""Relative; the foot and the US survey foot differ by 2e-6."""


@dataclass(frozen=True, slots=True)
class GeoKey:
    """A GeoTIFF key; ``value`` is its value where ``location`` is 0, else a place in the record of that number."""

    number: int
    location: int
    value: int


@dataclass(frozen=True, slots=True)
class StatedUnit:
    """A unit of length that a file states; ``metres`` is its length."""

    name: str
    metres: float


def check_units(path: Path, records: Sequence[LasRecord], unit: LengthUnit) -> tuple[str, ...]:
    """Notes on statements about units that cannot be understood.

    Raises
    ------
    InputError
        If the file states coordinates on the globe, or a unit of length other than ``unit``.
    """
    notes: list[str] = []
    for record in records:
        if record.owner not in PROJECTION:
            continue
        try:
            stated = tuple(_stated_units(path, record))
        except (struct.error, ValueError):
            notes.append(
                f"record {record.number} on the coordinate system is damaged; {unit} is taken as the unit"
            )
            continue
        for other in stated:
            if abs(other.metres / METRES_PER_UNIT[unit] - 1.0) > SAME_UNIT:
                raise InputError(
                    f"{path}: needs coordinates in {unit}, came {other.name} ({other.metres:.10g} m) in its coordinate "
                    f"system; convert all three coordinates to metres and export again"
                )
    return tuple(dict.fromkeys(notes))


def _stated_units(path: Path, record: LasRecord) -> Iterator[StatedUnit]:
    if record.number == WKT_NUMBER:
        yield from _units_of_wkt(path, record.content.split(b"\0")[0].decode("latin-1"))
    elif record.number == GEO_KEYS_NUMBER:
        yield from _units_of_keys(path, record.content)


def _units_of_wkt(path: Path, wkt: str) -> Iterator[StatedUnit]:
    if WKT_GLOBE.search(wkt) and not WKT_PLANE.search(wkt):
        raise _on_the_globe(path, "geographic or geocentric")
    for name, factor in WKT_UNIT.findall(wkt):
        if not ANGLE.search(name):
            yield StatedUnit(name, _metres(name, float(factor)))


def _metres(name: str, factor: float) -> float:
    """Length of a unit; some programs write a foot with the factor 1, and the name is right then."""
    if factor != 1.0 or not FOOT.search(name):
        return factor
    return METRES_PER_UNIT["US survey foot" if SURVEY.search(name) else "foot"]


def _units_of_keys(path: Path, content: bytes) -> Iterator[StatedUnit]:
    for key in geo_keys(content):
        if key.number == MODEL_KEY and key.value in GEO_MODELS:
            raise _on_the_globe(path, GEO_MODELS[key.value])
        if key.number in LINEAR_UNIT_KEYS and key.location == 0 and key.value in EPSG_UNITS_M:
            yield StatedUnit(f"EPSG unit {key.value}", EPSG_UNITS_M[key.value])


def geo_keys(content: bytes) -> Iterator[GeoKey]:
    """Keys of a GeoTIFF directory.

    Raises
    ------
    struct.error
        If it is shorter than it states.
    """
    n_keys = struct.unpack_from("<4H", content)[3]
    for index in range(1, n_keys + 1):
        number, location, _, value = struct.unpack_from("<4H", content, 8 * index)
        yield GeoKey(number, location, value)


def _on_the_globe(path: Path, kind: str) -> InputError:
    return InputError(
        f"{path}: needs plane coordinates in metres with z up, came {kind} coordinates; "
        "project them to a local or projected system and export again"
    )
