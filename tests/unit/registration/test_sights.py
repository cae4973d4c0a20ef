from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from tasks.registration import InstrumentSigmas, ShaftHint, StationScan
from tasks.registration.start import Starts, find_starts
from tests.unit.registration.conftest import HINT, SeenSite
from tests.unit.registration.courtyard import SIGMAS

AT_MID_HEIGHT_M = (0.37, -0.35)
ROUGHLY_M = 0.5
"""The axis is not seen over the same heights from everywhere, and a heading of 0.15 deg puts it 0.5 m aside."""

METRES = InstrumentSigmas((3.0, 3.0), SIGMAS.heading_rad, SIGMAS.level_rad)
UP_M = 500.0


def located(starts: Starts) -> ShaftHint:
    assert starts.seen is not None
    return starts.seen


def all_start_as_stated(starts: Starts) -> bool:
    return all(
        start.pose is not None and start.remark == "as stated" and start.suspicion is None
        for start in starts.stations
    )


def raised(scans: Sequence[StationScan]) -> list[StationScan]:
    up = np.array([0.0, 0.0, UP_M])
    return [replace(s, position_m=s.position_m + up) for s in scans if s.position_m is not None]


def raised_hint() -> ShaftHint:
    low, high = HINT.shaft_z_m
    return replace(HINT, shaft_z_m=(low + UP_M, high + UP_M))


@pytest.mark.parametrize("base_xy_m", [(3.0, 0.0), (-2.1, 2.1)])
@pytest.mark.parametrize("pair", [(0, 1), (1, 4), (2, 7)])
def test_a_base_three_metres_off_refuses_none_of_two_stations(
    eight: SeenSite, pair: tuple[int, int], base_xy_m: tuple[float, float]
) -> None:
    hint = replace(HINT, base_xy_m=base_xy_m)
    scans, planes = [eight.scans[i] for i in pair], [eight.planes[i] for i in pair]
    starts = find_starts(scans, planes, SIGMAS, hint)
    assert all_start_as_stated(starts)
    assert located(starts).base_xy_m == pytest.approx(AT_MID_HEIGHT_M, abs=ROUGHLY_M)


@pytest.mark.parametrize("wrong", [0.7, 1.3])
def test_a_rough_radius_that_is_wrong_by_a_third_is_put_right_and_refuses_nobody(
    eight: SeenSite, wrong: float
) -> None:
    hint = replace(HINT, radius_m=(wrong * HINT.radius_m[0], wrong * HINT.radius_m[1]))
    starts = find_starts(eight.scans, eight.planes, SIGMAS, hint)
    assert all_start_as_stated(starts)
    assert located(starts).base_xy_m == pytest.approx(AT_MID_HEIGHT_M, abs=ROUGHLY_M)
    # half a shaft of 2 cm noise tells its radius to some per cent
    assert located(starts).radius_m == pytest.approx(HINT.radius_m, rel=0.05)


@pytest.mark.parametrize("seed", range(3))
def test_positions_stated_to_three_metres_may_be_three_metres_off(eight: SeenSite, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scans = [
        replace(scan, position_m=scan.position_m + 3.0 * np.array([np.sin(towards), np.cos(towards), 0.0]))
        for scan, towards in zip(eight.scans, rng.uniform(0.0, 2.0 * np.pi, 8), strict=True)
        if scan.position_m is not None
    ]
    assert all_start_as_stated(find_starts(scans, eight.planes, METRES, HINT))


def test_a_structure_half_a_kilometre_above_zero_is_seen_where_it_stands(eight: SeenSite) -> None:
    below = located(find_starts(eight.scans, eight.planes, SIGMAS, HINT))
    starts = find_starts(raised(eight.scans), eight.planes, SIGMAS, raised_hint())
    assert all_start_as_stated(starts)
    # nothing but rounding differs
    assert located(starts).base_xy_m == pytest.approx(below.base_xy_m, abs=1e-6)


def test_a_wrong_heading_is_found_half_a_kilometre_above_zero(eight: SeenSite) -> None:
    scans = raised(eight.scans)
    heading = scans[1].heading_rad
    assert heading is not None
    scans[1] = replace(scans[1], heading_rad=heading + 1.0)
    start = find_starts(scans, eight.planes, SIGMAS, raised_hint()).stations[1]
    assert start.suspicion is not None
    assert start.suspicion.startswith("stated heading is 57.")


def test_a_station_without_position_sees_a_structure_half_a_kilometre_above_zero(eight: SeenSite) -> None:
    scans = raised(eight.scans)
    scans[1] = replace(scans[1], position_m=None)
    start = find_starts(scans, eight.planes, SIGMAS, raised_hint()).stations[1]
    assert "does not show the structure" not in (start.suspicion or "")
