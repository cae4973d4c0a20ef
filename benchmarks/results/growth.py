"""How a cold run grows with points, stations, epochs and cores."""

import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.results.section import Section
from benchmarks.results.whole_run import (
    WholeRun,
    as_las,
    campaign_of,
    scans_of,
    timed_decoding,
    timed_run,
)

STAGES = ("ingest", "registration", "preprocessing", "surface", "slicing", "axis")


def by_points(folder: Path, million_points: Sequence[float]) -> Section:
    """One epoch in 8 LAZ files, cold, beside only decoding the same files."""
    campaigns = {millions: campaign_of(folder, round(1e6 * millions)) for millions in million_points}
    return _beside_decoding("LAZ", "points", campaigns, folder)


def by_points_of_las(folder: Path, million_points: Sequence[float]) -> Section:
    """The same of LAS files."""
    campaigns = {millions: as_las(campaign_of(folder, round(1e6 * millions))) for millions in million_points}
    return _beside_decoding("LAS", "las", campaigns, folder)


def _beside_decoding(kind: str, section: str, campaigns: Mapping[float, Path], folder: Path) -> Section:
    rows = []
    for millions, campaign in campaigns.items():
        records = timed_decoding(scans_of(campaign), "records").wall_s
        metres = timed_decoding(scans_of(campaign), "metres").wall_s
        run = _cold(campaign, folder)
        rows.append(
            [
                f"{millions:g}",
                f"{records:.1f}",
                f"{metres:.1f}",
                f"{run.stages_s:.1f}",
                f"{run.stages_s / records:.2f}",
                f"{run.stages_s / metres:.2f}",
                f"{run.process.wall_s:.1f}",
                f"{run.process.peak_mib:.0f}",
                *(f"{run.by_stage_s.get(stage, 0.0):.1f}" for stage in STAGES),
            ]
        )
    return Section(
        f"One epoch of {kind}, cold, by the number of points",
        f"python -m benchmarks.results {section} --millions {' '.join(f'{m:g}' for m in campaigns)}",
        f"8 stations as {kind}. Decoding: a process that only reads the same files with laspy (and lazrs in parallel), a "
        "file a core, its start included: the records; and x, y and z in metres, too. Stages: from the start of the first "
        "to the end of the last; the run: with the start of Python and Prefect. Seconds of a stage are summed over stations "
        "and schemes, which work side by side.",
        [
            "million points",
            "records, s",
            "metres, s",
            "stages, s",
            "times records",
            "times metres",
            "run, s",
            "peak, MiB",
            *(f"{stage}, s" for stage in STAGES),
        ],
        rows,
    )


def by_stations(folder: Path, points: int, stations: Sequence[int]) -> Section:
    """The same number of points a station, more of them."""
    rows = []
    for count in stations:
        run = _cold(campaign_of(folder, points * count, count), folder)
        rows.append(
            [str(count), f"{run.stages_s:.1f}", f"{run.stages_s / count:.2f}", f"{run.process.peak_mib:.0f}"]
        )
    return Section(
        "One epoch, cold, by the number of stations",
        f"python -m benchmarks.results stations --points {points}",
        f"{points:,} points a station.",
        ["stations", "stages, s", "a station, s", "peak, MiB"],
        rows,
    )


def by_cores(folder: Path, points: int) -> Section:
    """The same run on one core and on all."""
    campaign = campaign_of(folder, points)
    every = os.sched_getaffinity(0)
    rows = []
    for count in sorted({1, len(every)}):
        os.sched_setaffinity(0, sorted(every)[:count])
        try:
            run = _cold(campaign, folder)
        finally:
            os.sched_setaffinity(0, every)
        rows.append([str(count), f"{run.stages_s:.1f}", f"{run.process.peak_mib:.0f}"])
    return Section(
        "One epoch, cold, by the number of cores",
        f"python -m benchmarks.results cores --points {points}",
        f"{points:,} points in 8 stations; with one core Prefect's server shares it.",
        ["cores", "stages, s", "peak, MiB"],
        rows,
    )


def _cold(campaign: Path, folder: Path) -> WholeRun:
    workspace = folder / "cold"
    shutil.rmtree(workspace, ignore_errors=True)
    return timed_run(campaign, workspace)
