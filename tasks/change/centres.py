"""The congruency test over the centres of all slices of two epochs, and where the shaft changed its shape.

The differences of the centres are taken apart: a smooth part (shift, lean, and bending up to a cubic), which stations out of
level or place move together, and what is left, which tells how much the centres really scatter. The smooth part is tested
as a whole by that scatter and by what the poses allow (after Pelzer 1971, DIN 18710-4): stations that see different heights
make them bend, too, so it is the covariance of the bending axis that says how much. What is left is searched for the run of
slices whose common shift explains most. What slices state of themselves is a few per cent off as a rule, and over
hundreds of components that alone would be a change: so their scatter is never taken from what they state.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

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


@dataclass(frozen=True, slots=True, eq=False)
class AxisError:
    """How uncertain the difference of two axes is, as bending curves.

    ``covariance`` (2 k, 2 k) of shift east and north at z = 0 in metres, lean east and north, and then, as far as they are
    known, of the coefficients of the second and third Legendre polynomial from ``ends_m[0]`` to ``ends_m[1]``, metres.
    """

    covariance: NDArray[np.float64]
    ends_m: tuple[float, float]

    def terms(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivatives (m, 2, 2 k) of the axis at heights (m,) by what the covariance is of."""
        low, high = self.ends_m
        k = len(self.covariance) // 2
        share = (2.0 * z_m - low - high) / (high - low)
        bends = np.polynomial.legendre.legvander(share, k - 1)[:, 2:]
        basis = np.column_stack([np.ones_like(z_m), z_m, bends])
        return _both_components(basis)


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


def compare_centres(before: Centres, after: Centres, axis_error: AxisError) -> CentreChange | None:
    """Test all centres that two epochs have at the same heights; None with fewer than ``LEAST_CENTRES`` of them.

    Parameters
    ----------
    before, after : Centres
        A centre counts where the other epoch has one within a millimetre of height.
    axis_error : AxisError
        Of the difference of the axes, points and poses.
    """
    from scipy.special import fdtrc  # noqa: PLC0415 (slow to import)

    nearest = np.abs(before.z_m[:, None] - after.z_m[None, :])
    old, new = np.nonzero(nearest < SAME_HEIGHT_M)
    if len(old) < LEAST_CENTRES:
        return None
    noise = after.covariance_m2[new] + before.covariance_m2[old]
    split = _Split(after.z_m[new], after.center_m[new] - before.center_m[old], noise)
    factor, freedom = split.scatter()
    allowed = split.allowed(axis_error, factor)
    smooth, size = split.smooth_test(allowed)
    p_smooth = float(fdtrc(size, freedom, smooth / size))
    bend = split.bend_test(allowed)
    found = CentreChange(
        n=len(old),
        statistic=smooth,
        freedom=size,
        p_value=min(1.0, 2.0 * p_smooth),
        noise_factor=float(np.sqrt(factor)),
        largest_m=float(np.linalg.norm(split.d, axis=1).max()),
        shape_p_value=None if bend is None else float(fdtrc(bend[1], freedom, bend[0] / bend[1])),
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
        return _both_components(np.asarray(np.polynomial.legendre.legvander(share, self.order)))

    def smooth(self, d: NDArray[np.float64]) -> NDArray[np.float64]:
        """Coefficients (2 k, ...) of the smooth part of differences (m, 2, ...)."""
        pull = self.smooth_noise @ np.einsum("mki,mkl->iml", self.terms, np.linalg.inv(self.noise)).reshape(
            2 * self.order + 2, -1
        )
        return np.asarray(pull @ d.reshape(2 * len(self.z_m), *d.shape[2:]))

    @property
    def smooth_noise(self) -> NDArray[np.float64]:
        """Covariance (2 k, 2 k) of the smooth part by the stated noise."""
        terms = self.terms
        return np.asarray(
            np.linalg.inv(np.einsum("mki,mkl,mlj->ij", terms, np.linalg.inv(self.noise), terms))
        )

    def scatter(self) -> tuple[float, float]:
        """Variance of the centres over the stated one, and its degrees of freedom.

        The median of the squared lengths of what is left: a part of the shaft that moved does not enlarge it.
        """
        m = len(self.z_m)
        left = self.d - self.terms @ self.smooth(self.d)
        squares = np.einsum("mi,mij,mj->m", left, np.linalg.inv(self.noise), left)
        redundant = m - self.order - 1
        factor = float(np.median(squares)) / (MEDIAN_CHI2_2 * redundant / m)
        return max(LEAST_FACTOR, factor), max(2.0 * redundant * MEDIAN_EFFICIENCY, 1.0)

    def allowed(self, axis_error: AxisError, factor: float) -> NDArray[np.float64]:
        """Covariance (2 k, 2 k) of the smooth part: what the centres scatter, and what poses move together."""
        noise = self.smooth_noise
        follows = self.smooth(axis_error.terms(self.z_m))
        # what the slices' own noise does is in that of the axes, too, and must not count twice
        beyond = _positive_part(follows @ axis_error.covariance @ follows.T - noise)
        return np.asarray(factor * noise + beyond)

    def smooth_test(self, allowed: NDArray[np.float64]) -> tuple[float, int]:
        """Statistic of the smooth part and its size."""
        coefficients = self.smooth(self.d)
        return float(coefficients @ np.linalg.solve(allowed, coefficients)), len(coefficients)

    def bend_test(self, allowed: NDArray[np.float64]) -> tuple[float, int] | None:
        """Statistic of the smooth part beyond shift and lean, and its size; None where it has no more."""
        bend, covariance = self.smooth(self.d)[RIGID:], allowed[RIGID:, RIGID:]
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


def _both_components(basis: NDArray[np.float64]) -> NDArray[np.float64]:
    """Functions (m, k) of the height as derivatives (m, 2, 2 k) of east and north, the coefficients by turns."""
    made = np.zeros((len(basis), 2, 2 * basis.shape[1]))
    made[:, 0, 0::2] = made[:, 1, 1::2] = basis
    return made


def _positive_part(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    scale = np.sqrt(np.maximum(np.abs(np.diag(matrix)), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    return np.asarray((vectors * np.maximum(values, 0.0) @ vectors.T) * np.outer(scale, scale))


def _placed(found: CentreChange, split: _Split, factor: float, freedom: float) -> CentreChange:
    """Say which run of slices moved beside the smooth part, if one did: the one whose common shift explains most."""
    from scipy.special import fdtrc  # noqa: PLC0415 (slow to import)

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
    p_value = min(1.0, len(gain) * float(fdtrc(2, freedom, gain[best] / 2.0)))
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
