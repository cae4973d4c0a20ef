"""Axis estimator ``joined_centres``: the bending line through all centres, and the line that fits it best."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.bending import bending_m
from tasks.axis.centres import Centres
from tasks.axis.curve import curve_heights
from tasks.axis.line import (
    Axis,
    AxisCurve,
    direction_of_lean,
    effective_number,
    line_distances,
    update_weight_ratio_pct,
)
from tasks.axis.model import AxisEstimator
from tasks.axis.two_points import fit_two_points
from tasks.geometry.failure import FitFailure
from tasks.geometry.plane_vectors import small_sample_factor

EFFECTIVE_SHARE: Final = 0.5
"""Degrees of freedom of a variance from second differences, as a part of their number: neighbours share centres."""


@dataclass(frozen=True, slots=True, eq=False)
class _Polyline:
    """Joined centres: heights (k,) ascending, east and north (k, 2), covariances (k, 2, 2), and k of each centre (m,)."""

    z_m: NDArray[np.float64]
    horizontal_m: NDArray[np.float64]
    covariances_m2: NDArray[np.float64]
    place: NDArray[np.intp]


def fit_joined_centres(centres: Centres) -> Axis | FitFailure:
    """Join the centres from the lowest to the highest and take the line that fits the polyline best over the height.

    Nothing is smoothed and every centre is believed: a bad one stays in the axis. Centres at one height are averaged.
    The weight of a centre is the height that it stands for. The covariance is that of the centres and of a model error,
    which shows in how far each centre is off the straight join of its neighbours; so bending that is sharper than the
    distance of the slices counts as error.

    References
    ----------
    Schneider 2006, terrestrial laser scanning for area based deformation analysis of towers and water dams (ref. 39 of
    Zhou et al. 2025); Gasser, Sroka & Jennen-Steinmetz 1986, Biometrika 73 (variance from differences).
    """
    if centres.count == 2:
        return fit_two_points(centres)
    joined = _join(centres)
    shares = _mean_shares(joined.z_m)
    middle_m = float(joined.z_m[0] + joined.z_m[-1]) / 2
    slopes = _slope_shares(joined.z_m)
    covariances = joined.covariances_m2
    freedom = 0
    if len(joined.z_m) > 2:
        variance = _model_variance(joined)
        covariances = covariances + variance * np.eye(2)
        freedom = max(round(2 * EFFECTIVE_SHARE * (len(joined.z_m) - 2)), 1) if variance > 0.0 else 0
    wide = small_sample_factor(freedom)
    direction = direction_of_lean(slopes @ joined.horizontal_m)
    point = np.array([*(shares @ joined.horizontal_m), middle_m])
    residuals = line_distances(centres.points_m, point, direction)
    weights = (shares / np.bincount(joined.place))[joined.place]
    return Axis(
        point_m=point,
        direction=direction,
        lean_covariance=wide * np.einsum("k,kab->ab", slopes**2, covariances),
        weights=weights / weights.max(),
        residuals_m=residuals,
        iterations=None,
        n_effective=effective_number(weights),
        mean_deviation_m=float(residuals.mean()),
        rmse_m=float(np.sqrt(np.mean(residuals**2))),
        bending_m=bending_m(centres, np.ones(centres.count)),
        update_weight_ratio_pct=update_weight_ratio_pct(weights),
        curve=_curve(centres, joined, wide * covariances),
    )


def _join(centres: Centres) -> _Polyline:
    """Sort the centres by height, those at one height averaged."""
    z, place = np.unique(centres.points_m[:, 2], return_inverse=True)
    count = np.bincount(place).astype(np.float64)
    horizontal = np.zeros((len(z), 2))
    covariances = np.zeros((len(z), 2, 2))
    np.add.at(horizontal, place, centres.points_m[:, :2])
    np.add.at(covariances, place, centres.covariances_m2)
    return _Polyline(
        z,
        horizontal / count[:, None],
        covariances / count[:, None, None] ** 2,
        np.asarray(place, dtype=np.intp),
    )


def _mean_shares(z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share (k,) of each corner in the mean of the polyline over the height."""
    steps = np.diff(z_m)
    halves = np.concatenate([[0.0], steps]) + np.concatenate([steps, [0.0]])
    return np.asarray(halves / 2 / (z_m[-1] - z_m[0]))


def _slope_shares(z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Factor (k,) of each corner in the slope of the line that fits the polyline best over the height."""
    middle = (z_m[0] + z_m[-1]) / 2
    low, high, steps = z_m[:-1] - middle, z_m[1:] - middle, np.diff(z_m)
    at_low, at_high = steps * (2 * low + high) / 6, steps * (low + 2 * high) / 6
    moments = np.concatenate([at_low, [0.0]]) + np.concatenate([[0.0], at_high])
    return np.asarray(12.0 * moments / (z_m[-1] - z_m[0]) ** 3)


def _model_variance(joined: _Polyline) -> float:
    """Variance of one component that the corners have beyond their covariances, by their neighbours, or 0."""
    z, c = joined.z_m, joined.covariances_m2.trace(axis1=1, axis2=2) / 2
    upper = (z[1:-1] - z[:-2]) / (z[2:] - z[:-2])
    factors = np.column_stack([upper - 1.0, np.ones(len(upper)), -upper])
    corners = np.arange(len(z) - 2)[:, None] + np.arange(3)
    off = np.einsum("kc,kca->ka", factors, joined.horizontal_m[corners])
    spread = (factors**2).sum(axis=1)
    stated = (factors**2 * c[corners]).sum(axis=1)
    return max(float(np.mean(((off**2).sum(axis=1) / 2 - stated) / spread)), 0.0)


def _curve(centres: Centres, joined: _Polyline, covariances_m2: NDArray[np.float64]) -> AxisCurve:
    z, horizontal = joined.z_m, joined.horizontal_m
    heights = curve_heights(centres)
    first = z[1] - z[0]
    return AxisCurve(
        model="polyline",
        reason="every centre is joined to the next",
        z_m=heights,
        east_m=np.interp(heights, z, horizontal[:, 0]),
        north_m=np.interp(heights, z, horizontal[:, 1]),
        base_lean=(horizontal[1] - horizontal[0]) / first,
        chord_lean=(horizontal[-1] - horizontal[0]) / centres.span_m,
        base_lean_sigma=float(np.sqrt(np.trace(covariances_m2[:2].sum(axis=0)) / 2.0) / first),
    )


AXIS: Final = AxisEstimator(
    "joined_centres", "centres joined to a bending line, and the line that fits it best", fit_joined_centres
)
