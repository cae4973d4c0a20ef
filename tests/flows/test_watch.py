"""A watch takes stations in as they arrive, and loses nothing."""

import json
import shutil
from pathlib import Path

import pytest

from tasks.settings.intake import read_intakes
from tests.flows.watched_sites import HEAD, Site, digest, in_inbox, in_scans, reasons, write_scan


def test_a_station_is_taken_in_when_it_has_settled(site: Site) -> None:
    path = site.send("ST01")
    sha256 = digest(path)
    site.watch.step()
    assert in_inbox(site) == ["ST01.csv", "ST01.toml"]
    site.now_s += 10.0
    site.watch.step()
    assert in_inbox(site) == []
    assert in_scans(site) == ["silo/2026-03/ST01.csv", "silo/2026-03/ST01.toml"]
    assert digest(site.folder / "inbox-scans" / "silo" / "2026-03" / "ST01.csv") == sha256
    (intake,) = read_intakes(site.workspace, "silo")
    assert intake.arrivals[0].sha256 == sha256
    assert intake.complete is None
    assert site.file.read_text() == HEAD


def test_the_crew_is_told_what_was_seen_and_what_is_missing(site: Site) -> None:
    site.send("ST01", 90.0, heading_deg=0.0)
    (preview,) = (event.facts for event in site.look() if event.kind == "preview")
    assert preview["covered_deg"] == pytest.approx(170.0, abs=15.0)
    ((first, last),) = preview["unseen_deg"]  # type: ignore[misc]
    assert (first, last) == (pytest.approx(170.0, abs=10.0), pytest.approx(10.0, abs=10.0))
    assert 180.0 < float(str(preview["next_azimuth_deg"])) < 360.0
    alone = float(str(preview["sigma_worst_arcsec"]))
    stored = json.loads((site.workspace / "previews" / "silo" / "2026-03.json").read_text())
    assert stored["covered_deg"] == preview["covered_deg"]
    site.send("ST02", 270.0, heading_deg=0.0)
    (preview,) = (event.facts for event in site.look() if event.kind == "preview")
    assert preview["covered_deg"] == pytest.approx(340.0, abs=20.0)
    assert float(str(preview["sigma_worst_arcsec"])) < alone


def test_a_station_without_a_stated_pose_is_taken_in_without_a_look(site: Site) -> None:
    site.send("ST01")
    events = site.look()
    assert [event.kind for event in events] == ["taken", "preview"]
    assert any("no position or heading is stated" in line for line in events[1].lines)


def test_a_scan_waits_for_its_sidecar_and_a_sidecar_for_its_scan(site: Site) -> None:
    write_scan(site.inbox / "ST01.csv", 0.0)
    site.send_sidecar("ST02")
    told = reasons(site.look(), "waiting")
    assert told == [
        "ST01.csv: waits for its sidecar ST01.toml",
        "ST02.toml: waits for its scan, a file of the same name with the suffix of a scan",
    ]
    assert site.look() == [], "it is said once"
    site.send_sidecar("ST01")
    assert "taken" in site.kinds()
    assert in_inbox(site) == ["ST02.toml"]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"haeding_deg": 3.0}, "unknown key; did you mean 'heading_deg'?"),
        ({"epoch": None}, "epoch: is required"),
        ({"sha256": "0" * 64}, "needed the digest 000000000000... by its sidecar"),
        ({"size_bytes": 7}, "needed 7 bytes by its sidecar"),
        ({"position_m": [400_000.0, 0.0, 0.0]}, "no scanner sees that far"),
        ({"pose": "file", "position_m": None}, 'which pose = "file" needs'),
    ],
)
def test_a_wrong_sidecar_is_told_and_everything_stays_where_it_is(
    site: Site, changes: dict[str, object], told: str
) -> None:
    site.send("ST01", **changes)
    (reason,) = reasons(site.look())
    assert told in reason
    assert site.look() == []
    assert in_inbox(site) == ["ST01.csv", "ST01.toml"]
    assert read_intakes(site.workspace, "silo") == ()
    site.send_sidecar("ST01")
    assert "taken" in site.kinds()


def test_a_scan_that_is_cut_short_stays(site: Site) -> None:
    site.send("ST01")
    path = site.inbox / "ST01.csv"
    path.rename(path.with_suffix(".las"))
    path.with_suffix(".las").write_bytes(b"LASF" + bytes(100))
    (reason,) = reasons(site.look())
    assert "ST01.las" in reason
    assert in_inbox(site) == ["ST01.las", "ST01.toml"]


def test_the_same_scan_under_another_name_is_not_counted(site: Site) -> None:
    site.send("ST01")
    site.look()
    site.send("ST02", 0.0)
    (told,) = reasons(site.look(), "duplicate")
    assert "ST02.csv: is the scan of station ST01 of epoch 2026-03, taken in as ST01.csv" in told
    assert in_inbox(site) == ["ST02.csv", "ST02.toml"]
    assert read_intakes(site.workspace, "silo")[0].arrived == ("ST01",)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"id": "ST01"}, "station ST01 of epoch 2026-03 is there already, with another scan"),
        ({"id": "st01"}, "station ST01 of epoch 2026-03 is there already"),
        ({"time": "2026-03-12T06:00:00Z"}, "all stations of an epoch have one time"),
        ({"of": ["ST02", "ST07"]}, "agree on one list"),
        ({"of": ["ST02", "ST03"]}, "but ST01 came before; list all of them"),
        ({"id": "ST09"}, "the sidecars before it list no station 'ST09'"),
    ],
)
def test_sidecars_that_contradict_each_other_are_told(
    site: Site, changes: dict[str, object], told: str
) -> None:
    site.send("ST01", of=["ST01", "ST02", "ST03"])
    site.look()
    site.send("ST02", 90.0, **changes)
    if "time" in changes:
        text = (site.inbox / "ST02.toml").read_text()
        (site.inbox / "ST02.toml").write_text(text.replace('"2026-03-12T06:00:00Z"', "2026-03-12T06:00:00Z"))
    (reason,) = reasons(site.look())
    assert told in reason
    assert in_inbox(site) == ["ST02.csv", "ST02.toml"]


def test_an_epoch_that_differs_by_its_case_alone_is_a_slip(site: Site) -> None:
    site.send("ST01", epoch="Spring")
    site.look()
    site.send("ST02", 90.0, epoch="spring")
    (reason,) = reasons(site.look())
    assert "there is an epoch 'Spring' (only the case differs)" in reason


def test_names_of_unfinished_files_and_strangers_are_left_alone(site: Site) -> None:
    for name in ("ST01.laz.part", ".ST01.laz.abc", "ST01.laz.filepart", "notes.docx"):
        (site.inbox / name).write_bytes(b"x")
    (reason,) = reasons(site.look(), "ignored")
    assert "notes.docx: is neither a scan" in reason
    assert len(in_inbox(site)) == 4


def test_stations_of_two_epochs_may_come_in_folders(site: Site) -> None:
    site.send("ST01", 0.0, into="a", epoch="2026-03")
    site.send("ST01", 90.0, into="b", epoch="2026-06", time="T")
    text = (site.inbox / "b" / "ST01.toml").read_text()
    (site.inbox / "b" / "ST01.toml").write_text(text.replace('"T"', "2026-06-11T06:00:00Z"))
    site.look()
    assert [intake.epoch for intake in read_intakes(site.workspace, "silo")] == ["2026-03", "2026-06"]


def test_files_that_are_to_stay_stay_and_are_known_after_a_restart(tmp_path: Path) -> None:
    site = Site(tmp_path, keeps=True)
    site.send("ST01")
    site.look()
    assert in_inbox(site) == ["ST01.csv", "ST01.toml"]
    site.begin()
    assert site.kinds() == []
    assert len(read_intakes(site.workspace, "silo")[0].stations) == 1


def test_when_the_workspace_is_lost_the_scans_and_sidecars_bring_the_epochs_back(tmp_path: Path) -> None:
    site = Site(tmp_path)
    site.send("ST01", of=["ST01", "ST02"])
    site.send("ST02", 90.0)
    site.look()
    site.watch.stop()
    before = read_intakes(site.workspace, "silo")[0]
    shutil.rmtree(site.workspace)
    again = Site(tmp_path, keeps=True)
    again.inbox.rmdir()
    again.inbox.symlink_to(tmp_path / "inbox-scans" / "silo")
    again.look()
    again.watch.stop()
    (after,) = read_intakes(site.workspace, "silo")
    assert (after.stations, after.complete) == (before.stations, "stations")
    assert len(in_scans(site)) == 4


def test_a_watch_that_was_killed_between_copy_and_note_goes_on(site: Site) -> None:
    path = site.send("ST01")
    target = site.folder / "inbox-scans" / "silo" / "2026-03" / "ST01.csv"
    target.parent.mkdir(parents=True)
    target.write_bytes(path.read_bytes())
    assert "taken" in site.kinds()
    assert in_scans(site) == ["silo/2026-03/ST01.csv", "silo/2026-03/ST01.toml"]


def test_what_the_disk_refused_is_tried_again_without_being_sent_again(site: Site) -> None:
    site.send("ST01")
    target = site.folder / "inbox-scans" / "silo" / "2026-03" / "ST01.csv"
    target.parent.mkdir(parents=True)
    target.write_bytes(b"something else")
    assert "is there already and holds something else; move it away" in reasons(site.look())[0]
    assert site.look() == []
    target.rename(target.with_suffix(".old"))
    assert "taken" in site.kinds()
    assert target.with_suffix(".old").read_bytes() == b"something else"


def test_one_file_that_cannot_be_read_stops_no_other(site: Site) -> None:
    site.send("ST01")
    (site.inbox / "ST00.csv").write_bytes(b"\xff\xfe" * 50)
    site.send_sidecar("ST00")
    events = site.look()
    assert {"taken", "kept"} <= {event.kind for event in events}


def test_an_inbox_that_is_away_is_looked_for_again(site: Site) -> None:
    site.inbox.rename(site.folder / "away")
    assert "check that the folder or share is there" in reasons(site.look(), "error")[0]
    (site.folder / "away").rename(site.inbox)
    site.send("ST01")
    assert "taken" in site.kinds()
