"""The global congruency test over the centres of slices, and where the shaft changed its shape.

All centres of two epochs are compared at once (Pelzer 1971, DIN 18710-4): d' C^-1 d, with the errors of each centre by
itself and those that move all of them together, as levels and positions of the stations do. Where that says that something
changed, the shaft is laid onto its former self by a shift and a lean; what is left is searched for the heights that moved.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, f

from tasks.change.chi_square import SIGNIFICANT_P

LEAST_CENTRES: Final = 4
"""Fewer have no shape."""

RIGID: Final = 4
"""Shift and lean, two components each."""

SMOOTH_ORDER: Final = 3
"""What is smoother than a cubic does not count as noise of the centres."""

MEDIAN_CHI2_2: Final = 2.0 * float(np.log(2.0))
"""Median of chi-square with two degrees of freedom."""

MEDIAN_EFFICIENCY: Final = 0.37
"""Of a variance that is taken from a median of squares."""


NOISY: Final = 2.0
"""The stated noise is enlarged from this many standard deviations of its own estimate on."""


@dataclass(frozen=True, slots=True, eq=False)
class Centres:
    """Centres (m, 2) of slices at heights (m,), east and north, with covariances (m, 2, 2) from their points, metres."""

    z_m: NDArray[np.float64]
    center_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CentreChange:
    """What the centres of two epochs say.

    ``statistic`` and ``freedom`` are of the global test, ``p_value`` follows F where the noise of the centres had to be
    enlarged by ``noise_factor`` (1 where it is as stated). ``shape_p_value`` is of the same test after a shift and a lean.
    ``z_low_m``, ``z_high_m``, ``moved_m`` say where the shape changed most and by how much there, with the probability of
    that or more anywhere; None where the shape did not change significantly. ``largest_m`` is the largest difference.
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
        Heights ascending; a centre counts where the other epoch has one within a millimetre of height.
    rigid_covariance : (4, 4) array
        Covariance of the difference of the straight axes: shift east and north at z = 0 in metres, lean east and north.
    """
    first, second = _matched(before.z_m, after.z_m)
    m = len(first)
    if m < LEAST_CENTRES:
        return None
    z_m = after.z_m[second]
    d = after.center_m[second] - before.center_m[first]
    noise = after.covariance_m2[second] + before.covariance_m2[first]
    factor, freedom = _noise_factor(d, noise, z_m)
    weight: NDArray[np.float64] = np.asarray(np.linalg.inv(noise * factor), dtype=np.float64)
    together = _rigid_terms(z_m)
    common = _beyond_noise(rigid_covariance, together, weight)
    statistic = _statistic(d, weight, together, common)
    shape = _Shape(z_m, d, weight, together)
    found = CentreChange(
        n=m,
        statistic=statistic,
        freedom=2 * m,
        p_value=_probability(statistic, 2 * m, factor, freedom),
        noise_factor=float(np.sqrt(factor)),
        largest_m=float(np.linalg.norm(d, axis=1).max()),
        shape_p_value=_probability(shape.statistic(), 2 * m - RIGID, factor, freedom),
    )
    return _placed(found, shape)


def _matched(before_m: NDArray[np.float64], after_m: NDArray[np.float64]) -> tuple[list[int], list[int]]:
    known = {round(1e3 * float(z)): place for place, z in enumerate(before_m)}
    pairs = [
        (known[key], place) for place, z in enumerate(after_m) if (key := round(1e3 * float(z))) in known
    ]
    return [old for old, _ in pairs], [new for _, new in pairs]


def _noise_factor(
    d: NDArray[np.float64], noise: NDArray[np.float64], z_m: NDArray[np.float64]
) -> tuple[float, float]:
    """By how much the variances of the centres are too small, at least 1, and the degrees of freedom of that factor.

    The median of the squared lengths of what is left after a cubic: a part of the shaft that moved does not enlarge it.
    """
    m = len(z_m)
    order = min(SMOOTH_ORDER, m - 2)
    share = 2.0 * (z_m - z_m.min()) / np.ptp(z_m) - 1.0
    basis = np.polynomial.legendre.legvander(share, order)
    left = d - basis @ np.linalg.lstsq(basis, d, rcond=None)[0]
    squares = np.einsum("mi,mij,mj->m", left, np.linalg.inv(noise), left)
    kept = (m - order - 1) / m
    freedom = max(2.0 * (m - order - 1) * MEDIAN_EFFICIENCY, 1.0)
    ratio = float(np.median(squares)) / (MEDIAN_CHI2_2 * kept)
    return (ratio if ratio > 1.0 + NOISY * np.sqrt(2.0 / freedom) else 1.0), freedom


def _rigid_terms(z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Derivatives (m, 2, 4) of the centres by shift and lean."""
    terms = np.zeros((len(z_m), 2, RIGID))
    terms[:, 0, 0] = terms[:, 1, 1] = 1.0
    terms[:, 0, 2] = terms[:, 1, 3] = z_m
    return terms


def _beyond_noise(
    rigid: NDArray[np.float64], terms: NDArray[np.float64], weight: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The part of a rigid motion's covariance (4, 4) that the centres' own noise does not explain."""
    scale = np.sqrt(np.diag(rigid))
    by_noise = np.linalg.inv(np.einsum("mki,mkl,mlj->ij", terms, weight, terms))
    values, vectors = np.linalg.eigh((rigid - by_noise) / np.outer(scale, scale))
    made = vectors * np.maximum(values, 0.0) @ vectors.T
    return np.asarray(made * np.outer(scale, scale))


def _statistic(
    d: NDArray[np.float64],
    weight: NDArray[np.float64],
    terms: NDArray[np.float64],
    common: NDArray[np.float64],
) -> float:
    """D' C^-1 d with C the noise of the centres and what moves them together."""
    weighed = np.einsum("mki,mkl,ml->i", terms, weight, d)
    normal = np.einsum("mki,mkl,mlj->ij", terms, weight, terms)
    alone = float(np.einsum("mi,mij,mj->", d, weight, d))
    # C^-1 by Woodbury, written so that a singular ``common`` does no harm
    together = np.linalg.solve(np.eye(RIGID) + common @ normal, common)
    return alone - float(weighed @ together @ weighed)


def _probability(statistic: float, freedom: int, factor: float, noise_freedom: float) -> float:
    if factor == 1.0:
        return float(chi2.sf(statistic, freedom))
    return float(f.sf(statistic / freedom, freedom, noise_freedom))


@dataclass(frozen=True, slots=True, eq=False)
class _Shape:
    """What is left of the differences (m, 2) after a shift and a lean."""

    z_m: NDArray[np.float64]
    d: NDArray[np.float64]
    weight: NDArray[np.float64]
    terms: NDArray[np.float64]

    def left_over(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Information (m, 2, m, 2) of the centres with the rigid motion free, and its product with d (m, 2)."""
        m = len(self.z_m)
        weighed = np.einsum("mkl,mlj->mkj", self.weight, self.terms)
        normal = np.einsum("mki,mkj->ij", self.terms, weighed)
        flat = weighed.reshape(2 * m, RIGID)
        information = -(flat @ np.linalg.solve(normal, flat.T)).reshape(m, 2, m, 2)
        each = np.arange(m)
        information[each, :, each, :] += self.weight
        return information, np.einsum("minj,nj->mi", information, self.d)

    def statistic(self) -> float:
        """D' of it d: chi-square with 2 m - 4 degrees of freedom if the shape is the same."""
        _, score = self.left_over()
        return float(np.sum(score * self.d))


def _placed(found: CentreChange, shape: _Shape) -> CentreChange:
    """Say where the shape changed most, if it did: the run of centres whose common shift explains most."""
    if found.shape_p_value is None or found.shape_p_value >= SIGNIFICANT_P:
        return found
    information, score = shape.left_over()
    m = found.n
    sums = np.zeros((m + 1, m + 1, 2, 2))
    sums[1:, 1:] = information.transpose(0, 2, 1, 3).cumsum(axis=0).cumsum(axis=1)
    scores = np.zeros((m + 1, 2))
    scores[1:] = score.cumsum(axis=0)
    best, place, moved = -1.0, (0, 0), np.zeros(2)
    runs = [(i, j) for i in range(m) for j in range(i + 1, m + 1) if j - i < m - 1]
    for i, j in runs:
        own = sums[j, j] - sums[i, j] - sums[j, i] + sums[i, i]
        pulled = scores[j] - scores[i]
        if np.linalg.det(own) <= 0.0:
            continue
        shift = np.linalg.solve(own, pulled)
        gain = float(pulled @ shift)
        if gain > best:
            best, place, moved = gain, (i, j), shift
    p_value = min(1.0, len(runs) * float(chi2.sf(best, 2)))
    if p_value >= SIGNIFICANT_P:
        return found
    return replace(
        found,
        z_low_m=float(shape.z_m[place[0]]),
        z_high_m=float(shape.z_m[place[1] - 1]),
        moved_m=float(np.linalg.norm(moved)),
        place_p_value=p_value,
    )
