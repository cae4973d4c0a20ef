import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.axis import Axis, fit_axis
from tests.unit.axis.shafts import LEAN, Shaft, push, shaft


def line(data: Shaft) -> Axis:
    fit = fit_axis("robust_line", data.centres_m, data.covariances_m2)
    assert isinstance(fit, Axis), fit
    return fit


def bound(m: int, sigma_m: float) -> float:
    """Variance of one component of the lean of an unweighted line (docs/estimators.md)."""
    return sigma_m**2 / float(np.sum((np.linspace(0.0, 100.0, m) - 50.0) ** 2))


def errors(fits: list[Axis]) -> NDArray[np.float64]:
    return np.array([fit.lean - LEAN for fit in fits])


def test_unit_of_length_changes_nothing() -> None:
    data = shaft(np.random.default_rng(1), 21, 0.01, 0.004)
    big = Shaft(1000.0 * data.centres_m, 1e6 * data.covariances_m2)
    assert line(big).lean == pytest.approx(line(data).lean, abs=1e-11)
    np.testing.assert_allclose(line(big).lean_covariance, line(data).lean_covariance, rtol=1e-6)


def test_with_true_covariances_it_is_the_weighted_line() -> None:
    rng = np.random.default_rng(2)
    z, sigma = np.linspace(0.0, 100.0, 9), np.linspace(0.002, 0.02, 9)
    centres = np.column_stack([z[:, None] * LEAN + 0.1 * sigma[:, None] * rng.standard_normal((9, 2)), z])
    covariances = np.eye(2) * (sigma**2)[:, None, None]
    fit = line(Shaft(centres, covariances))
    expected = np.polyfit(z, centres[:, 0], 1, w=1 / sigma)[0]
    assert fit.lean[0] == pytest.approx(expected, abs=2e-7)  # Tukey at a tenth of a sigma is nearly 1


@pytest.mark.parametrize(("m", "stated_m"), [(101, 0.01), (101, 0.001), (21, 0.01), (21, 0.001)])
def test_stated_sigma_matches_scatter_over_repeats(m: int, stated_m: float) -> None:
    rng = np.random.default_rng(3)
    fits = [line(shaft(rng, m, 0.01, stated_m)) for _ in range(300)]
    stated = np.sqrt(np.mean([fit.lean_covariance[0, 0] for fit in fits]))
    # model error is never negative: up to 5 % large at 21 centres; 600 values have s.e. 0.03
    assert stated / np.std(errors(fits)) == pytest.approx(1.0, abs=0.1)


def test_stated_sigma_never_falls_below_that_of_the_points() -> None:
    data = shaft(np.random.default_rng(4), 21, sigma_m=0.0001, stated_m=0.01)
    assert line(data).lean_covariance[0, 0] >= bound(21, 0.01)


@pytest.mark.parametrize(("m", "least"), [(101, 0.85), (21, 0.80)])
def test_tenth_of_bad_centres_costs_little(m: int, least: float) -> None:
    rng = np.random.default_rng(5)
    fits = []
    for _ in range(300):
        data = shaft(rng, m, 0.01, 0.002)
        fits.append(line(Shaft(push(rng, data.centres_m, 0.1), data.covariances_m2)))
    efficiency = bound(m, 0.01) / np.mean(errors(fits) ** 2)
    assert efficiency >= least - 0.15  # a tenth of the centres is lost; s.e. 0.06


def test_quarter_of_bad_centres_does_not_break_it() -> None:
    rng = np.random.default_rng(6)
    data = shaft(rng, 101, 0.01, 0.002)
    fit = line(Shaft(push(rng, data.centres_m, 0.25), data.covariances_m2))
    assert np.abs(fit.lean - LEAN).max() < 4 * np.sqrt(bound(101, 0.01))
    assert np.count_nonzero(fit.weights < 0.5) >= 20


def test_bad_centre_with_a_tiny_stated_covariance_is_left_out() -> None:
    data = shaft(np.random.default_rng(7), 21, 0.01, 0.005)
    clean = line(data).lean
    data.centres_m[-1, 0] += 0.5
    data.covariances_m2[-1] *= 1e-6
    fit = line(data)
    assert fit.weights[-1] == 0.0
    assert fit.lean == pytest.approx(clean, abs=4 * np.sqrt(bound(21, 0.01)))


def test_centres_of_a_narrow_arc_count_in_their_good_direction() -> None:
    rng = np.random.default_rng(8)
    z, m = np.linspace(0.0, 100.0, 11), 11
    wild = np.array([1.0, 1e-3])
    leans = []
    for _ in range(200):
        noise = rng.standard_normal((m, 2)) * wild
        covariances = np.tile(np.diag(wild**2), (m, 1, 1))
        leans.append(line(Shaft(np.column_stack([z[:, None] * LEAN + noise, z]), covariances)).lean)
    scatter = np.std(leans, axis=0)
    assert scatter[1] < 3e-3 * scatter[0]


def test_line_of_a_bent_axis_is_uniform_over_the_height_whatever_the_weights() -> None:
    z = np.linspace(0.0, 100.0, 41)
    x = z / 50.0 - 1.0
    centres = np.column_stack([z[:, None] * LEAN, z])
    centres[:, 0] += 0.05 * (3 * x**2 - 1) / 2
    sigma = np.where(z > 50.0, 0.0005, 0.003)  # the upper half is known much better
    centres[:, :2] += sigma[:, None] * np.random.default_rng(9).standard_normal((41, 2))
    fit = line(Shaft(centres, np.eye(2) * (sigma**2)[:, None, None]))
    assert fit.lean == pytest.approx(LEAN, abs=4 * np.sqrt(fit.lean_covariance[0, 0]))
    assert (
        np.sqrt(fit.lean_covariance[0, 0]) < 2.5e-5
    )  # not blown up by the bending: 50 mm would make it 6e-5
    assert fit.bending_m == pytest.approx(0.05, abs=0.003)


def test_noise_passes_for_bending_as_rarely_as_stated() -> None:
    # the line of a straight axis and that of the parabola are the same for equal weights, so look at unequal ones
    rng = np.random.default_rng(10)
    sigma = np.geomspace(0.002, 0.02, 31)
    z = np.linspace(0.0, 100.0, 31)
    fits = []
    for _ in range(300):
        centres = np.column_stack([z[:, None] * LEAN + sigma[:, None] * rng.standard_normal((31, 2)), z])
        fits.append(line(Shaft(centres, np.eye(2) * (sigma**2)[:, None, None])))
    w = sigma**-2
    best = 1.0 / float(np.sum(w * (z - np.average(z, weights=w)) ** 2))
    assert best / np.mean(errors(fits) ** 2) >= 0.8  # 0.95 of Tukey, 0.9 of the test, s.e. 0.06


@pytest.mark.parametrize("m", [3, 4])
def test_few_centres_get_no_tukey_weights(m: int) -> None:
    fit = line(shaft(np.random.default_rng(11), m))
    assert fit.weights == pytest.approx(np.ones(m))


def test_exact_centres_with_zero_covariances_give_their_line() -> None:
    data = shaft(np.random.default_rng(12), 21, 0.0, 0.0)
    fit = line(data)
    assert fit.lean == pytest.approx(LEAN, abs=1e-12)
    assert np.linalg.eigvalsh(fit.lean_covariance).min() > 0.0
