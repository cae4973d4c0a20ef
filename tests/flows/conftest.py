"""What tests of several flows share."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.flows.watched_sites import Site


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    made = Site(tmp_path)
    yield made
    made.watch.stop()
