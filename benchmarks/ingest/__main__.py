"""What it costs to take scans in, beside decoding the same files and nothing else.

`.venv/bin/python -m benchmarks.ingest SCAN.laz [SCAN.laz ...] [--repeats 3]` decodes and ingests all files in every way,
each in a process of its own, and prints Markdown: seconds and processor seconds, each the least of the repeats, million
points a second, the peak of memory above the start, and the time over that of decoding.

`.venv/bin/python -m benchmarks.ingest --make TARGET.laz --points 25000000 SCAN.laz [SCAN.laz ...]` makes a large file of
small ones: their points again and again, each time some millimetres off, with intensities and times that are noise.
"""

import argparse
import itertools
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import laspy
import numpy as np

from benchmarks.ingest.ways import REFERENCE, WAYS

JITTER_STEPS: Final = 30
LONGEST_INTENSITY: Final = 4000
SEED: Final = 1


@dataclass(frozen=True, slots=True)
class Cost:
    """What one way took for all files."""

    points: int
    seconds: float
    processor_s: float
    memory_mb: float


def main() -> None:
    """Measure, or make a file."""
    parser = argparse.ArgumentParser("python -m benchmarks.ingest", description=__doc__)
    parser.add_argument("scans", type=Path, nargs="+")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--make", type=Path)
    parser.add_argument("--points", type=int, default=25_000_000)
    asked = parser.parse_args()
    if asked.make is not None:
        make_large(asked.scans, asked.points, asked.make)
        return
    runs: dict[str, list[Cost]] = {way: [] for way in WAYS}
    for _ in range(asked.repeats):
        for way, costs in runs.items():
            costs.append(_measured(way, asked.scans))
    print(_table({way: _least(costs) for way, costs in runs.items()}))


def make_large(scans: Sequence[Path], n_points: int, target: Path) -> None:
    """Write a file, LAS or LAZ by its suffix, of the points of ``scans``, which must have one scale and offset."""
    rng = np.random.default_rng(SEED)
    with laspy.open(scans[0]) as first:
        header = laspy.LasHeader(point_format=6, version="1.4")
        header.scales, header.offsets = first.header.scales, first.header.offsets
    with laspy.open(target, "w", header=header) as writer:
        left = n_points
        for scan in itertools.cycle(scans):
            if left <= 0:
                return
            points = laspy.read(scan).points[:left]
            writer.write_points(_moved(points, header, rng))
            left -= len(points)


def _moved(
    points: laspy.ScaleAwarePointRecord, header: laspy.LasHeader, rng: np.random.Generator
) -> laspy.ScaleAwarePointRecord:
    moved = laspy.ScaleAwarePointRecord.zeros(len(points), header=header)
    for axis in "XYZ":
        moved[axis] = points[axis] + rng.integers(-JITTER_STEPS, JITTER_STEPS + 1, len(points))
    moved["intensity"] = rng.integers(0, LONGEST_INTENSITY, len(points))
    moved["gps_time"] = np.cumsum(rng.uniform(1e-6, 3e-6, len(points)))
    return moved


def _measured(way: str, scans: Sequence[Path]) -> Cost:
    with tempfile.TemporaryDirectory(dir=scans[0].parent) as folder:
        command = [sys.executable, "-m", "benchmarks.ingest.ways", way, folder, *map(str, scans)]
        told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return Cost(**json.loads(told))


def _least(costs: Sequence[Cost]) -> Cost:
    return Cost(
        costs[0].points,
        min(cost.seconds for cost in costs),
        min(cost.processor_s for cost in costs),
        min(cost.memory_mb for cost in costs),
    )


def _table(costs: dict[str, Cost]) -> str:
    lines = [
        "| way | s | processor s | Mpt/s | Mpt a processor s | memory, MB | s over decoding | processor s over decoding |",
        "|---|---|---|---|---|---|---|---|",
    ]
    base = costs[REFERENCE]
    for way, cost in costs.items():
        millions = cost.points / 1e6
        lines.append(
            f"| {way} | {cost.seconds:.2f} | {cost.processor_s:.2f} | {millions / cost.seconds:.1f} "
            f"| {millions / cost.processor_s:.1f} | {cost.memory_mb:.0f} | {cost.seconds / base.seconds:.2f} "
            f"| {cost.processor_s / base.processor_s:.2f} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
