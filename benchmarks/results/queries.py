"""What a dashboard asks of a catalog of many epochs."""

import time
from pathlib import Path
from typing import Final

from benchmarks.catalog.made_up import STRUCTURE
from benchmarks.catalog.workspace import grown_workspace
from benchmarks.results.section import Section
from storage.catalog import rebuild_catalog
from storage.catalog_reading import read_catalog

REPEATS: Final = 5

QUERIES: Final = {
    "latest tilt of every scheme": """
        SELECT * FROM tilt WHERE structure = $structure AND epoch_time =
        (SELECT max(epoch_time) FROM tilt WHERE structure = $structure)""",
    "history of one scheme": """
        SELECT epoch, epoch_time, lean_east, lean_north, deviation_m, deviation_sigma_m FROM tilt
        WHERE structure = $structure AND scheme = 'S' AND method = 'surface' ORDER BY epoch_time""",
    "change against the reference, one scheme": """
        SELECT * FROM changes WHERE structure = $structure AND scheme = 'S' AND method = 'surface'
        ORDER BY epoch_time""",
    "one slice over time": """
        SELECT epoch, epoch_time, center_east_m, center_north_m, radius_m FROM slices JOIN epochs USING (structure, epoch)
        WHERE structure = $structure AND scheme = 'A' AND method = 'robust' AND slice_index = 50 ORDER BY epoch_time""",
    "slices of one epoch": """
        SELECT * FROM slices WHERE structure = $structure AND scheme = 'A' AND method = 'robust'
        AND epoch = (SELECT max(epoch) FROM epochs WHERE structure = $structure)""",
}


def query_times(folder: Path, epochs: int) -> Section:
    """Each query several times on one open connection, rows fetched into Python."""
    ws = grown_workspace(folder / f"catalog-{epochs}", epochs)
    rebuild_catalog(ws)
    rows = []
    with read_catalog(ws) as connection:
        for name, sql in QUERIES.items():
            times = []
            for _ in range(REPEATS):
                began = time.perf_counter()
                found = connection.execute(sql, {"structure": STRUCTURE}).fetchall()
                times.append(1e3 * (time.perf_counter() - began))
            rows.append([name, str(len(found)), f"{times[0]:.1f}", f"{min(times):.1f}"])
    return Section(
        f"Queries of a dashboard at {epochs:,} epochs",
        f"python -m benchmarks.results queries --epochs {epochs}",
        "14 schemes and methods of 100 slices. The first time, and the least of all; rows fetched into Python.",
        ["query", "rows", "first, ms", "again, ms"],
        rows,
    )
