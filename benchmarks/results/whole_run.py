"""One `tiltwatch run` in a process of its own: wall time, its stages, and its largest memory; and decoding alone."""

import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Final

import psutil

from storage.catalog import read_catalog
from storage.workspace import Workspace
from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign

LOOK_S: Final = 0.02

DECODE: Final = """
import sys
import laspy
for path in sys.argv[1:]:
    laspy.read(path, laz_backend=laspy.LazBackend.LazrsParallel)
"""


@dataclass(frozen=True, slots=True)
class Measured:
    """A process: wall time and largest resident memory."""

    wall_s: float
    peak_mib: float


@dataclass(frozen=True, slots=True)
class WholeRun:
    """A run: the process, from the start of its first stage to the end of its last, and seconds by stage."""

    process: Measured
    stages_s: float
    by_stage_s: Mapping[str, float]


def campaign_of(folder: Path, points: int, stations: int = 8, epochs: int = 1) -> Path:
    """A simulated campaign of so many points in all in every epoch; kept in the folder for the next time."""
    request = SimulatedCampaignRequest(epochs=epochs, stations=stations, points=points // stations)
    return write_simulated_campaign(folder / f"{points}-{stations}-{epochs}", request)


def scans_of(campaign: Path) -> list[Path]:
    """Scans of its first epoch."""
    first = sorted(path for path in campaign.parent.iterdir() if path.is_dir())[0]
    return sorted(first.glob("*.laz"))


def timed_run(campaign: Path, workspace: Path, words: Sequence[str] = ()) -> WholeRun:
    """Run a campaign."""
    command = [sys.executable, "-m", "flows.cli", "-q", "run", str(campaign), "--workspace", str(workspace)]
    process = watched([*command, *words])
    with read_catalog(Workspace(workspace)) as catalog:
        rows = catalog.execute(
            "SELECT stage, started_at, seconds FROM runs WHERE run = (SELECT max(run) FROM runs) AND state = 'computed'"
        ).fetchall()
    by_stage: dict[str, float] = defaultdict(float)
    for stage, _, seconds in rows:
        by_stage[stage.split()[0]] += seconds
    begun = min((at for _, at, _ in rows), default=None)
    span = timedelta() if begun is None else max(at + timedelta(seconds=s) for _, at, s in rows) - begun
    return WholeRun(process, span.total_seconds(), dict(by_stage))


def timed_decoding(scans: Sequence[Path]) -> Measured:
    """Only decode scans, with laspy and lazrs in parallel, one after the other."""
    return watched([sys.executable, "-c", DECODE, *map(str, scans)])


def watched(command: Sequence[str]) -> Measured:
    """Run a command to its end; its own memory counts, not that of servers it starts."""
    began = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        seen, peak = psutil.Process(process.pid), 0
        while process.poll() is None:
            try:
                peak = max(peak, seen.memory_info().rss)
            except psutil.NoSuchProcess:
                break
            time.sleep(LOOK_S)
        code = process.wait()
    if code:
        raise SystemExit(f"{' '.join(command)} ended with {code}")
    return Measured(time.perf_counter() - began, peak / 2**20)
