"""Name the ways in which a placed cloud can still move, and what holds each."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.registration.cloud_evidence import Knowledge

UNSEEN: Final = 0.003
"""A direction in which the normals of both clouds agree on less than this mean square of motion is unobservable. Set
between what was seen: 1e-5 for bare cylinders with noise, 0.013 for the weakest direction of a room of scan lines."""

PURE: Final = 0.1
"""Share of a motion below which its rotation or its shift is not worth a word."""


@dataclass(frozen=True, slots=True)
class Direction:
    """One way of moving, as the eigenvectors of the information have it.

    ``seen`` is the mean square of how far the matched surfaces move along their normals for a unit of it, 0 to about
    1; ``information`` its eigenvalue in 1 / unit^2, residuals taken as independent; ``sigma`` its standard deviation
    from the covariance, in the unit of the clouds. A rotation counts as what it moves at the lever.
    """

    name: str
    seen: float
    information: float
    sigma: float
    observable: bool


@dataclass(frozen=True, slots=True)
class Observability:
    """What the clouds see of their relative pose, the weakest direction first.

    ``lever`` turns rotations into lengths: the rms distance of the matched points from the moving cloud's centroid.
    """

    directions: tuple[Direction, ...]
    lever: float

    @property
    def eigenvalues(self) -> NDArray[np.float64]:
        """Information (6,) in 1 / unit^2, in the order of the directions."""
        return np.array([direction.information for direction in self.directions])

    @property
    def weakest_direction(self) -> str:
        """Name of the direction of which least is seen."""
        return self.directions[0].name

    @property
    def unobservable(self) -> tuple[str, ...]:
        """Names of the directions that the clouds do not see."""
        return tuple(direction.name for direction in self.directions if not direction.observable)


def untangled(known: Knowledge) -> Knowledge:
    """The same knowledge, with unseen directions told apart into rotations and shifts.

    A cylinder does not see the turn about its axis nor the shift along it; any mixture of both is an eigenvector, too.
    """
    unseen = known.seen < UNSEEN
    directions = known.directions.copy()
    if np.count_nonzero(unseen) > 1:
        turns = np.linalg.svd(directions[:3, unseen])[2].T
        directions[:, unseen] = directions[:, unseen] @ turns
    return Knowledge(known.covariance, known.seen, directions, known.lever)


def with_unseen_unknown(known: Knowledge, extent: float) -> NDArray[np.float64]:
    """Covariance (6, 6) in which a direction that is not seen is as uncertain as the cloud is large."""
    scale = np.r_[np.full(3, 1.0 / known.lever), np.ones(3)]
    blind = known.directions[:, known.seen < UNSEEN]
    kept = np.eye(6) - blind @ blind.T
    scaled = known.covariance / np.outer(scale, scale)
    scaled = kept @ scaled @ kept + extent**2 * (blind @ blind.T)
    return np.asarray(scaled * np.outer(scale, scale))


def observability(
    known: Knowledge, covariance: NDArray[np.float64], unit: float, weight: float
) -> Observability:
    """Describe all six directions.

    ``weight`` is the number of matches over their variance. It, the covariance and what is known are in extents, of
    which one is ``unit`` of the clouds.
    """
    scale = np.r_[np.full(3, known.lever), np.ones(3)]
    spread = covariance * np.outer(scale, scale)
    directions = []
    for seen, vector in zip(known.seen, known.directions.T, strict=True):
        sigma = unit * float(np.sqrt(max(vector @ spread @ vector, 0.0)))
        information = max(float(seen), 0.0) * weight / unit**2
        directions.append(Direction(_name(vector), float(seen), information, sigma, bool(seen >= UNSEEN)))
    return Observability(tuple(directions), unit * known.lever)


def _name(vector: NDArray[np.float64]) -> str:
    turn, shift = vector[:3], vector[3:]
    parts = []
    if turn @ turn > PURE:
        parts.append((float(turn @ turn), f"rotation about {_axis(turn)}"))
    if shift @ shift > PURE:
        parts.append((float(shift @ shift), f"shift along {_axis(shift)}"))
    return " with ".join(text for _, text in sorted(parts, reverse=True))


def _axis(vector: NDArray[np.float64]) -> str:
    unit = vector / np.linalg.norm(vector)
    largest = int(np.argmax(np.abs(unit)))
    unit = unit * np.sign(unit[largest])
    if unit[largest] > np.cos(np.radians(8.0)):
        return "xyz"[largest]
    # 0.0 is added so that no component is printed as -0.00
    x, y, z = np.round(unit, 2) + 0.0
    return f"({x:.2f}, {y:.2f}, {z:.2f})"
