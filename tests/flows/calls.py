"""Call the command line inside the test, or as a process of its own."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from flows.cli import main
from flows.terminal import Terminal, use_terminal

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Called:
    """Exit code and what was written."""

    code: int
    out: str
    err: str

    @property
    def answer(self) -> dict:
        """The one JSON object on stdout."""
        (line,) = self.out.splitlines()
        return json.loads(line)


def call(capsys: pytest.CaptureFixture[str], *words: object) -> Called:
    """Call the command line in this process."""
    capsys.readouterr()
    try:
        code = main([str(word) for word in words])
    finally:
        use_terminal(Terminal())
    written = capsys.readouterr()
    return Called(code, written.out, written.err)


def call_process(*words: object, cwd: Path | None = None) -> Called:
    """Call the command line as a user does."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-m", "flows.cli", *(str(word) for word in words)],
        capture_output=True,
        encoding="utf-8",
        cwd=cwd or ROOT,
        env={**environment, "PYTHONIOENCODING": "utf-8"},
        timeout=120,
        check=False,
    )
    return Called(done.returncode, done.stdout, done.stderr)
