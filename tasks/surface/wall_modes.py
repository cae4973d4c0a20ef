"""How far the form of the wall may bend the lean, judged by the waves of the wall beside it.

The lean is one wave of the wall: once around, linear in height. What the wall's own form adds to it cannot be seen; but
a wall whose form is as rough at all heights adds as much to the waves beside it, which no axis follows: once around with
four to nine bends in height. Their power beyond noise is that of the lean. Slower ones are left out: they are bending,
which the surface follows.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.plane_vectors import small_sample_factor
from tasks.surface.choice import MOST_AXIS_ORDER
from tasks.surface.form import Form
from tasks.surface.normal import Weighed, normal_of

MOST_ORDER: Final = 9

SIGNIFICANT: Final = 2.0
"""Form counts from this many standard deviations of the noise's own power on."""


def wall_modes(weighed: Weighed, form: Form, values_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (2, 2) of the lean vector by the form of the wall; needs points all around.

    Parameters
    ----------
    weighed : Weighed
        Residuals of a surface at its minimum, which follows at most a cubic axis and quadratic harmonics.
    form : Form
        Form of that surface.
    values_m : (p,) array
        Its coefficients, metres.
    """
    return np.asarray(np.eye(2) * 3.0 * wall_variance(weighed, form, values_m) / form.half_m**2)


def wall_variance(weighed: Weighed, form: Form, values_m: NDArray[np.float64]) -> float:
    """Variance that the wall's waves give a coefficient of order j of the axis, over 2 j + 1, square metres.

    Widened for the few waves behind it, so that chi-square of 2 degrees of freedom holds.
    """
    waves = replace(form, axis_order=MOST_ORDER, harmonics=0, harmonic_order=0, free=None)
    cells = weighed.cells
    orders = np.arange(MOST_AXIS_ORDER + 1, MOST_ORDER + 1)
    places = np.concatenate([orders, waves.n_axis + orders])
    start = np.zeros(waves.size)
    start[2 * waves.n_axis :] = values_m[2 * form.n_axis : 2 * form.n_axis + form.n_radius]
    pull = normal_of(weighed, waves, start).pull(np.eye(waves.size)[places])
    own = np.einsum("pc,c,pc->p", pull, cells.robust_price / cells.weight, pull)
    noise = own + np.sum((pull @ weighed.poses) ** 2, axis=1)
    # a Legendre polynomial of order j has a mean square of 1 / (2 j + 1)
    scale = np.tile(2.0 * orders + 1.0, 2)
    found = float(np.mean((pull @ cells.residual_m) ** 2 / scale))
    expected = float(np.mean(noise / scale))
    excess = found - expected
    if excess <= SIGNIFICANT * expected * float(np.sqrt(2.0 / len(places))):
        return 0.0
    return small_sample_factor(len(places)) * excess
