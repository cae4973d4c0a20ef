"""From functions of the height to the straight axis that follows from them, and what to mind about it."""

from typing import Final

import numpy as np

from tasks.axis.bending import bending_m
from tasks.axis.centres import Centres
from tasks.axis.forms import Form
from tasks.axis.height_fit import HeightFit, fit_least_squares
from tasks.axis.line import (
    Axis,
    AxisCurve,
    direction_of_lean,
    effective_number,
    line_distances,
    update_weight_ratio_pct,
)
from tasks.axis.observations import observe
from tasks.geometry.failure import FitFailure
from tasks.geometry.plane_vectors import small_sample_factor

RAD_TO_ARCSEC: Final = float(np.degrees(1.0) * 3600.0)

FAR_APART: Final = 3.0
"""Sigmas between the robust axis and weighted least squares from which somebody should look at the slices."""

SMALL_SHARE: Final = 1.0 / 3.0
"""Share of the centres below which so few carry the axis that somebody should know."""


def axis_of(
    centres: Centres, fit: HeightFit, curve: AxisCurve | None = None, warning: str | None = None
) -> Axis:
    """Take the line of a fit: its first two coefficients, all others being orthogonal to them."""
    half_span = centres.span_m / 2
    middle = centres.points_m[:, :2].mean(axis=0) + fit.coefficients_m[0]
    point = np.array([middle[0], middle[1], centres.lowest_m + half_span])
    direction = direction_of_lean(fit.coefficients_m[1] / half_span)
    residuals = line_distances(centres.points_m, point, direction)
    weights = fit.information_weights
    return Axis(
        point_m=point,
        direction=direction,
        lean_covariance=small_sample_factor(fit.freedom) * fit.covariance_m2[:, 1, :, 1] / half_span**2,
        weights=weights,
        residuals_m=residuals,
        iterations=fit.iterations,
        n_effective=effective_number(weights),
        mean_deviation_m=float(residuals.mean()),
        rmse_m=float(np.sqrt(np.mean(residuals**2))),
        bending_m=bending_m(centres, fit.robust_weights),
        update_weight_ratio_pct=update_weight_ratio_pct(weights),
        curve=curve,
        warning=warning,
    )


def warning_of(centres: Centres, form: Form, fit: HeightFit) -> str | None:
    """Say where weighted least squares of the same form leans otherwise, and where few centres carry the axis."""
    clauses = [_few_centres(fit), _least_squares_elsewhere(centres, form, fit)]
    return "; ".join(clause for clause in clauses if clause is not None) or None


def _few_centres(fit: HeightFit) -> str | None:
    m, effective = len(fit.information_weights), effective_number(fit.information_weights)
    if effective >= SMALL_SHARE * m:
        return None
    return f"the axis rests on the weight of {effective:.1f} of {m} centres"


def _least_squares_elsewhere(centres: Centres, form: Form, fit: HeightFit) -> str | None:
    if fit.robust_weights.min() == 1.0:
        return None
    plain = fit_least_squares(observe(centres, form))
    if isinstance(plain, FitFailure):
        return f"weighted least squares fails beside the robust axis: {plain.reason}"
    away = (plain.coefficients_m[1] - fit.coefficients_m[1]) / (centres.span_m / 2)
    covariance = small_sample_factor(fit.freedom) * fit.covariance_m2[:, 1, :, 1] / (centres.span_m / 2) ** 2
    sigmas = float(np.sqrt(away @ np.linalg.solve(covariance, away)))
    if sigmas <= FAR_APART:
        return None
    arcsec = RAD_TO_ARCSEC * float(np.hypot(*away))
    return f'weighted least squares leans {arcsec:.1f}" away from the robust axis, {sigmas:.1f} sigma'
