"""The one place that writes LAS for others to open."""

import json
from datetime import UTC
from typing import TYPE_CHECKING, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.drawing.content import DrawnCloud
from storage.drawing.projected_system import projected_system
from storage.errors import StorageError

if TYPE_CHECKING:
    from laspy import LasHeader, ScaleAwarePointRecord

SCALE_M: Final = 1e-4
OWNER: Final = "tiltwatch"
STATIONS: Final = 1
"""Number of our record, which says as JSON what the points are and which station has which source id."""
MOST_BYTES: Final = 65_535
"""Of a record: LAS counts them in 16 bits."""
BUILDING: Final = 6
"""Class of the LAS specification."""


def write_las(cloud: DrawnCloud, file: BinaryIO, *, compress: bool) -> None:
    """Write a cloud in pieces as LAS 1.4 or LAZ; equal clouds give equal bytes (the date is that of the epoch).

    Raises
    ------
    StorageError
        If it lies too far from ``frame.origin_m`` for steps of 0.1 mm, or its stations have too many names for a record.
    InputError
        If its frame is no projected system in metres.
    """
    from laspy import LasWriter, LazBackend  # noqa: PLC0415 (slow to import)

    header = _header(cloud)
    # of one thread: how several cut the file into chunks is theirs
    backend = LazBackend.Lazrs if compress else None
    with LasWriter(file, header, do_compress=compress, laz_backend=backend, closefd=False) as writer:
        for points_m, station in cloud.pieces():
            writer.write_points(_record(header, points_m, station))


def _header(cloud: DrawnCloud) -> "LasHeader":
    from laspy import VLR, LasHeader  # noqa: PLC0415 (slow to import)

    header = LasHeader(version="1.4", point_format=6)
    header.scales = np.full(3, SCALE_M)
    header.offsets = np.floor(np.array(cloud.frame.origin_m))
    header.creation_date = cloud.epoch_time.astimezone(UTC).date()
    header.system_identifier = "EXTRACTION"
    header.generating_software = OWNER
    about: dict[str, object] = {
        "structure": cloud.structure,
        "epoch": cloud.epoch,
        "epoch_time": cloud.epoch_time.isoformat(),
        "coordinates": cloud.frame.meaning,
        "point_source_id": {str(number): name for number, name in enumerate(cloud.stations, 1)},
    }
    header.vlrs.append(VLR(OWNER, STATIONS, "stations by source id", _record_of(about, len(cloud.stations))))
    if cloud.frame.epsg is not None:
        _state_system(header, cloud.frame.epsg)
    return header


def _record_of(about: dict[str, object], n_stations: int) -> bytes:
    content = json.dumps(about, ensure_ascii=False).encode()
    if len(content) > MOST_BYTES:
        raise StorageError(
            f"the names of {n_stations:,} stations take {len(content):,} bytes, and a record of a LAS file holds "
            f"{MOST_BYTES:,}; export parquet or csv, which name the station of every point"
        )
    return content


def _state_system(header: "LasHeader", epsg: int) -> None:
    """State the system as LAS 1.4 wants it, in WKT 1; laspy's ``add_crs`` writes WKT 2, which most readers do not know."""
    from laspy.vlrs.known import WktCoordinateSystemVlr  # noqa: PLC0415 (slow to import)

    header.vlrs.append(WktCoordinateSystemVlr(projected_system(epsg).to_wkt("WKT1_GDAL")))
    header.global_encoding.wkt = True


def _record(
    header: "LasHeader", points_m: NDArray[np.float64], station: NDArray[np.int64]
) -> "ScaleAwarePointRecord":
    from laspy import ScaleAwarePointRecord  # noqa: PLC0415 (slow to import)

    record = ScaleAwarePointRecord.zeros(len(points_m), header=header)
    try:
        record.x, record.y, record.z = points_m.T
    except OverflowError as fault:
        raise StorageError(
            "the points lie more than 214 km from frame.origin_m, too far for LAS in steps of 0.1 mm; write the "
            "coordinates of a point near the foot of the structure there, or export parquet"
        ) from fault
    record.point_source_id = station + 1
    record.return_number = record.number_of_returns = np.ones(len(points_m), np.uint8)
    record.classification = np.full(len(points_m), BUILDING, np.uint8)
    return record
