"""What stages import is imported beside the start of the engine; what cannot be is left to them."""

import importlib
import subprocess
import sys
import threading

import pytest

from flows import early_imports
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
