"""The loops over all planes that are compared, compiled: partners, residuals, normal equations."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

Frame = tuple[NDArray[np.float64], NDArray[np.float64]]


@compiled
def turned(matrix: NDArray[np.float64], vectors: NDArray[np.float64], i: int) -> tuple[float, float, float]:
    """Vector i of vectors (n, 3), turned by a matrix (3, 3)."""
    x, y, z = vectors[i, 0], vectors[i, 1], vectors[i, 2]
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z,
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z,
        matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z,
    )


@compiled
def into_target(
    points_m: NDArray[np.float64],
    source: tuple[NDArray[np.float64], NDArray[np.float64]],
    target: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (n, 3) of the source in the site frame, and in that of the target; rotation and position of each."""
    placed, local = np.empty_like(points_m), np.empty_like(points_m)
    (turn, at), (other_turn, other_at) = source, target
    for i in range(len(points_m)):
        x, y, z = turned(turn, points_m, i)
        x, y, z = x + at[0], y + at[1], z + at[2]
        placed[i, 0], placed[i, 1], placed[i, 2] = x, y, z
        x, y, z = x - other_at[0], y - other_at[1], z - other_at[2]
        for k in range(3):
            local[i, k] = other_turn[0, k] * x + other_turn[1, k] * y + other_turn[2, k] * z
    return placed, local


@compiled
def apart(a: NDArray[np.float64], i: int, b: NDArray[np.float64], j: int) -> float:
    """Distance of point i of (n, 3) from point j of (m, 3)."""
    x, y, z = a[i, 0] - b[j, 0], a[i, 1] - b[j, 1], a[i, 2] - b[j, 2]
    return float(np.sqrt(x * x + y * y + z * z))


@compiled
def unsettled(
    local_m: NDArray[np.float64],
    searched_m: NDArray[np.float64],
    partner: NDArray[np.int64],
    others_m: NDArray[np.float64],
    target_m: NDArray[np.float64],
    reach_m: float,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Indices of the points (n, 3) whose nearest has to be searched for anew, and the distance (n,) of the last one found.

    Searched for at ``searched_m`` (n, 3), all but the partner (-1: all) were at least ``others_m`` (n,) away.
    """
    anew = np.empty(len(local_m), np.int64)
    distance = np.full(len(local_m), np.inf)
    n = 0
    for i in range(len(local_m)):
        if partner[i] >= 0:
            distance[i] = apart(local_m, i, target_m, partner[i])
        others = others_m[i] - apart(local_m, i, searched_m, i)
        # an equal is not settled: the search decides
        if min(distance[i], reach_m) >= others - 1e-9:
            anew[n] = i
            n += 1
    return anew[:n].copy(), distance


@compiled
def good_matches(  # noqa: PLR0913, PLR0917 - a compiled loop
    placed_m: NDArray[np.float64],
    normals: NDArray[np.float64],
    turn: NDArray[np.float64],
    found: tuple[NDArray[np.int64], NDArray[np.float64]],
    target: tuple[NDArray[np.float64], NDArray[np.float64]],
    target_pose: tuple[NDArray[np.float64], NDArray[np.float64]],
    gates: tuple[float, float, float],
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Which points (q, 3) of the source have a partner in whose plane they lie (m,), and what is known of each pair.

    ``normals`` (q, 3) are still to be turned; ``found`` are partner and distance (q,); ``target`` its points and normals,
    to be placed; ``gates`` the reach, the gate along the normal and the least cosine between normals. Then come, in the
    site frame, the normals of the source, signed as those of the target, its places and its normals (3, m, 3), and the
    residuals (m,).
    """
    partner, distance = found
    points_m, planes = target
    other_turn, other_at = target_pose
    good, n = np.empty(len(partner), np.int64), 0
    pairs, residuals = np.empty((3, len(partner), 3)), np.empty(len(partner))
    for i in range(len(partner)):
        if not distance[i] < gates[0]:
            continue
        nx, ny, nz = turned(other_turn, planes, partner[i])
        ox, oy, oz = turned(turn, normals, i)
        cosine = nx * ox + ny * oy + nz * oz
        if not abs(cosine) > gates[2]:
            continue
        if cosine < 0.0:
            ox, oy, oz = -ox, -oy, -oz
        x, y, z = turned(other_turn, points_m, partner[i])
        x, y, z = x + other_at[0], y + other_at[1], z + other_at[2]
        dx, dy, dz = placed_m[i, 0] - x, placed_m[i, 1] - y, placed_m[i, 2] - z
        residual = 0.5 * ((nx + ox) * dx + (ny + oy) * dy + (nz + oz) * dz)
        if abs(residual) <= gates[1]:
            pairs[0, n, 0], pairs[0, n, 1], pairs[0, n, 2] = ox, oy, oz
            pairs[1, n, 0], pairs[1, n, 1], pairs[1, n, 2] = x, y, z
            pairs[2, n, 0], pairs[2, n, 1], pairs[2, n, 2] = nx, ny, nz
            residuals[n] = residual
            good[n] = i
            n += 1
    return good[:n].copy(), pairs[:, :n].copy(), residuals[:n].copy()


@compiled
def _row(  # noqa: PLR0913, PLR0917 - a compiled loop
    p: NDArray[np.float64],
    q: NDArray[np.float64],
    own: NDArray[np.float64],
    other: NDArray[np.float64],
    i: int,
    at: NDArray[np.float64],
    other_at: NDArray[np.float64],
    row: NDArray[np.float64],
) -> None:
    """Derivatives (9,) of a residual: by the turns of source and target, and by the shift of the source."""
    mx, my, mz = (
        0.5 * (own[i, 0] + other[i, 0]),
        0.5 * (own[i, 1] + other[i, 1]),
        0.5 * (own[i, 2] + other[i, 2]),
    )
    hx, hy, hz = 0.5 * (p[i, 0] - q[i, 0]), 0.5 * (p[i, 1] - q[i, 1]), 0.5 * (p[i, 2] - q[i, 2])
    x, y, z = p[i, 0] - at[0], p[i, 1] - at[1], p[i, 2] - at[2]
    row[0] = y * mz - z * my + own[i, 1] * hz - own[i, 2] * hy
    row[1] = z * mx - x * mz + own[i, 2] * hx - own[i, 0] * hz
    row[2] = x * my - y * mx + own[i, 0] * hy - own[i, 1] * hx
    x, y, z = q[i, 0] - other_at[0], q[i, 1] - other_at[1], q[i, 2] - other_at[2]
    row[3] = z * my - y * mz + other[i, 1] * hz - other[i, 2] * hy
    row[4] = x * mz - z * mx + other[i, 2] * hx - other[i, 0] * hz
    row[5] = y * mx - x * my + other[i, 0] * hy - other[i, 1] * hx
    row[6], row[7], row[8] = mx, my, mz


@compiled
def _summed_as(parameter: int) -> tuple[int, float]:
    """Which of the nine summed parameters one of the twelve is, and with which sign."""
    part, k = parameter // 3, parameter % 3
    if part == 0:
        return k, 1.0
    if part == 2:
        return 3 + k, 1.0
    return 6 + k, 1.0 if part == 1 else -1.0


@compiled
def normal_equations(  # noqa: PLR0913, PLR0917 - a compiled loop
    p: NDArray[np.float64],
    q: NDArray[np.float64],
    own: NDArray[np.float64],
    other: NDArray[np.float64],
    positions_m: tuple[NDArray[np.float64], NDArray[np.float64]],
    weights: NDArray[np.float64],
    residuals_m: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normal equations (12, 12) and (12,) of pairs of points p and q with their normals (m, 3) of source and target.

    The parameters are turn and shift of the source, then of the target. The shifts are each other's reverse, so that nine
    parameters are summed.
    """
    sums, right, row = np.zeros((9, 9)), np.zeros(9), np.empty(9)
    for i in range(len(p)):
        _row(p, q, own, other, i, positions_m[0], positions_m[1], row)
        for j in range(9):
            weighted = weights[i] * row[j]
            right[j] -= weighted * residuals_m[i]
            for k in range(j, 9):
                sums[j, k] += weighted * row[k]
    matrix, vector = np.empty((12, 12)), np.empty(12)
    for j in range(12):
        from_j, sign_j = _summed_as(j)
        vector[j] = sign_j * right[from_j]
        for k in range(12):
            from_k, sign_k = _summed_as(k)
            matrix[j, k] = sign_j * sign_k * sums[min(from_j, from_k), max(from_j, from_k)]
    return matrix, vector
