"""The members of the crowd that live as long as it does: the watch with its senders, the reader, the dashboard."""

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import psutil

from dashboard.page import pages
from tests.browser.served import serve_dashboard
from tests.browser.visitors import Visitor
from tests.faults.crowding.crowd import WRONG_WORDS, Crowd, command_line, environment
from tests.faults.crowding.site import IN_FILE
from tests.flows.calls import ROOT
from tests.flows.campaigns import STRUCTURE

STOP_S: Final = 120.0
STOPPED: Final = 130


@contextmanager
def watching(crowd: Crowd, pause_s: float) -> Iterator[None]:
    """Watch an inbox into which epochs come, the last station of each late."""
    site = crowd.site
    words = ["watch", str(site.file), "--inbox", str(site.inbox), "--settle-s", "0.5", "--interval-s", "0.5"]
    command = [*command_line(), *words, "--json", "--workspace", str(site.workspace)]
    out, err = site.folder / "watch.jsonl", site.folder / "watch.err"
    with out.open("w") as told, err.open("w") as complained:
        process = subprocess.Popen(command, cwd=ROOT, env=environment(), stdout=told, stderr=complained)
        sender = threading.Thread(target=_send, args=(crowd, pause_s), daemon=True)
        sender.start()
        try:
            yield
        finally:
            sender.join(STOP_S)
            process.send_signal(signal.SIGTERM)
            code = process.wait(STOP_S)
    if code != STOPPED:
        crowd.find(f"watch: exit code {code}: {err.read_text()[-1500:]}")
    _judge_watch(crowd, out.read_text(), err.read_text())


def _send(crowd: Crowd, pause_s: float) -> None:
    for epoch in crowd.site.epochs[IN_FILE:]:
        *early, late = epoch["stations"]
        for station in early:
            crowd.site.send(epoch, station)
        crowd.site.complete(epoch)
        crowd.calls["epoch sent"] += 1
        if crowd.end.wait(pause_s):
            return
        crowd.site.send(epoch, late)
        crowd.calls["late station sent"] += 1
        if crowd.end.wait(pause_s):
            return


def _judge_watch(crowd: Crowd, out: str, err: str) -> None:
    if found := WRONG_WORDS.search(out + err):
        crowd.find(f"watch: told {found[0]!r}: {err[-1500:]}")
    for line in out.splitlines():
        event = json.loads(line)
        crowd.calls[f"watch: {event['event']}"] += 1
        if event["event"] in ("kept", "error"):
            crowd.find(f"watch: {line}")
        if event["event"] == "run-ended" and event.get("exit_code") != 0:
            crowd.find(f"watch: {line}")
        if event["event"] == "run-ended" and event.get("exit_code") == 0:
            crowd.runs.append(event["run"])


@contextmanager
def reading(crowd: Crowd) -> Iterator[dict[str, list[str]]]:
    """Read the catalog by plain DuckDB; gives the runs behind what was shown of every epoch, when it is over."""
    folder = crowd.site.folder
    stop, out = folder / "stop-reading", folder / "reader.json"
    words = [str(crowd.site.workspace / "catalog.duckdb"), str(out), str(stop)]
    command = [sys.executable, "-m", "tests.faults.crowding.reader", *words]
    shown: dict[str, list[str]] = {}
    process = subprocess.Popen(command, cwd=ROOT, env=environment())
    try:
        yield shown
    finally:
        stop.touch()
        code = process.wait(STOP_S)
    if code != 0:
        crowd.find(f"reader: exit code {code}")
        return
    content = json.loads(out.read_text(encoding="utf-8"))
    crowd.calls["readings"] += content["readings"]
    crowd.findings += [f"reader: {line}" for line in content["findings"]]
    shown.update(content["shown"])


@contextmanager
def showing(crowd: Crowd, seconds: float) -> Iterator[None]:
    """Serve the dashboard, and have a visitor turn its pages."""
    paths = [f"/{name}?structure={STRUCTURE}" for name in pages()]
    with serve_dashboard(crowd.site.file, crowd.site.workspace) as served:
        visitor = Visitor(served.url, paths, seconds)
        visitor.start()
        yield
        visitor.join(STOP_S)
        if visitor.is_alive():
            crowd.find("dashboard: its visitor waits for ever")
    crowd.calls["pages"] += len(visitor.took_s)
    crowd.findings += [f"dashboard: {line}" for line in visitor.wrong]


def left_behind(folder: Path) -> list[str]:
    """Processes that have to do with a folder."""
    own = psutil.Process().pid
    found = []
    for process in psutil.process_iter(["pid", "cmdline", "cwd"]):
        words = " ".join(process.info["cmdline"] or [])
        if process.info["pid"] != own and (
            str(folder) in words or str(folder) in (process.info["cwd"] or "")
        ):
            found.append(f"{process.info['pid']}: {words[:200]}")
    return found
