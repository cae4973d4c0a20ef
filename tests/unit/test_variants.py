"""Variants are found by themselves, and none is overlooked for its name."""

from pathlib import Path

import pytest

from tasks.geometry.variants import discover


class Thing:
    """A variant of nothing."""

    def __init__(self, name: str) -> None:
        self.name = name


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / f"things_of_{tmp_path.name}"  # a name that no other test has imported
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "one.py").write_text("from tests.unit.test_variants import Thing\nTHING = Thing('one')\n")
    (folder / "loop_kernel.py").write_text("raise RuntimeError('slow to import')\n")
    monkeypatch.syspath_prepend(tmp_path)
    return folder


def test_compiled_loops_are_no_variants_and_are_not_imported(package: Path) -> None:
    assert list(discover(package.name, "THING", Thing)) == ["one"]


@pytest.mark.parametrize("line", ["THING = Thing('two')", "THING: Final = Thing('two')"])
def test_a_variant_in_a_module_that_is_named_like_compiled_loops_is_told(package: Path, line: str) -> None:
    (package / "two_kernel.py").write_text(f"{line}\n")
    with pytest.raises(TypeError, match=r"two_kernel has a THING, .* name it otherwise"):
        discover(package.name, "THING", Thing)
