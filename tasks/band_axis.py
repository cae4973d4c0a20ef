"""The axis of a whole surface as the tables tell it: a line that was fitted to all points, and the bands beside it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit
from tasks.axis import Axis
from tasks.axis.line import direction_of_lean, effective_number, line_distances
from tasks.sections import centres_of


@dataclass(frozen=True, slots=True, eq=False)
class FittedLine:
    """A line through ``point_m`` (3,) with a lean vector (2,), its covariance (2, 2) from the points, and its iterations."""

    point_m: NDArray[np.float64]
    lean: NDArray[np.float64]
    covariance: NDArray[np.float64]
    iterations: int


def axis_of_bands(line: FittedLine, bands: Sequence[SectionFit], bending_m: float | None) -> Axis:
    """Tell a line with the distances of the bands that have a centre; they have no part in it beyond their points."""
    centres_m, covariances_m2 = centres_of(bands)
    direction = direction_of_lean(line.lean)
    residuals = line_distances(centres_m, line.point_m, direction)
    weights = band_weights(covariances_m2)
    return Axis(
        point_m=line.point_m,
        direction=direction,
        lean_covariance=line.covariance,
        weights=weights,
        residuals_m=residuals,
        iterations=line.iterations,
        n_effective=effective_number(weights),
        mean_deviation_m=float(residuals.mean()),
        rmse_m=float(np.sqrt(np.mean(residuals**2))),
        bending_m=bending_m,
        update_weight_ratio_pct=None,
    )


def band_weights(covariances_m2: NDArray[np.float64]) -> NDArray[np.float64]:
    """Information (m,) of every band about its centre, the largest is 1, from covariances (m, 2, 2)."""
    information = 1.0 / np.trace(covariances_m2, axis1=1, axis2=2)
    return np.asarray(information / information.max())
