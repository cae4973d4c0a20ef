"""Where an axis is, how it bends and how wide the shaft is, as numbers with a joint covariance."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

AXIS_NAMES: Final = (
    "base_east",
    "base_north",
    "lean_east",
    "lean_north",
    "bend_east",
    "bend_north",
    "s_bend_east",
    "s_bend_north",
)
"""Straight axis at z = 0 in metres, lean, and the coefficients of the second and third Legendre polynomial in metres."""

LEAN: Final = ("lean_east", "lean_north")

RADIUS_TERMS: Final = 5
"""Legendre polynomials of the radius: constant, taper and three of its curvature."""


def radius_names(count: int) -> tuple[str, ...]:
    """Names of the first coefficients of the radius."""
    return tuple(f"radius_{number}" for number in range(count))


@dataclass(frozen=True, slots=True, eq=False)
class AxisParameters:
    """Parameters of the axis and the radius of one epoch.

    Attributes
    ----------
    names : tuple of str
        Of ``AXIS_NAMES`` and ``radius_names``.
    values : (p,) array
        Metres; of the lean metres a metre.
    covariance : (p, p) array
        All of it.
    form_covariance : (p, p) array
        The part that the form of the wall causes, which is the same in every epoch that sees the same of it.
    frame_covariance : (p, p) array
        The part that the frame of the reference epoch brings along, which is the same in all epochs that are tied to it by
        stable surroundings; zero where nothing ties them.
    """

    names: tuple[str, ...]
    values: NDArray[np.float64]
    covariance: NDArray[np.float64]
    form_covariance: NDArray[np.float64]
    frame_covariance: NDArray[np.float64]

    def scaled(self, names: tuple[str, ...], factor: float) -> "AxisParameters":
        """The same with some parameters multiplied by a factor."""
        scale = np.array([factor if name in names else 1.0 for name in self.names])
        both = np.outer(scale, scale)
        return AxisParameters(
            self.names,
            self.values * scale,
            self.covariance * both,
            self.form_covariance * both,
            self.frame_covariance * both,
        )

    def places(self, names: tuple[str, ...]) -> list[int]:
        """Places of parameters by their names."""
        return [self.names.index(name) for name in names]


@dataclass(frozen=True, slots=True, eq=False)
class JointParts:
    """The parts (p, p) of a joint covariance as they were propagated.

    ``own`` is of points and poses together, ``form`` of the form of the wall, ``frame`` what of ``own`` comes from the frame
    of the reference epoch.
    """

    own: NDArray[np.float64]
    form: NDArray[np.float64]
    frame: NDArray[np.float64]


def as_stated(
    names: tuple[str, ...],
    values: NDArray[np.float64],
    parts: JointParts,
    lean_covariance: NDArray[np.float64],
    lean_form: NDArray[np.float64],
) -> AxisParameters:
    """Join parameters and covariances so that the lean has the covariance that is stated for it.

    What is stated of a lean (2, 2) may be more than what was propagated, where stations contradict each other: then nothing
    else that they measured is as certain as propagated either. Correlations stay as they are.
    """
    places = [names.index(name) for name in LEAN]
    propagated = parts.own[np.ix_(places, places)]
    own_of_lean = _positive(lean_covariance - lean_form, propagated)
    more = max(1.0, float(np.trace(own_of_lean) / np.trace(propagated)))
    own = _with_block(more * parts.own, places, own_of_lean)
    form = _with_block(parts.form, places, lean_form)
    return AxisParameters(names, values, own + form, form, parts.frame)


def root(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Symmetric root of a covariance; what rounding made negative counts as zero."""
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2.0)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T)


def _positive(wanted: NDArray[np.float64], least: NDArray[np.float64]) -> NDArray[np.float64]:
    """The part of a (2, 2) matrix that is a covariance; ``least`` along directions in which it is none."""
    values, vectors = np.linalg.eigh((wanted + wanted.T) / 2.0)
    floor = np.einsum("ij,ik,kj->j", vectors, least, vectors)
    return np.asarray(vectors * np.where(values > 0.0, values, floor) @ vectors.T)


def _with_block(
    covariance: NDArray[np.float64], places: list[int], block: NDArray[np.float64]
) -> NDArray[np.float64]:
    """A covariance with another block on its diagonal, its correlations kept."""
    now = covariance[np.ix_(places, places)]
    if np.linalg.matrix_rank(now) < len(places):
        # nothing is correlated with what does not vary
        made = covariance.copy()
        made[np.ix_(places, places)] = block
        return made
    turn = np.eye(len(covariance))
    turn[np.ix_(places, places)] = root(block) @ np.linalg.inv(root(now))
    made = turn @ covariance @ turn.T
    return np.asarray((made + made.T) / 2.0)
