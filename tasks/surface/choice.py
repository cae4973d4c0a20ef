"""Which form the data ask for: bending and harmonics by their own test, all from one set of normal equations."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.surface.form import FIRST_HARMONIC, Form, kept_in
from tasks.surface.normal import Normal, mean_radius_m, prior_matrix

MOST_AXIS_ORDER: Final = 3
"""A cubic follows a cantilever within 0.5 % of its bending."""

MOST_HARMONICS: Final = 6
MOST_HARMONIC_ORDER: Final = 2

FULL_COVERAGE_DEG: Final = 300.0
"""From here on the harmonics of a section can be told from a shift of its centre."""

HALF_COVERAGE_DEG: Final = 270.0
"""Below this only an oval is tried: the third harmonic of an arc cannot be told from its centre."""

BENDING_LEVEL: Final = 0.01
"""Probability with which a straight axis is taken for a bent one."""

WAVY: Final = 6.0
"""Twice the logarithm of the Bayes factor from which a wall counts as wavy: 20 to 1."""

FREE_OF_CHARGE: Final = 1.01
"""Terms that raise the variance of the lean by less than this factor stay in, asked for or not."""


@dataclass(frozen=True, slots=True)
class Choice:
    """The form that the data ask for.

    Attributes
    ----------
    asked_for : Form
        The smallest form that the data do not contradict.
    kept : Form
        The form of the fit: ``asked_for``, or the fullest one where it costs the lean nothing.
    axis_model : str
        straight, parabola or cubic.
    axis_reason, section_reason : str
        The tests and their outcome, in words.
    """

    asked_for: Form
    kept: Form
    axis_model: str
    axis_reason: str
    section_reason: str


AXIS_MODELS: Final = {1: "straight", 2: "parabola", 3: "cubic"}


def fullest_form(form: Form, coverage_deg: float) -> Form:
    """The largest form that is tried at that coverage of the circumference; harmonics that cannot be told are held."""
    harmonics = 0
    if coverage_deg >= FULL_COVERAGE_DEG:
        harmonics = MOST_HARMONICS
    elif coverage_deg >= HALF_COVERAGE_DEG:
        harmonics = FIRST_HARMONIC + 1
    else:
        harmonics = FIRST_HARMONIC
    return replace(
        form,
        axis_order=MOST_AXIS_ORDER,
        harmonics=MOST_HARMONICS,
        harmonic_order=MOST_HARMONIC_ORDER,
        free=(harmonics, MOST_HARMONIC_ORDER),
    )


@dataclass(frozen=True, slots=True)
class Evidence:
    """What there is to go by.

    ``n_independent`` observations, and the power ``wall_m2`` of the wall's own waves: a coefficient of order j has
    (2 j + 1) times that, square metres.
    """

    n_independent: float
    wall_m2: float


def choose_form(full: Form, values_m: NDArray[np.float64], normal: Normal, evidence: Evidence) -> Choice:
    """Choose a form within the fullest one.

    Bending: the last order whose terms are significant (chi-square with 2 degrees of freedom for each order, 1 % for all
    orders together). Sections:
    the least Bayesian information criterion, with what dropped terms would add to chi-square taken from the normal
    equations (Wald), so that nothing is fitted again.

    Parameters
    ----------
    full : Form
        The fullest form.
    values_m : (p,) array
        Its coefficients at the minimum, metres.
    normal : Normal
        Its normal equations there.
    evidence : Evidence
        How much there is to go by.
    """
    covariance = normal.covariance()
    order, axis_reason = _axis_order(full, values_m, covariance, evidence.wall_m2)
    sections = _sections(full, values_m, covariance, np.log(max(evidence.n_independent, 2.0)))
    asked_for = replace(sections.form, axis_order=order, free=None)
    kept = _kept(full, values_m, normal, asked_for)
    return Choice(asked_for, kept, AXIS_MODELS[order], axis_reason, sections.reason)


def _kept(full: Form, values_m: NDArray[np.float64], normal: Normal, asked_for: Form) -> Form:
    """The fullest form where it costs the lean nothing; with held harmonics where the wall has them; else the smallest."""
    radius_m = mean_radius_m(full, values_m)
    held = replace(full, free=(asked_for.harmonics, asked_for.harmonic_order))
    tighter = prior_matrix(held, radius_m) - prior_matrix(full, radius_m)
    matrix = normal.matrix + tighter
    straight = replace(held, axis_order=asked_for.axis_order)
    if _costs(held, straight, matrix) <= FREE_OF_CHARGE and _costs(held, asked_for, matrix) <= FREE_OF_CHARGE:
        return held
    values = values_m - np.linalg.solve(matrix, tighter @ values_m)
    places = np.array(kept_in(straight, held))
    dropped = np.setdiff1d(np.arange(held.size), places)
    own = matrix[np.ix_(places, places)]
    # what the others become without the bending that nobody asked for
    left = values[places] + np.linalg.solve(own, matrix[np.ix_(places, dropped)] @ values[dropped])
    covariance = np.asarray(np.linalg.inv(own), dtype=np.float64)
    is_wavy = _evidence(straight, left, covariance, radius_m) > WAVY
    return straight if is_wavy else asked_for


def _evidence(
    form: Form, values_m: NDArray[np.float64], covariance: NDArray[np.float64], radius_m: float
) -> float:
    """Twice the logarithm of how much likelier the data are with the held harmonics than without them (Bayes factor)."""
    lobes = np.flatnonzero(form.held)
    information = np.linalg.inv(covariance[np.ix_(lobes, lobes)])
    prior_variance = 1.0 / np.diag(prior_matrix(form, radius_m))[lobes]
    growth = float(np.linalg.slogdet(information)[1]) + float(np.log(prior_variance).sum())
    return float(values_m[lobes] @ information @ values_m[lobes]) - growth


def _axis_order(
    full: Form, values_m: NDArray[np.float64], covariance: NDArray[np.float64], wall_m2: float
) -> tuple[int, str]:
    found, said = 1, []
    level = BENDING_LEVEL / max(full.axis_order - 1, 1)
    for order in range(2, full.axis_order + 1):
        places = [order, full.n_axis + order]
        own = covariance[np.ix_(places, places)] + (2 * order + 1) * wall_m2 * np.eye(2)
        chi2 = float(values_m[places] @ np.linalg.solve(own, values_m[places]))
        p_value = float(np.exp(-chi2 / 2.0))
        size_mm = 1e3 * float(np.hypot(*values_m[places]))
        said.append(f"order {order}: {size_mm:.2f} mm, p {p_value:.2g}")
        if p_value < level:
            found = order
    return found, "; ".join(said)


@dataclass(frozen=True, slots=True)
class _Sections:
    form: Form
    reason: str


def _sections(
    full: Form, values_m: NDArray[np.float64], covariance: NDArray[np.float64], price: float
) -> _Sections:
    best, least, round_one = full, np.inf, 0.0
    for form in _harmonic_forms(full):
        kept = kept_in(form, full)
        dropped = sorted(set(np.flatnonzero(~full.held).tolist()) - set(kept))
        criterion = _wald(values_m, covariance, dropped) - price * len(dropped)
        if form.harmonics == 0:
            round_one = criterion
        if criterion < least:
            best, least = form, criterion
    if best.harmonics == 0:
        return _Sections(best, "round: no harmonic lowers the BIC")
    gain = round_one - least
    return _Sections(
        best, f"harmonics to {best.harmonics}, order {best.harmonic_order} in height: BIC lower by {gain:.0f}"
    )


def _harmonic_forms(full: Form) -> Iterator[Form]:
    """Forms with fewer harmonics, and with ones that change less with height; the axis as it is."""
    yield replace(full, harmonics=0, harmonic_order=0)
    highest = full.harmonics if full.free is None else full.free[0]
    for harmonics in range(FIRST_HARMONIC, highest + 1):
        for order in range(full.harmonic_order + 1):
            yield replace(full, harmonics=harmonics, harmonic_order=order)


def _wald(values_m: NDArray[np.float64], covariance: NDArray[np.float64], places: list[int]) -> float:
    """What chi-square rises by if these coefficients are dropped and the others adjusted again."""
    if not places:
        return 0.0
    values = values_m[places]
    return float(values @ np.linalg.solve(covariance[np.ix_(places, places)], values))


def _costs(full: Form, small: Form, matrix: NDArray[np.float64]) -> float:
    """Variance of the lean with the fullest form over that with a smaller one."""
    places = kept_in(small, full)
    large = np.linalg.inv(matrix)[np.ix_(full.lean_rows, full.lean_rows)]
    less = np.linalg.inv(matrix[np.ix_(places, places)])[np.ix_(small.lean_rows, small.lean_rows)]
    return float(np.trace(large) / np.trace(less))
