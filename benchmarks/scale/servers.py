"""How Prefect is told of its server before it is imported: one as runs have it, on loopback."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.dask_cluster import ONE_THREAD


@contextmanager
def prefect_for(folder: Path) -> Iterator[None]:
    """Let all runs of this process share one server, which the first of them starts and which ends with the process."""
    home = folder / "prefect"
    home.mkdir(parents=True, exist_ok=True)
    os.environ.update(ONE_THREAD, PREFECT_HOME=str(home), TILTWATCH_KEEP_SERVER_S="0")
    # a server that somebody named would be asked for more, and share no processors
    os.environ.pop("PREFECT_API_URL", None)
    yield
