"""What was compiled is kept for the sources that it was compiled from, and where it can be kept safely."""

from pathlib import Path

import pytest

from tasks.geometry import compiled


def test_another_source_has_another_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a_kernel.py").write_text("A = 1\n")
    (tmp_path / "b_kernels.py").write_text("B = 1\n")
    monkeypatch.setattr(compiled, "TASKS", tmp_path)
    monkeypatch.setattr(compiled, "__file__", str(tmp_path / "a_kernel.py"))
    before = compiled.digest_of_kernels()
    assert compiled.digest_of_kernels() == before
    (tmp_path / "b_kernels.py").write_text("B = 2\n")
    assert compiled.digest_of_kernels() != before


def test_where_nothing_can_be_written_nothing_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a file, no folder"
    file.touch()
    monkeypatch.setattr(compiled, "_places", lambda: iter([file]))
    assert compiled._folder() is None
    monkeypatch.setattr(compiled, "_places", lambda: iter([file, tmp_path / "cache"]))
    assert compiled._folder() == tmp_path / "cache" / f"compiled-{compiled.digest_of_kernels()}"


def test_a_folder_that_others_may_write_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / f"compiled-{compiled.digest_of_kernels()}"
    folder.mkdir()
    folder.chmod(0o777)
    monkeypatch.setattr(compiled, "_places", lambda: iter([tmp_path]))
    assert compiled._folder() is None
