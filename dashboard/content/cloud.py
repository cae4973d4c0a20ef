"""Points of a shaft as a graphics card takes them: about its foot, in 4 bytes a number, the order mixed.

The order is mixed so that any first part of them is an even sample: what is drawn while the view turns.

Bytes, little-endian: header (``HEADER``), float32 (n, 3) east, north, up from the origin in metres, int16 (n,) deviation
in ``DEVIATION_UNIT_M`` or ``UNKNOWN``, uint8 (n,) place of the station, ``OTHER_STATION`` from 255 on.
"""

import struct
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from dashboard.content.surface import SkinMap
from storage.views.shaft_points import ShaftPoints

HEADER: Final = struct.Struct("<4sIII3d")
"""Magic, version, points, points of the whole shaft; east, north and up of the origin."""

MAGIC: Final = b"twpc"
VERSION: Final = 1
DEVIATION_UNIT_M: Final = 1e-4
UNKNOWN: Final = -32768
OTHER_STATION: Final = 255
CHUNK: Final = 1 << 17


@dataclass(frozen=True, slots=True, eq=False)
class StraightLine:
    """East and north (2,) of an axis at z = 0 of the site frame, metres, and its lean (2,)."""

    base_m: NDArray[np.float64]
    lean: NDArray[np.float64]

    def at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """East and north (n, 2) at heights (n,)."""
        return np.asarray(self.base_m + np.asarray(z_m)[..., None] * self.lean)


def cloud_bytes(
    points: ShaftPoints, most: int, axis: StraightLine, origin_m: NDArray[np.float64], skin: SkinMap | None
) -> bytes:
    """Pack an even sample of at most ``most`` points.

    The deviation of a point is what the map of the surface says of its place, between the middles of pieces: the
    distance of a single point is mostly noise, and is not made for a square tower. Without a map none is known.
    """
    rows = mixed_rows(len(points), most)
    points_m = points.points_m[rows]
    deviation = np.full(len(rows), UNKNOWN, dtype="<i2")
    if skin is not None:
        for start in range(0, len(rows), CHUNK):
            piece = slice(start, start + CHUNK)
            deviation[piece] = _stored(deviation_m(points_m[piece], axis, skin))
    header = HEADER.pack(MAGIC, VERSION, len(rows), len(points), *origin_m)
    station = np.minimum(points.station_index[rows], OTHER_STATION).astype(np.uint8)
    return b"".join(
        [header, (points_m - origin_m).astype("<f4").tobytes(), deviation.tobytes(), station.tobytes()]
    )


def mixed_rows(n: int, most: int) -> NDArray[np.int64]:
    """Choose ``most`` of n rows evenly, or all where there are no more, in an order without any pattern.

    The same every time.
    """
    kept = min(n, most)
    return np.random.default_rng(kept).permutation(kept) * n // max(kept, 1)


def deviation_m(points_m: NDArray[np.float64], axis: StraightLine, skin: SkinMap) -> NDArray[np.float64]:
    """What the map says of the places of points (n, 3), metres: bilinear between middles of pieces, (n,).

    NaN where the piece of a point is above or below the map, or was not seen; pieces beside it that were not seen have
    no part in it.
    """
    out_m = points_m[:, :2] - axis.at(points_m[:, 2])
    n_bands, n_sectors = skin.deviation_m.shape
    around = np.degrees(np.arctan2(out_m[:, 0], out_m[:, 1])) % 360.0 * n_sectors / 360.0 - 0.5
    up = np.interp(points_m[:, 2], skin.grid.z_m, np.arange(n_bands))
    left, below = np.floor(around), np.minimum(np.floor(up), n_bands - 1)
    right_share, above_share = around - left, up - below
    total, weight = np.zeros(len(points_m)), np.zeros(len(points_m))
    for sector, share in ((left, 1.0 - right_share), (left + 1, right_share)):
        for band, part in ((below, 1.0 - above_share), (below + 1, above_share)):
            value = skin.deviation_m[
                np.minimum(band, n_bands - 1).astype(np.int64), sector.astype(np.int64) % n_sectors
            ]
            counts = np.where(np.isfinite(value), share * part, 0.0)
            total += counts * np.nan_to_num(value)
            weight += counts
    seen = _piece_is_seen(points_m[:, 2], around, skin) & (weight > 0.0)
    return np.where(seen, total / np.where(weight > 0.0, weight, 1.0), np.nan)


def _piece_is_seen(z_m: NDArray[np.float64], around: NDArray[np.float64], skin: SkinMap) -> NDArray[np.bool_]:
    band = np.searchsorted(skin.grid.z_edges_m, z_m, side="right") - 1
    n_bands, n_sectors = skin.deviation_m.shape
    inside = (band >= 0) & (band < n_bands)
    sector = np.floor(around + 0.5).astype(np.int64) % n_sectors
    return np.asarray(inside & np.isfinite(skin.deviation_m[np.clip(band, 0, n_bands - 1), sector]))


def _stored(values_m: NDArray[np.float64]) -> NDArray[np.int16]:
    units = np.clip(np.round(values_m / DEVIATION_UNIT_M), UNKNOWN + 1, 32767)
    return np.where(np.isfinite(values_m), units, UNKNOWN).astype("<i2")
