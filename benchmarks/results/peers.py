"""Our whole epoch beside what peers need for the registration alone, and open3d for its usual recipe, in one run."""

import os
import shutil
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter
from typing import Final

from benchmarks.registration.known import KnownEpoch
from benchmarks.registration.methods import METHODS
from benchmarks.registration.pose_graph import VOXEL_M
from benchmarks.registration.simulated import simulated_epoch
from benchmarks.results.section import Section
from benchmarks.results.whole_run import campaign_of, timed_run
from storage.errors import TiltwatchError
from tasks.geometry.failure import FitFailure
from tasks.open3d_import import import_open3d
from tasks.simulation import SimulatedCampaignRequest

NEIGHBOURS: Final = 20
RATIO: Final = 2.0
"""Of the statistical outlier removal, as in open3d's tutorial."""


def remove_outliers(epoch: KnownEpoch) -> None:
    """open3d's statistical outlier removal of every station, all of its points."""
    o3d = import_open3d()
    for scan in epoch.scans:
        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(scan.points_m))
        cloud.remove_statistical_outlier(nb_neighbors=NEIGHBOURS, std_ratio=RATIO)


def down_sample(epoch: KnownEpoch) -> None:
    """open3d's voxel down-sampling of every station, all of its points."""
    o3d = import_open3d()
    for scan in epoch.scans:
        o3d.geometry.PointCloud(o3d.utility.Vector3dVector(scan.points_m)).voxel_down_sample(VOXEL_M)


GICP: Final = ("small_gicp, sequential GICP alone", METHODS["gicp"])

RECIPE: Final[Mapping[str, Callable[[KnownEpoch], object]]] = {
    f"open3d, statistical outlier removal of every station ({NEIGHBOURS} neighbours, {RATIO:g} sigma), all points": (
        remove_outliers
    ),
    f"open3d, voxel down-sampling of every station ({VOXEL_M:g} m), all points": down_sample,
    "open3d, pairwise ICP and pose graph alone": METHODS["open3d"],
}


def beside_peers(folder: Path, points: int, stations: int = 8) -> Section:
    """The same simulated campaign for all."""
    campaign = campaign_of(folder, points, stations)
    workspace = folder / "cold"
    shutil.rmtree(workspace, ignore_errors=True)
    ours = timed_run(campaign, workspace).stages_s
    request = SimulatedCampaignRequest(epochs=1, stations=stations, points=points // stations)
    simulated_epoch(request, folder)
    measured = {words: _in_process(step, request, folder) for words, step in (GICP, *RECIPE.items())}
    of_recipe = [seconds for words in RECIPE if (seconds := measured[words]) is not None]
    whole = sum(of_recipe) if len(of_recipe) == len(RECIPE) else None
    measured["open3d, these three steps in all"] = whole
    return Section(
        "Beside peers",
        f"python -m benchmarks.results peers --points {points}",
        f"{points:,} points in {stations} stations. Peers start from the stated poses, read nothing, isolate nothing; each "
        "line of theirs is a process of its own, from the points in memory on. ICP and pose graph work on points thinned by "
        f"{VOXEL_M:g} m and cleaned again, as in the tutorial, whatever the other two lines took.",
        ["what", "wall, s", "times ours"],
        [
            ["tiltwatch: reading, registration, isolation, all schemes", f"{ours:.1f}", "1.0"],
            *(
                [words, "failed", ""]
                if seconds is None
                else [words, f"{seconds:.1f}", f"{seconds / ours:.1f}"]
                for words, seconds in measured.items()
            ),
        ],
    )


def _in_process(
    step: Callable[[KnownEpoch], object], request: SimulatedCampaignRequest, folder: Path
) -> float | None:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(_timed, step, request, folder).result()


def _timed(
    step: Callable[[KnownEpoch], object], request: SimulatedCampaignRequest, folder: Path
) -> float | None:
    os.environ.setdefault("OMP_NUM_THREADS", str(os.cpu_count() or 1))
    epoch = simulated_epoch(request, folder)
    # nobody is slower for what is imported once
    with suppress(TiltwatchError):
        import_open3d()
    began = perf_counter()
    found = step(epoch)
    return None if isinstance(found, FitFailure) else perf_counter() - began
