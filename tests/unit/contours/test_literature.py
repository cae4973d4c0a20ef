import json

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.contours.circle import Circle
from tasks.contours.circle_adjustment import Squares, adjust_circle
from tasks.contours.circle_start import taubin_circle
from tasks.contours.kasa import KasaFit, kasa_circle
from tasks.contours.straightening import straighten
from tests.shared import SHARED, needs_shared
from tests.unit.contours.rings import flat_section

pytestmark = needs_shared


def points_and_answer(case: str, group: str, method: str) -> tuple[NDArray[np.float64], list[float]]:
    entry = json.loads((SHARED / "reference" / "literature_fits.json").read_text(encoding="utf-8"))[case]
    answer = entry[group][method] if method else entry[group]
    return np.array(entry["points"], dtype=np.float64), [answer["cx"], answer["cy"], answer["r"]]


def numbers(circle: Circle) -> list[float]:
    return [circle.east_m, circle.north_m, circle.radius_m]


@pytest.mark.parametrize("case", ["gander1994_circle", "pratt1987_short_arc"])
def test_kasa_agrees_with_the_literature(case: str) -> None:
    points, expected = points_and_answer(case, "verified_here", "kasa")
    fit = kasa_circle(points)
    assert isinstance(fit, KasaFit)
    assert numbers(fit.circle) == pytest.approx(expected, rel=1e-12)  # same minimum, float64 rounding only


@pytest.mark.parametrize("case", ["gander1994_circle", "pratt1987_short_arc"])
def test_taubin_agrees_with_the_literature(case: str) -> None:
    points, expected = points_and_answer(case, "verified_here", "taubin")
    circle = taubin_circle(points)
    assert isinstance(circle, Circle)
    assert numbers(circle) == pytest.approx(expected, rel=1e-10)  # the short arc loses two digits


@pytest.mark.parametrize(
    ("case", "tolerance"),
    [
        ("gander1994_circle", 1e-6),
        ("spath_coope_circle", 2e-8),
    ],  # six printed digits; the stored solution's gradient
)
def test_geometric_circle_agrees_with_the_literature(case: str, tolerance: float) -> None:
    points, expected = points_and_answer(case, "geometric", "")
    start = taubin_circle(points)
    assert isinstance(start, Circle)
    section = straighten(flat_section(points))
    local = Circle(start.east_m - section.origin_m[0], start.north_m - section.origin_m[1], start.radius_m)
    circle = adjust_circle(section, local, Squares())
    assert isinstance(circle, Circle)
    found = [circle.east_m + section.origin_m[0], circle.north_m + section.origin_m[1], circle.radius_m]
    assert found == pytest.approx(expected, abs=tolerance)
