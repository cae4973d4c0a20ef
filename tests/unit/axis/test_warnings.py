"""What an axis says that one should mind before signing."""

import numpy as np
import pytest

from tasks.axis import Axis, fit_axis
from tests.unit.axis.shafts import Shaft, shaft

ROBUST = ["mm_line", "robust_line", "tukey_line"]


def warning(name: str, data: Shaft) -> str | None:
    fit = fit_axis(name, data.centres_m, data.covariances_m2)
    assert isinstance(fit, Axis)
    return fit.warning


@pytest.mark.parametrize("name", [*ROBUST, "huber_line", "weighted_line"])
@pytest.mark.parametrize("m", [3, 6, 21, 101])
def test_good_centres_give_no_warning(name: str, m: int) -> None:
    rng = np.random.default_rng(1)
    assert [warning(name, shaft(rng, m, 0.01, 0.003)) for _ in range(5)] == [None] * 5


@pytest.mark.parametrize("name", ROBUST)
def test_least_squares_elsewhere_is_said_with_its_figures(name: str) -> None:
    data = shaft(np.random.default_rng(2), 21, 0.002)
    data.centres_m[-1, 0] += 0.5
    found = warning(name, data)
    assert found is not None
    # the highest of 21 centres moves the slope of the line by 6 (m - 1) / (m (m + 1) L) of its own shift
    start, arcsec, rest = found.partition('" away from the robust axis')
    assert rest.endswith("sigma")
    assert arcsec
    expected = np.degrees(6.0 * 20.0 / (21.0 * 22.0) * 0.5 / 100.0) * 3600.0
    assert float(start.split()[-1]) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("name", [*ROBUST, "weighted_line"])
def test_few_centres_that_carry_all_are_said(name: str) -> None:
    data = shaft(np.random.default_rng(3), 21, 0.0001)
    data.covariances_m2[2:-2] *= 1e6
    found = warning(name, data)
    assert found is not None
    assert "of 21 centres" in found
