"""Axis and radius of a surface as a few numbers with a joint covariance, for comparing epochs."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.axis_parameters import AXIS_NAMES, RADIUS_TERMS, radius_names
from tasks.surface.form import Form
from tasks.surface.profile import Profile

HEIGHTS: Final = 201


def names_of(form: Form) -> tuple[str, ...]:
    """Names of the parameters of a form whose axis bends."""
    return AXIS_NAMES + radius_names(min(RADIUS_TERMS, form.n_radius))


def rows_of(form: Form) -> NDArray[np.float64]:
    """Matrix (p, size) that takes the parameters out of the coefficients; the base counts from the origin of the profile."""
    lean = np.zeros((2, form.size))
    lean[[0, 1], form.lean_rows] = 1.0 / form.half_m
    base = -form.middle_m * lean
    base[[0, 1], [0, form.n_axis]] = 1.0
    bend, s_bend = np.zeros((2, 2, form.size))
    bend[[0, 1], [2, form.n_axis + 2]] = 1.0
    s_bend[[0, 1], [3, form.n_axis + 3]] = 1.0
    return np.concatenate([base, lean, bend, s_bend, _radius_rows(form)])


def values_of(profile: Profile) -> NDArray[np.float64]:
    """Values (p,) of the parameters, site frame."""
    values = rows_of(profile.form) @ profile.values_m
    values[:2] += profile.origin_m
    return np.asarray(values)


def scale_of(form: Form) -> NDArray[np.float64]:
    """Metres (p,) that a unit of each parameter moves the end of the shaft: half its height for the lean."""
    names = names_of(form)
    return np.array([form.half_m if name.startswith("lean") else 1.0 for name in names])


def _radius_rows(form: Form) -> NDArray[np.float64]:
    share = np.linspace(-1.0, 1.0, HEIGHTS)
    terms = form.radius_terms(form.middle_m + share * form.half_m)
    legendre = np.polynomial.legendre.legvander(share, min(RADIUS_TERMS, form.n_radius) - 1)
    rows = np.zeros((legendre.shape[1], form.size))
    first = 2 * form.n_axis
    rows[:, first : first + form.n_radius] = np.linalg.pinv(legendre) @ terms
    return rows
