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
    layers = _layers(points_m[:, 2], np.flatnonzero(stay))
    begins = np.cumsum([0, *(len(layer) for layer in layers)])
    sorted_m, of_scan = np.empty((begins[-1], 3)), np.empty(begins[-1], dtype=np.uint16)

    def sort(number: int) -> None:
        layer, out = layers[number], slice(begins[number], begins[number + 1])
        order = layer[_rising(points_m[layer, 2])]
        # several times as fast as an index for rows of three
        np.take(points_m, order, axis=0, out=sorted_m[out], mode="clip")
        of_scan[out] = scan_index[order]

    side_by_side(sort, range(len(layers)))
    return sorted_m, of_scan


def _rising(z_m: NDArray[np.float64]) -> NDArray[np.int64]:
    """Order (n,) of heights (n,), equal ones as they come."""
    # not the stable one at first, which takes seven times as long: where no two are equal there is one order
    order = np.argsort(z_m)
    rising_m = z_m[order]
    if (rising_m[1:] == rising_m[:-1]).any():
        order = np.argsort(z_m, kind="stable")
    return order


def _layers(z_m: NDArray[np.float64], rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Rows (n,) in layers, each above the one before, in the order of input."""
    if not len(rows):
        return []
    from tasks.geometry.layer_kernel import rows_of_layers  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    place_m = z_m[rows]
    low_m, span_m = float(place_m.min()), float(np.ptp(place_m))
    count = int(min(max(len(rows) // LAYER_POINTS, 1), np.iinfo(np.int16).max - 1))
    if not span_m > 0.0:
        return [rows]
    # the highest point alone is in the layer above the last
    order, begins = rows_of_layers(place_m, low_m, count / span_m, count)
    return np.split(rows[order], begins[1:-1])
