"""The covariance of a difference of two axes that rest on the same poses and, in part, on the same points."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

LEAST_RATIO: Final = 1e-12
"""Eigenvalues below this share of the largest are rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Centres:
    """The slices that gave a centre to an axis.

    Attributes
    ----------
    z_m, thickness_m : (m,) arrays
        Mid-height and thickness of the slices, metres.
    covariances_m2 : (m, 2, 2) array
        Covariance of (east, north) of each centre from its points, square metres.
    weights : (m,) array
        Weight of each centre in the axis, not negative.
    """

    z_m: NDArray[np.float64]
    thickness_m: NDArray[np.float64]
    covariances_m2: NDArray[np.float64]
    weights: NDArray[np.float64]

    def __post_init__(self) -> None:
        m = len(self.z_m)
        shapes = (self.thickness_m.shape, self.weights.shape, self.covariances_m2.shape)
        if shapes != ((m,), (m,), (m, 2, 2)):
            raise ShapeError(
                f"centres need z_m, thickness_m and weights (m,) and covariances_m2 (m, 2, 2); got m = {m} and {shapes}"
            )

    @property
    def lean_coefficients(self) -> NDArray[np.float64]:
        """By how much the lean follows each centre (m,), 1/m: of the weighted line through the centres."""
        w = self.weights / self.weights.sum()
        from_middle_m = self.z_m - w @ self.z_m
        return np.asarray(w * from_middle_m / (w @ from_middle_m**2))


def shared_points_covariance(
    covariances: tuple[NDArray[np.float64], NDArray[np.float64]], first: Centres, second: Centres
) -> NDArray[np.float64]:
    """Covariance (2, 2) of the difference of two lean vectors from what their points do, shared ones cancelled.

    The correlation of the two leans is that of the centres of overlapping slices, each weighted as in its axis. Of two
    centres of the same points the less certain one is taken as the more certain one plus noise of its own: their
    covariance is that of the more certain one (Hausman 1978). Of slices that overlap in part it is that of the larger
    slice as far as they overlap. The correlation is then put between the stated covariances, which may hold more than
    the centres say: a model error, or what few centres leave unknown.

    Assumes that the points are evenly spread over the thickness of a slice, and that what makes one stated covariance
    larger than its centres say is shared in the same measure as the points are.

    Parameters
    ----------
    covariances : pair of (2, 2) arrays
        The parts of both lean covariances that come from the points.
    first, second : Centres
        What the axes rest on.

    Returns
    -------
    (2, 2) array
        Positive semi-definite; zero for an axis against itself.

    References
    ----------
    Hausman 1978, Econometrica 46, lemma 2.1: the covariance of an efficient estimator with its difference from
    another one is zero. docs/estimators.md.
    """
    root_a, root_b = _root(covariances[0]), _root(covariances[1])
    K = root_a @ lean_correlation(first, second) @ root_b
    return _positive(covariances[0] + covariances[1] - K - K.T)


def lean_correlation(first: Centres, second: Centres) -> NDArray[np.float64]:
    """Correlation (2, 2) of two lean vectors by the points that their slices share; its singular values are at most 1."""
    whitened = (
        _inverse_root(_cross_covariance(first, first))
        @ _cross_covariance(first, second)
        @ _inverse_root(_cross_covariance(second, second))
    )
    left, sizes, right = np.linalg.svd(whitened)
    return np.asarray(left @ np.diag(np.minimum(sizes, 1.0)) @ right)


def whole_surface_covariance(
    points_cov: NDArray[np.float64], surface_cov: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Covariance (2, 2) of a difference from a fit of all points, which is efficient: the one less the other.

    None where that is not positive definite: then the two are so alike, or their covariances so uncertain, that
    it says nothing.
    """
    difference = np.asarray(points_cov - surface_cov)
    smallest, largest = np.linalg.eigvalsh(difference)
    return difference if smallest > LEAST_RATIO * largest else None


def common_poses_covariance(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (2, 2) of what pose errors common to two axes leave in their difference.

    The same errors act on both: equal parts cancel. Where they act on one more than on the other, the difference of
    the two effects remains, taken as fully correlated.
    """
    left = _root(first) - _root(second)
    return np.asarray(left @ left.T)


def _cross_covariance(a: Centres, b: Centres) -> NDArray[np.float64]:
    """Covariance (2, 2) of two lean vectors, from centres with the covariances of their points."""
    overlap_m = np.minimum.outer(a.z_m + a.thickness_m / 2, b.z_m + b.thickness_m / 2) - np.maximum.outer(
        a.z_m - a.thickness_m / 2, b.z_m - b.thickness_m / 2
    )
    i, j = np.nonzero(overlap_m > 1e-9)
    by_second = (overlap_m[i, j] / a.thickness_m[i])[:, None, None] * b.covariances_m2[j]
    by_first = (overlap_m[i, j] / b.thickness_m[j])[:, None, None] * a.covariances_m2[i]
    is_smaller = np.trace(by_first, axis1=1, axis2=2) < np.trace(by_second, axis1=1, axis2=2)
    shared = np.where(is_smaller[:, None, None], by_first, by_second)
    factors = a.lean_coefficients[i] * b.lean_coefficients[j]
    return np.asarray(np.einsum("k,kij->ij", factors, shared))


def _root(C: NDArray[np.float64]) -> NDArray[np.float64]:
    values, vectors = np.linalg.eigh(C)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T)


def _inverse_root(C: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inverse of the symmetric root; a direction without variance has none and is left out."""
    values, vectors = np.linalg.eigh(C)
    known = values > LEAST_RATIO * values.max()
    inverse = np.where(known, 1.0 / np.sqrt(np.where(known, values, 1.0)), 0.0)
    return np.asarray(vectors * inverse @ vectors.T)


def _positive(C: NDArray[np.float64]) -> NDArray[np.float64]:
    """Set negative eigenvalues, which are rounding here, to zero."""
    values, vectors = np.linalg.eigh((C + C.T) / 2)
    return np.asarray(vectors * np.maximum(values, 0.0) @ vectors.T)
