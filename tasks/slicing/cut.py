"""The points of each slice."""

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.slicing.heights import ROUNDING_M

Rows = slice | NDArray[np.intp]
"""Which points of a cloud: from one to another, or their indices."""


def cut_slices(
    z_m: NDArray[np.float64], heights_m: NDArray[np.float64], thickness_m: float
) -> list[NDArray[np.intp]]:
    """Find the points of each slice: z_j - dh/2 <= z <= z_j + dh/2, both ends included.

    Slices may overlap; a point then belongs to each. Points with a height that is not a number belong to none.

    Parameters
    ----------
    z_m : (n,) array
        Heights of the points, metres.
    heights_m : (m,) array
        Mid-heights of the slices, in the same frame, metres.
    thickness_m : float
        Height of a slice, metres, above 0.

    Returns
    -------
    list of (n_j,) arrays
        For each slice the ascending indices into ``z_m``.

    Raises
    ------
    ShapeError
        If ``z_m`` or ``heights_m`` is not one-dimensional, or the thickness is not above 0.

    References
    ----------
    Zhou et al. 2025, eq. 2. The ends are widened by 1e-9 m so that decimal heights on an end are in.
    """
    if z_m.ndim != 1 or heights_m.ndim != 1 or not thickness_m > 0.0:
        raise ShapeError(
            "cut_slices needs heights (n,) and mid-heights (m,) and a thickness above 0 m; "
            f"got {z_m.shape}, {heights_m.shape} and {thickness_m:g}"
        )
    half = thickness_m / 2 + ROUNDING_M
    if _ascend(z_m):
        return [_indices(run) for run in _runs(z_m, heights_m - half, heights_m + half)]
    # most points lie in no slice when slices are thin: sorting only the others is several times faster
    near = _in_any(z_m, heights_m, half)
    order = near[np.argsort(z_m[near])]
    sorted_z = z_m[order]
    begins = np.searchsorted(sorted_z, heights_m - half, side="left")
    ends = np.searchsorted(sorted_z, heights_m + half, side="right")
    return [np.sort(order[begin:end]) for begin, end in zip(begins, ends, strict=True)]


def cut_between(z_m: NDArray[np.float64], edges_m: NDArray[np.float64]) -> list[NDArray[np.intp]]:
    """Find the points of slices that stand on one another: e_j <= z < e_(j+1), the upper end of the last included.

    Every point between the first edge and the last belongs to one slice.

    Parameters
    ----------
    z_m : (n,) array
        Heights of the points, metres.
    edges_m : (m + 1,) array
        Ends of the slices, ascending, in the same frame, metres; an empty one has no slices.

    Returns
    -------
    list of (n_j,) arrays
        For each slice the ascending indices into ``z_m``.

    Raises
    ------
    ShapeError
        If ``z_m`` or ``edges_m`` is not one-dimensional.
    """
    if z_m.ndim != 1 or edges_m.ndim != 1:
        raise ShapeError(
            f"cut_between needs heights (n,) and edges (m + 1,); got {z_m.shape} and {edges_m.shape}"
        )
    if not edges_m.size:
        return []
    if _ascend(z_m):
        return [_indices(run) for run in _steps(z_m, edges_m)]
    order = np.argsort(z_m, kind="stable")
    sorted_z = z_m[order]
    begins = np.searchsorted(sorted_z, edges_m[:-1], side="left")
    last = np.searchsorted(sorted_z, edges_m[-1] + ROUNDING_M, side="right")
    return [np.sort(order[begin:end]) for begin, end in zip(begins, [*begins[1:], last], strict=True)]


def _ascend(z_m: NDArray[np.float64]) -> bool:
    """Whether the points come from the bottom up, as those of an isolated shaft do: then slices need no sorting."""
    return bool((z_m[1:] >= z_m[:-1]).all()) and not np.isnan(z_m[:1]).any()


def rows_of_slices(
    z_m: NDArray[np.float64], heights_m: NDArray[np.float64], thickness_m: float
) -> list[Rows]:
    """The same as ``cut_slices``; of heights that ascend Python's slices, which take no copy of the points they hold."""
    half = thickness_m / 2 + ROUNDING_M
    if thickness_m > 0.0 and _ascend(z_m):
        return [*_runs(z_m, heights_m - half, heights_m + half)]
    return [*cut_slices(z_m, heights_m, thickness_m)]


def rows_between_edges(z_m: NDArray[np.float64], edges_m: NDArray[np.float64]) -> list[Rows]:
    """The same as ``cut_between``; of heights that ascend Python's slices."""
    if edges_m.size and _ascend(z_m):
        return [*_steps(z_m, edges_m)]
    return [*cut_between(z_m, edges_m)]


def _runs(z_m: NDArray[np.float64], low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> list[slice]:
    """Places of ascending heights (n,) from each low (m,) to each high end, both included."""
    begins, ends = np.searchsorted(z_m, low_m, side="left"), np.searchsorted(z_m, high_m, side="right")
    return [slice(int(begin), int(end)) for begin, end in zip(begins, ends, strict=True)]


def _steps(z_m: NDArray[np.float64], edges_m: NDArray[np.float64]) -> list[slice]:
    """Places of ascending heights (n,) from each edge (m + 1,) up to, not with, the next; with the last one."""
    begins = np.searchsorted(z_m, edges_m[:-1], side="left")
    last = np.searchsorted(z_m, edges_m[-1] + ROUNDING_M, side="right")
    return [slice(int(begin), int(end)) for begin, end in zip(begins, [*begins[1:], last], strict=True)]


def _indices(run: slice) -> NDArray[np.intp]:
    return np.arange(run.start, run.stop)


def _in_any(z_m: NDArray[np.float64], heights_m: NDArray[np.float64], half_m: float) -> NDArray[np.intp]:
    """Indices of the points within ``half_m`` of the nearest mid-height."""
    if not heights_m.size:
        return np.empty(0, dtype=np.intp)
    middles = np.sort(heights_m)
    nearest = np.searchsorted((middles[1:] + middles[:-1]) / 2, z_m)
    # a hair wider than the slices: which points are in is decided by the sorted search alone
    return np.flatnonzero(np.abs(z_m - middles[nearest]) <= half_m * (1 + 1e-6))
