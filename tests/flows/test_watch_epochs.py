"""When an epoch of a watch is complete, what it then does, and what the alarms hear meanwhile."""

import time
from datetime import timedelta

from storage.intake import read_run_note
from storage.views import alarm_rows
from storage.workspace import open_workspace
from tasks.settings.intake import load_with_intake, read_intakes
from tests.flows.watched_sites import HEAD, Site, in_scans, reasons, write_scan

LISTED = """\
[[epochs]]
id = "2026-03"
time = 2026-03-11T06:00:00Z
[[epochs.stations]]
id = "ST01"
scan = "2026-03/ST01.csv"
[[epochs.stations]]
id = "ST02"
scan = "2026-03/ST02.csv"
heading_deg = 0.0
"""


def load_epochs(site: Site) -> list[str]:
    """Epochs that the other commands see."""
    if not any(intake.complete for intake in read_intakes(site.workspace, "silo")):
        return []
    return [epoch.id for epoch in load_with_intake(site.file, site.workspace).epochs]


def test_an_epoch_is_complete_when_the_stations_that_sidecars_list_are_there(site: Site) -> None:
    site.send("ST01", of=["ST01", "ST02"])
    events = site.look()
    assert events[1].facts["missing_stations"] == ["ST02"]
    assert load_epochs(site) == []
    site.send("ST02", 90.0)
    assert "complete" in site.kinds()
    assert load_epochs(site) == ["2026-03"]


def test_an_epoch_is_complete_when_its_marker_says_so_and_nothing_is_on_its_way(site: Site) -> None:
    (site.inbox / "2026-03.complete").touch()
    assert "waits for the first station of epoch '2026-03'" in reasons(site.look(), "waiting")[0]
    site.send("ST01")
    site.look()
    (site.inbox / "ST02.csv.part").write_bytes(b"on its way")
    assert load_epochs(site) == ["2026-03"], "the marker was there before anything else was on its way"
    assert "silo/2026-03/2026-03.complete" in in_scans(site)


def test_a_marker_says_which_scans_it_leaves_out(site: Site) -> None:
    site.send("ST01")
    site.send("ST02", 90.0, epoch=None)
    (site.inbox / "2026-03.complete").touch()
    (line,) = reasons(site.look(), "complete")
    assert line.endswith("still in the inbox: ST02.csv")
    site.send_sidecar("ST02", 90.0)
    (taken,) = reasons(site.look(), "taken")
    assert "its epoch was complete before, and is processed again" in taken


def test_a_marker_waits_for_what_is_still_being_written(site: Site) -> None:
    site.send("ST01")
    site.look()
    (site.inbox / "2026-03.complete").touch()
    part = site.inbox / "ST02.csv.part"
    for size in range(3):
        part.write_bytes(b"x" * (size + 1))
        site.watch.step()
        site.now_s += 10.0
        assert load_epochs(site) == []
    site.look()
    assert load_epochs(site) == ["2026-03"]


def test_scans_of_an_epoch_that_the_file_lists_go_where_it_awaits_them(site: Site) -> None:
    site.file.write_text(HEAD + LISTED)
    site.send("ST01", 0.0)
    site.send("ST03", 45.0)
    events = site.look()
    assert "without a station 'ST03'" in reasons(events)[0]
    assert (site.folder / "2026-03" / "ST01.csv").is_file()
    site.send("ST02", 90.0, heading_deg=7.0)
    assert "heading_deg is 7.0 in the sidecar and 0.0 in the campaign file" in reasons(site.look())[0]
    site.send_sidecar("ST02", 90.0)
    assert "complete" in site.kinds()
    (epoch,) = load_with_intake(site.file, site.workspace).epochs
    assert [station.scan for station in epoch.stations] == ["2026-03/ST01.csv", "2026-03/ST02.csv"]
    assert epoch.stations[0].position_m == (0.0, 60.0, 1.5)


def test_an_epoch_that_the_file_has_with_other_scans_is_not_mixed_up(site: Site) -> None:
    site.file.write_text(HEAD + LISTED)
    (site.folder / "2026-03").mkdir()
    write_scan(site.folder / "2026-03" / "ST01.csv", 200.0)
    site.send("ST01")
    (reason,) = reasons(site.look())
    assert "the campaign file has the scan of station ST01 of epoch 2026-03 already" in reason
    site.file.write_text(HEAD + LISTED[: LISTED.index("[[epochs.st")] + 'registered = "2026-03/all.laz"\n')
    (reason,) = reasons(site.look())
    assert "as one registered cloud" in reason


def test_a_run_that_takes_too_long_is_ended_and_the_watch_goes_on(site: Site) -> None:
    site.send("ST01", of=["ST01"])
    kinds = site.kinds()
    assert kinds[-1] == "run-started"
    time.sleep(0.6)
    (ended,) = reasons(site.look(), "error")
    assert "stopped at its time limit of 0.5 s" in ended
    note = read_run_note(open_workspace(site.workspace), "silo", "2026-03")
    assert note is not None
    assert note["timed_out"] is True
    assert "run-started" not in site.kinds(), "not again and again"
    site.begin()
    assert "run-started" in site.kinds(), "but once after a restart"
    site.send("ST02", 90.0, epoch="2026-06")
    assert "taken" in site.kinds()


def test_a_late_station_raises_its_alarm_while_the_crew_can_still_go_back(site: Site) -> None:
    site.file.write_text(HEAD + '[[alarms]]\nid = "late"\nwhen = "late-station"\nhours = 2.0\n')
    site.send("ST01", of=["ST01", "ST02"])
    site.look()
    assert alarm_rows(open_workspace(site.workspace), "silo") == []
    site.now += timedelta(hours=3)
    site.begin()
    assert reasons(site.look(), "error") == []
    (alarm,) = alarm_rows(open_workspace(site.workspace), "silo")
    assert alarm.eased_at is None
    assert (alarm.rule, alarm.epoch, alarm.state) == ("late", "2026-03", "new")
    site.now += timedelta(hours=1)
    site.send("ST02", 90.0)
    site.begin()
    site.look()
    # the run of the epoch reaches its time limit: while one is under way, it is the run that looks at alarms
    time.sleep(0.6)
    site.look()
    assert alarm_rows(open_workspace(site.workspace), "silo")[0].eased_at is not None
