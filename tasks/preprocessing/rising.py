"""Points from the bottom up: what is near in height is near in memory, and slices need no sorting."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.side_by_side import side_by_side

LAYER_POINTS: Final = 1 << 17
"""Points that are sorted together: their heights stay in the processor's cache."""


def from_bottom_up(
    points_m: NDArray[np.float64], scan_index: NDArray[np.uint16], stay: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.uint16]]:
    """Points (m, 3) and scans (m,) of those of (n, 3) that stay (n,), by height; of equal heights in the order of input."""
    rows = np.flatnonzero(stay)
    sorted_m, of_scan = np.empty((len(rows), 3)), np.empty(len(rows), dtype=np.uint16)
    layers = _layers(points_m[:, 2], rows)
    begins = np.cumsum([0, *(len(layer) for layer in layers)])

    def sort(number: int) -> None:
        layer, out = layers[number], slice(begins[number], begins[number + 1])
        order = layer[np.argsort(points_m[layer, 2], kind="stable")]
        sorted_m[out], of_scan[out] = points_m[order], scan_index[order]

    side_by_side(sort, range(len(layers)))
    return sorted_m, of_scan


def _layers(z_m: NDArray[np.float64], rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Rows (n,) in layers, each above the one before, in the order of input."""
    if not len(rows):
        return []
    place = z_m[rows]
    low_m, span_m = float(place.min()), float(np.ptp(place))
    count = int(min(max(len(rows) // LAYER_POINTS, 1), np.iinfo(np.int16).max - 1))
    if not span_m > 0.0:
        return [rows]
    place -= low_m
    place *= count / span_m
    layer = place.astype(np.int16)
    del place
    order = np.argsort(layer, kind="stable")
    # the highest point alone is in the layer above the last
    return np.split(rows[order], np.cumsum(np.bincount(layer, minlength=count + 1))[:-1])
