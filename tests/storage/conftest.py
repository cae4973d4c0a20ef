"""A workspace of its own for each test."""

from pathlib import Path

import pytest

from storage.workspace import Workspace, open_workspace


@pytest.fixture
def ws(tmp_path: Path) -> Workspace:
    return open_workspace(tmp_path / "ws")
