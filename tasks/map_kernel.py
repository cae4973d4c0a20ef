"""The loops over all points of a shaft that make a map of its surface, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled
from tasks.geometry.knot_kernel import knot_below
from tasks.geometry.median_kernel import median_in_place
from tasks.geometry.robust_kernel import biweight
from tasks.geometry.sector_kernel import Sectors, find_sectors

BLOCK: Final = 512

Line = tuple[float, float, float, float]
"""East and north of a straight axis at z = 0, and its lean vector."""

Loss = tuple[float, int, float]
"""Where Tukey's biweight ends, in sigmas; how often means are weighted; smallest scale."""


@compiled
def find_pieces(  # noqa: PLR0913, PLR0917 - a compiled loop
    points_m: NDArray[np.float64],
    station: NDArray[np.uint16],
    axis: Line,
    edges_m: NDArray[np.float64],
    sectors: Sectors,
    piece: NDArray[np.uint16],
    counts: NDArray[np.int64],
) -> None:
    """Piece (n,) of each point by band and sector clockwise from north, and counts (pieces, stations)."""
    n_sectors, last = len(sectors[1]) - 1, len(edges_m) - 2
    step = (edges_m[-1] - edges_m[0]) / (last + 1)
    east, north = np.empty(BLOCK), np.empty(BLOCK)
    found = np.empty(BLOCK, dtype=np.int64)
    for begin in range(0, len(points_m), BLOCK):
        block = points_m[begin : begin + BLOCK]
        n = len(block)
        for i in range(n):
            east[i] = block[i, 0] - (axis[0] + axis[2] * block[i, 2])
            north[i] = block[i, 1] - (axis[1] + axis[3] * block[i, 2])
        find_sectors(north[:n], east[:n], sectors, found)
        for i in range(n):
            z = block[i, 2]
            # the division is right to a rounding, and says where to look
            band = knot_below(edges_m, z, min(max(int((z - edges_m[0]) / step), 0), last))
            number = band * n_sectors + found[i]
            piece[begin + i] = number
            counts[number, station[begin + i]] += 1


@compiled
def off_round(
    points_m: NDArray[np.float64],
    axis: Line,
    knots_z_m: NDArray[np.float64],
    radius_m: NDArray[np.float64],
    across: bool,
    off_m: NDArray[np.float64],
) -> None:
    """Distance (n,) of points from a straight shaft that is round, in the horizontal or across its axis."""
    length = np.sqrt(axis[2] ** 2 + axis[3] ** 2 + 1.0)
    ue, un, uz = axis[2] / length, axis[3] / length, 1.0 / length
    knot = 0
    for i in range(len(points_m)):
        z = points_m[i, 2]
        if across:
            de, dn = points_m[i, 0] - axis[0], points_m[i, 1] - axis[1]
            along = de * ue + dn * un + z * uz
            de, dn, up = de - along * ue, dn - along * un, z - along * uz
            distance, z = np.sqrt(de * de + dn * dn + up * up), along * uz
        else:
            de = points_m[i, 0] - (axis[0] + axis[2] * z)
            dn = points_m[i, 1] - (axis[1] + axis[3] * z)
            distance = np.sqrt(de * de + dn * dn)
        knot = knot_below(knots_z_m, z, knot)
        slope = (radius_m[knot + 1] - radius_m[knot]) / (knots_z_m[knot + 1] - knots_z_m[knot])
        held = min(max(z, knots_z_m[0]), knots_z_m[-1])
        off_m[i] = distance - (slope * (held - knots_z_m[knot]) + radius_m[knot])


@compiled
def put_together(
    values: NDArray[np.float64],
    piece: NDArray[np.uint16],
    places: NDArray[np.int64],
    together: NDArray[np.float64],
) -> None:
    """Put values (n,) where those of their pieces stand; ``places`` (pieces,) are the next free ones."""
    for i in range(len(values)):
        together[places[piece[i]]] = values[i]
        places[piece[i]] += 1


@compiled
def find_scales(
    together: NDArray[np.float64], ends: NDArray[np.int64], least: int, medians: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Median absolute deviations (pieces,) of pieces with at least so many values; medians of all that have any."""
    deviations = np.zeros(len(ends) - 1)
    for number in range(len(deviations)):
        values = together[ends[number] : ends[number + 1]].copy()
        if not len(values):
            continue
        medians[number] = median_in_place(values)
        if len(values) >= least:
            for i in range(len(values)):
                values[i] = abs(values[i] - medians[number])
            deviations[number] = median_in_place(values)
    return deviations


@compiled
def weigh_means(
    together: NDArray[np.float64],
    ends: NDArray[np.int64],
    reach: NDArray[np.float64],
    steps: int,
    before: NDArray[np.float64],
    mean: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Robust means of pieces, from their medians in ``before``; it ends as what the last weights are about.

    Returns the sums (pieces, 2) of squared influence and slope of the last weights. Where no value has a weight (two or
    three that contradict each other) all have the weight one, and ``reach`` becomes infinite.
    """
    spread = np.zeros((len(mean), 2))
    for number in range(len(mean)):
        values = together[ends[number] : ends[number + 1]]
        if not len(values):
            continue
        mean[number] = before[number]
        for step in range(steps):
            before[number] = mean[number]
            total, summed = 0.0, 0.0
            for i in range(len(values)):
                weight = biweight(values[i] - before[number], reach[number])
                total += weight
                summed += weight * values[i]
            if total == 0.0:
                mean[number] = values.sum() / len(values)
                if step == steps - 1:
                    reach[number] = np.inf
            else:
                mean[number] = summed / total
        for i in range(len(values)):
            weight = biweight(values[i] - before[number], reach[number])
            root = np.sqrt(weight)
            spread[number, 0] += (weight * (values[i] - mean[number])) ** 2
            spread[number, 1] += root * (5.0 * root - 4.0)
    return spread


@compiled
def add_weighted(
    values: NDArray[np.float64],
    others: NDArray[np.float64],
    piece: NDArray[np.uint16],
    before: NDArray[np.float64],
    reach: NDArray[np.float64],
    sums: NDArray[np.float64],
) -> None:
    """Add up weights and weighted ``others`` (n,) of pieces (pieces, 2), with the last weights of the means of values."""
    for i in range(len(values)):
        weight = biweight(values[i] - before[piece[i]], reach[piece[i]])
        sums[piece[i], 0] += weight
        sums[piece[i], 1] += weight * others[i]
