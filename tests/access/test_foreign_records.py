"""A record that somebody else wrote into the store cannot run code: it is data, whatever it says that it is.

Prefect reads a record as the record itself asks for. Each trap below is sprung by Prefect's own reader (the first test of
each pair shows that), and by none of ours.
"""

import base64
import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from prefect._internal.result_records import ResultRecord
from prefect.results import ResultStore

from flows.stage_records import PLAIN_JSON, StageRecords
from storage.errors import StorageError
from storage.places import store_of
from storage.sealed import json_digest
from storage.verify import verify_workspace
from storage.workspace import Workspace, open_workspace
from tasks.caching import on_record, record_name, set_aside_if_damaged
from tasks.produced import Cost, Produced, record_result

KEY = "registration-0123456789abcdef"
SOUND = Produced(Cost(0.1, None, None), facts={"n_points": 7})


class Bait:
    """Unpickled it makes a file."""

    def __init__(self, canary: Path) -> None:
        self._canary = canary

    def __reduce__(self) -> tuple[Callable[..., object], tuple[object, ...]]:
        return Path.touch, (self._canary,)


def pickled(canary: Path) -> str:
    return base64.b64encode(pickle.dumps(Bait(canary))).decode()


def record(metadata: object, result: object, **more: object) -> bytes:
    return json.dumps({"metadata": metadata, "result": result, **more}).encode()


def polyglot(canary: Path) -> str:
    """JSON of a sound stage whose letters, taken for base64, are a pickle: what is after its end is not read."""
    head = pickled(canary).rstrip("=")
    head += "A" * (-len(head) % 4)
    text = json.dumps({head: 0, "": "", **with_digest(SOUND.to_json())})
    letters = sum(sign.isalnum() or sign in "+/" for sign in text)
    # a digest is as long whatever of, so that the letters stay as many
    return json.dumps(with_digest(json.loads(text.replace('""', f'"{"A" * (-letters % 4)}"', 1))))


def with_digest(content: dict[str, Any]) -> dict[str, Any]:
    """Content with the digest that belongs to it: whoever writes a record can work that out, too."""
    plain = {name: value for name, value in content.items() if name != "digest"}
    return {**plain, "digest": json_digest(plain)}


def as_pickle(canary: Path) -> bytes:
    return record({"serializer": {"type": "pickle"}}, pickled(canary))


def as_nothing_said(canary: Path) -> bytes:
    return record({}, pickled(canary))


def as_sound_json_too(canary: Path) -> bytes:
    return record({"serializer": {"type": "pickle"}}, polyglot(canary))


def as_sound_json_in_old_form(canary: Path) -> bytes:
    return record({}, polyglot(canary), serializer={"type": "pickle"})


def as_json_with_a_hook(canary: Path) -> bytes:
    """The decoder is any function that can be imported; this one is given every object of the JSON."""
    how = {"type": "json", "object_decoder": "tests.access.test_foreign_records.spring"}
    return record({"serializer": how}, json.dumps(with_digest({"canary": str(canary), **SOUND.to_json()})))


def as_json_of_another_library(canary: Path) -> bytes:
    how = {"type": "json", "jsonlib": "tests.access.springing_json", "object_decoder": None}
    return record({"serializer": how}, json.dumps(with_digest({"canary": str(canary), **SOUND.to_json()})))


def spring(found: dict[str, object]) -> dict[str, object]:
    """What an attacker would name; a module of the standard library does as well."""
    if "canary" in found:
        Path(str(found["canary"])).touch()
    return found


TRAPS = [
    as_pickle,
    as_nothing_said,
    as_sound_json_too,
    as_sound_json_in_old_form,
    as_json_with_a_hook,
    as_json_of_another_library,
]
LOOKS_SOUND = [trap for trap in TRAPS if trap not in (as_pickle, as_nothing_said)]


@pytest.fixture
def ws(tmp_path: Path) -> Workspace:
    return open_workspace(tmp_path / "ws")


@pytest.fixture
def canary(tmp_path: Path) -> Path:
    return tmp_path / "canary"


@pytest.mark.parametrize("trap", TRAPS)
def test_prefects_own_reader_springs_the_trap(trap: Callable[[Path], bytes], canary: Path) -> None:
    try:
        ResultRecord.deserialize(trap(canary))
    except Exception:  # what comes after the deed is of no interest
        assert canary.exists()
    assert canary.exists()


@pytest.mark.parametrize("trap", TRAPS)
def test_ours_does_not(trap: Callable[[Path], bytes], canary: Path, ws: Workspace) -> None:
    store_of(ws).put(record_name(KEY), trap(canary))
    records = ResultStore(result_storage=StageRecords(place=ws.place), serializer=PLAIN_JSON)
    if trap in LOOKS_SOUND:
        assert on_record(ws, KEY) == SOUND
        assert records.read(KEY).result == SOUND.to_json()
    else:
        assert on_record(ws, KEY) is None
        assert not records.exists(KEY)
    set_aside_if_damaged(ws, KEY)
    assert not canary.exists()


def test_a_record_of_no_stage_is_none(ws: Workspace, canary: Path) -> None:
    store_of(ws).put(record_name(KEY), as_pickle(canary))
    with pytest.raises(StorageError, match="no record of a stage"):
        StageRecords(place=ws.place).read_path(KEY)


def test_what_prefect_wrote_it_reads_again(ws: Workspace) -> None:
    records = ResultStore(result_storage=StageRecords(place=ws.place), serializer=PLAIN_JSON)
    records.write(SOUND.to_json(), key=KEY)
    assert records.exists(KEY)
    assert records.read(KEY).result == SOUND.to_json()
    assert on_record(ws, KEY) == SOUND


@pytest.mark.parametrize(
    "artifact",
    [
        {"kind": "points", "sha256": "../../../../etc/passwd", "size": 1, "ext": "npy"},
        {"kind": "points", "sha256": "a" * 64, "size": 1, "ext": "../x"},
        {"kind": "points", "sha256": "a" * 64, "size": "1", "ext": "npy"},
    ],
)
def test_a_record_whose_artifact_lies_elsewhere_is_set_aside(ws: Workspace, artifact: object) -> None:
    content = with_digest({**SOUND.to_json(), "artifacts": {"points": artifact}})
    store_of(ws).put(record_name(KEY), record({}, json.dumps(content)))
    set_aside_if_damaged(ws, KEY)
    assert store_of(ws).get(record_name(KEY)) is None
    with pytest.raises(ValueError, match="not the record"):
        record_result(record({}, json.dumps(content)))


def test_the_record_of_another_stage_is_none(ws: Workspace) -> None:
    sound = json.dumps(SOUND.to_json())
    store_of(ws).put(record_name(KEY), record({"storage_key": "axis-0123"}, sound))
    assert on_record(ws, KEY) is None
    assert [fault.what for fault in verify_workspace(ws).faults] == ["is the record of axis-0123"]
    store_of(ws).put(record_name(KEY), record({"storage_key": KEY}, sound))
    assert on_record(ws, KEY) == SOUND
    assert verify_workspace(ws).faults == ()
