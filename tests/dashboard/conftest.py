"""A workspace of two epochs, made of rows, and the reader over it."""

from pathlib import Path

import pytest

from dashboard.reader import Reader
from storage.catalog import rebuild_catalog
from storage.workspace import Workspace, open_workspace
from tests.storage.campaign import fill


@pytest.fixture
def ws(tmp_path: Path) -> Workspace:
    """An empty workspace."""
    return open_workspace(tmp_path / "ws")


@pytest.fixture
def reader(ws: Workspace) -> Reader:
    """A reader over the two epochs e0 and e1 of scheme A, method paper."""
    fill(ws)
    rebuild_catalog(ws)
    return Reader(ws, look_every_s=0.0)
