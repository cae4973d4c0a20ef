"""Our whole epoch beside what peers need for the registration alone, in one run."""

import os
import shutil
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter

from benchmarks.registration.methods import METHODS
from benchmarks.registration.simulated import simulated_epoch
from benchmarks.results.section import Section
from benchmarks.results.whole_run import campaign_of, timed_run
from tasks.geometry.failure import FitFailure
from tasks.simulation import SimulatedCampaignRequest

PEERS = {"gicp": "small_gicp, sequential GICP alone", "open3d": "open3d, pairwise ICP and pose graph alone"}


def beside_peers(folder: Path, points: int, stations: int = 8) -> Section:
    """The same simulated campaign for all."""
    campaign = campaign_of(folder, points, stations)
    workspace = folder / "cold"
    shutil.rmtree(workspace, ignore_errors=True)
    ours = timed_run(campaign, workspace).stages_s
    rows = [["tiltwatch: reading, registration, isolation, all schemes", f"{ours:.1f}", "1.0"]]
    request = SimulatedCampaignRequest(epochs=1, stations=stations, points=points // stations)
    simulated_epoch(request, folder)
    for method, words in PEERS.items():
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            seconds = pool.submit(_timed, method, request, folder).result()
        told = "failed" if seconds is None else f"{seconds:.1f}"
        rows.append([words, told, "" if seconds is None else f"{seconds / ours:.1f}"])
    return Section(
        "Beside peers",
        f"python -m benchmarks.results peers --points {points}",
        f"{points:,} points in {stations} stations. Peers start from the stated poses, read nothing, isolate nothing.",
        ["what", "wall, s", "times ours"],
        rows,
    )


def _timed(method: str, request: SimulatedCampaignRequest, folder: Path) -> float | None:
    os.environ.setdefault("OMP_NUM_THREADS", str(os.cpu_count() or 1))
    epoch = simulated_epoch(request, folder)
    began = perf_counter()
    found = METHODS[method](epoch)
    return None if isinstance(found, FitFailure) else perf_counter() - began
