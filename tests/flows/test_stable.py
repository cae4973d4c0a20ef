"""Epochs that share their frame with the reference epoch by surroundings that do not move."""

import numpy as np
import pytest

from tests.faults.sites import FIRST, SECOND, Site, epoch_text, head_of, state_of, stations_of
from tests.flows.calls import Called
from tests.flows.campaigns import replace_text, small_campaign

OFF_EAST_M = 0.06
"""How far the base of GNSS is wrong in the second epoch: four times the sigma of one station."""

BOXES = (
    '{ name = "east", low_m = [20.0, -400.0, -20.0], high_m = [400.0, 400.0, 60.0] }',
    '{ name = "west", low_m = [-400.0, -400.0, -20.0], high_m = [-20.0, 400.0, 60.0] }',
)
NOWHERE = '{ name = "nowhere", low_m = [3000.0, 0.0, 0.0], high_m = [3001.0, 1.0, 1.0] }'


def stable(*boxes: str) -> str:
    return f"stable = [{', '.join(boxes)}]"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory, prefect_api: str) -> Site:
    site = Site(tmp_path_factory.mktemp("stable"))
    small_campaign(site.folder, epochs=2, stations=4, points=20_000)
    text = site.text()
    first, second = (stations_of(text, epoch) for epoch in (FIRST, SECOND))
    moved = [
        {**t, "position_m": list(np.add(t["position_m"], (OFF_EAST_M, 0.0, 0.0)).tolist())} for t in second
    ]
    epochs = epoch_text(FIRST, 0, first) + epoch_text(SECOND, 1, moved)
    site.file.write_text(f"{head_of(text)}\n[registration]\n{stable(*BOXES)}\n{epochs}", encoding="utf-8")
    return site


@pytest.fixture(scope="module")
def told(site: Site) -> Called:
    return site.run("--scheme", "A", "--json")


def mean_correction_m(site: Site) -> float:
    return float(np.mean([row.correction_east_m for row in site.stations(SECOND).values()]))


def reasons_with(site: Site, old: str, new: str) -> str:
    """What the second epoch tells when it is run with another campaign file."""
    before = site.text()
    replace_text(site.file, old, new)
    try:
        again = site.run("--scheme", "A", "--epoch", SECOND, "--json")
    finally:
        site.file.write_text(before, encoding="utf-8")
    return "\n".join(state_of(again, SECOND)["errors"])  # type: ignore[call-overload]


def test_the_reference_epoch_holds_a_later_one_whose_gnss_is_off(told: Called, site: Site) -> None:
    # GNSS alone, all of one weight, corrects nothing on the whole; how far so few planes outweigh it is not said here
    assert -OFF_EAST_M - 0.02 < mean_correction_m(site) < -0.01


def test_the_reference_epoch_is_taken_from_the_cache_for_the_later_one(told: Called, site: Site) -> None:
    stages = dict(site.query("select stage, state from runs where epoch = ?", [SECOND]))
    assert stages[f"{FIRST} registration"] == "cached"
    assert stages[f"{FIRST} stable surroundings"] == "computed"
    assert not any(
        "stable" in stage for (stage,) in site.query("select stage from runs where epoch = ?", [FIRST])
    )


def test_boxes_that_hold_nothing_leave_the_epoch_to_gnss_and_are_told(told: Called, site: Site) -> None:
    assert (
        f"no stable surroundings from the reference epoch {FIRST}: the stable surroundings (nowhere) hold 0 planes"
    ) in reasons_with(site, stable(*BOXES), stable(NOWHERE))


def test_a_reference_epoch_that_is_a_registered_cloud_is_told(told: Called, site: Site) -> None:
    text = site.text()
    stations = text[
        text.index("[[epochs.stations]]") : text.index("[[epochs]]", text.index("[[epochs]]") + 1)
    ]
    assert (
        f"no stable surroundings from the reference epoch {FIRST}: it is a registered cloud, without scans of "
        "stations; the epoch rests on GNSS alone"
    ) in reasons_with(site, stations, 'registered = "merged.laz"\n')


def test_a_reference_epoch_that_cannot_be_read_is_told(told: Called, site: Site) -> None:
    told_of = reasons_with(site, f'scan = "{FIRST}/', 'scan = "away/')
    assert f"no stable surroundings from the reference epoch {FIRST}: station ST01: " in told_of
    assert told_of.endswith("no scan of the epoch could be read; the epoch rests on GNSS alone")
