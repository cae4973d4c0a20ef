"""One `tiltwatch run` in a process of its own: wall time, its stages, and its largest memory; and decoding alone."""

import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Final, Literal

import laspy
import psutil

from storage.catalog_reading import read_catalog
from storage.decoders import child
from storage.workspace import Workspace
from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign

LOOK_S: Final = 0.02
FIND_S: Final = 0.5
"""Between two searches for the decoders of a process: a search looks at all processes there are."""

DECODE: Final = """
import os
import sys
from concurrent.futures import ThreadPoolExecutor
import laspy
import numpy as np

def decode(path):
    las = laspy.read(path, laz_backend=laspy.LazBackend.LazrsParallel)
    return len(np.column_stack([las.x, las.y, las.z])) if sys.argv[1] == "metres" else len(las.points)

with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
    list(pool.map(decode, sys.argv[2:]))
"""

FINE: Final = (0, 4, 5, 6)
"""Done; and `status` says by its code how the structure is."""

COPY_POINTS: Final = 1_000_000


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


def as_las(campaign: Path) -> Path:
    """The same campaign with its scans as LAS; kept beside it for the next time."""
    home = campaign.parent.with_name(f"{campaign.parent.name}-las")
    copy = home / campaign.name
    if not copy.is_file():
        for scan in scans_of(campaign):
            target = home / scan.parent.name / f"{scan.stem}.las"
            target.parent.mkdir(parents=True, exist_ok=True)
            with laspy.open(scan) as source, laspy.open(target, mode="w", header=source.header) as written:
                for piece in source.chunk_iterator(COPY_POINTS):
                    written.write_points(piece)
        copy.write_text(campaign.read_text(encoding="utf-8").replace(".laz", ".las"), encoding="utf-8")
    return copy


def scans_of(campaign: Path) -> list[Path]:
    """Scans of its first epoch."""
    first = sorted(path for path in campaign.parent.iterdir() if path.is_dir())[0]
    return sorted(first.glob("*.la[sz]"))


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


def timed_decoding(scans: Sequence[Path], what: Literal["records", "metres"]) -> Measured:
    """Only decode scans, a file a core, LAZ with the parallel decoder: the records, or x, y and z in metres, too."""
    return watched([sys.executable, "-c", DECODE, what, *map(str, scans)])


def watched(command: Sequence[str]) -> Measured:
    """Run a command to its end; its own memory counts and that of its decoders, not that of servers it starts."""
    began = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        seen, peak, decoders = psutil.Process(process.pid), 0, list[psutil.Process]()
        found_at = began
        while process.poll() is None:
            try:
                if time.perf_counter() > found_at + FIND_S:
                    decoders, found_at = _decoders_of(seen), time.perf_counter()
                peak = max(peak, seen.memory_info().rss + sum(map(_own_bytes, decoders)))
            except psutil.NoSuchProcess:
                break
            time.sleep(LOOK_S)
        code = process.wait()
    if code not in FINE:
        raise SystemExit(f"{' '.join(command)} ended with {code}")
    return Measured(time.perf_counter() - began, peak / 2**20)


def _decoders_of(process: psutil.Process) -> list[psutil.Process]:
    return [found for found in process.children() if _is_decoder(found)]


def _is_decoder(process: psutil.Process) -> bool:
    try:
        return child.__file__ in process.cmdline()
    except psutil.Error:
        return False


def _own_bytes(decoder: psutil.Process) -> int:
    """Memory of a decoder that it does not share with the process that asks it."""
    try:
        return int(decoder.memory_full_info().uss)
    except psutil.Error:
        # it ended just now
        return 0
