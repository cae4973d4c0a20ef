"""The command ``tiltwatch watch``: its words, its answers, its end."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from flows.child_process import started_child
from storage.locks import watch_lock
from storage.workspace import open_workspace
from tasks.settings.toml_text import toml_text
from tests.flows.calls import ROOT, call
from tests.flows.campaigns import rows, run, small_campaign
from tests.flows.watched_sites import Site


def test_a_second_watch_of_an_inbox_is_refused(site: Site, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("watch", site.file, "--inbox", site.inbox, "--once")
    # the lock may be taken again by the thread that holds it, so another process holds it here
    holder = (
        "import sys; from pathlib import Path; from storage.locks import watch_lock; "
        "from storage.workspace import open_workspace\n"
        "with watch_lock(open_workspace(Path(sys.argv[1])), 'silo', Path(sys.argv[2])):\n"
        " print('held', flush=True); sys.stdin.read()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", holder, site.workspace, site.inbox],
        cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"held\n"
        for place in (site.workspace, site.folder / "another workspace"):
            called = call(capsys, *words, "--workspace", place)
            assert called.code == 3
            assert "is in use" in called.err
    finally:
        process.communicate(timeout=30)
    with watch_lock(open_workspace(site.workspace), "silo", site.inbox):
        pass


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--inbox", "s3://bucket/x", "--keep"), "--keep is for folders"),
        (("--inbox", "in", "--move"), "--move is for objects on S3"),
        (("--inbox", "in", "--listen", "127.0.0.1:0"), "needs a token"),
        (("--inbox", "in", "--interval-s", "0"), "--interval-s needs seconds above 0"),
        (("--inbox", "in", "--settle-s", "-1"), "--settle-s needs seconds from 0 on"),
        ((), "--inbox"),
    ],
)
def test_words_that_do_not_fit_are_refused(
    site: Site,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    told: str,
) -> None:
    monkeypatch.chdir(site.folder)
    called = call(capsys, "watch", site.file, *words)
    assert (called.code, told in called.err) == (2, True), called.err


def test_one_pass_that_keeps_something_says_so_by_its_exit_code(
    site: Site, capsys: pytest.CaptureFixture[str]
) -> None:
    site.send("ST01", epoch=None)
    called = call(capsys, "watch", site.file, "--inbox", site.inbox, "--once", "--settle-s", "0")
    assert called.code == 3
    assert "kept: ST01.csv" in called.err


def test_one_pass_takes_in_what_is_there_and_answers_a_line_an_event(
    site: Site, capsys: pytest.CaptureFixture[str]
) -> None:
    site.send("ST01")
    called = call(
        capsys,
        "watch",
        site.file,
        "--inbox",
        site.inbox,
        "--once",
        "--json",
        "--settle-s",
        "0.2",
        "--interval-s",
        "0.1",
    )
    events = [json.loads(line) for line in called.out.splitlines()]
    assert [event["event"] for event in events] == ["started", "taken", "preview", "stopped"]
    assert (called.code, events[-1]["ok"], events[1]["station"]) == (0, True, "ST01")
    log = site.folder / "tiltwatch-data" / "logs" / "watch-silo.jsonl"
    assert [json.loads(line)["event"] for line in log.read_text().splitlines()] == [
        "started",
        "taken",
        "preview",
    ]


@pytest.mark.slow
def test_an_epoch_from_the_inbox_gives_what_the_same_epoch_in_the_campaign_file_gives(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], prefect_api: str
) -> None:
    """Each station on its own, the last with the marker; two whole runs of the flow."""
    assert prefect_api
    plain = small_campaign(tmp_path / "plain", stations=3)
    run(plain, tmp_path / "plain" / "workspace")
    raw = tomllib.loads(plain.read_text())
    (epoch,) = raw["epochs"]
    file, inbox = tmp_path / "fed" / "campaign.toml", tmp_path / "fed" / "inbox"
    inbox.mkdir(parents=True)
    file.write_text(plain.read_text().split("[[epochs]]")[0])
    words = ("watch", file, "--inbox", inbox, "--once", "--json", "--settle-s", "0.2", "--interval-s", "0.2")
    for number, station in enumerate(epoch["stations"], start=1):
        sidecar = {key: value for key, value in station.items() if key not in {"id", "scan"}}
        shutil.copy(plain.parent / station["scan"], inbox)
        text = toml_text("", {"epoch": epoch["id"], "time": epoch["time"], **sidecar})
        (inbox / f"{station['id']}.toml").write_text(text)
        if number == len(epoch["stations"]):
            (inbox / f"{epoch['id']}.complete").touch()
        called = call(capsys, *words)
    kinds = [json.loads(line)["event"] for line in called.out.splitlines()]
    assert kinds == ["started", "taken", "preview", "complete", "run-started", "run-ended", "stopped"], called
    fed, expected = (
        rows(folder, "tilt", epoch["id"])
        for folder in (tmp_path / "fed" / "tiltwatch-data", tmp_path / "plain" / "workspace")
    )
    assert [row.lean_east for row in fed] == [row.lean_east for row in expected]
    assert call(capsys, "status", file, "--json").answer["epoch"] == epoch["id"]
    again = call(capsys, *words)
    assert [json.loads(line)["event"] for line in again.out.splitlines()] == ["started", "stopped"]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such signal")
def test_told_to_end_it_ends_with_130_and_leaves_no_lock(site: Site) -> None:
    words = [
        "watch",
        str(site.file),
        "--inbox",
        str(site.inbox),
        "--json",
        "--workspace",
        str(site.workspace),
    ]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with started_child([sys.executable, "-m", "flows.cli", *words], environment=environment) as child:
        log = site.workspace / "logs" / "watch-silo.jsonl"
        while not log.exists() and child.running:
            time.sleep(0.05)
        child.process.send_signal(signal.SIGTERM)
        child.process.wait(30)
        outcome = child.outcome()
    assert outcome.exit_code == 130, outcome
    assert json.loads(outcome.stdout.splitlines()[-1])["event"] == "stopped"
    with watch_lock(open_workspace(site.workspace), "silo", site.inbox):
        pass
