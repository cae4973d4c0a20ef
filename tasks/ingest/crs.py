"""The horizontal coordinate system that a file states, against the one of the campaign.

Nothing here turns or moves a point. A LAS file holds x = east by habit, even in a system that the EPSG defines with
north first (EPSG:4548): which coordinate is east is said by the campaign's axes, never by the system.
"""

import re
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.las_records import LasRecord
from tasks.ingest.las_units import GEO_KEYS_NUMBER, PROJECTION, WKT_NUMBER, geo_keys
from tasks.ingest.scan import METRES_PER_UNIT, ScanRequest

if TYPE_CHECKING:
    from pyproj import CRS

PROJECTED_KEY: Final = 3072
"""ProjectedCSTypeGeoKey of GeoTIFF."""

EPSG_NUMBERS: Final = range(1024, 32767)
"""Values of that key that are EPSG codes; 0 is undefined and 32767 defined by further keys."""

USER_DEFINED: Final = 32767
USER_DEFINED_LABEL: Final = "'user-defined'"

LONGEST_WKT: Final = 1 << 16
"""Systems take some thousand characters; a record before the points can hold no more than this."""

WKT_PROJECTED: Final = re.compile(r'\b(?:PROJCS|PROJCRS|PROJECTEDCRS)\s*[\[(]\s*"([^"]{0,80})', re.IGNORECASE)

LOCAL: Final = "local"
"""What the campaign says of coordinates that are in no system."""

SCANNER_REACH_M: Final = 50_000.0
"""No point is that far from its scanner; a false easting alone is 500 km."""

SAMPLE_POINTS: Final = 10_000
"""Enough for a median that tells a grid from a scanner's frame."""


@dataclass(frozen=True, slots=True)
class StatedSystem:
    """A horizontal system that a file states.

    ``label`` is "EPSG:n" where the system has a code, else its name in quotes. ``definition`` is what PROJ
    understands, WKT or "EPSG:n"; None where the file does not say enough.
    """

    label: str
    definition: str | None


def stated_systems(records: Sequence[LasRecord]) -> tuple[StatedSystem, ...]:
    """Horizontal systems that the records of a LAS file state, the best defined first; most files state one or none.

    Systems of a site or of an instrument (LOCAL_CS) are no statement, and neither is what cannot be understood at all.
    """
    found = {system.label: system for record in records for system in _systems_of(record)}
    return tuple(sorted(found.values(), key=lambda system: system.definition is None))


def system_of_wkt(wkt: str) -> StatedSystem | None:
    """Projected system that a WKT states, of a compound one the horizontal part; None if it states none."""
    from pyproj import CRS  # noqa: PLC0415  # takes 0.2 s, and most scans state no system
    from pyproj.exceptions import CRSError  # noqa: PLC0415

    name = WKT_PROJECTED.search(wkt)
    if name is None:
        return None
    undefined = StatedSystem(_quoted(name.group(1)), None)
    if len(wkt) > LONGEST_WKT:
        return undefined
    try:
        system = _horizontal_part(CRS.from_wkt(wkt))
        if not system.is_projected:
            return None
        code = system.to_epsg()
    except CRSError:
        return undefined
    return StatedSystem(_quoted(system.name) if code is None else f"EPSG:{code}", wkt)


def check_horizontal(path: Path, systems: Sequence[StatedSystem], wanted: str | None) -> tuple[str, ...]:
    """Notes on systems that the campaign does not state or that cannot be compared.

    Parameters
    ----------
    wanted : str or None
        What the campaign says of the file: "EPSG:n", "local", or nothing, then nothing is compared.

    Raises
    ------
    InputError
        If the file states another system than ``wanted``.
    """
    if wanted is None:
        return ()
    if wanted == LOCAL:
        return tuple(
            f'the file states the coordinate system {system.label}, [frame] horizontal is "local": '
            "if the points are on that grid, write it there, with origin_m near the foot of the structure"
            for system in systems[:1]
        )
    other = next((s for s in systems if s.definition is not None and not _is_same(s, wanted)), None)
    if other is not None:
        raise InputError(
            f"{path}: needs coordinates in {wanted}, as [frame] horizontal says, came {other.label} in its coordinate "
            f"system; reproject the cloud to {wanted} and export it again, or correct [frame] horizontal"
        )
    if systems and systems[0].definition is None:
        return (
            f"the coordinate system that the file states, {systems[0].label}, is not fully defined there; "
            f"it could not be compared with {wanted}",
        )
    return ()


def note_grid_of_scanner(
    systems: Sequence[StatedSystem], values: NDArray[np.float64], request: ScanRequest
) -> tuple[str, ...]:
    """A note if a station's scan, values (n, 3) x, y, z in the unit of the file, lies on a projected grid.

    The values may be an even sample of SAMPLE_POINTS.
    """
    if not systems or request.frame != "scanner" or request.horizontal is not None:
        return ()
    sample = values[:: max(1, len(values) // SAMPLE_POINTS), :2]
    distance_m = float(np.abs(np.median(sample, axis=0)).max()) * METRES_PER_UNIT[request.unit]
    if not distance_m > SCANNER_REACH_M:
        return ()
    return (
        f"the file states the coordinate system {systems[0].label} and its points lie {distance_m / 1000:.4g} km from "
        "zero: they are on that grid, but the scan of a station must be in the frame of its scanner; export it so",
    )


def _systems_of(record: LasRecord) -> Iterator[StatedSystem]:
    if record.owner not in PROJECTION:
        return
    if record.number == WKT_NUMBER:
        system = system_of_wkt(record.content.split(b"\0")[0].decode("latin-1"))
        if system is not None:
            yield system
    elif record.number == GEO_KEYS_NUMBER:
        yield from _systems_of_keys(record.content)


def _systems_of_keys(content: bytes) -> Iterator[StatedSystem]:
    try:
        keys = tuple(geo_keys(content))
    except struct.error:
        return
    for key in keys:
        if key.number != PROJECTED_KEY or key.location != 0:
            continue
        if key.value in EPSG_NUMBERS:
            yield StatedSystem(f"EPSG:{key.value}", f"EPSG:{key.value}")
        elif key.value == USER_DEFINED:
            yield StatedSystem(USER_DEFINED_LABEL, None)


def _is_same(system: StatedSystem, wanted: str) -> bool:
    """Whether both are one system, whatever the order of their axes."""
    from pyproj import CRS  # noqa: PLC0415
    from pyproj.exceptions import CRSError  # noqa: PLC0415

    if system.label == wanted:
        return True
    try:
        first, second = (_east_first(CRS.from_user_input(text)) for text in (system.definition, wanted))
    except CRSError:
        return False
    return bool(first.equals(second, ignore_axis_order=True))


def _horizontal_part(system: "CRS") -> "CRS":
    """Take height, time and shift of datum off a system."""
    if system.is_compound:
        return _horizontal_part(system.sub_crs_list[0])
    inner = system.source_crs if system.is_bound else None
    return system if inner is None else _horizontal_part(inner)


def _east_first(system: "CRS") -> "CRS":
    """Put east before north, as files hold it: PROJ ignores the order for latitude and longitude only."""
    from pyproj import CRS  # noqa: PLC0415

    content = _horizontal_part(system).to_json_dict()
    axes = content.get("coordinate_system", {}).get("axis", [])
    axes.sort(key=lambda axis: axis.get("direction") != "east")
    return CRS.from_json_dict(content)


def _quoted(name: str) -> str:
    """Name from a file, fit for a message."""
    return repr(name[:80])
