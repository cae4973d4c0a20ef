"""How far the form of plane faces may bend the lean: pieces of brickwork or formwork that are off their plane.

As for a round wall (``wall_form``): if the form keeps its sign over a distance, smaller pieces are not independent, so
several sizes are tried and the largest variance counts.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import tukey_weights
from tasks.surface.face_equations import Cut, FaceEquations, FaceState

HEIGHTS: Final = 48
COLUMNS: Final = 12
"""Cells of a face, in height and across: 0.9 m by 0.5 m on a tower of 45 m that is 6 m wide."""

BLOCKS: Final = ((3, 3), (6, 6), (12, 12))
"""Sizes of the pieces that are tried, in cells; of larger ones too few are left once planes and twist are taken out."""

LEAST_FREEDOM: Final = 0.2
"""Share of the pieces that the unknowns must leave."""

SIGNIFICANT: Final = 2.0
"""Form counts from this many standard deviations of its own statistic on: noise alone must not look like form."""


@dataclass(frozen=True, slots=True, eq=False)
class _Sums:
    """Sums over the points of every cell (c,): weights, weighted residuals, their squares, weighted designs (c, p)."""

    weight: NDArray[np.float64]
    off: NDArray[np.float64]
    off_squared: NDArray[np.float64]
    design: NDArray[np.float64]


def face_form(
    points_m: NDArray[np.float64],
    state: FaceState,
    cut: Cut,
    equations: FaceEquations,
    lean_of: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Covariance (2, 2) that the form of the faces causes in the lean, dimensionless.

    Parameters
    ----------
    points_m : (n, 3) array
        Points of the shaft, site frame, metres.
    state, cut, equations
        The faces at their minimum, which points count, and the normal equations there.
    lean_of : (2, p) array
        Takes the lean out of the unknowns of the equations.
    """
    sums, free = _sums(points_m, state, cut, equations), equations.free
    inverse = np.zeros_like(equations.normal)
    inverse[np.ix_(free, free)] = np.linalg.inv(equations.normal[np.ix_(free, free)])
    pull = lean_of @ inverse @ sums.design.T
    largest = np.zeros((2, 2))
    for size in BLOCKS:
        block = _blocks(len(equations.seen), size)
        of_blocks = np.stack([np.bincount(block, row) for row in pull])
        found = _variance_m2(_joined(sums, block), inverse) * of_blocks @ of_blocks.T
        largest = found if np.trace(found) > np.trace(largest) else largest
    return np.asarray(largest)


def _sums(points_m: NDArray[np.float64], state: FaceState, cut: Cut, equations: FaceEquations) -> _Sums:
    m, t = len(equations.seen), equations.n_terms
    n_cells, size = m * HEIGHTS * COLUMNS, m * (t + 1) + 1
    # weights, weighted residuals, and their squares
    scalars, design = np.zeros((3, n_cells)), np.zeros((n_cells, size))
    for chunk in state.chunks(points_m):
        split = state.split(chunk)
        weights = tukey_weights(split.off, cut.sigma_m)
        margin = cut.corners.split(chunk).margin
        weights[(np.abs(split.off) > cut.gate_m) | (margin < cut.gate_m) | ~cut.seen[split.face]] = 0.0
        rise = chunk[:, 2] - state.z_mid_m
        half_m = state.distance_m[:, 0].mean()
        row = np.clip((rise / state.half_height_m + 1.0) / 2.0 * HEIGHTS, 0, HEIGHTS - 1).astype(np.intp)
        column = np.clip((split.along / half_m + 1.0) / 2.0 * COLUMNS, 0, COLUMNS - 1).astype(np.intp)
        cell = (split.face * HEIGHTS + row) * COLUMNS + column
        pulled = weights * split.off
        scalars += [np.bincount(cell, values, n_cells) for values in (weights, pulled, pulled**2)]
        terms = np.column_stack([state.terms(chunk[:, 2]), -split.along])
        place = split.face[:, None] * (t + 1) + np.arange(t + 1)
        np.add.at(design, (cell[:, None], place), weights[:, None] * terms)
        design[:, -1] += np.bincount(cell, -weights * split.along * rise, n_cells)
    return _Sums(scalars[0], scalars[1], scalars[2], design)


def _blocks(n_faces: int, size: tuple[int, int]) -> NDArray[np.intp]:
    """Number of the block (c,) of every cell."""
    face, row, column = np.indices((n_faces, HEIGHTS, COLUMNS)).reshape(3, -1)
    rows, columns = HEIGHTS // size[0], COLUMNS // size[1]
    return np.asarray((face * rows + row // size[0]) * columns + column // size[1], dtype=np.intp)


def _joined(sums: _Sums, block: NDArray[np.intp]) -> _Sums:
    """Sums of the blocks that have points."""
    n = int(block.max()) + 1
    joined = np.zeros((n, 3 + sums.design.shape[1]))
    np.add.at(joined, block, np.column_stack([sums.weight, sums.off, sums.off_squared, sums.design]))
    kept = joined[joined[:, 0] > 0.0]
    return _Sums(kept[:, 0], kept[:, 1], kept[:, 2], kept[:, 3:])


def _variance_m2(blocks: _Sums, inverse: NDArray[np.float64]) -> float:
    """Variance of what a block is off its plane, square metres; what the fit took out is put back (``wall_form``)."""
    weight, n = blocks.weight, len(blocks.weight)
    mean = blocks.off / weight
    left = np.eye(n) - (blocks.design / weight[:, None]) @ inverse @ blocks.design.T
    freedom = float(np.sum(weight[:, None] * left**2))
    if freedom < LEAST_FREEDOM * float(weight.sum()):
        return 0.0
    expected = float(np.sum(weight[:, None] * left**2 * blocks.off_squared / weight**2))
    excess = float(weight @ mean**2) - expected
    scatter = expected * float(np.sqrt(2.0 / max(n * freedom / weight.sum(), 1.0)))
    return excess / freedom if excess > SIGNIFICANT * scatter else 0.0
