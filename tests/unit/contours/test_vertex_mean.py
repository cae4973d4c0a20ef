import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.contours import Contour, fit_contour
from tests.unit.contours.rings import flat_section


def even_ring(n: int, gap_deg: float = 0.0, kappa: float = 0.0) -> NDArray[np.float64]:
    """Noise-free places on a ring of 4 m whose density is 1 + kappa cos(theta), with a gap about -x."""
    half_gap = np.radians(gap_deg)
    share = (np.arange(n) + 0.5) / n
    grid = np.linspace(-np.pi + half_gap, np.pi - half_gap, 20_001)
    cumulated = grid + kappa * np.sin(grid)
    cumulated = (cumulated - cumulated[0]) / (cumulated[-1] - cumulated[0])
    angle = np.interp(share, cumulated, grid)
    return 4.0 * np.column_stack([np.cos(angle), np.sin(angle)])


def mean_of(xy: NDArray[np.float64]) -> Contour:
    fit = fit_contour("vertex_mean", flat_section(xy))
    assert isinstance(fit, Contour), fit
    return fit


def test_even_ring_has_its_centre_within_a_cell() -> None:
    fit = mean_of(even_ring(720))
    assert [fit.center_east_m, fit.center_north_m] == pytest.approx([0.0, 0.0], abs=0.035)  # a cell is 35 mm


@pytest.mark.parametrize("gap_deg", [10.0, 30.0])
def test_gap_shifts_the_centre_as_the_theory_says(gap_deg: float) -> None:
    fit = mean_of(even_ring(2000, gap_deg))
    half_gap = np.radians(gap_deg)
    theory = 4.0 * np.sin(half_gap) / (np.pi - half_gap)  # away from the gap at -x
    # marching squares sets more vertices on slopes than along the grid: up to a fifth off
    assert fit.center_east_m == pytest.approx(theory, rel=0.2)


@pytest.mark.parametrize("kappa", [0.1, 0.3])
def test_uneven_density_of_sparse_points_shifts_the_centre_by_half_kappa_radius(kappa: float) -> None:
    rng = np.random.default_rng(1)
    shifts = []
    for _ in range(60):
        angle = rng.uniform(-np.pi, np.pi, 1200)
        angle = angle[rng.random(1200) < (1 + kappa * np.cos(angle)) / (1 + kappa)][:500]
        shifts.append(mean_of(4.0 * np.column_stack([np.cos(angle), np.sin(angle)])).center_east_m)
    # neighbours that share a cell count less, which takes up to a third off; s.e. of the mean of 60 is 16 mm
    assert 0.6 * kappa * 2.0 - 0.05 <= np.mean(shifts) <= kappa * 2.0 + 0.05


def test_stated_sigma_is_that_of_a_mean_of_random_places() -> None:
    rng = np.random.default_rng(2)
    fits = []
    for _ in range(150):
        angle = rng.uniform(-np.pi, np.pi, 400)
        fits.append(mean_of(4.0 * np.column_stack([np.cos(angle), np.sin(angle)])))
    scatter = np.std([[fit.center_east_m, fit.center_north_m] for fit in fits])
    stated = np.sqrt(np.mean([fit.covariance_m2[0, 0] for fit in fits]))
    assert 1.0 <= stated / scatter <= 1.7  # on the safe side: an outline evens out what points heap up


def test_dense_ring_gives_one_outer_outline_and_no_hole() -> None:
    rng = np.random.default_rng(3)
    angle = rng.uniform(-np.pi, np.pi, 40_000)
    fit = mean_of(4.0 * np.column_stack([np.cos(angle), np.sin(angle)]))
    assert [fit.center_east_m, fit.center_north_m] == pytest.approx([0.0, 0.0], abs=0.01)
    assert fit.radius_m == pytest.approx(4.0, abs=0.01)  # half a cell of 8 mm outside
