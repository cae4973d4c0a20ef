"""The loop over points that sums up, layer by layer, what they say about a centre, compiled."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled


@compiled
def add_to_layers(  # noqa: PLR0913, PLR0917 - a compiled loop
    z_m: NDArray[np.float64],
    azimuth_rad: NDArray[np.float64],
    sigma_m: NDArray[np.float64],
    weights: NDArray[np.float64],
    low_m: float,
    layers_per_m: float,
    sums: NDArray[np.float64],
) -> None:
    """Add points (n,) to sums (layers, 13); ``weights`` are (n,), or (0,) where all are one."""
    n_layers = len(sums)
    for i in range(len(z_m)):
        place = (z_m[i] - low_m) * layers_per_m
        if not 0.0 <= place <= n_layers:
            continue
        layer = sums[min(int(place), n_layers - 1)]
        c, s = np.cos(azimuth_rad[i]), np.sin(azimuth_rad[i])
        weight = weights[i] if len(weights) else 1.0
        scatter = weight * weight * sigma_m[i] ** 2
        layer[0] += weight * (c * c)
        layer[1] += weight * (c * s)
        layer[2] += weight * (s * s)
        layer[3] += weight * c
        layer[4] += weight * s
        layer[5] += weight
        layer[6] += scatter * (c * c)
        layer[7] += scatter * (c * s)
        layer[8] += scatter * (s * s)
        layer[9] += scatter * c
        layer[10] += scatter * s
        layer[11] += scatter
        layer[12] += 1.0
