"""The slicing workload of the schemes against each other, and the paper's advice on the interval."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from storage.records import TiltRow


@dataclass(frozen=True, slots=True)
class WorkloadFactor:
    """How many times the slices of ``than`` the scheme cuts."""

    scheme: str
    than: str
    factor: float


@dataclass(frozen=True, slots=True)
class Recommendation:
    """One case of section 5 of the paper; ``schemes`` are those of its schemes that the case means."""

    when: str
    advice: str
    reliability: str
    schemes: tuple[str, ...]


RECOMMENDATIONS: Final = (
    Recommendation(
        when="workload does not matter",
        advice="slice every 1 to 5 m",
        reliability="the highest: most redundant centres",
        schemes=("A", "B"),
    ),
    Recommendation(
        when="workload must be reduced somewhat",
        advice="slice at larger intervals",
        reliability="good, falling with the number of redundant centres",
        schemes=("C", "D"),
    ),
    Recommendation(
        when="a result is needed fast",
        advice="take one slice at the top and one at the bottom",
        reliability="poor: no redundant centre, a bad slice goes unnoticed",
        schemes=("E",),
    ),
)
"""Section 5 of the paper, its last three sentences; the reliability from the paragraph before them."""


def slice_counts(rows: Sequence[TiltRow]) -> dict[str, int]:
    """Slices of each scheme, failed ones too, in the order of the rows."""
    return {row.scheme: row.n_slices for row in rows}


def workload_factors(counts: Mapping[str, int]) -> list[WorkloadFactor]:
    """Ratio of the slice counts of every two schemes of which the first cuts more, in the given order.

    Parameters
    ----------
    counts : mapping of str to int
        Slices by scheme; schemes without slices (the whole surface) are left out.

    Returns
    -------
    list of WorkloadFactor
        All above 1.
    """
    sliced = [(scheme, n) for scheme, n in counts.items() if n > 0]
    return [WorkloadFactor(a, b, n_a / n_b) for a, n_a in sliced for b, n_b in sliced if n_a > n_b]


def savings(recommendation: Recommendation, counts: Mapping[str, int]) -> list[WorkloadFactor]:
    """By which factor the schemes of a case cut less than the scheme with the most slices."""
    factors = workload_factors(counts)
    if not factors:
        return []
    densest = max(counts, key=lambda scheme: counts[scheme])
    return [f for f in factors if f.scheme == densest and f.than in recommendation.schemes]
