"""Whether the centres ask for more of a form than a simpler one has."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from tasks.axis.centres import Centres
from tasks.axis.forms import ClampedSpline, Form
from tasks.axis.height_fit import HeightFit

BENDING_LEVEL: Final = 0.01
"""Probability with which a straight axis is taken for a bent one."""

SPARE_HEIGHTS: Final = 3
"""Different heights beyond the number of functions that a bent form needs."""

LEAST_IN_SPAN: Final = 2
"""Different heights between two knots of a spline below which the span is only guessed."""


@dataclass(frozen=True, slots=True, eq=False)
class Chosen:
    """A form, its fit, and why it was chosen."""

    form: Form
    fit: HeightFit
    reason: str


@dataclass(frozen=True, slots=True)
class FormTest:
    """F test of the last coefficients of a fit.

    Attributes
    ----------
    statistic, bound : float
        F, and its quantile at ``1 - BENDING_LEVEL``.
    bic_change : float
        Bayesian information criterion with these coefficients minus that without.
    """

    statistic: float
    bound: float
    bic_change: float

    @property
    def significant(self) -> bool:
        """Whether the coefficients are more than chance."""
        return self.statistic > self.bound

    @property
    def text(self) -> str:
        """The test in a clause."""
        return f"F {self.statistic:.1f} {'>' if self.significant else '<='} {self.bound:.1f}"


def carries(centres: Centres, form: Form) -> bool:
    """Whether there are heights enough for a bent form, and in every span of a spline."""
    heights = np.unique(centres.points_m[:, 2])
    if len(heights) < form.count + SPARE_HEIGHTS:
        return False
    if not isinstance(form, ClampedSpline):
        return True
    in_span = np.histogram(centres.place(heights), bins=form.knots + 1, range=(-1.0, 1.0))[0]
    return int(in_span.min()) >= LEAST_IN_SPAN


def examine(fit: HeightFit, first: int) -> FormTest | None:
    """Test all coefficients of a fit from number ``first`` on by their covariance; None without redundancy.

    References
    ----------
    Koch 1999, Parameter Estimation and Hypothesis Testing in Linear Models, section 4.2; Schwarz 1978, Ann. Stat. 6.
    """
    freedom = fit.redundancy
    if freedom <= 0:
        return None
    from scipy.special import fdtri  # noqa: PLC0415 (slow to import, and every command reads settings)

    more = fit.coefficients_m[first:].T.ravel()
    covariance = fit.covariance_m2[:, first:, :, first:].reshape(len(more), len(more))
    statistic = float(more @ np.linalg.solve(covariance, more)) / len(more)
    observed = 2 * int(np.count_nonzero(fit.robust_weights))
    gain = observed * np.log1p(len(more) * statistic / freedom)
    return FormTest(
        statistic=statistic,
        bound=float(fdtri(len(more), freedom, 1.0 - BENDING_LEVEL)),
        bic_change=float(len(more) * np.log(observed) - gain),
    )
