"""The congruency test over the centres of all slices of two epochs, and where the shaft changed its shape.

The differences of the centres are taken apart: a smooth part (shift, lean, and bending up to a cubic), which stations out of
level move together, and what is left, which tells how much the centres really scatter. The smooth part is tested as a whole
by that scatter and by what levels and positions allow (after Pelzer 1971, DIN 18710-4); what is left is searched for the run
of slices whose common shift explains most. What slices state of themselves is a few per cent off as a rule, and over
hundreds of components that alone would be a change: so their scatter is never taken from what they state.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f

from tasks.change.chi_square import SIGNIFICANT_P

LEAST_CENTRES: Final = 6
"""Fewer have no shape and no scatter."""

SMOOTH_ORDER: Final = 3
CENTRES_PER_ORDER: Final = 3

RIGID: Final = 4
"""Shift and lean, two components each."""

SAME_HEIGHT_M: Final = 1e-3

MEDIAN_CHI2_2: Final = 2.0 * float(np.log(2.0))
"""Median of chi-square with two degrees of freedom."""

MEDIAN_EFFICIENCY: Final = 0.37
"""Of a variance that is taken from a median of squares."""

LEAST_FACTOR: Final = 0.25
"""Centres that agree better than half as well as stated are few, or the same ones."""

LEAST_DETERMINANT: Final = 1e-9
"""Over the squared trace; below it a run of centres says nothing by itself."""


@dataclass(frozen=True, slots=True, eq=False)
class Centres:
    """Centres (m, 2) of slices at heights (m,), east and north, with covariances (m, 2, 2) from their points, metres."""

    z_m: NDArray[np.float64]
    center_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CentreChange:
    """What the centres of two epochs say.

    ``statistic`` over ``freedom`` is F for the smooth part. ``p_value`` is of the test as a whole, ``shape_p_value`` of the
    bending in it. ``noise_factor`` is how many times as stated the centres scatter. ``z_low_m``, ``z_high_m``, ``moved_m``
    say which run of slices moved beside the smooth part and by how much, with the probability of that or more anywhere;
    None where none did significantly. ``largest_m`` is the largest difference.
    """

    n: int
    statistic: float
    freedom: int
    p_value: float
    noise_factor: float
    largest_m: float
    shape_p_value: float | None
    z_low_m: float | None = None
    z_high_m: float | None = None
    moved_m: float | None = None
    place_p_value: float | None = None

    @property
    def significant(self) -> bool:
        """Whether chance alone would do so in less than 1 of 100 cases."""
        return self.p_value < SIGNIFICANT_P


def compare_centres(
    before: Centres, after: Centres, rigid_covariance: NDArray[np.float64]
) -> CentreChange | None:
    """Test all centres that two epochs have at the same heights; None with fewer than ``LEAST_CENTRES`` of them.

    Parameters
    ----------
    before, after : Centres
        A centre counts where the other epoch has one within a millimetre of height.
    rigid_covariance : (4, 4) array
        Covariance of the difference of the straight axes: shift east and north at z = 0 in metres, lean east and north.
    """
    nearest = np.abs(before.z_m[:, None] - after.z_m[None, :])
    old, new = np.nonzero(nearest < SAME_HEIGHT_M)
    if len(old) < LEAST_CENTRES:
        return None
    noise = after.covariance_m2[new] + before.covariance_m2[old]
    split = _Split(after.z_m[new], after.center_m[new] - before.center_m[old], noise)
    factor, freedom = split.scatter()
    smooth, size = split.smooth_test(rigid_covariance, factor)
    p_smooth = float(f.sf(smooth / size, size, freedom))
    bend = split.bend_test(factor)
    found = CentreChange(
        n=len(old),
        statistic=smooth,
        freedom=size,
        p_value=min(1.0, 2.0 * p_smooth),
        noise_factor=float(np.sqrt(factor)),
        largest_m=float(np.linalg.norm(split.d, axis=1).max()),
        shape_p_value=None if bend is None else float(f.sf(bend[0] / bend[1], bend[1], freedom)),
    )
    return _placed(found, split, factor, freedom)


@dataclass(frozen=True, slots=True, eq=False)
class _Split:
    """Differences (m, 2) of centres at heights (m,), with the sums of their covariances (m, 2, 2)."""

    z_m: NDArray[np.float64]
    d: NDArray[np.float64]
    noise: NDArray[np.float64]

    @property
    def order(self) -> int:
        """Order of the smooth part."""
        return int(min(SMOOTH_ORDER, max(1, len(self.z_m) // CENTRES_PER_ORDER - 1)))

    @property
    def terms(self) -> NDArray[np.float64]:
        """Derivatives (m, 2, 2 k) of the centres by the coefficients of the smooth part, east and north by turns."""
        low, high = float(self.z_m.min()), float(self.z_m.max())
        share = (2.0 * self.z_m - low - high) / (high - low)
        basis = np.polynomial.legendre.legvander(share, self.order)
        made = np.zeros((len(self.z_m), 2, 2 * basis.shape[1]))
        made[:, 0, 0::2] = made[:, 1, 1::2] = basis
        return made

    def smooth(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Coefficients (2 k,) of the smooth part and their covariance (2 k, 2 k) by the stated noise."""
        weight, terms = np.linalg.inv(self.noise), self.terms
        normal = np.einsum("mki,mkl,mlj->ij", terms, weight, terms)
        covariance = np.linalg.inv(normal)
        return covariance @ np.einsum("mki,mkl,ml->i", terms, weight, self.d), covariance

    def scatter(self) -> tuple[float, float]:
        """Variance of the centres over the stated one, and its degrees of freedom.

        The median of the squared lengths of what is left: a part of the shaft that moved does not enlarge it.
        """
        m = len(self.z_m)
        left = self.d - self.terms @ self.smooth()[0]
        squares = np.einsum("mi,mij,mj->m", left, np.linalg.inv(self.noise), left)
        redundant = m - self.order - 1
        factor = float(np.median(squares)) / (MEDIAN_CHI2_2 * redundant / m)
        return max(LEAST_FACTOR, factor), max(2.0 * redundant * MEDIAN_EFFICIENCY, 1.0)

    def smooth_test(self, rigid: NDArray[np.float64], factor: float) -> tuple[float, int]:
        """Statistic of the smooth part and its size; levels and positions may move it as a rigid body."""
        coefficients, noise = self.smooth()
        low, high = float(self.z_m.min()), float(self.z_m.max())
        by_rigid = np.zeros((len(coefficients), RIGID))
        by_rigid[[0, 1], [0, 1]] = 1.0
        by_rigid[[0, 1], [2, 3]] = (low + high) / 2.0
        by_rigid[[2, 3], [2, 3]] = (high - low) / 2.0
        moved = by_rigid @ rigid @ by_rigid.T
        # what the slices' own noise does is in the rigid covariance, too, and must not count twice
        beyond = _positive_part(moved[:RIGID, :RIGID] - noise[:RIGID, :RIGID])
        total = factor * noise
        total[:RIGID, :RIGID] += beyond
        return float(coefficients @ np.linalg.solve(total, coefficients)), len(coefficients)

    def bend_test(self, factor: float) -> tuple[float, int] | None:
        """Statistic of the smooth part beyond shift and lean, and its size; None where it has no more."""
        coefficients, noise = self.smooth()
        bend, covariance = coefficients[RIGID:], factor * noise[RIGID:, RIGID:]
        return (float(bend @ np.linalg.solve(covariance, bend)), len(bend)) if len(bend) else None

    def left_over(self, factor: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Information (m, 2, m, 2) of the centres with the smooth part free, and its product with d (m, 2)."""
        m, terms = len(self.z_m), self.terms
        weight = np.linalg.inv(factor * self.noise)
        flat = np.einsum("mkl,mlj->mkj", weight, terms).reshape(2 * m, -1)
        normal = flat.T @ terms.reshape(2 * m, -1)
        information = -(flat @ np.linalg.solve(normal, flat.T)).reshape(m, 2, m, 2)
        each = np.arange(m)
        information[each, :, each, :] += weight
        return information, np.einsum("minj,nj->mi", information, self.d)


def _positive_part(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    scale = np.sqrt(np.maximum(np.abs(np.diag(matrix)), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    return np.asarray((vectors * np.maximum(values, 0.0) @ vectors.T) * np.outer(scale, scale))


def _placed(found: CentreChange, split: _Split, factor: float, freedom: float) -> CentreChange:
    """Say which run of slices moved beside the smooth part, if one did: the one whose common shift explains most."""
    information, score = split.left_over(factor)
    m = found.n
    sums = np.zeros((m + 1, m + 1, 2, 2))
    sums[1:, 1:] = information.transpose(0, 2, 1, 3).cumsum(axis=0).cumsum(axis=1)
    scores = np.zeros((m + 1, 2))
    scores[1:] = score.cumsum(axis=0)
    first, past = np.triu_indices(m + 1, 1)
    runs = past - first <= m // 2
    first, past = first[runs], past[runs]
    own = sums[past, past] - sums[first, past] - sums[past, first] + sums[first, first]
    pulled = scores[past] - scores[first]
    tell = np.linalg.det(own) > LEAST_DETERMINANT * np.trace(own, axis1=1, axis2=2) ** 2
    shift = np.zeros_like(pulled)
    shift[tell] = np.linalg.solve(own[tell], pulled[tell, :, None])[:, :, 0]
    gain = np.sum(pulled * shift, axis=1)
    best = int(np.argmax(gain))
    p_value = min(1.0, len(gain) * float(f.sf(gain[best] / 2.0, 2, freedom)))
    whole = replace(found, p_value=min(found.p_value, 2.0 * p_value, 1.0))
    if p_value >= SIGNIFICANT_P:
        return whole
    return replace(
        whole,
        z_low_m=float(split.z_m[first[best]]),
        z_high_m=float(split.z_m[past[best] - 1]),
        moved_m=float(np.linalg.norm(shift[best])),
        place_p_value=p_value,
    )
