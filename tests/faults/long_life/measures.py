"""What is measured of a campaign's life now and then, and which laws must hold of it."""

import resource
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import duckdb
import psutil

from storage.workspace import Workspace

QUERIES: Final = {
    "newest lean": "SELECT * FROM latest",
    "course of one scheme": "SELECT epoch_time, lean_east, lean_north FROM tilt WHERE scheme = 'S' ORDER BY ALL",
    "slices of one epoch": "SELECT * FROM slices WHERE epoch = (SELECT max(epoch) FROM epochs)",
}

MOST_GROWTH: Final = 1.25
"""A folder may take so many times as many bytes, and files, an epoch in a later stretch as in the first one."""

SLACK: Final = {"bytes": 16_384.0, "files": 1.0}
"""An epoch, a sixteenth of the bytes of its tables and one file of thirty: the list of the parts of a run's settings is
itself cut in parts as it grows longer."""

AT_TIMES_ANEW: Final = "catalog.duckdb"
"""It grows, and shrinks when it is made anew: its growth is taken from the first point on."""


@dataclass(frozen=True)
class Point:
    """A campaign after so many epochs."""

    epochs: int
    bytes: Mapping[str, int]
    """Size of every folder and file of the workspace's root."""
    files: Mapping[str, int]
    descriptors: int
    rss_mb: float
    peak_rss_mb: float
    seconds: Mapping[str, float]
    """Middle time of every step since the last point."""
    query_ms: Mapping[str, float]
    """The first time in a connection of its own."""


def point_of(ws: Workspace, epochs: int, taken: Mapping[str, Sequence[float]]) -> Point:
    """Measure a workspace and this process."""
    sizes, counts = _sizes(ws.root)
    process = psutil.Process()
    return Point(
        epochs,
        sizes,
        counts,
        process.num_fds(),
        process.memory_info().rss / 1e6,
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
        {step: sorted(times)[len(times) // 2] for step, times in taken.items()},
        {name: _query_ms(ws.catalog, sql) for name, sql in QUERIES.items()},
    )


def creeping(points: Sequence[Point]) -> list[str]:
    """What grows faster than the number of epochs; the first point is taken after the beginning is over."""
    steps = list(pairwise(points))
    first, later = steps[0], steps[1:]
    found = []
    for what in ("bytes", "files"):
        for folder in points[-1].bytes:
            usual = _an_epoch(first, what, folder)
            since = [(points[0], step[1]) for step in later] if folder == AT_TIMES_ANEW else later
            found += [
                f"{folder} grows by {now:.0f} {what} an epoch up to {step[1].epochs} epochs, by {usual:.0f} at first"
                for step in since
                if (now := _an_epoch(step, what, folder)) > MOST_GROWTH * usual + SLACK[what]
            ]
    if points[-1].descriptors > points[0].descriptors:
        found.append(f"{points[-1].descriptors} open files, {points[0].descriptors} at first")
    return found


def _an_epoch(step: tuple[Point, Point], what: str, folder: str) -> float:
    before, after = step
    grown = getattr(after, what).get(folder, 0) - getattr(before, what).get(folder, 0)
    return float(grown) / (after.epochs - before.epochs)


def _sizes(root: Path) -> tuple[dict[str, int], dict[str, int]]:
    sizes: dict[str, int] = {}
    counts: dict[str, int] = {}
    seen: set[int] = set()
    for path in sorted(root.rglob("*")):
        try:
            status = path.lstat()
        except FileNotFoundError:  # of a workflow server that is just ending
            continue
        if path.is_dir() or status.st_ino in seen:
            continue
        seen.add(status.st_ino)
        parts = path.relative_to(root).parts
        name = "/".join(parts[:2]) if parts[0] == "runs" else parts[0]
        sizes[name] = sizes.get(name, 0) + status.st_size
        counts[name] = counts.get(name, 0) + 1
    return sizes, counts


def _query_ms(catalog: Path, sql: str) -> float:
    began = time.perf_counter()
    with duckdb.connect(str(catalog), read_only=True) as connection:
        connection.execute(sql).fetchall()
    return 1e3 * (time.perf_counter() - began)
