"""The form of a fitted axis: base tangent, chord and points of the curve."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.centres import Centres
from tasks.axis.forms import Form
from tasks.axis.height_fit import HeightFit
from tasks.axis.line import AxisCurve
from tasks.geometry.plane_vectors import small_sample_factor

CURVE_HEIGHTS: Final = 41
"""Heights at which a curve is stated."""


def curve_of(centres: Centres, form: Form, fit: HeightFit, reason: str) -> AxisCurve:
    """State the form that was fitted: base tangent and its sigma, chord, and the curve over the height range."""
    x = np.linspace(-1.0, 1.0, CURVE_HEIGHTS)
    origin = centres.points_m[:, :2].mean(axis=0)
    east, north = (form.values(x) @ fit.coefficients_m + origin).T
    slope = form.slopes(x[:1])[0] / (centres.span_m / 2)
    return AxisCurve(
        model=form.model,
        reason=reason,
        z_m=curve_heights(centres),
        east_m=east,
        north_m=north,
        base_lean=slope @ fit.coefficients_m,
        chord_lean=np.array([east[-1] - east[0], north[-1] - north[0]]) / centres.span_m,
        base_lean_sigma=_sigma_of(slope, fit),
    )


def curve_heights(centres: Centres) -> NDArray[np.float64]:
    """Heights (41,) at which a curve is stated, from the lowest centre to the highest, metres."""
    return np.linspace(centres.lowest_m, centres.lowest_m + centres.span_m, CURVE_HEIGHTS)


def _sigma_of(functional: NDArray[np.float64], fit: HeightFit) -> float:
    """Standard deviation of a component, both directions taken together, of a sum (p,) of coefficients."""
    covariance = np.einsum("k,akbl,l->ab", functional, fit.covariance_m2, functional)
    return float(np.sqrt(small_sample_factor(fit.freedom) * np.trace(covariance) / 2.0))
