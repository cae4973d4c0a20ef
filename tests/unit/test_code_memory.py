"""The memory of code versions saves time and changes nothing."""

import json
from pathlib import Path

import pytest

from storage.sealed import unsealed
from tasks.change_rows import change_test_rows_of
from tasks.code_memory import remembered, remembered_versions
from tasks.code_version import code_version

LIBRARIES = ("numpy==2",)


def _find(text: str) -> str:
    return text


def _known(file: Path, libraries: tuple[str, ...] = LIBRARIES, found: str = "anew") -> str:
    with remembered_versions(file, libraries):
        return remembered(change_test_rows_of, lambda: _find(found))


def test_a_version_is_found_once(tmp_path: Path) -> None:
    assert _known(tmp_path / "there" / "versions.json", found="first") == "first"
    assert _known(tmp_path / "there" / "versions.json", found="second") == "first"


def test_a_version_of_other_libraries_is_not_taken(tmp_path: Path) -> None:
    _known(tmp_path / "versions.json", found="first")
    assert _known(tmp_path / "versions.json", ("numpy==3",), found="second") == "second"


def test_a_version_of_other_sources_is_not_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tasks.code_memory.ROOT", tmp_path)
    (tmp_path / "tasks").mkdir()
    source = tmp_path / "tasks" / "one.py"
    source.write_text("a = 1\n")
    _known(tmp_path / "versions.json", found="first")
    source.write_text("a = 2\n")
    assert _known(tmp_path / "versions.json", found="second") == "second"


@pytest.mark.parametrize("content", ["", "[]", '{"sources": 1}', "\0", '{"versions": {}}'])
def test_a_file_that_cannot_be_read_is_as_good_as_none(tmp_path: Path, content: str) -> None:
    (tmp_path / "versions.json").write_text(content)
    assert _known(tmp_path / "versions.json", found="first") == "first"
    assert _known(tmp_path / "versions.json", found="second") == "first"


def test_a_function_of_others_is_not_remembered(tmp_path: Path) -> None:
    with remembered_versions(tmp_path / "versions.json", LIBRARIES):
        assert remembered(_find, lambda: "first") == "first"
        assert remembered(_find, lambda: "second") == "second"


def test_what_is_remembered_is_the_version(tmp_path: Path) -> None:
    plain = code_version(change_test_rows_of)
    code_version.cache_clear()
    with remembered_versions(tmp_path / "versions.json", LIBRARIES):
        assert code_version(change_test_rows_of) == plain
    code_version.cache_clear()
    content = json.loads(unsealed((tmp_path / "versions.json").read_bytes()) or b"")
    assert content["versions"] == {"tasks.change_rows.change_test_rows_of": plain}
    with remembered_versions(tmp_path / "versions.json", LIBRARIES):
        assert code_version(change_test_rows_of) == plain
