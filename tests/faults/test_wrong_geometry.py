"""Scans in a wrong unit or with wrong axes, which no format shows: left out by name, never a lean without a word."""

import shutil
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.ingest import read_scan
from tests.faults.conftest import STATIONS
from tests.faults.sites import FIRST, Site, epoch_text, head_of, state_of, stations_of
from tests.flows.calls import Called
from tests.unit.ingest.clouds import write_las

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]

Points = NDArray[np.float64]
WRONG: Mapping[str, Callable[[Points], Points]] = {
    "millimetres": lambda points: points * 1000.0,
    "feet": lambda points: points / 0.3048,
    "mirrored": lambda points: points * (-1.0, 1.0, 1.0),
    "swapped": lambda points: points[:, (1, 0, 2)],
    "y-up": lambda points: points[:, (0, 2, 1)],
    "upside-down": lambda points: points * (1.0, -1.0, -1.0),
}
LONG = 1e4
"""Beyond it, integers of 32 bits are too short for steps of 0.0001."""

ONE, ALL = "one-", "all-"


def _epoch(
    site: Site, name: str, change: Callable[[Points], Points], n_wrong: int
) -> Sequence[Mapping[str, object]]:
    """An epoch as the first one, with some of its scans changed."""
    folder = site.folder / name
    shutil.copytree(site.folder / FIRST, folder)
    for scan in sorted(folder.glob("*.laz"))[:n_wrong]:
        points = change(read_scan(scan).points_m)
        write_las(scan, points, scale=1e-4 if np.ptp(points, axis=0).max() < LONG else 1e-3)
    return [{**table, "scan": f"{name}/{table['id']}.laz"} for table in stations_of(site.text(), FIRST)]


@pytest.fixture(scope="module")
def told(sound: Site, tmp_path_factory: pytest.TempPathFactory) -> tuple[Site, Called]:
    site = Site(tmp_path_factory.mktemp("geometry") / "campaign")
    shutil.copytree(sound.folder, site.folder)
    text, epochs = site.text(), [epoch_text(FIRST, -1, stations_of(site.text(), FIRST))]
    for month, name in enumerate([prefix + name for prefix in (ONE, ALL) for name in WRONG]):
        n_wrong = 1 if name.startswith(ONE) else 99
        epochs.append(epoch_text(name, month, _epoch(site, name, WRONG[name[4:]], n_wrong)))
    site.file.write_text(head_of(text) + "\n".join(epochs), encoding="utf-8")
    return site, site.run("--scheme", "A", "--json")


@pytest.mark.parametrize("wrong", WRONG)
def test_one_wrong_scan_of_five_is_left_out_and_named(told: tuple[Site, Called], wrong: str) -> None:
    state = state_of(told[1], ONE + wrong)
    assert (state["state"], state["n_stations_used"]) == ("degraded", STATIONS - 1)
    assert [error.split(":")[0] for error in state["errors"]] == ["station ST01"]


@pytest.mark.parametrize("wrong", WRONG)
def test_an_epoch_of_wrong_scans_has_no_lean(told: tuple[Site, Called], wrong: str) -> None:
    state = state_of(told[1], ALL + wrong)
    assert (state["state"], state["lean_east"], state["deviation_m"]) == ("failed", None, None)
    assert state["errors"]
