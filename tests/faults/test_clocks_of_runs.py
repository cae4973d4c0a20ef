"""Real commands under other clocks and time zones: the same results, the same files, nothing lost."""

import os
import signal
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from storage.run_record import folder_of
from storage.workspace import Workspace
from tests.faults.clocks.clock import YEAR_S, Clock, why_not
from tests.faults.conftest import copy_of
from tests.faults.full_site import runs_in_ledger
from tests.faults.killing.stored import Content, content_of, left_behind
from tests.faults.sites import SECOND, Site
from tests.flows.watched_sites import Site as WatchedSite
from tests.flows.watched_sites import in_inbox

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(why_not() is not None and os.environ.get("CI") != "true", reason=str(why_not())),
]

# one that skipped a day, one with half an hour, one with a quarter, one that is none
ELSEWHERE = [
    ("Pacific/Apia", -YEAR_S),
    ("America/St_Johns", 12 * YEAR_S),
    ("Asia/Kathmandu", -3600),
    ("No/Zone", -40 * YEAR_S),
]

DAY_S = 86_400


@pytest.fixture
def clock(tmp_path: Path) -> Clock:
    return Clock(tmp_path / "clock")


@pytest.mark.parametrize(("zone", "shift_s"), ELSEWHERE)
def test_a_run_gives_the_same_results_under_every_clock_and_zone(
    unpublished: Site, sound: Site, clock: Clock, zone: str, shift_s: int
) -> None:
    clock.set(shift_s)
    done = clock.call(unpublished, "run", "--json", zone=zone)
    assert done.code == 0, done.err
    assert results(unpublished) == results(sound)
    again = clock.call(unpublished, "run", "--only-new", "--json", zone=zone)
    assert again.answer["stages"]["computed"] == 0
    # files dated up to a day ahead may hide a change, and are looked at each time
    is_settled = abs(shift_s) > DAY_S
    unchanged = f"unchanged since run {done.answer['run']}"
    assert {unchanged in epoch["notes"] for epoch in again.answer["epochs"]} == {is_settled}, again.err
    assert left_behind(Workspace(unpublished.workspace)) == []


def test_files_for_others_are_the_same_bytes_under_every_clock_and_zone(
    published: Site, clock: Clock, tmp_path: Path
) -> None:
    here = files_for_others(published, clock, tmp_path / "0", "UTC")
    for number, (zone, shift_s) in enumerate(ELSEWHERE[::3], start=1):
        clock.set(shift_s)
        assert files_for_others(published, clock, tmp_path / str(number), zone) == here, zone


def test_a_clock_that_was_years_ahead_turns_no_order_and_loses_nothing(published: Site, clock: Clock) -> None:
    before = results(published)
    ids = [max(runs_in_ledger(published.workspace))]
    for shift_s in (9 * YEAR_S, 0, -YEAR_S):
        clock.set(shift_s)
        done = clock.call(published, "run", "--json")
        assert done.code == 0, done.err
        ids.append(done.answer["run"])
    assert ids == sorted(ids)
    assert runs_in_ledger(published.workspace) >= set(ids)
    assert results(published) == before
    clock.set(0)
    told = clock.call(published, "verify", "--deep")
    assert told.code == 0, told.out
    assert left_behind(Workspace(published.workspace)) == []


def test_a_clock_that_is_set_during_a_run_changes_nothing(sound: Site, clock: Clock, tmp_path: Path) -> None:
    with_one, with_many = (anew(sound, tmp_path / name) for name in ("one", "many"))
    words = ("run", "--epoch", SECOND, "--scheme", "S")
    done = clock.call(with_one, *words)
    assert done.code == 0, done.err
    process = clock.start(with_many, *words)
    seen, end_s = 0, time.monotonic() + 300
    while process.poll() is None and time.monotonic() < end_s:
        lines = _lines(with_many)
        if lines > seen:
            seen = lines
            clock.set((-3600, YEAR_S, -2 * YEAR_S, 5)[lines % 4])
        time.sleep(0.02)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, out + err
    assert seen > 3
    assert results(with_many) == results(with_one)
    took = with_many.query("select seconds from runs where seconds is not null")
    assert took
    assert all(0.0 <= seconds < 300.0 for (seconds,) in took)
    assert left_behind(Workspace(with_many.workspace)) == []


def test_a_watch_takes_stations_in_while_the_clock_is_set(clock: Clock, tmp_path: Path) -> None:
    site = WatchedSite(tmp_path / "silo")
    site.send("ST01")
    pace = ("--interval-s", "0.2", "--settle-s", "2")
    process = clock.start(Site(site.folder), "watch", "--inbox", site.inbox, *pace, file=site.file)
    try:
        began_s, turn = time.monotonic(), 0
        while (
            ".csv" in "".join(in_inbox(site)) and time.monotonic() < began_s + 120 and process.poll() is None
        ):
            turn += 1
            clock.set((0, -3600, YEAR_S, -YEAR_S)[turn % 4])
            time.sleep(0.3)
    finally:
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert not any(name.endswith(".csv") for name in in_inbox(site)), out + err
    (taken,) = (site.folder / "ws" / "intake").rglob("*.toml")
    assert "ST01" in taken.read_text(encoding="utf-8")


def anew(site: Site, folder: Path) -> Site:
    """A copy in which nothing was computed yet."""
    copy = copy_of(site, folder)
    copy.workspace.rename(folder / "unused")
    return copy


def results(site: Site) -> Content:
    """All results; what is remembered of their files is none."""
    found = content_of(Workspace(site.workspace))
    kept = [name for name in found.artifacts if not name.endswith("verified.txt")]
    return Content(found.epochs, found.series, found.alarms, kept, found.versions)


def files_for_others(site: Site, clock: Clock, folder: Path, zone: str) -> Mapping[str, bytes]:
    """Report and exports of a site, as they are made in a time zone."""
    folder.mkdir()
    asked: Sequence[tuple[object, ...]] = [
        ("report", "--html", folder / "report.html", "--pdf", folder / "report.pdf"),
        *(
            ("export", what, "--format", form, "--out", folder / f"{what}.{form}")
            for what, form in [
                ("epochs", "csv"),
                ("runs", "json"),
                ("tilt", "parquet"),
                ("axis", "dxf"),
                ("axis", "geojson"),
                ("cloud", "las"),
            ]
        ),
    ]
    for words in asked:
        done = clock.call(site, *words, zone=zone)
        assert done.code == 0, done.err
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def _lines(site: Site) -> int:
    """How many lines the journal of a run has."""
    journals = folder_of(Workspace(site.workspace)).glob("*.jsonl")
    return sum(path.read_bytes().count(b"\n") for path in journals)
