"""How far the form of the wall may bend the lean, judged by the waves of the wall beside it.

The lean is one wave of the wall: once around, linear in height. What the wall's own form adds to it cannot be seen; but a
wall whose form is as rough in all directions adds as much to the waves beside it, which no axis follows: once around with
four and more bends in height, twice and three times around with three and more. Their power beyond noise is that of the
lean. Slow waves are left out: they are bending and ovals, the shape of the structure, which the surface follows.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.surface.choice import MOST_AXIS_ORDER, MOST_HARMONIC_ORDER
from tasks.surface.form import Form, kept_in
from tasks.surface.normal import Weighed, normal_of

AXIS_ORDER: Final = 8
HARMONICS: Final = 3
HARMONIC_ORDER: Final = 6

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
    wide = few_waves_factor(len(_beside(_waves_of(form))[0]))
    return np.asarray(np.eye(2) * wide * 3.0 * wave_power(weighed, form, values_m) / form.half_m**2)


def wave_power(weighed: Weighed, form: Form, values_m: NDArray[np.float64]) -> float:
    """Power of the wall's waves beside the lean, beyond noise: the variance of a coefficient of order j over 2 j + 1."""
    waves, cells = _waves_of(form), weighed.cells
    places, orders = _beside(waves)
    start = np.zeros(waves.size)
    start[kept_in(replace(form, harmonics=0), waves)] = values_m[: 2 * form.n_axis + form.n_radius]
    pull = normal_of(weighed, waves, start).pull(np.eye(waves.size)[places])
    own = np.einsum("pc,c,pc->p", pull, cells.robust_price / cells.weight, pull)
    noise = own + np.sum((pull @ weighed.poses) ** 2, axis=1)
    # a Legendre polynomial of order j has a mean square of 1 / (2 j + 1)
    power = pull @ cells.residual_m
    scale = 2.0 * orders + 1.0
    found, expected = float(np.mean(power**2 / scale)), float(np.mean(noise / scale))
    excess = found - expected
    return excess if excess > SIGNIFICANT * expected * float(np.sqrt(2.0 / len(places))) else 0.0


def _waves_of(form: Form) -> Form:
    return Form(
        form.shaft_z_m,
        AXIS_ORDER,
        form.radius_intervals,
        form.radius_order,
        harmonics=HARMONICS,
        harmonic_order=HARMONIC_ORDER,
    )


def few_waves_factor(n: int) -> float:
    """Factor that makes the chi-square region of a variance from n squares hold in 95 of 100: F(2, n)."""
    return float(n * (0.05 ** (-2.0 / n) - 1.0) / -np.log(0.05) / 2.0)


def _beside(waves: Form) -> tuple[list[int], NDArray[np.float64]]:
    """Places of the waves beside the lean among the coefficients, and their orders in height."""
    places, orders = [], []
    for component in range(2):
        for order in range(MOST_AXIS_ORDER + 1, AXIS_ORDER + 1):
            places.append(component * waves.n_axis + order)
            orders.append(order)
    first = 2 * waves.n_axis + waves.n_radius
    for number in range(2 * len(waves.orders)):
        for order in range(MOST_HARMONIC_ORDER + 1, HARMONIC_ORDER + 1):
            places.append(first + number * (HARMONIC_ORDER + 1) + order)
            orders.append(order)
    return places, np.array(orders, dtype=np.float64)
