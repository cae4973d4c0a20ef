from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from tasks.registration import StationPose, StationScan
from tasks.registration.planar import ScanPlanes, planes_of_scan, scan_planes
from tasks.registration.start import Start, Starts, find_starts
from tasks.simulation import SimulatedCampaignRequest, SimulatedStation
from tests.unit.registration.conftest import HINT, SeenSite, simulated, stated_scan
from tests.unit.registration.courtyard import SIGMAS

VICTIM = 1
OTHER = 3


def started(scans: Sequence[StationScan], planes: Sequence[ScanPlanes]) -> Starts:
    return find_starts(scans, planes, SIGMAS, HINT)


def placed(start: Start) -> StationPose:
    assert start.pose is not None, start.suspicion
    return start.pose


def heading_error_deg(start: Start, station: SimulatedStation) -> float:
    forward = placed(start).rotation[:, 1]
    off = np.arctan2(forward[0], forward[1]) - station.setup.heading_rad
    return abs(float(np.degrees((off + np.pi) % (2.0 * np.pi) - np.pi)))


def position_error_m(start: Start, station: SimulatedStation) -> float:
    return float(np.linalg.norm(placed(start).position_m - station.setup.position_m))


def others_start_as_stated(starts: Starts, *victims: int) -> bool:
    return all(
        start.remark == "as stated" and start.suspicion is None
        for i, start in enumerate(starts.stations)
        if i not in victims
    )


def test_a_good_epoch_starts_as_stated(eight: SeenSite) -> None:
    starts = started(eight.scans, eight.planes)
    assert others_start_as_stated(starts)
    assert starts.seen is not None
    assert starts.seen.base_xy_m == pytest.approx([0.37, -0.35], abs=0.3)


def test_without_a_hint_what_is_stated_is_believed(eight: SeenSite) -> None:
    turned = replace(eight.scans[VICTIM], heading_rad=0.0)
    starts = find_starts(eight.with_scan(VICTIM, turned), eight.planes, SIGMAS, None)
    assert starts.seen is None
    assert placed(starts.stations[VICTIM]).rotation == pytest.approx(np.eye(3))


@pytest.mark.parametrize(
    ("off_deg", "told"), [(1.2, "1.[0-4]"), (-5.0, "[45].[0-9]"), (90.0, "(89|90).[0-9]")]
)
def test_a_wrong_heading_is_found_by_the_shaft_and_named(eight: SeenSite, off_deg: float, told: str) -> None:
    heading = eight.scans[VICTIM].heading_rad
    assert heading is not None
    wrong = replace(eight.scans[VICTIM], heading_rad=heading + float(np.radians(off_deg)))
    starts = started(eight.with_scan(VICTIM, wrong), eight.planes)
    start = starts.stations[VICTIM]
    # the axis of the shaft is known to 0.3 m at 230 m
    assert heading_error_deg(start, eight.stations[VICTIM]) < 0.1
    assert start.remark == "heading found by the direction of the structure: the stated one is wrong"
    assert start.scan.heading_rad is None
    with pytest.raises(
        ValueError, match=rf"stated heading is {told} deg off and is not used; check heading_deg"
    ):
        raise ValueError(start.suspicion)
    assert others_start_as_stated(starts, VICTIM)


def test_headings_that_nobody_stated_are_all_found_and_none_is_suspected(eight: SeenSite) -> None:
    starts = started([replace(scan, heading_rad=None) for scan in eight.scans], eight.planes)
    for start, station in zip(starts.stations, eight.stations, strict=True):
        # by the rough base alone, from which the leaning axis is 0.5 m off at mid height: 0.14 deg at 200 m
        assert heading_error_deg(start, station) < 0.2
        assert start.remark == "heading found by the direction of the structure: none is stated"
        assert start.suspicion is None


@pytest.mark.parametrize("heading_is_stated", [True, False])
def test_a_station_without_position_is_placed_right_or_refused(
    eight: SeenSite, heading_is_stated: bool
) -> None:
    heading = eight.scans[VICTIM].heading_rad if heading_is_stated else None
    lost = replace(eight.scans[VICTIM], position_m=None, heading_rad=heading)
    starts = started(eight.with_scan(VICTIM, lost), eight.planes)
    start = starts.stations[VICTIM]
    if start.pose is None:
        assert start.suspicion is not None
        assert "fits that of the others" in start.suspicion
    else:
        what = "position" if heading_is_stated else "position and heading"
        assert start.remark == f"{what} found by what stands around the structure: none is stated"
        assert position_error_m(start, eight.stations[VICTIM]) < 0.1
        assert heading_error_deg(start, eight.stations[VICTIM]) < 0.05
    assert others_start_as_stated(starts, VICTIM)


def test_two_swapped_stations_are_both_named_and_placed_where_they_stood(eight: SeenSite) -> None:
    exchange = {VICTIM: OTHER, OTHER: VICTIM}
    order = [exchange.get(i, i) for i in range(len(eight.scans))]
    scans = [
        replace(scan, points_m=eight.scans[k].points_m) for scan, k in zip(eight.scans, order, strict=True)
    ]
    starts = started(scans, [eight.planes[k] for k in order])
    for i, other in exchange.items():
        start, truth = starts.stations[i], eight.stations[other]
        # by GNSS, as stated of the other station
        assert position_error_m(start, truth) < 4.0 * 0.0225
        assert heading_error_deg(start, truth) < 0.1
        assert start.remark == f"as stated of {eight.scans[other].station}: the two are swapped"
        assert start.suspicion is not None
        assert "the two are swapped, and each is placed where it stood" in start.suspicion
    assert others_start_as_stated(starts, VICTIM, OTHER)


def test_a_position_that_is_metres_off_is_found_again_or_refused_and_named(eight: SeenSite) -> None:
    station, scan = eight.stations[VICTIM], eight.scans[VICTIM]
    outward = station.setup.position_m * [1.0, 1.0, 0.0] / np.hypot(*station.setup.position_m[:2])
    wrong = replace(scan, position_m=station.setup.position_m + 12.0 * outward)
    start = started(eight.with_scan(VICTIM, wrong), eight.planes).stations[VICTIM]
    assert start.suspicion is not None
    if start.pose is None:
        assert "m from its stated position, and what it sees beside the structure fits" in start.suspicion
    else:
        assert position_error_m(start, station) < 0.1
        assert start.suspicion.startswith("stated position is 12.0 m off and is not used; check position_m")


@pytest.mark.slow
def test_lost_stations_are_placed_where_points_are_dense_enough() -> None:
    stations = simulated(SimulatedCampaignRequest(stations=8, points=200_000, seed=3))
    scans = [stated_scan(station) for station in stations]
    planes = scan_planes([scan.points_m for scan in scans])
    for i in (1, 5):
        lost = [replace(s, position_m=None, heading_rad=None) if k == i else s for k, s in enumerate(scans)]
        start = started(lost, planes).stations[i]
        assert position_error_m(start, stations[i]) < 0.1
        assert heading_error_deg(start, stations[i]) < 0.05
        assert (
            start.remark == "position and heading found by what stands around the structure: none is stated"
        )


def test_a_scan_of_another_site_is_refused_with_the_reason(eight: SeenSite) -> None:
    elsewhere = simulated(SimulatedCampaignRequest(stations=2, points=60_000, seed=9))[1]
    scan = replace(eight.scans[VICTIM], points_m=stated_scan(elsewhere).points_m)
    planes = list(eight.planes)
    planes[VICTIM] = planes_of_scan(scan.points_m)
    starts = started(eight.with_scan(VICTIM, scan), planes)
    start = starts.stations[VICTIM]
    assert start.pose is None
    assert start.suspicion is not None
    assert (
        "fits that of the others nowhere; left out; check scan, position_m and heading_deg" in start.suspicion
    )
    assert others_start_as_stated(starts, VICTIM)


def test_a_station_without_position_that_does_not_see_the_shaft_is_refused(eight: SeenSite) -> None:
    scan = replace(eight.scans[VICTIM], position_m=None)
    planes = list(eight.planes)
    planes[VICTIM] = planes_of_scan(scan.points_m[scan.points_m[:, 2] < 3.0])
    start = started(eight.with_scan(VICTIM, scan), planes).stations[VICTIM]
    assert start.pose is None
    assert start.suspicion is not None
    assert "no position is stated and its scan does not show the structure" in start.suspicion
