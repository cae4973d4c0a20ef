"""The loops over the points of a common shaft, compiled: residuals, and sums of a fit of axis and radii.

A row of the design has 6 terms of the axis (east, then north, by powers of height) and 2 of the knots' radii beside it.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

TINY: Final = float(np.finfo(np.float64).tiny)
"""A point on the axis itself has no direction, and no say."""

AXIS_TERMS: Final = 6
TERMS: Final = 8


@compiled
def knots_beside(
    z_m: NDArray[np.float64], knots_m: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Lower of the two knots beside each height (m,), and the share (m,) of the upper; the ends hold on beyond them."""
    lower, share = np.empty(len(z_m), np.int64), np.empty(len(z_m))
    last = len(knots_m) - 1
    for i in range(len(z_m)):
        k = min(max(np.searchsorted(knots_m, z_m[i], "right") - 1, 0), last - 1)
        lower[i] = k
        share[i] = min(max((z_m[i] - knots_m[k]) / (knots_m[k + 1] - knots_m[k]), 0.0), 1.0)
    return lower, share


@compiled
def residuals_off(
    points_m: NDArray[np.float64],
    height: NDArray[np.float64],
    beside: tuple[NDArray[np.int64], NDArray[np.float64]],
    axis_m: NDArray[np.float64],
    radii_m: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distances (m,) of points from the surface, and their directions (m, 2) from the axis (3, 2), by powers of height."""
    lower, share = beside
    residuals, outward = np.empty(len(points_m)), np.empty((len(points_m), 2))
    for i in range(len(points_m)):
        h = height[i]
        east = points_m[i, 0] - (axis_m[0, 0] + h * axis_m[1, 0] + h * h * axis_m[2, 0])
        north = points_m[i, 1] - (axis_m[0, 1] + h * axis_m[1, 1] + h * h * axis_m[2, 1])
        distance = max(np.sqrt(east * east + north * north), TINY)
        k = lower[i]
        residuals[i] = distance - ((1.0 - share[i]) * radii_m[k] + share[i] * radii_m[k + 1])
        outward[i, 0], outward[i, 1] = east / distance, north / distance
    return residuals, outward


@compiled
def _row(
    outward: NDArray[np.float64],
    i: int,
    h: float,
    share: float,
    row: NDArray[np.float64],
) -> None:
    """Derivatives (8,) of a residual by axis and the radii of two knots."""
    east, north = outward[i, 0], outward[i, 1]
    row[0], row[1], row[2] = -east, -h * east, -h * h * east
    row[3], row[4], row[5] = -north, -h * north, -h * h * north
    row[6], row[7] = share - 1.0, -share


@compiled
def mirror(matrix: NDArray[np.float64]) -> None:
    """Fill the lower half of a symmetric matrix (q, q) from its upper one."""
    for j in range(len(matrix)):
        for k in range(j):
            matrix[j, k] = matrix[k, j]


@compiled
def design_sums(
    outward: NDArray[np.float64],
    height: NDArray[np.float64],
    beside: tuple[NDArray[np.int64], NDArray[np.float64]],
    weights: NDArray[np.float64],
    residuals_m: NDArray[np.float64],
    n_knots: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normal matrix (q, q) and right side (q,) of axis and radii, q = 6 + knots."""
    lower, share = beside
    q = AXIS_TERMS + n_knots
    matrix, vector, row = np.zeros((q, q)), np.zeros(q), np.empty(TERMS)
    for i in range(len(outward)):
        if weights[i] == 0.0:
            continue
        _row(outward, i, height[i], share[i], row)
        for j in range(TERMS):
            at = j if j < AXIS_TERMS else lower[i] + j
            weighted = weights[i] * row[j]
            vector[at] -= weighted * residuals_m[i]
            for k in range(j, TERMS):
                matrix[at, k if k < AXIS_TERMS else lower[i] + k] += weighted * row[k]
    mirror(matrix)
    return matrix, vector


@compiled
def stepped(
    outward: NDArray[np.float64],
    height: NDArray[np.float64],
    beside: tuple[NDArray[np.int64], NDArray[np.float64]],
    residuals_m: NDArray[np.float64],
    step: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Residuals (m,) after a step (q,) of axis and radii, to first order."""
    lower, share = beside
    after, row = np.empty(len(outward)), np.empty(TERMS)
    for i in range(len(outward)):
        _row(outward, i, height[i], share[i], row)
        after[i] = residuals_m[i]
        for j in range(TERMS):
            after[i] += row[j] * step[j if j < AXIS_TERMS else lower[i] + j]
    return after


@compiled
def station_sums(  # noqa: PLR0913, PLR0917 - a compiled loop
    arms_m: NDArray[np.float64],
    normals: NDArray[np.float64],
    outward: NDArray[np.float64],
    height: NDArray[np.float64],
    beside: tuple[NDArray[np.int64], NDArray[np.float64]],
    weights: NDArray[np.float64],
    residuals_m: NDArray[np.float64],
    n_knots: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Sums of one station: of its pose (6, 6), of its pose with axis and radii (6, q), and its right side (6,).

    ``arms_m`` (m, 3) are its points from the scanner, in the directions of the site.
    """
    lower, share = beside
    own, mixed, vector = np.zeros((6, 6)), np.zeros((6, AXIS_TERMS + n_knots)), np.zeros(6)
    pose, row = np.empty(6), np.empty(TERMS)
    for i in range(len(arms_m)):
        if weights[i] == 0.0:
            continue
        x, y, z = arms_m[i, 0], arms_m[i, 1], arms_m[i, 2]
        e, n, u = normals[i, 0], normals[i, 1], normals[i, 2]
        pose[0], pose[1], pose[2] = y * u - z * n, z * e - x * u, x * n - y * e
        pose[3], pose[4], pose[5] = e, n, u
        _row(outward, i, height[i], share[i], row)
        for j in range(6):
            weighted = weights[i] * pose[j]
            vector[j] -= weighted * residuals_m[i]
            for k in range(j, 6):
                own[j, k] += weighted * pose[k]
            for k in range(TERMS):
                mixed[j, k if k < AXIS_TERMS else lower[i] + k] += weighted * row[k]
    mirror(own)
    return own, mixed, vector
