"""The form of the wall in the covariance of the lean: rough walls state it, smooth ones have none."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from tasks.geometry.plane_vectors import small_sample_factor
from tasks.surface.cells import SECTORS
from tasks.surface.form import Form
from tasks.surface.normal import Normal, Weighed, normal_of
from tasks.surface.wall_form import wall_form
from tasks.surface.wall_modes import wall_modes
from tests.unit.surface.cells_by_hand import N_HEIGHTS, SHAFT_Z_M, cells_with, patches, white

FORM = Form(SHAFT_Z_M, axis_order=3, radius_intervals=27)
SIGMA_M = 0.006
"""Of the points of a cell, and of the wall's own pieces."""


def solved(residual_m: NDArray[np.float64]) -> tuple[Weighed, Normal, NDArray[np.float64]]:
    """Fit ``FORM`` to the residuals of all cells: cells at the minimum, equations, coefficients."""
    values = np.zeros(FORM.size)
    values[2 * FORM.n_axis :] = 3.6
    cells = cells_with(residual_m, SIGMA_M)
    share, poses = np.ones(len(cells.z_m)), np.zeros((len(cells.z_m), 0))
    normal = normal_of(Weighed(cells, share, poses), FORM, values)
    step = normal.step()
    return Weighed(cells.moved(normal.design @ step), share, poses), normal, values + step


def lean_pull(normal: Normal) -> NDArray[np.float64]:
    return normal.pull(np.eye(FORM.size)[FORM.lean_rows] / FORM.half_m)


def by_pieces(residual_m: NDArray[np.float64]) -> NDArray[np.float64]:
    weighed, normal, _ = solved(residual_m)
    return wall_form(weighed.cells, normal, lean_pull(normal))


def by_waves(residual_m: NDArray[np.float64]) -> NDArray[np.float64]:
    weighed, _, values = solved(residual_m)
    return wall_modes(weighed, FORM, values)


def scatter_of_pieces(heights: int, sectors: int) -> float:
    """Variance of one component of the lean by pieces of that size, from how the lean follows each of them."""
    _, normal, _ = solved(np.zeros((N_HEIGHTS, SECTORS)))
    of_cell = lean_pull(normal)[0].reshape(N_HEIGHTS, SECTORS)
    pieces = np.add.reduceat(
        np.add.reduceat(of_cell, range(0, N_HEIGHTS, heights), 0), range(0, SECTORS, sectors), 1
    )
    return float(SIGMA_M**2 * np.sum(pieces**2))


def mean_of(
    state: Callable[[NDArray[np.float64]], NDArray[np.float64]], heights: int, sectors: int
) -> NDArray[np.float64]:
    rng = np.random.default_rng(1)
    walls = (patches(rng, SIGMA_M, heights, sectors) + white(rng, SIGMA_M) for _ in range(8))
    return np.asarray(np.mean([state(wall) for wall in walls], axis=0))


@pytest.mark.parametrize("size", [(3, 3), (6, 6), (12, 9)])
def test_pieces_of_a_rough_wall_state_the_scatter_that_they_cause(size: tuple[int, int]) -> None:
    form = mean_of(by_pieces, *size)
    # the largest of three estimates is a little too large; of the largest pieces a draw has 60 beyond the unknowns
    assert np.trace(form) / 2.0 / scatter_of_pieces(*size) == pytest.approx(1.2, abs=0.4)
    assert abs(form[0, 1]) < 0.1 * np.trace(form)


@pytest.mark.parametrize("size", [(3, 3), (6, 6)])
def test_waves_beside_the_lean_state_the_scatter_that_a_rough_wall_causes(size: tuple[int, int]) -> None:
    # 12 waves tell a variance to 41 %, 8 walls to 14 %; small_sample_factor adds 30 %; pieces flatten fast waves
    assert np.trace(mean_of(by_waves, *size)) / 2.0 / scatter_of_pieces(*size) == pytest.approx(1.3, abs=0.6)


@pytest.mark.parametrize("state", [by_pieces, by_waves])
def test_noise_alone_does_not_look_like_the_form_of_a_wall(
    state: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> None:
    rng = np.random.default_rng(2)
    _, normal, _ = solved(np.zeros((N_HEIGHTS, SECTORS)))
    noise = float(normal.covariance()[1, 1] / FORM.half_m**2)
    found = [float(np.trace(state(white(rng, SIGMA_M)))) / 2.0 for _ in range(12)]
    # beyond two standard deviations by chance, once or twice, and then below the noise itself
    assert np.count_nonzero(found) <= 2
    assert max(found) < noise


@pytest.mark.parametrize("state", [by_pieces, by_waves])
def test_what_the_surface_follows_is_no_form_of_the_wall(
    state: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> None:
    """A bent, leaning axis and a radius that swells are the shape of the structure."""
    noise_m = white(np.random.default_rng(3), SIGMA_M)
    cells = cells_with(noise_m, SIGMA_M)
    share = (cells.z_m - FORM.middle_m) / FORM.half_m
    shape = (0.05 + 0.1 * share + 0.04 * share**2 - 0.03 * share**3) * cells.direction.real
    shape += 0.02 * np.sin(2.0 * share)
    assert state(noise_m + shape.reshape(noise_m.shape)) == pytest.approx(state(noise_m), abs=1e-14)


@pytest.mark.parametrize("n", [1, 40])
def test_the_factor_for_few_waves_is_that_of_fisher(n: int) -> None:
    wanted = stats.f.ppf(0.95, 2, n) / (stats.chi2.ppf(0.95, 2) / 2.0)
    assert small_sample_factor(n) == pytest.approx(wanted, rel=1e-9)
