"""Long settings are kept in parts: each text comes back as it was, and one epoch more costs what one epoch costs."""

import json
from pathlib import Path

import pytest

from storage.digests import text_sha256
from storage.errors import StorageError
from storage.ledger import read_settings, settings_parts, settings_path, store_settings
from storage.publish import publish_epoch
from storage.verify import verify_workspace
from storage.workspace import Workspace
from tests.storage.campaign import epoch_tables, fill


def settings(epochs: int, first: int = 0) -> str:
    """Filled-in settings of so many epochs of eight stations, as long as real ones."""
    stations = [
        {"heading_deg": 271.25, "id": f"ST{k:02d}", "position_m": [200.5 + k, -12.75, 1.5]} for k in range(8)
    ]
    content = [{"id": f"e{number:05d}", "stations": stations} for number in range(first, first + epochs)]
    return json.dumps(
        {"alarms": None, "epochs": content, "structure": "chimney-01 Ω"}, sort_keys=True, ensure_ascii=False
    )


def stored(ws: Workspace, text: str) -> str:
    store_settings(ws, text_sha256(text), text)
    return text_sha256(text)


def size_of(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


@pytest.mark.parametrize("epochs", [0, 1, 20, 200, 2000])
def test_settings_of_any_length_come_back_as_they_were(ws: Workspace, epochs: int) -> None:
    text = settings(epochs)
    assert read_settings(ws, stored(ws, text)) == text


def test_short_settings_are_a_file_that_can_be_read_as_it_is(ws: Workspace) -> None:
    text = settings(10)
    assert settings_path(ws, stored(ws, text)).read_text(encoding="utf-8") == text
    assert not settings_parts(ws).exists()


def test_one_epoch_more_costs_no_more_among_a_thousand_than_among_a_hundred(ws: Workspace) -> None:
    cost = {}
    for epochs in (100, 1000):
        stored(ws, settings(epochs))
        before = size_of(ws.runs)
        for more in range(1, 21):
            stored(ws, settings(epochs + more))
        cost[epochs] = (size_of(ws.runs) - before) / 20
    # whole, a thousand would cost ten times what a hundred cost; a list of parts of parts makes less than three of it
    assert cost[1000] < 3.0 * cost[100]
    assert cost[1000] < 0.05 * len(settings(1000))


def test_an_epoch_in_front_of_all_others_costs_no_more_than_one_behind_them(ws: Workspace) -> None:
    stored(ws, settings(500, first=1))
    before = size_of(ws.runs)
    stored(ws, settings(501))
    assert size_of(ws.runs) - before < 0.1 * len(settings(501))


@pytest.mark.parametrize("spoil", ["absent", "damaged"])
def test_a_part_that_is_absent_or_damaged_is_told_and_healed(ws: Workspace, spoil: str) -> None:
    text = settings(300)
    digest = stored(ws, text)
    part = sorted(settings_parts(ws).iterdir())[3]
    part.unlink() if spoil == "absent" else part.write_bytes(part.read_bytes()[:-1])
    with pytest.raises(StorageError, match=f"{part.name} is {spoil}"):
        read_settings(ws, digest)
    stored(ws, text)
    assert read_settings(ws, digest) == text


def test_a_damaged_list_of_parts_is_told(ws: Workspace) -> None:
    digest = stored(ws, settings(300))
    path = settings_path(ws, digest)
    content = json.loads(path.read_text())
    path.write_text(json.dumps({**content, "parts": content["parts"][:-1]}))
    with pytest.raises(StorageError, match="is damaged: its digest is"):
        read_settings(ws, digest)


def test_verify_finds_a_damaged_part_of_the_settings_of_an_epoch(ws: Workspace) -> None:
    fill(ws, n_epochs=1)
    digest = stored(ws, settings(300))
    publish_epoch(ws, "chimney-01", "e1", epoch_tables("e1", 1, campaign_digest=digest))
    part = sorted(settings_parts(ws).iterdir())[0]
    part.write_bytes(part.read_bytes() + b" ")
    assert any(part.name in fault.what for fault in verify_workspace(ws).faults)
