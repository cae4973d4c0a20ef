"""The loops that sort points into layers of equal height, compiled."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled


@compiled
def rows_of_layers(
    z_m: NDArray[np.float64], low_m: float, layers_a_metre: float, last: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows (n,) of heights (n,) layer after layer, in one as they come; and where in them each layer begins (last + 2,).

    Layers are counted from 0 at ``low_m`` up; what is below the first or above the last counts to it.
    """
    layer, begins = np.empty(len(z_m), np.int32), np.zeros(last + 2, np.int64)
    for i in range(len(z_m)):
        layer[i] = int(min(max((z_m[i] - low_m) * layers_a_metre, 0.0), float(last)))
        begins[layer[i] + 1] += 1
    for k in range(last + 1):
        begins[k + 1] += begins[k]
    rows, ends = np.empty(len(z_m), np.int64), begins[:-1].copy()
    for i in range(len(z_m)):
        rows[ends[layer[i]]] = i
        ends[layer[i]] += 1
    return rows, begins


@compiled
def rows_of_cube_layers(
    z_m: NDArray[np.float64],
    among: NDArray[np.bool_],
    low_m: float,
    edge_m: float,
    cubes_of_layer: float,
    count: int,
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Rows (m,) of those ``among`` heights (n,) by layers of so many cubes from ``low_m`` up, each as they come.

    Also where in them each of the ``count`` layers begins (count + 1,); what is above the last counts to it.
    """
    layer, begins = np.full(len(z_m), -1, np.int16), np.zeros(count + 1, np.int64)
    for i in range(len(z_m)):
        if among[i]:
            layer[i] = min(int(np.floor((z_m[i] - low_m) / edge_m) / cubes_of_layer), count - 1)
            begins[layer[i] + 1] += 1
    for k in range(count):
        begins[k + 1] += begins[k]
    rows, ends = np.empty(begins[count], np.int32), begins[:-1].copy()
    for i in range(len(z_m)):
        if layer[i] >= 0:
            rows[ends[layer[i]]] = i
            ends[layer[i]] += 1
    return rows, begins
