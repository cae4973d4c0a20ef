"""The servers that a measurement needs, on loopback, and how Prefect is told of its own before it is imported."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.dask_cluster import ONE_THREAD
from tests.prefect_server import prefect_server


@contextmanager
def prefect_for(folder: Path) -> Iterator[str]:
    """Run a Prefect server as long as the block lasts, and name it to this process."""
    home = folder / "prefect"
    home.mkdir(parents=True, exist_ok=True)
    os.environ.update(ONE_THREAD)
    with prefect_server(home) as url:
        os.environ.update(PREFECT_API_URL=url, PREFECT_HOME=str(home), PREFECT_LOGGING_LEVEL="CRITICAL")
        yield url
