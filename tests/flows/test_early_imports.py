"""What stages import is imported beside the start of the engine; what cannot be is left to them."""

import importlib
import json
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from flows import early_imports
from storage.sealed import unsealed
from tasks import stages
from tasks.caching import Stage
from tasks.code_memory import remembered_versions
from tasks.code_version import code_version
from tests.flows.calls import ROOT


def test_all_of_them_are_there() -> None:
    for name in early_imports.MODULES:
        importlib.import_module(name)


def test_they_are_imported_by_a_thread() -> None:
    code = (
        "import sys, threading; from flows.early_imports import MODULES, begin_imports; begin_imports()\n"
        "[t.join(60) for t in threading.enumerate() if t.name == 'early imports']\n"
        "print([name for name in MODULES if name not in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "[]", done.stderr


def test_one_that_cannot_be_imported_stops_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(early_imports, "MODULES", ("no_such_module", "json"))
    early_imports.begin_imports()
    for thread in threading.enumerate():
        if thread.name == "early imports":
            thread.join(timeout=10.0)
    assert "no_such_module" not in sys.modules


def test_versions_of_all_stages_are_found_before_the_first_begins(tmp_path: Path) -> None:
    code_version.cache_clear()
    with remembered_versions(tmp_path / "versions.json", ()):
        early_imports.find_versions()
        known = [
            f"{one.fn.__module__}.{one.fn.__qualname__}"
            for one in vars(stages).values()
            if isinstance(one, Stage)
        ]
    assert known
    content = json.loads(unsealed((tmp_path / "versions.json").read_bytes()) or b"")
    assert set(known) <= set(content["versions"])


def test_forms_that_cannot_be_kept_end_no_run(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail() -> None:
        raise TypeError("unsupported operand")

    monkeypatch.setattr("tasks.geometry.compiled_forms.keep_forms", fail)
    early_imports.keep_what_was_compiled()
    assert "which compiled loops were needed cannot be kept" in caplog.text
