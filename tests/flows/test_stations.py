"""Stations of an epoch that harm, that are doubled, or whose pose their scan file states."""

import pytest

from tasks.ingest import read_scan
from tasks.inspection import inspect_campaign
from tasks.settings import load_campaign
from tests.faults.sites import FIRST, Site, state_of
from tests.flows.calls import Called
from tests.flows.campaigns import small_campaign
from tests.flows.spoiled_stations import Epochs, Table, bend_shaft, write_ptx
from tests.unit.ingest.clouds import rows_of, write_text

ALL = ["ST01", "ST02", "ST03", "ST04", "ST05"]
BAD, OTHER_BAD = (80.0, 60.0), (-80.0, 60.0)
"""Lean of 100 arc seconds that a station sees too much; its few points leave some 5 of them open."""

IN_FILE, REFUSED, ONE_BAD, BOTH_BAD, HALF_BAD = "in-file", "refused", "one-bad", "both-bad", "half-bad"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory, prefect_api: str) -> Site:
    site = Site(tmp_path_factory.mktemp("stations"))
    small_campaign(site.folder, stations=len(ALL), points=20_000)
    epochs = Epochs(site)
    epochs.add(FIRST, epochs.tables())
    write_ptx(site, "all.ptx", epochs.tables(), (0.02, -0.01, 0.0))
    parts = enumerate(ALL, start=1)
    epochs.add(IN_FILE, [{"id": n, "scan": "all.ptx", "part": part, "pose": "file"} for part, n in parts])
    for epoch, stations, bad in (
        (ONE_BAD, ALL, {"ST02": BAD}),
        (BOTH_BAD, ALL[:2], {"ST02": BAD}),
        (HALF_BAD, ALL[:4], {"ST02": BAD, "ST04": OTHER_BAD}),
    ):
        copied = epochs.copy(epoch, stations)
        for table in copied:
            if table["id"] in bad:
                bend_shaft(site, table, *bad[str(table["id"])])
        epochs.add(epoch, copied)
    epochs.add(REFUSED, _refused(epochs))
    epochs.write()
    return site


def _refused(epochs: Epochs) -> list[Table]:
    """An epoch with a pose that no file states, one that is far away, and a scan that is in another file, too."""
    site, tables = epochs.site, {str(table["id"]): table for table in epochs.copy(REFUSED, ALL)}
    points_m = read_scan(site.folder / str(tables["ST01"]["scan"])).points_m
    write_text(site.folder / "ST01.xyz", rows_of(points_m))
    write_text(site.folder / "copy.csv", rows_of(points_m, ","))
    write_ptx(site, "far.ptx", [{**tables["ST03"], "position_m": [5e5, 0.0, 0.0]}], (0.0, 0.0, 0.0))
    return [
        {**tables["ST01"], "scan": "ST01.xyz"},
        {"id": "ST02", "scan": tables["ST02"]["scan"], "pose": "file"},
        {"id": "ST03", "scan": "far.ptx", "pose": "file"},
        {**tables["ST04"], "scan": "copy.csv"},
        tables["ST05"],
    ]


@pytest.fixture(scope="module")
def told(site: Site) -> Called:
    return site.run("--scheme", "A", "--json")


def states(site: Site, epoch: str) -> dict[str, str]:
    return {name: row.state for name, row in site.stations(epoch).items()}


def errors(told: Called, epoch: str) -> list[str]:
    return list(state_of(told, epoch)["errors"])  # type: ignore[call-overload]


def sigmas_apart(site: Site, epoch: str) -> float:
    """How far an epoch's lean is from that of the sound one, in standard deviations of its points alone."""
    one, sound = site.tilts(epoch)["A/robust"], site.tilts(FIRST)["A/robust"]
    apart = max(abs(one.lean_east - sound.lean_east), abs(one.lean_north - sound.lean_north))
    return apart / one.point_cov_ee**0.5


def test_a_station_that_leans_against_the_others_is_left_out_with_the_reason(
    told: Called, site: Site
) -> None:
    row, epoch = site.stations(ONE_BAD)["ST02"], site.epoch(ONE_BAD)
    assert states(site, ONE_BAD) == {**dict.fromkeys(ALL, "ok"), "ST02": "failed"}
    assert row.reason == (
        f"its side of the shaft leans {row.level_check_arcsec:.0f} arc seconds against the common one; left out; "
        "check its level (compensator) and set it up again"
    )
    assert (epoch.state, epoch.n_stations_used) == ("degraded", 4)
    assert errors(told, ONE_BAD) == [f"station ST02: {row.reason}"]


def test_the_rest_of_the_epoch_leans_as_if_the_bad_station_were_not_there(told: Called, site: Site) -> None:
    # four of the same five scans: within three standard deviations of what their points leave open
    assert sigmas_apart(site, ONE_BAD) < 3.0


def test_the_ledger_tells_what_was_tried_without_a_station(told: Called, site: Site) -> None:
    tried = site.query("select stage from runs where epoch = ? and stage like '%without%'", [ONE_BAD])
    assert tried == [("registration without ST02",), ("preprocessing without ST02",)]


def test_of_two_stations_that_disagree_both_are_named_and_used(told: Called, site: Site) -> None:
    assert states(site, BOTH_BAD) == {"ST01": "suspect", "ST02": "suspect"}
    assert site.epoch(BOTH_BAD).n_stations_used == 2
    for told_of in errors(told, BOTH_BAD):
        assert told_of.startswith(("station ST01 is suspect: ", "station ST02 is suspect: "))
        assert "of two stations either may be out" in told_of or "the scans cannot tell which" in told_of
        assert "check its level" in told_of or "check its compensator" in told_of


def test_half_of_the_stations_is_not_left_out_and_the_epoch_is_called_doubtful(
    told: Called, site: Site
) -> None:
    # two against two: nobody can say which two are right, only that something is wrong with a level
    assert "suspect" in states(site, HALF_BAD).values()
    assert site.epoch(HALF_BAD).n_stations_used == 4
    assert site.epoch(HALF_BAD).state == "degraded"
    for told_of in errors(told, HALF_BAD):
        assert "its side of the shaft leans " in told_of or "stated level is " in told_of


def test_tilted_scans_whose_poses_stand_in_their_file_lean_as_the_stated_ones(
    told: Called, site: Site
) -> None:
    assert states(site, IN_FILE) == dict.fromkeys(ALL, "ok")
    assert errors(told, IN_FILE) == []
    # the same points to 5e-6 m: only which points are redundant may differ
    assert sigmas_apart(site, IN_FILE) < 0.5
    by_file, by_campaign = site.stations(IN_FILE), site.stations(FIRST)
    for name in ALL:
        assert by_file[name].heading_deg == pytest.approx(by_campaign[name].heading_deg, abs=1e-3)
        # a tenth of its sigma: other points may stand for their voxels
        assert by_file[name].position_up_m == pytest.approx(by_campaign[name].position_up_m, abs=2.5e-3)


def test_parts_of_one_file_are_no_copies_of_each_other(told: Called, site: Site) -> None:
    assert not any("same bytes" in told_of for told_of in errors(told, IN_FILE))
    assert not any("is it the right file" in note for note in state_of(told, IN_FILE)["notes"])  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("station", "reason"),
    [
        (
            "ST02",
            'needs the pose of the scan for pose = "file", came a file that states none; write position_m',
        ),
        (
            "ST03",
            "needs a pose within 10000 m of the origin, came one 500000 m away; write frame.origin_m near",
        ),
        ("ST04", "holds the same points as the scan of station ST01; name the right file"),
    ],
)
def test_a_scan_that_cannot_be_placed_is_refused_with_the_reason(
    told: Called, site: Site, station: str, reason: str
) -> None:
    row = site.stations(REFUSED)[station]
    assert row.state == "failed"
    assert reason in str(row.reason)
    assert told.code == 3


def test_the_check_of_the_file_finds_no_fault_in_parts_and_poses(site: Site) -> None:

    problems = inspect_campaign(load_campaign(site.file)).problems
    assert [problem for problem in problems if f"epochs[{IN_FILE}]" in problem] == []
    assert any("is a copy of" in problem for problem in problems)


def test_a_row_of_a_station_says_how_its_stated_pose_fits(told: Called, site: Site) -> None:
    row = site.stations(FIRST)["ST01"]
    assert row.start == "as stated"
    assert row.correction_east_m is not None
    # a stated pose that is sound fits within five of its own standard deviations
    assert all(
        abs(value) < 5.0
        for value in (row.normalised_heading, row.normalised_east, row.normalised_north)
        if value is not None
    )
    assert site.stations(ONE_BAD)["ST02"].start is None


@pytest.mark.slow
def test_a_second_run_computes_nothing(told: Called, site: Site) -> None:
    again = site.run("--scheme", "A", "--json")
    assert again.answer["stages"]["computed"] == 0
