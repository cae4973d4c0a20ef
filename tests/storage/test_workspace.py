"""A workspace is made, found again, and refused when it is not one."""

import json
from pathlib import Path

import pytest

from storage.errors import InputError, StorageError
from storage.identity import SCHEMA_VERSION, Identity, read_identity, second_of_identity
from storage.ids import check_id
from storage.mend import mend_copies
from storage.workspace import Workspace, existing_workspace, open_workspace
from tests.faults.damages import DAMAGES, Damage, truncate

ONE = {name: damage for name, damage in DAMAGES.items() if name != "exchanged"}


def test_a_new_workspace_says_version_and_maker(tmp_path: Path) -> None:
    ws = open_workspace(tmp_path / "a" / "ws", made_by="tiltwatch 0.1.0")
    assert json.loads(ws.identity.read_bytes()) == {
        "schema_version": SCHEMA_VERSION,
        "made_by": "tiltwatch 0.1.0",
    }
    assert all(
        place.is_dir()
        for place in (ws.artifacts, ws.records, ws.tables, ws.runs, ws.prefect, ws.locks, ws.tmp)
    )


def test_a_workspace_that_is_there_keeps_its_maker(tmp_path: Path) -> None:
    open_workspace(tmp_path, made_by="tiltwatch 0.1.0")
    assert open_workspace(tmp_path, made_by="another") == existing_workspace(tmp_path)
    assert json.loads((tmp_path / "workspace.json").read_bytes())["made_by"] == "tiltwatch 0.1.0"


def test_an_absent_workspace_is_answered_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"no workspace at .*tiltwatch run FILE.*--workspace"):
        existing_workspace(tmp_path / "none")


@pytest.mark.parametrize("opening", [open_workspace, existing_workspace])
def test_a_workspace_of_a_newer_version_is_refused(tmp_path: Path, opening: object) -> None:
    (tmp_path / "workspace.json").write_text('{"schema_version": 3}')
    with pytest.raises(StorageError, match="has schema version 3; this tiltwatch reads up to 2"):
        opening(tmp_path)  # type: ignore[operator]


def test_a_damaged_identity_is_told(tmp_path: Path) -> None:
    (tmp_path / "workspace.json").write_text("{")
    with pytest.raises(StorageError, match=r"workspace\.json is damaged"):
        existing_workspace(tmp_path)


@pytest.mark.parametrize("damage", ONE.values(), ids=ONE)
def test_what_a_workspace_says_of_itself_is_believed_of_its_whole_second_copy(
    tmp_path: Path, damage: Damage
) -> None:
    ws = open_workspace(tmp_path, made_by="tiltwatch 0.1.0")
    damage(ws.identity, None)
    assert read_identity(existing_workspace(tmp_path).identity) == Identity(SCHEMA_VERSION, "tiltwatch 0.1.0")


def test_a_flipped_version_refuses_nobody_and_is_put_back(tmp_path: Path) -> None:
    ws = open_workspace(tmp_path)
    ws.identity.write_text('{"schema_version": 3, "made_by": "tiltwatch"}')
    told = mend_copies(existing_workspace(tmp_path))
    assert [(one.where, one.is_lost) for one in told] == [("workspace.json", False)]
    assert json.loads(ws.identity.read_bytes())["schema_version"] == SCHEMA_VERSION


def test_a_workspace_with_both_copies_damaged_is_refused(tmp_path: Path) -> None:
    ws = open_workspace(tmp_path)
    for path in (ws.identity, second_of_identity(ws.identity)):
        truncate(path, None)
    with pytest.raises(StorageError, match=r"workspace\.json is damaged.*restore the file"):
        existing_workspace(tmp_path)


def test_a_file_is_no_workspace(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="needs a folder; it is a file"):
        open_workspace(tmp_path / "file")


def test_all_places_are_inside_the_root(tmp_path: Path) -> None:
    ws = Workspace(tmp_path)
    assert all(place.is_relative_to(tmp_path) for place in (ws.catalog, ws.journal, ws.tables, ws.records))


@pytest.mark.parametrize("value", ["a", "2025-03", "chimney_01.b", "x" * 64, "COM", "CONCRETE", "nulla"])
def test_safe_ids_are_taken(value: str) -> None:
    assert check_id(value, "an epoch") == value


@pytest.mark.parametrize(
    "value", ["", ".", "..", "a/b", "a\\b", "-a", ".a", "a.", "a b", "ä", "x" * 65, "a\n", "a:b", "a*"]
)
def test_ids_that_cannot_be_file_names_are_refused(value: str) -> None:
    with pytest.raises(InputError, match="of an epoch cannot be a file name"):
        check_id(value, "an epoch")


@pytest.mark.parametrize("value", ["CON", "nul", "Aux", "com1", "LPT9", "con.txt", "prn.2025"])
def test_ids_that_windows_takes_for_devices_are_refused(value: str) -> None:
    with pytest.raises(InputError, match="name of a device on Windows"):
        check_id(value, "an epoch")
