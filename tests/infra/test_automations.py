"""An alarm reaches a Prefect server as an event, and the automation that we ship calls a webhook."""

import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from uuid import uuid4

import pytest

from flows.alarm_events import EVENT, tell_prefect
from tests.flows.alarm_receivers import Desk, http_server
from tests.storage.campaign import alarm_event_row

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = ROOT / "infra" / "automations.yaml"
NO_BLOCK = "00000000-0000-0000-0000-000000000000"
LONGEST_S = 90.0

EMIT = """
import sys, json
from datetime import datetime
from dataclasses import replace
from flows.alarm_events import tell_prefect
from tests.storage.campaign import alarm_event_row
for severity, action, alarm in json.loads(sys.argv[1]):
    tell_prefect([replace(alarm_event_row("e", action), severity=severity, alarm=alarm, note="21 mm", unit="m")])
"""


def emit(*events: tuple[str, str, str]) -> None:
    """Emit in a process of its own: it ends when the events are with the server."""
    words = [sys.executable, "-c", EMIT, json.dumps(events)]
    subprocess.run(words, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=True, timeout=120)


@pytest.mark.usefixtures("prefect_api")
def test_the_shipped_automation_calls_a_webhook_for_a_raised_alarm(tmp_path: Path) -> None:
    from prefect.blocks.webhook import Webhook  # noqa: PLC0415 (slow to import)

    name = f"desk-{uuid4().hex[:8]}"
    with http_server() as desk:
        block = Webhook(method="POST", url=f"http://127.0.0.1:{desk.port}/", allow_private_urls=True)
        identity = block.save(name)
        file = tmp_path / "automations.yaml"
        text = SHIPPED.read_text("utf-8").replace(NO_BLOCK, str(identity)).replace("tiltwatch-alarm", name)
        file.write_text(text, encoding="utf-8")
        create = [sys.executable, "-m", "prefect", "automation", "create", "--from-file", str(file)]
        subprocess.run(create, check=True, timeout=120, capture_output=True)
        emit(
            ("warning", "raised", "a-warning"), ("alarm", "eased", "over"), ("alarm", "raised", "movement-e0")
        )
        _wait_for(desk)
    assert desk.posts == [
        {"structure": "chimney-01", "rule": "movement", "epoch": "e0", "what": "21 mm"},
    ]


def _wait_for(desk: Desk) -> None:
    deadline = time.monotonic() + LONGEST_S
    while not desk.posts and time.monotonic() < deadline:
        time.sleep(0.1)


@pytest.mark.slow
def test_a_server_that_is_not_there_never_stops_a_run() -> None:
    """The process goes on and ends by itself, within the limit of Prefect's own tries."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PREFECT_API_URL": "http://127.0.0.1:9/api"}
    words = [sys.executable, "-c", EMIT, json.dumps([("alarm", "raised", "movement-e0")])]
    done = subprocess.run(words, cwd=ROOT, env=environment, check=False, timeout=120, capture_output=True)
    assert done.returncode == 0


def test_nothing_is_emitted_where_no_server_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PREFECT_API_URL", raising=False)
    assert tell_prefect([replace(alarm_event_row("e"), unit="m")]) == 0
    assert EVENT in SHIPPED.read_text("utf-8")
