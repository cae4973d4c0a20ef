"""Accuracy of the estimators at 102 m with and without bad centres, against the figures of the prototype study.

Centres scatter by 10.4 mm in each component; bad ones lie 0.05 to 0.3 m aside. Rms in mm of one component of the
deviation at 102 m; 100 shafts give it within 7 % (standard error 5 %, the table's own 4 %).
"""

import numpy as np
import pytest

from tasks.axis import Axis, fit_axis
from tasks.geometry.plane_vectors import CHI2_95
from tests.unit.axis.shafts import LEAN, Shaft, push, shaft

SIGMA_M = 0.0104
ROBUST = ["huber_line", "mm_line", "robust_line", "tukey_line"]
STATING = ["weighted_line", "huber_line", "robust_line", "tukey_line", "mm_line"]


def fits(name: str, m: int, bad: float, count: int, seed: int) -> list[Axis]:
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        data = shaft(rng, m, SIGMA_M, 0.002)
        fit = fit_axis(name, push(rng, data.centres_m, bad), data.covariances_m2)
        assert isinstance(fit, Axis)
        found.append(fit)
    return found


def rms_mm(name: str, m: int, bad: float) -> float:
    errors = [fit.lean - LEAN for fit in fits(name, m, bad, 100, m)]
    return float(102e3 * np.sqrt(np.mean(np.square(errors))))


@pytest.mark.parametrize(("m", "printed_mm"), [(101, 3.83), (21, 7.59), (11, 9.86), (6, 12.8)])
def test_weighted_line_scatters_as_printed(m: int, printed_mm: float) -> None:
    assert rms_mm("weighted_line", m, 0.0) == pytest.approx(printed_mm, rel=0.2)


@pytest.mark.parametrize(
    ("name", "m", "printed_mm"),
    [
        ("huber_line", 101, 3.94),
        ("huber_line", 21, 7.80),
        ("huber_line", 11, 10.1),
        ("huber_line", 6, 13.3),
        ("tukey_line", 101, 3.99),
        ("tukey_line", 21, 7.88),
        ("tukey_line", 11, 10.4),
        ("tukey_line", 6, 14.0),
        ("mm_line", 21, 7.88),
        ("robust_line", 21, 7.88),
    ],
)
def test_robust_lines_cost_little_without_outliers(name: str, m: int, printed_mm: float) -> None:
    assert rms_mm(name, m, 0.0) == pytest.approx(printed_mm, rel=0.2)


@pytest.mark.parametrize(
    ("name", "m", "bad", "printed_mm"),
    [
        ("huber_line", 101, 0.1, 3.83),
        ("tukey_line", 101, 0.1, 3.63),
        ("mm_line", 101, 0.1, 3.63),
        ("huber_line", 21, 0.1, 9.48),
        ("tukey_line", 21, 0.1, 8.40),
        ("mm_line", 21, 0.1, 8.40),
        ("huber_line", 101, 0.25, 6.13),
        ("tukey_line", 101, 0.25, 4.44),
        ("mm_line", 101, 0.25, 4.44),
    ],
)
def test_robust_lines_are_as_good_as_printed_with_bad_centres(
    name: str, m: int, bad: float, printed_mm: float
) -> None:
    # which centres are bad, and by how much, is not printed
    assert rms_mm(name, m, bad) < 1.25 * printed_mm


@pytest.mark.parametrize(("m", "bad", "least_mm"), [(101, 0.1, 10.0), (21, 0.1, 20.0), (101, 0.25, 15.0)])
def test_bad_centres_ruin_least_squares(m: int, bad: float, least_mm: float) -> None:
    assert rms_mm("weighted_line", m, bad) > least_mm


@pytest.mark.slow
@pytest.mark.parametrize("name", STATING)
@pytest.mark.parametrize("m", [21, 101])
def test_region_of_95_percent_holds_the_truth(name: str, m: int) -> None:
    inside = []
    for fit in fits(name, m, 0.0, 150, 10 * m):
        away = fit.lean - LEAN
        inside.append(float(away @ np.linalg.solve(fit.lean_covariance, away)) < CHI2_95)
    # standard error 0.018
    assert 0.90 <= np.mean(inside) <= 0.99


@pytest.mark.parametrize("name", ROBUST)
def test_region_holds_the_truth_with_a_tenth_of_bad_centres(name: str) -> None:
    inside = []
    for fit in fits(name, 21, 0.1, 120, 7):
        away = fit.lean - LEAN
        inside.append(float(away @ np.linalg.solve(fit.lean_covariance, away)) < CHI2_95)
    # standard error 0.02
    assert 0.89 <= np.mean(inside) <= 0.995


def top_aside(rng: np.random.Generator, m: int, bad: float) -> Shaft:
    """The top of the shaft, all 0.15 m to one side: bad centres that agree with each other."""
    data = shaft(rng, m, SIGMA_M, 0.002)
    data.centres_m[m - round(bad * m) :, 0] += 0.15
    return data


@pytest.mark.slow
@pytest.mark.parametrize(("m", "bad"), [(21, 0.3), (101, 0.3), (101, 0.4)])
def test_mm_line_holds_where_a_third_of_the_centres_agrees_on_something_else(m: int, bad: float) -> None:
    rng = np.random.default_rng(8)
    good = 0
    for _ in range(30):
        data = top_aside(rng, m, bad)
        fit = fit_axis("mm_line", data.centres_m, data.covariances_m2)
        assert isinstance(fit, Axis)
        good += np.abs(fit.lean - LEAN).max() < 5e-4
    assert good >= 28


def test_tukey_line_does_not_hold_there() -> None:
    data = top_aside(np.random.default_rng(8), 101, 0.4)
    fit = fit_axis("tukey_line", data.centres_m, data.covariances_m2)
    assert isinstance(fit, Axis)
    assert np.abs(fit.lean - LEAN).max() > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("bad", [0.3, 0.4])
def test_mm_line_holds_with_many_bad_centres_everywhere(bad: float) -> None:
    errors = [np.abs(fit.lean - LEAN).max() for fit in fits("mm_line", 101, bad, 40, 9)]
    # four sigma of a line through the 60 good ones
    assert max(errors) < 4 * SIGMA_M / np.sqrt(60 * 850.0)
