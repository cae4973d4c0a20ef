"""The cache key and the guard before it, without a flow: Prefect's engine is tried in tests/flows."""

import json
from pathlib import Path

import numpy as np
import pytest

from storage.artifacts import artifact_path, put_array
from storage.workspace import Workspace, open_workspace
from tasks.caching import set_aside_if_damaged, stage_key
from tasks.produced import Cost, Outcome, Produced, produced_from_json


def one_stage(workspace: str, path: str, digest: str, parameter: float) -> Outcome:
    return Outcome()


INPUTS = {"workspace": "here", "path": "a.laz", "digest": "d", "parameter": 1.0}


def test_places_do_not_count_in_the_key() -> None:
    elsewhere = {**INPUTS, "workspace": "there", "path": "b.laz"}
    assert stage_key("x", one_stage, INPUTS) == stage_key("x", one_stage, elsewhere)


@pytest.mark.parametrize("change", [{"digest": "e"}, {"parameter": 1.0000001}], ids=["digest", "parameter"])
def test_inputs_count_in_the_key(change: dict[str, object]) -> None:
    assert stage_key("x", one_stage, INPUTS) != stage_key("x", one_stage, {**INPUTS, **change})


def test_two_stages_with_equal_inputs_have_different_keys() -> None:
    assert stage_key("x", one_stage, INPUTS) != stage_key("y", one_stage, INPUTS)


def test_an_array_as_input_is_a_fault_and_not_an_unstable_key() -> None:
    with pytest.raises(TypeError, match="not JSON serializable"):
        stage_key("x", one_stage, {**INPUTS, "parameter": np.zeros(3)})


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    return open_workspace(tmp_path / "ws")


def keep_record(workspace: Workspace) -> tuple[Path, Path]:
    """A record as Prefect writes it, and the artifact that it names."""
    ref = put_array(workspace, "numbers", np.arange(1000.0))
    produced = Produced(Cost(0.1, 10, None), {"numbers": ref})
    record = workspace.records / "key"
    record.write_text(json.dumps({"metadata": {}, "result": json.dumps(produced.to_json())}))
    return record, artifact_path(workspace, ref)


def test_a_record_with_whole_artifacts_stays(workspace: Workspace) -> None:
    record, _ = keep_record(workspace)
    set_aside_if_damaged(workspace, "key")
    assert record.exists()


def test_a_record_whose_artifact_has_one_flipped_byte_is_set_aside(workspace: Workspace) -> None:
    record, artifact = keep_record(workspace)
    content = bytearray(artifact.read_bytes())
    content[-1] ^= 1
    artifact.write_bytes(content)
    set_aside_if_damaged(workspace, "key")
    assert not record.exists()
    assert record.with_name("key.bad").exists()


def test_a_record_whose_artifact_is_gone_is_set_aside(workspace: Workspace) -> None:
    record, artifact = keep_record(workspace)
    artifact.unlink()
    set_aside_if_damaged(workspace, "key")
    assert not record.exists()


@pytest.mark.parametrize("text", ["", "{", "[]", '{"result": "7"}', '{"result": "{}"}', '{"metadata": {}}'])
def test_a_torn_or_foreign_record_is_set_aside(workspace: Workspace, text: str) -> None:
    (workspace.records / "key").write_text(text)
    set_aside_if_damaged(workspace, "key")
    assert not (workspace.records / "key").exists()


def test_what_a_stage_produced_survives_its_json() -> None:
    produced = Produced(Cost(0.5, None, 100.0), {}, {"n": 3, "notes": ["a"]}, refusal="too few points")
    assert produced_from_json(json.loads(json.dumps(produced.to_json()))) == produced
