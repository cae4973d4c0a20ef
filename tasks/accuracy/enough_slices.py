"""How many slices are enough: the fewest that cost nothing that could be seen."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from tasks.geometry.failure import FitFailure

MOST_EXCESS: Final = 0.10
"""By how much a sigma may be above the best and still be as good: no stated sigma is known better than that."""

LEAST_CENTRES: Final = 3
"""Two centres leave nothing over by which a bad slice would be seen."""

SURFACE: Final = "surface"
"""The method that slices nothing."""


@dataclass(frozen=True, slots=True)
class SchemeSigma:
    """An axis of an epoch: its slices, and the standard deviation of one component at the top, metres: points and poses."""

    label: str
    method: str
    n_slices: int
    n_centres: int
    sigma_m: float

    @property
    def is_sliced(self) -> bool:
        """Whether it rests on slices, and not on the whole surface."""
        return self.method != SURFACE

    @property
    def is_checked(self) -> bool:
        """Whether a bad slice would be seen by the others."""
        return not self.is_sliced or self.n_centres >= LEAST_CENTRES


@dataclass(frozen=True, slots=True)
class Judged:
    """Whether the slices of a scheme are enough; ``excess`` is the share by which its sigma is above that of the best."""

    label: str
    excess: float
    is_enough: bool | None
    reason: str


def best_of(sigmas: Sequence[SchemeSigma]) -> SchemeSigma | FitFailure:
    """The axis of the smallest sigma, of those that a bad slice could not spoil unseen; of equals the fewest slices."""
    checked = [scheme for scheme in sigmas if scheme.is_checked]
    if not checked:
        return FitFailure(
            f"needs an axis of at least {LEAST_CENTRES} centres with a known sigma; there is none"
        )
    return min(checked, key=lambda scheme: (scheme.sigma_m, scheme.n_slices, scheme.label))


def judge_slices(scheme: SchemeSigma, best: SchemeSigma, differs: bool | None) -> Judged:
    """Say whether the slices of a scheme are enough, and why.

    They are if its sigma, poses included, is at most 10 % above that of the best, if it does not differ significantly
    from it, and if it has a centre more than a line needs.

    Parameters
    ----------
    scheme, best : SchemeSigma
        Of one epoch.
    differs : bool or None
        Whether the scheme differs significantly from the best; None where that is not known.
    """
    excess = scheme.sigma_m / best.sigma_m - 1.0
    if scheme.label == best.label:
        return Judged(scheme.label, 0.0, True, "the smallest sigma of all")
    above = _above(excess, best.label)
    if not scheme.is_checked:
        return Judged(
            scheme.label,
            excess,
            False,
            f"{scheme.n_centres} centres: a bad slice would go unnoticed; {above}",
        )
    if differs:
        return Judged(scheme.label, excess, False, f"differs significantly from {best.label}; {above}")
    if excess > MOST_EXCESS:
        return Judged(scheme.label, excess, False, above)
    if differs is None:
        return Judged(scheme.label, excess, None, f"whether it differs from {best.label} is unknown; {above}")
    return Judged(scheme.label, excess, True, f"{above}, no significant difference")


def _above(excess: float, best: str) -> str:
    if excess >= 1.0:
        return f"sigma {1.0 + excess:.1f} times that of {best}"
    return f"sigma {100.0 * excess:.0f} % above that of {best}"


def recommended_of(sigmas: Sequence[SchemeSigma], judged: Sequence[Judged]) -> str | FitFailure:
    """Label of the sliced scheme that is enough with the fewest slices; of equals the one of the smallest sigma."""
    enough = {one.label for one in judged if one.is_enough}
    sliced = [scheme for scheme in sigmas if scheme.is_sliced and scheme.label in enough]
    if not sliced:
        return FitFailure("needs a sliced scheme whose slices are enough; there is none")
    return min(sliced, key=lambda scheme: (scheme.n_slices, scheme.sigma_m, scheme.label)).label
