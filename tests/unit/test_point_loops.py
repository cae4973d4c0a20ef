"""The compiled loops over the points of a shaft do what plain arithmetic does."""

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.median_kernel import median_in_place
from tasks.geometry.robust import TUKEY_1D, mad_sigma, tukey_weights
from tasks.geometry.rows_between import rows_between
from tasks.geometry.sector_kernel import even_sectors, find_sectors
from tasks.level_kernel import count_stations, take_places, weigh_rows
from tasks.map_cells import robust_means
from tasks.map_kernel import off_round
from tasks.uncertainty import Ring, Skin, sum_by_station, sum_ring_by_station

N = 3000


@pytest.mark.parametrize("n_sectors", [7, 36, 72, 360])
def test_sectors_are_those_of_the_angle(n_sectors: int) -> None:
    rng = np.random.default_rng(1)
    turn, length = rng.uniform(-np.pi, np.pi, 20_000), rng.uniform(0.1, 9.0, 20_000)
    x, y = length * np.cos(turn), length * np.sin(turn)
    found = np.empty(len(x), dtype=np.int64)
    find_sectors(x, y, even_sectors(n_sectors), found)
    width = 2.0 * np.pi / n_sectors
    assert found.tolist() == (np.floor(np.arctan2(y, x) / width).astype(int) % n_sectors).tolist()


@pytest.mark.parametrize("n_sectors", [8, 36, 72])
def test_a_direction_on_an_edge_is_beside_it_and_an_axis_begins_its_sector(n_sectors: int) -> None:
    edge = np.arange(n_sectors)
    turn = 2.0 * np.pi * edge / n_sectors
    x = np.append(np.cos(turn), [1.0, 0.0, -1.0, 0.0, 0.0])
    y = np.append(np.sin(turn), [0.0, 1.0, 0.0, -1.0, 0.0])
    found = np.empty(len(x), dtype=np.int64)
    find_sectors(x, y, even_sectors(n_sectors), found)
    assert set(((edge - found[:n_sectors]) % n_sectors).tolist()) <= {0, 1}
    quarter = n_sectors // 4
    assert found[n_sectors:].tolist() == [0, quarter, 2 * quarter, 3 * quarter, 0]


@pytest.mark.parametrize("n", [1, 2, 3, 10, 11, 500, 501])
def test_a_median_is_that_of_numpy(n: int) -> None:
    rng = np.random.default_rng(n)
    for values in (
        rng.standard_normal(n),
        np.round(rng.standard_normal(n)),
        np.arange(float(n)),
        np.zeros(n),
    ):
        assert median_in_place(values.copy()) == np.median(values)


def test_rows_between_heights_are_a_slice_where_points_rise() -> None:
    z_m = np.linspace(0.0, 10.0, 101)
    assert rows_between(z_m, 2.0, 3.0) == slice(20, 31)
    assert rows_between(z_m, 20.0, 30.0) == slice(0, 0)
    mixed = np.random.default_rng(2).permutation(z_m)
    assert mixed[rows_between(mixed, 2.0, 3.0)].tolist() == mixed[(mixed >= 2.0) & (mixed <= 3.0)].tolist()


def ring_points() -> tuple[NDArray[np.float64], NDArray[np.uint16]]:
    rng = np.random.default_rng(3)
    turn, rise = rng.uniform(0.0, 2.0 * np.pi, N), rng.uniform(-0.1, 0.1, N)
    distance = 4.0 - 0.02 * rise + 0.01 * rng.standard_normal(N)
    centre = np.array([0.3, -0.2]) + rise[:, None] * [0.02, -0.03]
    xy = centre + distance[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.column_stack([xy, 30.0 + rise]), rng.integers(0, 3, N).astype(np.uint16)


def test_sums_by_station_are_those_of_plain_arithmetic() -> None:
    points_m, station = ring_points()
    ray = points_m[:, :2] - [0.3, -0.2] - (points_m[:, 2:] - 30.0) * [0.02, -0.03]
    distance = np.linalg.norm(ray, axis=1)
    out = ray / distance[:, None]
    outward = np.column_stack([out, 0.02 - out @ [0.02, -0.03]])
    residual_m = distance - 4.0 + 0.02 * (points_m[:, 2] - 30.0)
    used = np.abs(residual_m) <= 0.012
    terms = np.column_stack([out, np.ones(N)])
    columns = np.column_stack([terms, residual_m, np.cross(points_m, outward), outward])
    plain = np.array([terms[of].T @ columns[of] for of in (used & (station == s) for s in range(3))])
    skin = Skin(points_m[used], outward[used], residual_m[used], station[used])
    assert sum_by_station(skin, 3) == pytest.approx(plain, rel=1e-10, abs=1e-9)
    ring = Ring((0.3, -0.2), 30.0, 4.0, (0.02, -0.03), -0.02, 0.012)
    assert sum_ring_by_station(points_m, station, ring, 3) == pytest.approx(plain, rel=1e-10, abs=1e-9)


def test_a_ring_without_a_station_for_every_point_is_misuse() -> None:
    points_m, station = ring_points()
    with pytest.raises(ShapeError, match="a station each of 3000 points"):
        sum_ring_by_station(points_m, station[1:], Ring((0.0, 0.0), 30.0, 4.0, (0.0, 0.0), 0.0, 1.0), 3)


def plain_mean(values: NDArray[np.float64]) -> tuple[float, float, NDArray[np.float64]]:
    """Robust mean of a piece, its sigma, and the weights (n,)."""
    mean = float(np.median(values))
    scale = mad_sigma(values - mean)
    for _ in range(4):
        weight = tukey_weights(values - mean, scale)
        mean = float(weight @ values / weight.sum())
    root, n = np.sqrt(weight), len(values)
    slope = float(np.sum(root * (5.0 * root - 4.0)))
    return mean, float(np.sqrt(np.sum((weight * (values - mean)) ** 2) * n / (n - 1)) / slope), weight


def test_means_of_pieces_are_those_of_plain_arithmetic() -> None:
    rng = np.random.default_rng(5)
    cell = rng.integers(0, 20, N).astype(np.uint16)
    values = 0.01 * rng.standard_normal(N) + 0.1 * cell + np.where(np.arange(N) % 9 == 0, 0.2, 0.0)
    others = rng.standard_normal(N)
    means = robust_means(lambda rows: values[rows], cell, np.bincount(cell, minlength=20))
    found = means.mean_of(lambda rows: others[rows], lambda rows: values[rows], cell)
    assert means.sigma is not None
    for number in range(20):
        mean, sigma, weight = plain_mean(values[cell == number])
        assert means.mean[number] == pytest.approx(mean, rel=1e-12, abs=1e-14)
        assert means.sigma[number] == pytest.approx(sigma, rel=1e-11)
        assert found[number] == pytest.approx(weight @ others[cell == number] / weight.sum(), rel=1e-10)


@pytest.mark.parametrize("across", [False, True])
def test_distances_from_a_round_shaft_are_those_of_plain_arithmetic(across: bool) -> None:
    rng = np.random.default_rng(7)
    points_m = rng.uniform([-5.0, -5.0, 15.0], [5.0, 5.0, 25.0], (N, 3))
    knots, radii, foot, lean = (
        np.array([16.0, 19.0, 24.0]),
        np.array([4.0, 3.0, 2.8]),
        [0.3, -0.2],
        [0.05, -0.08],
    )
    direction = np.array([*lean, 1.0]) / np.linalg.norm([*lean, 1.0])
    away = points_m - [*foot, 0.0]
    along = away @ direction
    if across:
        distance = np.linalg.norm(away - np.outer(along, direction), axis=1)
        plain = distance - np.interp(along * direction[2], knots, radii)
    else:
        distance = np.linalg.norm(away[:, :2] - np.outer(points_m[:, 2], lean), axis=1)
        plain = distance - np.interp(points_m[:, 2], knots, radii)
    off_m = np.empty(N)
    off_round(points_m, (foot[0], foot[1], lean[0], lean[1]), knots, radii, across, off_m)
    assert off_m == pytest.approx(plain, abs=1e-13)


def test_rows_at_places_are_those_of_their_stations() -> None:
    station = np.random.default_rng(9).integers(0, 4, N).astype(np.uint16)
    counts = count_stations(station, 3)
    assert counts.tolist() == np.bincount(station, minlength=4)[:3].tolist()
    places = [np.arange(0, n, 3) for n in counts]
    ends = np.cumsum([0, *(len(of) for of in places)])
    rows = np.empty(ends[-1], dtype=np.int64)
    take_places(station, np.concatenate(places), ends, rows)
    assert rows.tolist() == [row for s in range(3) for row in np.flatnonzero(station == s)[::3]]


def test_weighed_rows_are_those_of_plain_arithmetic() -> None:
    rng = np.random.default_rng(10)
    design, residual, error = rng.standard_normal((N, 5)), rng.standard_normal(N), rng.standard_normal(N)
    weight = tukey_weights(error, 0.3)
    normal, right = weigh_rows(design, residual, error, TUKEY_1D * 0.3)
    assert normal == pytest.approx(design.T @ (design * weight[:, None]), rel=1e-10, abs=1e-10)
    assert right == pytest.approx(design.T @ (weight * residual), rel=1e-10, abs=1e-10)
