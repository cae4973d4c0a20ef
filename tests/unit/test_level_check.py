from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD
from tasks.level_check import check_levels, worst_suspect
from tasks.preprocessing import ShaftModel

MODEL = ShaftModel(0.0, 0.0, 0.007, -0.007, (2.0, 102.0), (4.6, 2.7), (0.0, 0.0), (0.0, 0.0), 0.01)
LEVEL_RAD = 2.9 * ARCSEC_RAD


Form = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


def round_form(azimuth_rad: NDArray[np.float64], z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.zeros_like(z_m)


def twisting_oval(azimuth_rad: NDArray[np.float64], z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """10 mm out of round, and turning by a quarter from foot to top: as like a lean as an oval can be."""
    return np.asarray(0.01 * np.cos(2.0 * azimuth_rad - np.pi * z_m / 100.0))


def smooth_form(seed: int) -> Form:
    """Harmonics of 10 mm together, 2 to 5 around and none to two along: what no common axis and radius follow."""
    rng = np.random.default_rng(300 + seed)
    size, phase = rng.normal(size=(4, 3)), rng.uniform(0.0, 2.0 * np.pi, (4, 3))
    size *= 0.01 / np.sqrt(np.sum(size**2 * [0.5, 0.25, 0.25]))

    def form(azimuth_rad: NDArray[np.float64], z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        around = [np.cos((2 + k) * azimuth_rad + phase[k, m]) for k in range(4) for m in range(3)]
        along = [np.cos(np.pi * m * z_m / 100.0) for k in range(4) for m in range(3)]
        return np.asarray(sum(one * a * b for one, a, b in zip(size.ravel(), around, along, strict=True)))

    return form


def half_shaft(
    rng: np.random.Generator, azimuth_rad: float, level: NDArray[np.float64], form: Form = round_form
) -> NDArray[np.float64]:
    """What a station at that azimuth sees of the shaft, its level off by ``level`` (lean east, north)."""
    n = 20_000
    z = rng.uniform(2.0, 102.0, n)
    around = azimuth_rad + rng.uniform(-1.4, 1.4, n)
    radius = MODEL.radius_at(z) + form(around, z) + 0.012 * rng.normal(size=n)
    xy = MODEL.axis_at(z) + radius[:, None] * np.column_stack([np.sin(around), np.cos(around)])
    return np.column_stack([xy + z[:, None] * level, z])


def epoch(
    seed: int, levels_arcsec: list[tuple[float, float]], form: Form = round_form
) -> tuple[NDArray[np.float64], NDArray[np.uint16]]:
    rng = np.random.default_rng(seed)
    n = len(levels_arcsec)
    seen = [
        half_shaft(rng, 2 * np.pi * i / n, ARCSEC_RAD * np.array(level), form)
        for i, level in enumerate(levels_arcsec)
    ]
    return np.concatenate(seen), np.repeat(np.arange(n, dtype=np.uint16), [len(s) for s in seen])


def test_the_station_that_is_out_of_level_is_named_with_its_error() -> None:
    points, stations = epoch(1, [(0, 0), (0, 0), (30, -40), (0, 0), (0, 0), (0, 0)])
    checks = check_levels(points, stations, MODEL, [LEVEL_RAD] * 6)
    assert worst_suspect(checks) == 2
    found = np.array([checks[2].lean_east, checks[2].lean_north], float) / ARCSEC_RAD
    # the noise of 20,000 points on half a shaft leaves 1 to 2 arc seconds
    assert found == pytest.approx([30, -40], abs=5)


@pytest.mark.parametrize("seed", range(5))
def test_levels_within_their_sigma_make_nobody_suspect(seed: int) -> None:
    levels = 2.9 * np.random.default_rng(100 + seed).normal(size=(8, 2))
    points, stations = epoch(seed, [tuple(level) for level in levels])
    assert worst_suspect(check_levels(points, stations, MODEL, [LEVEL_RAD] * 8)) is None


@pytest.mark.parametrize("seed", range(5))
def test_a_shaft_out_of_round_makes_nobody_suspect(seed: int) -> None:
    levels = 2.9 * np.random.default_rng(200 + seed).normal(size=(6, 2))
    points, stations = epoch(seed, [tuple(level) for level in levels], smooth_form(seed))
    assert worst_suspect(check_levels(points, stations, MODEL, [LEVEL_RAD] * 6)) is None


@pytest.mark.parametrize("n", [2, 4])
def test_an_oval_that_turns_with_height_makes_nobody_suspect(n: int) -> None:
    points, stations = epoch(1, [(0, 0)] * n, twisting_oval)
    assert worst_suspect(check_levels(points, stations, MODEL, [LEVEL_RAD] * n)) is None


@pytest.mark.parametrize("lean", [(60, 0), (0, -60), (42, 42)])
def test_a_minute_of_arc_on_a_round_shaft_is_suspect(lean: tuple[float, float]) -> None:
    points, stations = epoch(2, [(0, 0), (0, 0), lean, (0, 0), (0, 0), (0, 0)])
    assert worst_suspect(check_levels(points, stations, MODEL, [LEVEL_RAD] * 6)) == 2


def test_ladder_in_front_of_one_station_is_no_level_error() -> None:
    points, stations = epoch(3, [(0, 0)] * 4)
    rng = np.random.default_rng(4)
    on_ladder = (stations == 1) & (rng.uniform(size=len(points)) < 0.04)
    outward = points[on_ladder, :2] - MODEL.axis_at(points[on_ladder, 2])
    points[on_ladder, :2] += 0.1 * outward / np.linalg.norm(outward, axis=1)[:, None]
    assert worst_suspect(check_levels(points, stations, MODEL, [LEVEL_RAD] * 4)) is None


def test_one_station_alone_cannot_be_checked() -> None:
    points, stations = epoch(1, [(100, 0)])
    (check,) = check_levels(points, stations, MODEL, [LEVEL_RAD])
    assert check.chi2 is None
    assert worst_suspect([check]) is None


def test_station_with_few_points_is_not_judged() -> None:
    points, stations = epoch(1, [(0, 0), (100, 0)])
    few = (stations == 0) | (np.arange(len(points)) % 100 == 0)
    checks = check_levels(points[few], stations[few], MODEL, [LEVEL_RAD] * 2)
    assert checks[1].chi2 is None
    assert checks[0].chi2 is not None
