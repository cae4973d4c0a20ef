import re
from dataclasses import replace

import numpy as np
import pytest

from tasks.conventions import ARCSEC_RAD
from tasks.registration import Registration, StationScan, register_stations
from tests.unit.registration.conftest import Site, succeed
from tests.unit.registration.courtyard import SIGMAS, Courtyard, draw_courtyard

VICTIM = 1
Offsets = dict[int, tuple[float, float, float]]
NOBODY_CAN_TELL = "or that of another station is: the scans cannot tell which"


def settled(scans: list[StationScan]) -> Registration:
    return succeed(register_stations(scans, SIGMAS))


def told(registration: Registration, part: str, unit: str) -> float:
    """How far off the victim's statement is said to be; the others must be ok."""
    states = [diagnosis.state for diagnosis in registration.diagnoses]
    assert states == ["suspect" if i == VICTIM else "ok" for i in range(len(states))]
    reason = registration.diagnoses[VICTIM].reason or ""
    found = re.match(rf"stated {part} is ([\d.]+) {unit} off \(\d+ sigmas\) and is not used; check", reason)
    assert found, reason
    return float(found[1])


def test_nothing_is_said_against_right_statements() -> None:
    for seed in range(4):
        registration = settled(list(draw_courtyard(10 + seed).scans))
        assert [diagnosis.reason for diagnosis in registration.diagnoses] == [None] * 4


@pytest.mark.parametrize("off_m", [(0.5, 0.0, 0.0), (0.3, -0.4, 0.0), (-0.3, -0.4, 0.0)])
def test_a_position_half_a_metre_off_is_named_with_its_size(
    yard: Courtyard, off_m: tuple[float, float, float]
) -> None:
    registration = settled(yard.stated_off(VICTIM, off_m))
    # what is told holds the GNSS error, too
    assert told(registration, "position", "m") == pytest.approx(0.5, rel=0.1)
    wrong = registration.poses[VICTIM].position_m - yard.truth[VICTIM].position_m
    assert np.linalg.norm(wrong[:2]) < 0.05


@pytest.mark.parametrize("off_m", [0.5, -0.5])
def test_a_height_half_a_metre_off_is_named_with_its_size(yard: Courtyard, off_m: float) -> None:
    scans = yard.stated_off(VICTIM, (0.0, 0.0, off_m))
    registration = settled(scans)
    assert scans[VICTIM].position_m is not None
    whole = abs(scans[VICTIM].position_m[2] - yard.truth[VICTIM].position_m[2])
    # the frame is as high as the mean of the three other heights, each known to 22 mm
    assert told(registration, "height", "m") == pytest.approx(whole, abs=0.05)
    assert registration.poses[VICTIM].position_m[2] == pytest.approx(
        yard.truth[VICTIM].position_m[2], abs=0.05
    )


@pytest.mark.parametrize("off_deg", [1.2, -1.2])
def test_a_heading_a_degree_off_is_named_with_its_size(yard: Courtyard, off_deg: float) -> None:
    registration = settled(yard.turned(VICTIM, float(np.radians(off_deg))))
    stated = yard.scans[VICTIM].heading_rad
    assert stated is not None
    true = yard.truth[VICTIM].rotation[:, 1]
    whole = abs(off_deg + np.degrees(stated - np.arctan2(true[0], true[1])))
    # the frame itself is known to the mean of four headings of 0.15 deg
    assert told(registration, "heading", "deg") == pytest.approx(whole, abs=0.2)


@pytest.mark.parametrize(("east", "north"), [(60.0, 0.0), (0.0, 60.0), (-60.0, 0.0)])
def test_a_level_a_minute_off_is_named_with_its_size(yard: Courtyard, east: float, north: float) -> None:
    registration = settled(yard.out_of_level(VICTIM, east, north))
    assert told(registration, "level", "arc seconds") == pytest.approx(60.0, rel=0.15)
    # what it saw is now as plumb as the rest says: four levels of 2.9"
    lean = registration.diagnoses[VICTIM]
    assert np.hypot(lean.level_east_rad, lean.level_north_rad) == pytest.approx(60.0 * ARCSEC_RAD, rel=0.15)


@pytest.mark.parametrize("azimuth_deg", [0.0, 45.0, 90.0, 135.0])
def test_a_level_off_is_named_whichever_way_it_leans(yard: Courtyard, azimuth_deg: float) -> None:
    axis = 50.0 * np.array([np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))])
    registration = settled(yard.out_of_level(VICTIM, axis[0], axis[1]))
    assert told(registration, "level", "arc seconds") == pytest.approx(50.0, rel=0.15)


def test_the_worst_of_two_blunders_does_not_hide_the_other(yard: Courtyard) -> None:
    scans = yard.stated_off(VICTIM, (0.0, 0.0, 0.5))
    assert scans[2].position_m is not None
    scans[2] = replace(scans[2], position_m=scans[2].position_m + np.array([0.4, 0.0, 0.0]))
    diagnoses = settled(scans).diagnoses
    assert [diagnosis.state for diagnosis in diagnoses] == ["ok", "suspect", "suspect", "ok"]
    assert diagnoses[1].reason is not None
    assert diagnoses[2].reason is not None
    assert "stated height is 0.5" in diagnoses[1].reason
    assert "stated position is 0.4" in diagnoses[2].reason


@pytest.mark.parametrize("off_m", [(0.4, -0.3, 0.0), (0.0, 0.0, 0.5)])
@pytest.mark.parametrize(("n", "victim"), [(3, 0), (3, 1), (3, 2), (4, 3)])
def test_half_a_metre_is_named_at_its_station_or_said_not_to_be_told_apart(
    yard: Courtyard, n: int, victim: int, off_m: tuple[float, float, float]
) -> None:
    diagnoses = settled(yard.stated_off(victim, off_m)[:n]).diagnoses
    assert diagnoses[victim].state == "suspect"
    for diagnosis in diagnoses:
        is_blamed_alone = diagnosis.reason is not None and NOBODY_CAN_TELL not in diagnosis.reason
        assert not is_blamed_alone or diagnosis.station == yard.scans[victim].station


def off_in(yard: Courtyard, n: int, wrong: Offsets) -> list[StationScan]:
    scans = list(yard.scans[:n])
    for i, off_m in wrong.items():
        position = scans[i].position_m
        assert position is not None
        scans[i] = replace(scans[i], position_m=position + np.array(off_m))
    return scans


@pytest.mark.parametrize(
    "wrong",
    [
        {0: (0.0, 0.0, 0.5), 1: (0.0, 0.0, -0.5)},
        {0: (0.5, 0.0, 0.0), 1: (0.0, 0.5, 0.0)},
        {0: (0.0, 0.0, 0.5), 1: (0.5, 0.0, 0.0)},
        {0: (0.4, 0.0, 0.0), 2: (0.0, -0.3, 0.0)},
        {1: (0.0, 0.0, 0.5), 2: (0.0, 0.0, 0.3)},
    ],
)
def test_of_three_stations_with_two_wrong_none_of_the_wrong_is_ok(yard: Courtyard, wrong: Offsets) -> None:
    diagnoses = settled(off_in(yard, 3, wrong)).diagnoses
    assert [diagnoses[i].state for i in wrong] == ["suspect"] * 2


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_of_three_stations_with_two_wrong_headings_none_of_the_wrong_is_ok(seed: int) -> None:
    scans = list(draw_courtyard(seed).scans[:3])
    for i, off_deg in ((0, 1.2), (1, -1.2)):
        heading = scans[i].heading_rad
        assert heading is not None
        scans[i] = replace(scans[i], heading_rad=heading + np.radians(off_deg))
    assert [diagnosis.state for diagnosis in settled(scans).diagnoses[:2]] == ["suspect"] * 2


def test_of_two_stations_nobody_can_say_which_height_is_wrong(yard: Courtyard) -> None:
    registration = settled(yard.stated_off(VICTIM, (0.0, 0.0, 0.5))[:2])
    reasons = [diagnosis.reason for diagnosis in registration.diagnoses if diagnosis.reason is not None]
    assert reasons
    for reason in reasons:
        assert "stated height is" in reason
        assert NOBODY_CAN_TELL in reason


def test_of_two_stations_that_contradict_each_other_both_are_suspect(yard: Courtyard) -> None:
    registration = settled(yard.stated_off(VICTIM, (0.0, 0.0, 0.5))[:2])
    assert [diagnosis.state for diagnosis in registration.diagnoses] == ["suspect", "suspect"]


def test_corrections_of_right_statements_are_a_few_of_their_own_sigmas(yard: Courtyard) -> None:
    registration = settled(list(yard.scans))
    tested = [w for d in registration.diagnoses for w in d.normalised if w is not None]
    assert len(tested) == 24
    # 24 of them, hardly correlated: their mean square scatters by 0.3
    assert 0.3 < np.mean(np.square(tested)) < 2.0


def test_what_is_not_stated_is_not_tested(yard: Courtyard) -> None:
    scan = replace(yard.scans[VICTIM], heading_rad=None)
    diagnosis = next(d for d in settled(yard.with_scan(VICTIM, scan)).diagnoses if d.station == scan.station)
    assert diagnosis.normalised[2] is None
    assert diagnosis.heading_correction_rad is None


@pytest.mark.slow
@pytest.mark.parametrize("off_m", [0.2, 0.3, 0.5])
def test_a_wrong_height_is_named_or_said_to_be_untested_on_a_site_of_few_points(
    site: Site, off_m: float
) -> None:
    position = site.scans[2].position_m
    assert position is not None
    scans = list(site.scans)
    scans[2] = replace(scans[2], position_m=position + np.array([0.0, 0.0, off_m]))
    diagnosis = settled(scans).diagnoses[2]
    assert diagnosis.state == "suspect" or diagnosis.normalised[5] is None
