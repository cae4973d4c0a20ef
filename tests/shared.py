"""Where the shared data lie, and what becomes of a test without them, or without what else a machine may lack."""

import os
from pathlib import Path
from typing import NoReturn

import pytest

SHARED = Path(__file__).resolve().parents[2] / "shared"

needs_shared = pytest.mark.skipif(
    not SHARED.exists() and os.environ.get("CI") != "true",
    reason="needs the shared data beside the project, which are absent here",
)


def unavailable(reason: str) -> NoReturn:
    """Skip a test for what a user's machine may lack; fail under CI, which has to have it."""
    if os.environ.get("CI") == "true":
        pytest.fail(reason)
    pytest.skip(reason)
