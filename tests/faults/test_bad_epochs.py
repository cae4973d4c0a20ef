"""Epochs that are bad as a whole, or whose scans do not fit together: recorded, told, and the others processed."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from tasks.conventions import rotation_site_scanner
from tasks.ingest import read_scan
from tests.faults.conftest import STATIONS
from tests.faults.sites import FIRST, SECOND, Site, epoch_text, head_of, state_of, stations_of
from tests.flows.calls import Called
from tests.unit.ingest.clouds import write_las

FOOT_M = 0.3048
LAST = "last"
NAMES = [f"ST{number:02d}" for number in range(1, STATIONS + 1)]


def put_into_feet(scan: Path) -> None:
    write_las(scan, read_scan(scan).points_m / FOOT_M)


def all_in_feet(folder: Path) -> None:
    for name in NAMES:
        put_into_feet(folder / f"{name}.laz")


def one_in_feet(folder: Path) -> None:
    put_into_feet(folder / "ST03.laz")


def all_empty_files(folder: Path) -> None:
    for name in NAMES:
        (folder / f"{name}.laz").write_bytes(b"")


def one_given_twice(folder: Path) -> None:
    shutil.copy(folder / "ST02.laz", folder / "ST04.laz")


SPOILED = {
    "all-in-feet": all_in_feet,
    "one-in-feet": one_in_feet,
    "all-empty": all_empty_files,
    "given-twice": one_given_twice,
}
REGISTERED = "registered-in-feet"


def site_cloud(site: Site, epoch: str) -> np.ndarray:  # type: ignore[type-arg]
    """The points (n, 3) of an epoch in the frame of the site, placed as stated."""
    placed = []
    for table in stations_of(site.text(), epoch):
        points_m = read_scan(site.folder / str(table["scan"])).points_m
        rotation = rotation_site_scanner(np.radians(table["heading_deg"]))
        placed.append(points_m @ rotation.T + np.array(table["position_m"]))
    return np.concatenate(placed)


@pytest.fixture(scope="module")
def spoiled(sound: Site, tmp_path_factory: pytest.TempPathFactory) -> Site:
    site = Site(tmp_path_factory.mktemp("spoiled") / "campaign")
    shutil.copytree(sound.folder, site.folder)
    text = site.text()
    stations = stations_of(text, SECOND)
    epochs = [epoch_text(FIRST, -1, stations_of(text, FIRST))]
    for month, (name, spoil) in enumerate(SPOILED.items()):
        shutil.copytree(site.folder / SECOND, site.folder / name)
        spoil(site.folder / name)
        tables = [{**table, "scan": f"{name}/{table['id']}.laz"} for table in stations]
        epochs.append(epoch_text(name, month, tables))
    write_las(site.folder / "merged.laz", site_cloud(site, FIRST) / FOOT_M)
    epochs.append(
        f'[[epochs]]\nid = "{REGISTERED}"\ntime = 2026-10-01T06:00:00Z\nregistered = "merged.laz"\n'
    )
    epochs.append(epoch_text(LAST, 11, stations))
    site.file.write_text(head_of(text) + "\n".join(epochs), encoding="utf-8")
    return site


@pytest.fixture(scope="module")
def told(spoiled: Site) -> Called:
    return spoiled.run("--scheme", "A", "--json")


def errors_of(told: Called, epoch: str) -> str:
    return "\n".join(state_of(told, epoch)["errors"])


def test_bad_epochs_end_with_exit_code_3_and_the_sound_ones_are_ok(told: Called, spoiled: Site) -> None:
    assert told.code == 3
    states = {
        FIRST: "ok",
        "all-in-feet": "failed",
        "one-in-feet": "degraded",
        "all-empty": "failed",
        "given-twice": "degraded",
        REGISTERED: "failed",
        LAST: "ok",
    }
    assert {epoch["epoch"]: epoch["state"] for epoch in told.answer["epochs"]} == states
    assert spoiled.states().items() >= states.items()


@pytest.mark.parametrize("epoch", ["all-in-feet", REGISTERED])
def test_feet_are_named_as_such_and_recorded(told: Called, spoiled: Site, epoch: str) -> None:
    assert re.search(
        r"preprocessing: .*look(s)? like feet: the shaft is found after scaling .*by 0\.3048, needed metres; "
        r"export (it|them) in metres",
        errors_of(told, epoch),
    )
    assert "feet" in str(spoiled.epoch(epoch).reason)
    assert spoiled.tilts(epoch) == {}


def test_one_station_in_feet_is_left_out_and_does_not_move_the_axis(told: Called, spoiled: Site) -> None:
    bad, sound = spoiled.tilts("one-in-feet")["A/robust"], spoiled.tilts(LAST)["A/robust"]
    states = {name: row.state for name, row in spoiled.stations("one-in-feet").items()}
    assert states == {**dict.fromkeys(NAMES, "ok"), "ST03": "failed"}
    assert spoiled.epoch("one-in-feet").n_stations_used == STATIONS - 1
    assert f"station ST03: {spoiled.stations('one-in-feet')['ST03'].reason}" in errors_of(told, "one-in-feet")
    # the same scans but one: within three standard deviations of what the points alone leave open
    tolerance = 3.0 * sound.point_cov_ee**0.5
    assert abs(bad.lean_east - sound.lean_east) < tolerance
    assert abs(bad.lean_north - sound.lean_north) < tolerance


def test_an_epoch_whose_stations_are_all_bad_has_failed_without_a_result(told: Called, spoiled: Site) -> None:
    epoch, stations = spoiled.epoch("all-empty"), spoiled.stations("all-empty")
    assert (epoch.state, epoch.n_stations_used, epoch.n_points_in) == ("failed", 0, 0)
    assert {row.state for row in stations.values()} == {"failed"}
    assert str(epoch.reason).endswith("no scan of the epoch could be read")
    assert spoiled.tilts("all-empty") == {}


def test_equal_bad_bytes_are_told_under_each_file_of_their_own(told: Called, spoiled: Site) -> None:
    # they have one digest, so the second to fifth answer come from the cache
    for name, row in spoiled.stations("all-empty").items():
        assert str(row.reason).startswith(f"{spoiled.folder / 'all-empty' / name}.laz: needs ")


def test_a_copy_of_a_scan_under_another_name_is_refused_and_the_first_one_used(
    told: Called, spoiled: Site
) -> None:
    stations = spoiled.stations("given-twice")
    assert (stations["ST02"].state, stations["ST04"].state) == ("ok", "failed")
    copy = spoiled.folder / "given-twice" / "ST04.laz"
    error = f"station ST04: {copy}: holds the same bytes as the scan of station ST02; name the right file"
    assert errors_of(told, "given-twice") == error


def test_a_scan_that_another_epoch_has_too_is_told(told: Called) -> None:
    (last,) = (epoch for epoch in told.answer["epochs"] if epoch["epoch"] == LAST)
    told_of = "station ST01: its scan is that of station ST01 of epoch "
    assert [note for note in last["notes"] if note.startswith(told_of)]
