"""What a watch tells of files whose names were chosen to do harm."""

import json
from pathlib import Path

import pytest

from flows.watch.events import Teller, WatchEvent
from storage.workspace import Workspace

NAME = "a\x1b]0;owned\x07\x1b[2J\u202eb.complete"


@pytest.mark.parametrize("kind", ["kept", "waiting"])
def test_a_name_cannot_give_orders_to_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    event = WatchEvent(kind, (f"kept: {NAME}: no epoch",), {"name": NAME})
    Teller(Workspace(tmp_path), "silo", as_json=False).tell(event)
    told = "".join(capsys.readouterr())
    assert told == "kept: a\\x1b]0;owned\\x07\\x1b[2J\\u202eb.complete: no epoch\n"
    (log,) = tmp_path.rglob("watch-silo.jsonl")
    assert json.loads(log.read_text(encoding="utf-8"))["name"] == NAME
