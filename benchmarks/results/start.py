"""What a command costs that has nothing to compute."""

import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.results.section import Section
from benchmarks.results.whole_run import campaign_of, timed_run, watched

REPEATS = 3


def starts(folder: Path, points: int) -> Section:
    """Warm runs and reading commands on a small campaign."""
    campaign, workspace = campaign_of(folder, points, epochs=2), folder / "warm"
    shutil.rmtree(workspace, ignore_errors=True)
    timed_run(campaign, workspace)
    place = ["--workspace", str(workspace)]
    run = ["run", str(campaign), *place]
    commands = {
        "`run`, nothing new": run,
        "`run --only-new`, nothing new": [*run, "--only-new"],
        "`status`": ["status", str(campaign), *place],
        "`compare`": ["compare", str(campaign), "2025-04", "2025-01", *place],
        "`--help`": ["--help"],
        "`--version`": ["--version"],
    }
    rows = [_to_first_line("`run`, to its first line", run)]
    for name, words in commands.items():
        several = [watched([sys.executable, "-m", "flows.cli", "-q", *words]) for _ in range(REPEATS)]
        rows.append(
            [
                name,
                f"{several[0].wall_s:.2f}",
                f"{min(one.wall_s for one in several[1:]):.2f}",
                f"{max(one.peak_mib for one in several):.0f}",
            ]
        )
    return Section(
        "Commands that have nothing to compute",
        f"python -m benchmarks.results start --points {points}",
        "The whole process, its start and end included; the first time, and the least of the times after it.",
        ["command", "first, s", "again, s", "peak, MiB"],
        rows,
    )


def _to_first_line(name: str, words: Sequence[str]) -> list[str]:
    """How long a command takes to say that it is at work."""
    seconds = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        command = [sys.executable, "-m", "flows.cli", *words]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            process.stderr.readline()
            seconds.append(time.perf_counter() - began)
            process.stderr.read()
    return [name, f"{seconds[0]:.2f}", f"{min(seconds[1:]):.2f}", ""]
