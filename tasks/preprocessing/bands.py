"""Points by bands of height."""

import numpy as np
from numpy.typing import NDArray


def split_bands(z_m: NDArray[np.float64], edges_m: NDArray[np.float64]) -> list[NDArray[np.int64]]:
    """Indices of the points (n,) of each band between evenly spaced ``edges_m`` (k + 1,), in the order of input.

    Points below the first or above the last edge count to the band next to them.
    """
    from tasks.geometry.layer_kernel import rows_of_layers  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    bands_a_metre = (len(edges_m) - 1) / (edges_m[-1] - edges_m[0])
    rows, begins = rows_of_layers(z_m, float(edges_m[0]), float(bands_a_metre), len(edges_m) - 2)
    return np.split(rows, begins[1:-1])


def sample_bands(
    z_m: NDArray[np.float64], edges_m: NDArray[np.float64], n_per_band: int, rng: np.random.Generator
) -> list[NDArray[np.int64]]:
    """Indices of at most ``n_per_band`` of the points (n,) of each band, drawn without return."""
    return [
        rows[np.sort(rng.choice(len(rows), n_per_band, replace=False))] if len(rows) > n_per_band else rows
        for rows in split_bands(z_m, edges_m)
    ]
