"""What a stage's code version covers: tried on a copy of the checkout, read in a process of its own."""

import ast
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tasks.code_version import _parse

ROOT = Path(__file__).resolve().parents[2]
ASK = """
import sys
from tasks.code_version import code_version
from tasks.{module} import {function}
print(code_version({function}))
"""


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    copy = tmp_path_factory.mktemp("checkout")
    for package in ("tasks", "storage"):
        shutil.copytree(ROOT / package, copy / package, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


def version_in(checkout: Path, module: str = "sections", function: str = "fit_sections") -> str:
    script = ASK.format(module=module, function=function)
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=checkout, capture_output=True, text=True, check=True, timeout=60
    )
    return done.stdout.strip()


class Edited:
    """A file of the copy with one text replaced, as long as the block lasts."""

    def __init__(self, path: Path, old: str, new: str) -> None:
        self.path, self.before = path, path.read_text(encoding="utf-8")
        assert old in self.before
        self.after = self.before.replace(old, new, 1)

    def __enter__(self) -> None:
        self.path.write_text(self.after, encoding="utf-8")

    def __exit__(self, *exception: object) -> None:
        self.path.write_text(self.before, encoding="utf-8")


def test_a_changed_helper_two_calls_below_changes_the_version(checkout: Path) -> None:
    before = version_in(checkout)
    with Edited(checkout / "tasks/geometry/robust.py", "(1.0 - u * u) ** 2", "(1.0 - u * u) ** 3"):
        assert version_in(checkout) != before
    assert version_in(checkout) == before


def test_a_changed_constant_of_a_variant_changes_the_version(checkout: Path) -> None:
    before = version_in(checkout)
    with Edited(checkout / "tasks/contours/vertex_mean.py", "MIN_POINTS: Final = 8", "MIN_POINTS: Final = 9"):
        assert version_in(checkout) != before


def test_a_new_variant_changes_the_version_of_the_stage_that_finds_it(checkout: Path) -> None:
    before = version_in(checkout)
    new = checkout / "tasks/contours/another.py"
    new.write_text("X = 1\n")
    try:
        assert version_in(checkout) != before
    finally:
        new.unlink()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"""Robust scales and weights.', '"""Robust scales, and weights.'),
        ('"""Makes the median absolute', '"""It makes the median absolute'),
        ("def mad_sigma(", "# a comment\n\n\ndef mad_sigma("),
        (
            "u = np.clip(np.abs(residuals) / (cut * sigma), 0.0, 1.0)",
            "u = np.clip(\n        np.abs(residuals) / (cut * sigma), 0.0, 1.0\n    )",
        ),
    ],
    ids=["docstring", "text below a constant", "comment", "layout"],
)
def test_what_does_not_run_does_not_change_the_version(checkout: Path, old: str, new: str) -> None:
    before = version_in(checkout)
    with Edited(checkout / "tasks/geometry/robust.py", old, new):
        assert version_in(checkout) == before


def test_code_that_a_stage_does_not_reach_does_not_change_its_version(checkout: Path) -> None:
    before = version_in(checkout)
    with Edited(
        checkout / "tasks/registration/partners.py", "QUERIES: Final = 3000", "QUERIES: Final = 3001"
    ):
        assert version_in(checkout) == before
        assert version_in(checkout, "registration.register", "register_stations") != ""


def test_a_lazy_import_inside_a_function_is_reached(checkout: Path) -> None:
    with Edited(
        checkout / "tasks/sections.py",
        "    cloud = ShaftCloud(",
        "    from tasks.registration import pairs\n\n    cloud = ShaftCloud(",
    ):
        before = version_in(checkout)
        with Edited(
            checkout / "tasks/registration/partners.py", "QUERIES: Final = 3000", "QUERIES: Final = 3001"
        ):
            assert version_in(checkout) != before


def test_a_source_that_python_refuses_by_its_own_fault_is_parsed_once_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    parse, refused = ast.parse, []

    def moody(text: str) -> ast.Module:
        if len(refused) < 2:
            refused.append(text)
            raise SystemError("AST constructor recursion depth mismatch (before=255, after=54)")
        return parse(text)

    monkeypatch.setattr("tasks.code_version.ast.parse", moody)
    assert ast.dump(_parse("x = 1")) == ast.dump(parse("x = 1"))
    assert len(refused) == 2
