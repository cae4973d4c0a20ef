"""Eigenvalues of many small symmetric matrices, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

MOST_SWEEPS: Final = 30
"""Five are enough, convergence being quadratic."""


@compiled
def _turn(a: NDArray[np.float64], v: NDArray[np.float64], p: int, q: int) -> None:
    """Make a[p, q] zero by a rotation in its plane, and turn the vectors with it."""
    theta = (a[q, q] - a[p, p]) / (2.0 * a[p, q])
    t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
    if theta < 0.0:
        t = -t
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    a[p, p] -= t * a[p, q]
    a[q, q] += t * a[p, q]
    a[p, q] = a[q, p] = 0.0
    r = 3 - p - q
    to_p, to_q = a[r, p], a[r, q]
    a[r, p] = a[p, r] = c * to_p - s * to_q
    a[r, q] = a[q, r] = s * to_p + c * to_q
    for i in range(3):
        to_p, to_q = v[i, p], v[i, q]
        v[i, p] = c * to_p - s * to_q
        v[i, q] = s * to_p + c * to_q


@compiled
def _one(a: NDArray[np.float64], v: NDArray[np.float64]) -> None:
    """Bring a (3, 3) to its eigenvalues on the diagonal, and v to the vectors, by Jacobi's method."""
    for i in range(3):
        for j in range(3):
            v[i, j] = 1.0 if i == j else 0.0
    small = np.finfo(np.float64).eps ** 2 * (a[0, 0] + a[1, 1] + a[2, 2]) ** 2
    for _ in range(MOST_SWEEPS):
        if a[0, 1] ** 2 + a[0, 2] ** 2 + a[1, 2] ** 2 <= 1e-4 * small:
            return
        for p in range(2):
            for q in range(p + 1, 3):
                if a[p, q] != 0.0:
                    _turn(a, v, p, q)


@compiled
def eigen_of(matrices: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Eigenvalues (n, 3), ascending, and vectors (n, 3, 3) in columns, of symmetric matrices (n, 3, 3).

    References
    ----------
    Golub & Van Loan 2013, Matrix Computations, 8.5.
    """
    values, vectors = np.empty((len(matrices), 3)), np.empty((len(matrices), 3, 3))
    a, v = np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(matrices)):
        a[:] = matrices[n]
        _one(a, v)
        for k in range(3):
            # its place: how many are smaller, or equal and before it
            place = 0
            for other in range(3):
                place += a[other, other] < a[k, k] or (a[other, other] == a[k, k] and other < k)
            values[n, place] = a[k, k]
            for i in range(3):
                vectors[n, i, place] = v[i, k]
    return values, vectors
