"""Normal equations of a surface piece by piece, to solve them again with some pieces left out or drawn twice."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tasks.surface.cells import Cells
from tasks.surface.normal import Normal


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Normal equations of n pieces, coefficients before pose errors.

    ``matrices`` (n, q, q) and ``rights`` (n, q) are those of the points, ``prior`` (q, q) what holds for all of them;
    the first ``size`` of the q unknowns are the coefficients.
    """

    matrices: NDArray[np.float64]
    rights: NDArray[np.float64]
    prior: NDArray[np.float64]
    size: int

    def solved(self, counts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Step (size,) of the coefficients with each piece counted so often (n,)."""
        n, q = self.rights.shape
        matrix = (counts @ self.matrices.reshape(n, q * q)).reshape(q, q) + self.prior
        return np.asarray(np.linalg.solve(matrix, counts @ self.rights)[: self.size])


def small_equations(cells: Cells, normal: Normal, piece: NDArray[np.intp], n_pieces: int) -> Pieces:
    """Split normal equations by the piece (c,) that each cell belongs to."""
    terms = np.concatenate([normal.design, normal.poses], axis=1)
    weighted = terms * normal.weight[:, None]
    q, p = terms.shape[1], normal.design.shape[1]
    matrices, rights = np.zeros((n_pieces, q, q)), np.zeros((n_pieces, q))
    order = np.argsort(piece, kind="stable")
    ends = np.searchsorted(piece[order], np.arange(n_pieces + 1))
    for number in range(n_pieces):
        rows = order[ends[number] : ends[number + 1]]
        matrices[number] = weighted[rows].T @ terms[rows]
        rights[number] = weighted[rows].T @ cells.residual_m[rows]
    prior = np.zeros((q, q))
    prior[p:, p:] = np.eye(q - p)
    # what holds the coefficients beside the points, found again from the whole
    explained = normal.cross @ np.linalg.solve(normal.inner, normal.cross.T)
    prior[:p, :p] = normal.matrix + explained - matrices.sum(axis=0)[:p, :p]
    return Pieces(matrices, rights, prior, p)
