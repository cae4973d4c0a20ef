"""The compiled sums over points are those of the plain arithmetic, whatever the form of the surface."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.surface.cells import SECTORS, TUKEY_CUT, Grid, sector_of, sum_cells
from tasks.surface.form import Form
from tasks.surface.profile import Profile, ProfileTable, tabulate
from tests.unit.surface.shafts import HIGH_M, LOW_M, Shaft, scanned

GRID = Grid(LOW_M, (HIGH_M - LOW_M) / 108, 108)


def table_of(across: bool) -> ProfileTable:
    """A leaning, bent, tapering shaft that is out of round."""
    form = Form((LOW_M, HIGH_M), axis_order=3, radius_intervals=0, harmonics=4, harmonic_order=1)
    rng = np.random.default_rng(3)
    values = 0.01 * rng.standard_normal(form.size)
    values[form.lean_rows] += np.array([0.36, -0.28])
    first = 2 * form.n_axis
    values[first : first + 2] = [3.65, -0.95]
    return tabulate(Profile(form, values, np.array([0.38, -0.29])), across=across)


def plain_sums(table: ProfileTable, sigma_m: NDArray[np.float64]) -> tuple[NDArray[np.float64], list[float]]:
    """Sums (10, cells) and moments by numpy alone."""
    cloud = scanned(Shaft(), 2)
    look = table.look_at(cloud.points_m)
    station = cloud.station_index.astype(np.intp)
    sector = sector_of(look.direction)
    place = (cloud.points_m[:, 2] - GRID.low_m) / GRID.step_m
    height = np.clip(place, 0, GRID.n_heights - 1).astype(np.intp)
    cell = (station * GRID.n_heights + height) * SECTORS + sector
    sigma = sigma_m[station, sector]
    ratio = np.minimum((look.residual_m / (TUKEY_CUT * sigma)) ** 2, 1.0)
    robust = (1.0 - ratio) ** 2
    weight, used = robust / sigma**2, (ratio < 1.0).astype(np.float64)
    columns = [np.ones(len(cell)), used, weight, weight * look.residual_m, weight * look.direction.real]
    columns += [weight * look.direction.imag, weight * cloud.points_m[:, 2], weight * look.foot_m]
    columns += [used * look.residual_m**2, robust]
    size = cloud.n_stations * GRID.n_heights * SECTORS
    scaled = (look.residual_m / sigma) ** 2
    moments = [robust**2 * scaled, (1.0 - ratio) * (1.0 - 5.0 * ratio), robust]
    return np.stack([np.bincount(cell, column, size) for column in columns]), [m.mean() for m in moments]


@pytest.mark.parametrize("across", [False, True])
def test_compiled_sums_are_those_of_plain_arithmetic(across: bool) -> None:
    table, cloud = table_of(across), scanned(Shaft(), 2)
    sigma_m = np.random.default_rng(4).uniform(0.01, 0.03, (cloud.n_stations, SECTORS))
    cells = sum_cells(cloud, table, GRID, sigma_m)
    plain, moments = plain_sums(table, sigma_m)
    held = np.flatnonzero(plain[2] > 0.0)
    number = (cells.station * GRID.n_heights + cells.height) * SECTORS + cells.sector
    assert number.tolist() == held.tolist()
    n_points, used, weight, wr, wc, ws, wz, wf, square, _ = plain[:, held]
    assert cells.n_points.tolist() == n_points.tolist()
    assert cells.n_used.tolist() == used.tolist()
    assert cells.weight == pytest.approx(weight, rel=1e-11)
    assert cells.residual_m * weight == pytest.approx(wr, rel=1e-9, abs=1e-6)
    assert cells.direction == pytest.approx((wc + 1j * ws) / weight, rel=1e-11)
    assert cells.z_m == pytest.approx(wz / weight, rel=1e-12)
    assert cells.foot_m == pytest.approx(wf / weight, rel=1e-12)
    assert cells.square_m2 == pytest.approx(square, rel=1e-9, abs=1e-15)
    assert [cells.influence, cells.slope, cells.mean_weight] == pytest.approx(moments, rel=1e-11)
    # this test can fail: points are in and out of the weights
    assert 0.0 < used.sum() < n_points.sum()
