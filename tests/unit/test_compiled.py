"""What was compiled is kept for the sources that it was compiled from, and where it can be kept safely."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tasks.geometry import compiled
from tests.flows.calls import ROOT


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


def test_what_was_compiled_in_a_tree_that_can_only_be_read_is_copied(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = f"compiled-{compiled.digest_of_kernels()}"
    tree, cache = tmp_path / "tree", tmp_path / "cache"
    (tree / name).mkdir(parents=True, mode=0o755)
    (tree / name / "index").write_text("machine code")
    can_write = compiled._can_write
    monkeypatch.setattr(compiled, "_can_write", lambda folder: folder.parent != tree and can_write(folder))
    monkeypatch.setattr(compiled, "_places", lambda: iter([tree, cache]))
    assert compiled._folder() == cache / name
    assert (cache / name / "index").read_text() == "machine code"
    monkeypatch.setattr(compiled, "_places", lambda: iter([tree]))
    own = compiled._folder()
    assert own is not None and own.parent != tree
    assert (own / "index").read_text() == "machine code"


def test_a_folder_that_others_may_write_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / f"compiled-{compiled.digest_of_kernels()}"
    folder.mkdir()
    folder.chmod(0o777)
    monkeypatch.setattr(compiled, "_places", lambda: iter([tmp_path]))
    assert compiled._folder() is None


@pytest.mark.slow
def test_the_set_up_compiles_what_a_run_needs(tmp_path: Path) -> None:
    # a process of its own with an empty cache: what other tests compiled proves nothing
    command = [sys.executable, "-m", "flows.compile_kernels"]
    own = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run(command, cwd=ROOT, env=own, check=True, timeout=600.0, capture_output=True)
    found = {index.name.split(".")[0] for index in tmp_path.rglob("*.nbi")}
    assert {"match_kernel", "neighbour_kernel", "cell_kernel", "circle_kernel", "kernels"} <= found
