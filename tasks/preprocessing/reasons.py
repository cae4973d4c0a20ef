"""Why points go, and how many."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

NOT_NEEDED: Final = "more than needed (an even sample stays)"

REASONS: Final = (
    "outside the height range",
    "far from the structure",
    "inside the shaft",
    "off the surface (ladder, platform, surroundings)",
    NOT_NEEDED,
    "isolated",
    "duplicate",
    "kept",
)
"""Why a point goes, in the order in which it is asked; the last one stays."""

KEPT: Final = len(REASONS) - 1


@dataclass(frozen=True, slots=True)
class Removal:
    """How many points went for one reason; the reason 'kept' counts those that stayed."""

    reason: str
    n_points: int


def count_reasons(reason: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Points (``len(REASONS)``,) of every reason (n,)."""
    return np.bincount(reason, minlength=len(REASONS))


def removals(counts: NDArray[np.int64]) -> tuple[Removal, ...]:
    """The counts (``len(REASONS)``,) by name."""
    return tuple(Removal(name, int(n)) for name, n in zip(REASONS, counts, strict=True))
