"""Clocks that are set back or were years ahead: nothing lost, nothing silent, nothing kept for ever."""

import hashlib
import importlib
import os
import time
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from flows import recovery
from flows.faults import keep_log
from flows.ledger import new_run_id
from flows.old_homes import UNUSED_S, sweep_old_homes
from flows.terminal import Terminal, use_terminal
from storage.alarm_log import UNNUMBERED, append_alarm_event, append_alarm_events
from storage.artifacts import is_whole, put_array
from storage.atomic import TEMP_SUFFIX
from storage.errors import InputError
from storage.parquet import encode_rows, read_rows
from storage.publish import stale_temps
from storage.records import TiltRow
from storage.run_record import may_live, record_of_this_process, write_record
from storage.store import Content
from storage.store_cache import StoreCache
from storage.verified import stamp_of, would_show_change
from storage.workspace import Workspace, open_workspace
from tasks.lean_series import stored_series
from tasks.trend_rows import chart_rows, trend_rows
from tests.storage.campaign import HEIGHT_M, STRUCTURE, alarm_event_row, tilt_row
from tests.unit.settings.campaign_text import WHOLE, edited, load

YEAR = timedelta(days=366)
START = datetime(2025, 1, 1, 6, tzinfo=UTC)
STATED = "2025-03-14T06:00:00+08:00"
DAY_S = 86_400.0


@pytest.fixture
def ws(tmp_path: Path) -> Workspace:
    return open_workspace(tmp_path / "ws")


def date(path: Path, ahead_s: float) -> Path:
    """Give a file a time of so many seconds ahead of now."""
    os.utime(path, times=(time.time() + ahead_s,) * 2)
    return path


@pytest.mark.parametrize(
    ("ahead_s", "trusted"),
    [(-0.5, False), (0.5, False), (3600.0, False), (-3.0, True), (2 * DAY_S, True), (5000 * DAY_S, True)],
)
def test_a_file_is_hashed_again_only_where_its_date_may_hide_a_change(
    tmp_path: Path, ahead_s: float, trusted: bool
) -> None:
    stamp = stamp_of(date(_file(tmp_path / "scan.laz"), ahead_s))
    assert stamp is not None
    assert would_show_change(stamp) is trusted


@pytest.mark.parametrize("seconds", [-1e9, 0.0, 315_532_800.0])
def test_a_file_of_1938_1970_or_1980_is_as_old_as_any(tmp_path: Path, seconds: float) -> None:
    path = _file(tmp_path / "scan.laz")
    os.utime(path, times=(seconds, seconds))
    stamp = stamp_of(path)
    assert stamp is not None
    assert would_show_change(stamp)


def test_artifacts_of_a_clock_that_was_years_ahead_are_hashed_once(ws: Workspace) -> None:
    ref = put_array(ws, "x", importlib.import_module("numpy").arange(10.0))
    (path,) = ws.artifacts.glob("*/*")
    (ws.artifacts / "verified.txt").unlink(missing_ok=True)
    date(path, 400 * DAY_S)
    assert is_whole(ws, ref)
    assert path.name in (ws.artifacts / "verified.txt").read_text(encoding="ascii")


@pytest.mark.parametrize(("ahead_s", "swept"), [(3600.0, False), (400 * DAY_S, True), (-400 * DAY_S, True)])
def test_a_temp_of_nobody_known_is_swept_also_where_its_date_lies_ahead(
    ws: Workspace, ahead_s: float, swept: bool
) -> None:
    temp = date(_file(ws.artifacts / f"x.00000000-1.{'0' * 32}{TEMP_SUFFIX}"), ahead_s)
    assert (temp in stale_temps(ws)) is swept


def test_the_cache_keeps_its_limit_and_what_is_in_use_after_the_clock_was_set_back(tmp_path: Path) -> None:
    cache = StoreCache(tmp_path / "cache", limit_bytes=1000)
    of_the_future = [_cached(cache, tmp_path, bytes([number]) * 400) for number in range(4)]
    for name in of_the_future:
        date(cache.root / name, 300 * DAY_S)
    present = _cached(cache, tmp_path, b"now" * 100)
    cache.make_room()
    assert (cache.root / present).is_file()
    assert sum((cache.root / name).is_file() for name in of_the_future) == 1


def test_events_sort_as_they_came_however_many_follow_a_clock_that_was_years_ahead(ws: Workspace) -> None:
    now = datetime(2026, 3, 1, 6, tzinfo=UTC)
    ahead = replace(alarm_event_row(UNNUMBERED, "raised"), happened_at=now + 9 * YEAR)
    (first,) = append_alarm_events(ws, [ahead])
    last_of_time = first.event.replace("-0000", "-9998")
    append_alarm_event(ws, replace(ahead, event=last_of_time))
    later = append_alarm_events(ws, [replace(ahead, action="updated", happened_at=now)] * 3)
    ids = [first.event, last_of_time, *(row.event for row in later)]
    assert sorted(set(ids)) == ids
    assert {row.happened_at for row in later} == {now}


def test_ids_of_runs_sort_as_they_began_after_the_clock_was_set_back(ws: Workspace) -> None:
    first = new_run_id(ws, STRUCTURE)
    ahead = f"{datetime.now(UTC) + 9 * YEAR:%Y%m%dT%H%M%SZ}-ffffff"
    write_record(ws, record_of_this_process(ahead, STRUCTURE, "own"))
    second = new_run_id(ws, STRUCTURE)
    write_record(ws, record_of_this_process(second, STRUCTURE, "own"))
    third = new_run_id(ws, STRUCTURE)
    assert [first, ahead, second, third] == sorted([first, ahead, second, third])


def test_an_id_of_a_run_that_tells_no_time_does_not_count(ws: Workspace) -> None:
    write_record(ws, record_of_this_process("zzz-by-hand", STRUCTURE, "own"))
    assert new_run_id(ws, STRUCTURE).startswith(f"{datetime.now(UTC):%Y}")


def test_a_run_lives_though_the_clock_was_set_since_it_began(monkeypatch: pytest.MonkeyPatch) -> None:
    record = record_of_this_process("run-1", STRUCTURE, "own")
    psutil = importlib.import_module("psutil")
    began = psutil.boot_time()
    # the system reckons the time of the boot back from the clock
    monkeypatch.setattr(psutil._psplatform, "boot_time", lambda: began - 3600.0)
    assert may_live(record)
    assert not may_live(replace(record, boot="another"))


@pytest.mark.parametrize(("ahead", "waits"), [(YEAR, False), (timedelta(minutes=-1), True), (-YEAR, False)])
def test_the_end_of_a_run_is_not_awaited_until_the_clock_has_caught_up(ahead: timedelta, waits: bool) -> None:
    record = record_of_this_process("run-1", STRUCTURE, "own")
    ended = replace(record, ended_at=(datetime.now(UTC) + ahead).isoformat())
    assert recovery._may_tell_itself(ended) is waits


def test_homes_dated_far_ahead_are_swept_too(tmp_path: Path) -> None:
    home = tmp_path / "old"
    home.mkdir()
    date(_file(home / "prefect.db"), 2 * UNUSED_S)
    date(home, 2 * UNUSED_S)
    sweep_old_homes(tmp_path, tmp_path / "own")
    assert not home.exists()


def test_two_faults_of_one_second_are_two_logs(tmp_path: Path) -> None:
    use_terminal(Terminal(log_folder=tmp_path))
    try:
        kept = [keep_log(f"fault {number}") for number in range(3)]
    finally:
        use_terminal(Terminal())
    assert [Path(path).read_text(encoding="utf-8")[-7:] for path in kept] == ["fault 0", "fault 1", "fault 2"]


@pytest.mark.parametrize(
    ("stated", "instant"),
    [
        ("2025-03-30T01:59:59+01:00", "2025-03-30T00:59:59+00:00"),
        (
            "2025-03-30T02:30:00+01:00",
            "2025-03-30T01:30:00+00:00",
        ),  # not on any clock of Berlin, an instant all the same
        ("2025-10-26T02:30:00+02:00", "2025-10-26T00:30:00+00:00"),
        ("2025-10-26T02:30:00+01:00", "2025-10-26T01:30:00+00:00"),
        ("2011-12-30T12:00:00+14:00", "2011-12-29T22:00:00+00:00"),  # the day that Apia skipped
        ("2025-03-30T02:30:00-03:30", "2025-03-30T06:00:00+00:00"),
        ("2025-03-30T02:30:00+05:45", "2025-03-29T20:45:00+00:00"),
        ("2024-02-29T23:59:59.999999Z", "2024-02-29T23:59:59.999999+00:00"),
        ("1969-12-31T23:59:59.5Z", "1969-12-31T23:59:59.500000+00:00"),
        ("2038-01-19T03:14:08Z", "2038-01-19T03:14:08+00:00"),
    ],
)
def test_a_time_with_its_offset_is_that_instant_also_when_stored(
    ws: Workspace, stated: str, instant: str
) -> None:
    when = load(ws.root, edited(STATED, stated, WHOLE)).epochs[0].time
    assert when == datetime.fromisoformat(instant)
    path = ws.root / "row.parquet"
    path.write_bytes(encode_rows("tilt", TiltRow, [replace(tilt_row("e1"), epoch_time=when)]))
    (row,) = read_rows(path, "tilt", TiltRow)
    assert row.epoch_time.isoformat() == instant


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        ("2025-03-30T02:30:00", "needs an offset from UTC"),
        ("2025-03-30", "needs a date and time with an offset from UTC"),
        ("1741903200", "needs a date and time with an offset from UTC"),
        ('"2025-03-30T02:30:00+01:00"', "without quotes"),
        ("2025-02-29T12:00:00Z", "line 22, column 8: invalid date or datetime"),
        ("2016-12-31T23:59:60Z", "line 22, column 18"),
        ("1959-12-31T23:59:59Z", "needs a year from 1960 to 2200"),
    ],
)
def test_a_time_that_is_no_instant_is_refused(tmp_path: Path, stated: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load(tmp_path, edited(STATED, stated, WHOLE))


@pytest.mark.parametrize(("first", "days"), [(2023, 365), (2024, 366)])
def test_a_rate_is_one_per_365_and_a_quarter_days_in_leap_years_too(first: int, days: int) -> None:
    began = datetime(first, 1, 1, tzinfo=UTC)
    lean = 1e-4
    rows = [
        replace(tilt_row(f"e{n}", n, (n * lean, 0.0)), epoch_time=began + n * timedelta(days=days))
        for n in range(4)
    ]
    (trend,) = trend_rows(rows)
    assert trend.rate_m_per_year == pytest.approx(HEIGHT_M * lean * 365.25 / days, rel=1e-9)


@pytest.mark.parametrize("apart", [timedelta(microseconds=1), timedelta(seconds=0.4), timedelta(hours=2)])
def test_epochs_of_one_day_have_no_rate_and_a_chart(apart: timedelta) -> None:
    rows = [replace(tilt_row(f"e{n}", n, (1e-5 * n, 0.0)), epoch_time=START + n * apart) for n in range(8)]
    (trend,) = trend_rows(rows)
    assert (trend.rate_m_per_year, trend.model) == (None, "level")
    assert "no rate: 8 epochs within" in str(trend.reason)
    assert [row.epoch for row in chart_rows(rows)] == [f"e{n}" for n in range(1, 8)]


def test_epochs_on_both_sides_of_a_change_of_clocks_come_in_the_order_of_their_instants() -> None:
    times = ["2025-10-26T02:50:00+02:00", "2025-10-26T02:10:00+01:00", "2025-10-26T01:30:00+00:00"]
    rows = [
        replace(tilt_row(f"e{n}"), epoch_time=datetime.fromisoformat(time)) for n, time in enumerate(times)
    ]
    (made,) = stored_series(rows[::-1], {})
    assert [row.epoch for row in made.rows] == ["e0", "e1", "e2"]
    assert (made.series.times * 365.25 * 24 * 60).round(6).tolist() == [0.0, 20.0, 40.0]


def _file(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"content")
    return path


def _cached(cache: StoreCache, folder: Path, content: bytes) -> str:
    sha256 = hashlib.sha256(content).hexdigest()
    temp = folder / "temp"
    temp.write_bytes(content)
    name = f"artifacts/{sha256[:2]}/{sha256}"
    cache.take(name, temp, Content(sha256, len(content)))
    return name
