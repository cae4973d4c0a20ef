"""What a survey will give: the covariance of the lean vector, part by part, and what follows from it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD, PARAMETERS_PER_STATION
from tasks.conventions import azimuth_deg as azimuth_deg_of
from tasks.design.normals import AXIS, LEAN_ROWS, Joined, StationNormals, half_length_m, join
from tasks.design.shaft import Cells
from tasks.design.sight import Errors
from tasks.geometry.failure import FitFailure
from tasks.geometry.plane_vectors import DETECTABLE_FACTOR

WEAKEST: Final = 1e-11
"""Least eigenvalue of the normal matrix with a unit diagonal: below it rounding decides."""

LEVEL, HEADING, HORIZONTAL, VERTICAL = (0, 1), (2,), (3, 4), (5,)
"""Places of the errors in the pose of a station."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """Covariances (2, 2) of the lean vector by cause; they add up to its covariance.

    ``pull`` (n,) is by how much the lean turns when the level of one station turns by a unit, in the direction in which
    it turns most; n equal stations evenly around have 1/n each.
    """

    noise: NDArray[np.float64]
    form: NDArray[np.float64]
    level: NDArray[np.float64]
    position: NDArray[np.float64]
    heading: NDArray[np.float64]
    pull: NDArray[np.float64]

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance (2, 2) of (lean_east, lean_north), dimensionless."""
        return np.asarray(self.noise + self.form + self.level + self.position + self.heading)

    @property
    def sigma_worst(self) -> float:
        """Standard deviation of the lean in its worst direction."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance)[1]))

    @property
    def sigma_best(self) -> float:
        """Standard deviation of the lean in its best direction."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance)[0]))

    @property
    def worst_azimuth_deg(self) -> float:
        """Azimuth of the worst direction, 0 to 180 degrees."""
        east, north = np.linalg.eigh(self.covariance)[1][:, 1]
        return azimuth_deg_of(float(east), float(north)) % 180.0

    @property
    def sigma_worst_arcsec(self) -> float:
        """The same as ``sigma_worst``, seconds of arc."""
        return self.sigma_worst / ARCSEC_RAD

    @property
    def shares(self) -> dict[str, float]:
        """Share of each cause in the sum of both variances; they add up to 1."""
        total = float(np.trace(self.covariance))
        parts = {
            "noise": self.noise,
            "form": self.form,
            "level": self.level,
            "position": self.position,
            "heading": self.heading,
        }
        return {name: float(np.trace(part)) / total for name, part in parts.items()}

    def smallest_detectable_m(self, height_m: float) -> float:
        """Change of the top between two such epochs that a 1 % test finds in 80 % of cases, metres.

        What both epochs share, the form of the shaft above all, is not taken out.
        """
        return DETECTABLE_FACTOR * float(np.sqrt(2.0)) * self.sigma_worst * height_m


def predict_lean(cells: Cells, parts: Sequence[StationNormals], errors: Errors) -> Prediction | FitFailure:
    """Predict the covariance of the lean vector from the parts of the stations.

    Position and heading of the stations are adjusted together with axis and radii, from their priors: the shaft ties
    the stations, and nothing else does. Levels are held with their prior as it is, or adjusted along like the others, as
    ``errors.levels`` says. Points weigh by their noise alone, as if the shaft were round.
    """
    if not parts or not any(part.radius.any() for part in parts):
        return FitFailure("needed a station that sees the shaft, none does")
    joined = join(parts, cells)
    prior = _prior_variance(errors, len(parts))
    kept = np.flatnonzero(prior > 0.0)
    normal = joined.matrix[np.ix_(kept, kept)] + np.diag(1.0 / prior[kept])
    inverse = _inverse(normal)
    if isinstance(inverse, FitFailure):
        return inverse
    rows = inverse[list(LEAN_ROWS)] / half_length_m(cells)
    by_prior = rows / prior[kept]
    to_lean = np.zeros((2, len(prior)))
    to_lean[:, kept] = rows
    return _by_cause(joined, to_lean, by_prior, _Known(errors, prior, kept, len(parts)))


@dataclass(frozen=True, slots=True)
class _Known:
    errors: Errors
    prior: NDArray[np.float64]
    kept: NDArray[np.intp]
    n: int

    def prior_part(self, by_prior: NDArray[np.float64], places: Sequence[int]) -> NDArray[np.float64]:
        """What the prior errors of some places of the poses do to the lean."""
        is_one = np.isin(self.kept, _columns(places, self.n))
        some = by_prior[:, is_one]
        return np.asarray(some * self.prior[self.kept][is_one] @ some.T)


def _by_cause(
    joined: Joined, to_lean: NDArray[np.float64], by_prior: NDArray[np.float64], known: _Known
) -> Prediction:
    turned = _turned(joined, to_lean, by_prior, known)
    shifted = to_lean @ joined.form.T
    if turned.shape[1] == 0:
        turned = np.zeros((2, known.n * len(LEVEL)))
    turned_by_station = turned.reshape(2, known.n, len(LEVEL)).transpose(1, 0, 2)
    return Prediction(
        noise=to_lean @ joined.matrix @ to_lean.T,
        form=known.errors.form_m**2 * (shifted @ shifted.T),
        level=known.errors.level_rad**2 * (turned @ turned.T),
        position=known.prior_part(by_prior, (*HORIZONTAL, *VERTICAL)),
        heading=known.prior_part(by_prior, HEADING),
        pull=np.linalg.norm(turned_by_station, ord=2, axis=(1, 2)),
    )


def _turned(
    joined: Joined, to_lean: NDArray[np.float64], by_prior: NDArray[np.float64], known: _Known
) -> NDArray[np.float64]:
    """Change (2, 2 n) of the lean with errors of the levels, station by station."""
    columns = _columns(LEVEL, known.n)
    if known.errors.levels == "held":
        return np.asarray((to_lean @ joined.matrix)[:, columns])
    return np.asarray(by_prior[:, np.isin(known.kept, columns)]).reshape(2, -1)


def _columns(places: Sequence[int], n: int) -> NDArray[np.intp]:
    """Places among the unknowns, station by station."""
    first = AXIS + PARAMETERS_PER_STATION * np.arange(n)
    return np.asarray((first[:, None] + np.asarray(places)).ravel())


def _prior_variance(errors: Errors, n: int) -> NDArray[np.float64]:
    """Variance (4 + 6 n,) of the unknowns beforehand: infinite for the axis, 0 for what is not adjusted."""
    horizontal_m, vertical_m = errors.position_m
    level_rad = errors.level_rad if errors.levels == "adjusted" else 0.0
    pose = [level_rad, level_rad, errors.heading_rad, horizontal_m, horizontal_m, vertical_m]
    return np.concatenate([np.full(AXIS, np.inf), np.tile(np.square(pose), n)])


def _inverse(normal: NDArray[np.float64]) -> NDArray[np.float64] | FitFailure:
    diagonal = np.diag(normal)
    if not (diagonal > 0.0).all():
        return FitFailure("needed an arc of the shaft at two heights, the stations see less")
    scale = 1.0 / np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    if values[0] < WEAKEST:
        return FitFailure(
            f"needed a lean that shows in all directions, one hardly does (least eigenvalue {values[0]:.1e})"
        )
    return np.asarray((vectors / values) @ vectors.T * np.outer(scale, scale))
