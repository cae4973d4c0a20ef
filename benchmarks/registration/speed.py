"""Registration alone on a large campaign, ours and small_gicp's in one run: wall time and peak memory.

    .venv/bin/python -m benchmarks.registration speed [--points 600000] [--repeats 3] [--cache DIR]

Every repeat is a process of its own, the methods by turns, so that a busy machine is busy for both.
"First" is the peak before registration starts: libraries and the scans, some of it held twice while they are read.
"""

import argparse
import os
import resource
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter
from typing import Final

import numpy as np

from benchmarks.registration.methods import METHODS
from benchmarks.registration.simulated import simulated_epoch
from tasks.geometry.failure import FitFailure
from tasks.simulation import SimulatedCampaignRequest

THREADS: Final = "2"
MIB: Final = 1024.0
"""KiB in it: the system counts in KiB."""


@dataclass(frozen=True, slots=True)
class Run:
    """One registration in a process of its own; memory in MiB, with the scans alone and at its peak."""

    seconds: float
    scans_mib: float
    peak_mib: float


def main(arguments: Sequence[str] | None = None) -> None:
    """Simulate once, then time the methods by turns."""
    wanted = argparse.ArgumentParser(
        prog="speed", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    wanted.add_argument("--seed", type=int, default=2000)
    wanted.add_argument("--stations", type=int, default=8)
    wanted.add_argument("--points", type=int, default=600_000, help="of each station")
    wanted.add_argument("--repeats", type=int, default=3)
    wanted.add_argument("--methods", default="ours,gicp", help=f"of {', '.join(METHODS)}")
    wanted.add_argument("--cache", type=Path, help="folder that keeps the simulated scans")
    asked = wanted.parse_args(arguments)
    request = SimulatedCampaignRequest(
        epochs=1, stations=asked.stations, points=asked.points, seed=asked.seed
    )
    with tempfile.TemporaryDirectory() as folder:
        _measure(request, asked.cache or Path(folder), asked.methods.split(","), asked.repeats)


def _measure(request: SimulatedCampaignRequest, cache: Path, methods: Sequence[str], repeats: int) -> None:
    # the children read it, and simulate nothing
    simulated_epoch(request, cache)
    os.environ["OMP_NUM_THREADS"] = THREADS
    runs: dict[str, list[Run]] = {method: [] for method in methods}
    for _ in range(repeats):
        for method in methods:
            with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
                runs[method].append(pool.submit(_timed, method, request, cache).result())
    print(
        f"{request.stations} stations of {request.points} points, {repeats} runs, {THREADS} threads, "
        f"{os.cpu_count()} cores"
    )
    print("method   best (s)  median (s)  peak (MiB)  first (MiB)  median to the last's")
    last = float(np.median([run.seconds for run in runs[methods[-1]]]))
    for method, several in runs.items():
        seconds = [run.seconds for run in several]
        peak, scans = (max(run.peak_mib for run in several), max(run.scans_mib for run in several))
        median = float(np.median(seconds))
        print(
            f"{method:7s} {min(seconds):9.2f} {median:11.2f} {peak:11.0f} {scans:12.0f} {median / last:30.2f}"
        )


def _timed(method: str, request: SimulatedCampaignRequest, cache: Path) -> Run:
    epoch = simulated_epoch(request, cache)
    before = _peak_mib()
    started = perf_counter()
    registration = METHODS[method](epoch)
    seconds = perf_counter() - started
    if isinstance(registration, FitFailure):
        raise SystemExit(f"{method}: {registration.reason}")
    return Run(seconds, before, _peak_mib())


def _peak_mib() -> float:
    """Largest resident memory of this process so far."""
    status = Path("/proc/self/status")
    if status.exists():
        # not ru_maxrss: on linux a child inherits the parent's through exec
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
        return float(line.split()[1]) / MIB
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MIB
